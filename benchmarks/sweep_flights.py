"""What K controllers on one flight cost, against one flight and K times the sensing.

Prints ratios of processor time, measured one after the other in one process: the machine's speed cancels.
"""

from __future__ import annotations

import logging
import statistics
import tempfile
import time
from pathlib import Path

from aerosim.flight.interface import FlightSource, fresh
from aerosim.scenario import load_scenario
from aerosim.scenario.build import build
from aerosim.simulate import simulate
from aerosim.sweep.flights import Flights

MODES = ("fixed", "schmelovsky_1988", "pipelined", "ideal")
ROUNDS = 3


def run(mode: str, flights: FlightSource) -> float:
    """Processor time of one run without pictures, s."""
    scenario = load_scenario("crosswind", {"control.mode": mode, "record.rrd": False, "record.report": False})
    started = time.process_time()
    simulate(scenario, flights=flights)
    return time.process_time() - started


def flight_alone() -> float:
    """Processor time of the flight without any camera, s."""
    mission = build(load_scenario("crosswind"))
    started = time.process_time()
    while not mission.flight.done:
        mission.flight.advance(mission.rows_every)
    return time.process_time() - started


def ratio() -> tuple[float, float]:
    """Cost of K controllers over flight + K x sensing, and over K runs of their own."""
    flight, own = flight_alone(), [run(mode, fresh) for mode in MODES]
    sensing = sum(own) - len(MODES) * flight
    with tempfile.TemporaryDirectory() as folder:
        # one object a run: each reads the file, as processes of their own do
        shared = sum(run(mode, Flights(Path(folder))) for mode in MODES)
    return shared / (flight + sensing), shared / sum(own)


def main() -> None:
    """Print the ratios."""
    logging.getLogger("aerosim").setLevel(logging.WARNING)
    for mode in MODES:
        run(mode, fresh)
    found = [ratio() for _ in range(ROUNDS)]
    limit, own = (statistics.median(values) for values in zip(*found, strict=True))
    print(f"{len(MODES)} controllers on one flight / (flight + {len(MODES)} x sensing): {limit:.2f}, limit 1")
    print(f"{len(MODES)} controllers on one flight / {len(MODES)} runs with flights of their own: {own:.2f}")


if __name__ == "__main__":
    main()
