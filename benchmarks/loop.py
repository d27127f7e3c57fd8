"""Closed loop without pictures against JSBSim alone, in one process, one after the other.

Prints ratios, not times: the machine's speed cancels.  `make bench` runs all files of this folder.
"""

from __future__ import annotations

import statistics
import time

from aerosim.flight.jsbsim_flight import JsbsimFlight, bare_loop
from aerosim.recorder import Recorder
from aerosim.scenario import load_scenario
from aerosim.scenario.build import build
from aerosim.simulate import fly

LIMIT = 2.5
ROUNDS = 5


def closed_loop() -> tuple[float, int]:
    """Wall time of the whole loop, s, and its steps."""
    mission = build(load_scenario("crosswind", {"record.rrd": False}))
    flown = fly(mission, Recorder(keep_signals=False))
    return flown.wall, round(flown.duration / mission.dt)


def flight_alone(steps: int) -> float:
    """Wall time of the same flight with its air and guidance but without camera, s."""
    mission = build(load_scenario("crosswind"))
    started = time.perf_counter()
    for _ in range(0, steps, mission.rows_every):
        mission.flight.advance(mission.rows_every)
    return time.perf_counter() - started


def jsbsim_alone(steps: int) -> float:
    """Wall time of as many bare JSBSim steps of the same aircraft under its own autopilot, s."""
    flight = build(load_scenario("crosswind")).flight
    assert isinstance(flight, JsbsimFlight)
    started = time.perf_counter()
    bare_loop(flight.aircraft, steps)
    return time.perf_counter() - started


def main() -> None:
    """Print the ratios of several rounds."""
    closed_loop()
    to_bare, to_flight, step_us = [], [], []
    for _ in range(ROUNDS):
        wall, steps = closed_loop()
        bare, flight = jsbsim_alone(steps), flight_alone(steps)
        to_bare.append(wall / bare)
        to_flight.append(wall / flight)
        step_us.append(bare / steps * 1e6)
    same, bare = statistics.median(to_flight), statistics.median(to_bare)
    print(f"closed loop / JSBSim alone on the same flight (its air, its guidance): {same:.2f}, limit {LIMIT}")
    print(f"closed loop / bare calls of JSBSim in constant wind, no guidance: {bare:.2f}")
    print(f"such a bare call takes {statistics.median(step_us):.2f} us (medians of {ROUNDS})")


if __name__ == "__main__":
    main()
