"""Closed loop without pictures against JSBSim alone, in one process, in turn; by mode and aiding.

Prints ratios of the shortest processor times of several rounds: the machine's speed cancels, and most of what
others do on it.  The terrain is read before: once a flight, 0.1 to 0.3 s.  `make bench` runs all files of this
folder.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from aerosim.flight.jsbsim_flight import JsbsimFlight, bare_loop
from aerosim.recorder import Recorder
from aerosim.scenario import load_scenario
from aerosim.scenario.build import build
from aerosim.simulate import fly

LIMIT = 2.0
ROUNDS = 7
LINE = {  # 9 km and the run-in: two minutes
    "flight.lines": [{"start_deg": [36.52, -84.38], "end_deg": [36.52, -84.28]}],
    "record.rrd": False,
}
MODES: dict[str, dict[str, Any]] = {
    "pipelined": {"control.mode": "pipelined"},
    "schmelovsky_1988": {"control.mode": "schmelovsky_1988"},
    "schmelovsky_1988 in whole numbers": {
        "control.mode": "schmelovsky_1988",
        "estimation.arithmetic": "integer",
        "estimation.subpixel": False,
    },
    "ideal": {"control.mode": "ideal"},
    "best, imu": {"control.mode": "best", "estimation.aiding": "imu"},
    "best, bank": {"control.mode": "best", "estimation.aiding": "bank"},
    "best, gyro": {"control.mode": "best", "estimation.aiding": "gyro"},
    "best, none": {"control.mode": "best", "estimation.aiding": "none"},
}


def closed_loop(settings: dict[str, Any]) -> tuple[float, int, int]:
    """Time of the whole loop, s, its steps, and steps from one exposure to the next."""
    mission = build(load_scenario("crosswind", {**LINE, **settings}))
    line = mission.flight.plan.lines[0]
    (lat, lon), height = np.mean([line.start, line.end], axis=0), mission.flight.plan.height
    mission.ground.around(float(lat), float(lon), mission.rows.reach(height))
    started = time.process_time()
    flown = fly(mission, Recorder(keep_signals=False))
    wall = time.process_time() - started
    if flown.status != "done":
        raise SystemExit(flown.reason)
    return wall, round(flown.duration / mission.dt), mission.rows_every


def flight_alone(steps: int, every: int) -> float:
    """Time of the same flight with its air and guidance but without camera, s."""
    flight = build(load_scenario("crosswind", LINE)).flight
    started = time.process_time()
    for _ in range(0, steps, every):
        flight.advance(every)
    return time.process_time() - started


def jsbsim_alone(steps: int) -> float:
    """Time of as many bare JSBSim steps of the same aircraft under its own autopilot, s."""
    flight = build(load_scenario("crosswind", LINE)).flight
    assert isinstance(flight, JsbsimFlight)
    started = time.process_time()
    bare_loop(flight.aircraft, steps)
    return time.process_time() - started


def main() -> None:
    """Print the ratios."""
    loops: dict[str, list[float]] = {name: [] for name in MODES}
    flights, bares = [], []
    for _ in range(ROUNDS):
        for name, settings in MODES.items():
            wall, steps, every = closed_loop(settings)
            loops[name].append(wall)
        flights.append(flight_alone(steps, every))
        bares.append(jsbsim_alone(steps))
    exposures, flight, bare = steps / every, min(flights), min(bares)
    us = 1e6 / exposures
    print(
        f"bare calls of JSBSim in constant wind: {bare * us:.0f} us an exposure ({bare / steps * 1e6:.1f} a step)"
    )
    print(f"JSBSim on the same flight, with air and guidance: {flight * us:.0f} us, {flight / bare:.2f} of them")
    for name, walls in loops.items():
        wall = min(walls)
        print(
            f"closed loop, {name}: {wall * us:.0f} us, {wall / flight:.2f} of the same flight (limit {LIMIT:g}), "
            f"{wall / bare:.2f} of bare calls; rows and estimator {(wall - flight) * us:.0f} us"
        )


if __name__ == "__main__":
    main()
