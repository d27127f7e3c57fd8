"""A replay beside JSBSim, and what its parts cost: ratios and microseconds a step.

python benchmarks/replay.py
"""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path

import numpy as np

from aerosim import assets
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.jsbsim_flight import JsbsimFlight, bare_loop
from aerosim.flight.plan import FlightPlan, Line
from aerosim.flight.replay.replay import Replay, ReplayParameters, prepare
from aerosim.flight.replay.replay_flight import ReplayFlight
from aerosim.frames import WGS84_A
from aerosim.truth import AirState, Where

RATE, LOOP_STEPS = 120.0, 6
PLACE = (math.radians(47.0), math.radians(11.0))


class Steady:
    """A wind of 10 m/s with a gust."""

    state = AirState(6.0, 8.0, 0.0, 0.3, 0.2, -0.3, 0.0, 0.0, 0.0)

    def at(self, index: int, where: Where) -> AirState:
        return self.state


def line(length: float) -> Line:
    return Line(PLACE, (PLACE[0] + length / WGS84_A, PLACE[1]))


def jsbsim() -> JsbsimFlight:
    aircraft = Aircraft(assets.folder("aircraft") / "survey_twin", RATE)
    return JsbsimFlight(aircraft, FlightPlan([line(60_000.0)], 3000.0, 69.44), Steady(), 3)


def recorded(file: Path, seconds: float) -> None:
    """A straight flight as it comes from a receiver, a point each second."""
    t = np.arange(0.0, seconds)
    lat = np.degrees(PLACE[0] + 69.44 * t / WGS84_A)
    rows = [f"{a:.0f},{b:.6f},{math.degrees(PLACE[1]):.6f},3000" for a, b in zip(t, lat, strict=True)]
    file.write_text("\n".join(["t_s,latitude_deg,longitude_deg,height_m", *rows]) + "\n")


def step_us(flight: JsbsimFlight | ReplayFlight, steps: int) -> float:
    """Time of a step in a loop that looks at the state each 50 ms, us."""
    started = time.perf_counter()
    for _ in range(steps // LOOP_STEPS):
        flight.advance(LOOP_STEPS)
        flight.state()
    return (time.perf_counter() - started) / steps * 1e6


def bare_us(steps: int) -> float:
    aircraft = jsbsim().aircraft
    started = time.perf_counter()
    bare_loop(aircraft, steps)
    return (time.perf_counter() - started) / steps * 1e6


def state_us(flight: ReplayFlight, count: int) -> float:
    started = time.perf_counter()
    for _ in range(count):
        flight.state()
    return (time.perf_counter() - started) / count * 1e6


def prepared(seconds: float) -> tuple[Replay, float]:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "flight.csv"
        recorded(file, seconds)
        started = time.perf_counter()
        return prepare(file, ReplayParameters()), (time.perf_counter() - started) * 1e3


def main() -> None:
    steps = 60_000
    replay, milliseconds = prepared(800.0)
    # the best of three: another program on the machine makes any of them slower
    mine = min(step_us(ReplayFlight(replay, Steady(), 3, RATE), steps) for _ in range(3))
    flown = min(step_us(jsbsim(), steps) for _ in range(3))
    bare = min(bare_us(steps) for _ in range(3))
    state = min(state_us(ReplayFlight(replay, Steady(), 3, RATE), 100_000) for _ in range(3))
    print(f"step of a replay, its air asked, states looked at   {mine:8.2f} us")
    print(f"  against the flight by JSBSim                      {mine / flown:8.2f}  (limit 1, {flown:.1f} us)")
    print(f"  against JSBSim alone                              {mine / bare:8.2f}  ({bare:.1f} us)")
    print(f"one state                                           {state:8.2f} us  (limit 2)")
    print(f"reading and smoothing 800 points                    {milliseconds:8.1f} ms")
    print(f"  the same for an hour, a point a second            {prepared(3600.0)[1]:8.1f} ms")


if __name__ == "__main__":
    main()
