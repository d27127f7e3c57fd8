"""The flight against a bare JSBSim step: turbulence and guidance, and how long it takes to get an aircraft flying.

Prints ratios to the limits, measured one after the other in one process: the machine's speed cancels.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from typing import Any

from aerosim import assets
from aerosim.flight.jsbsim_flight import JsbsimFlight, bare_loop
from aerosim.scenario import load_scenario
from aerosim.scenario.build import build
from aerosim.scenario.build.flight import aircraft_of

PART, PARTS, ROUNDS = 768, 100, 9
LIMIT_SHARE = 0.25
LIMIT_START_S = 0.1
AIRSPEED = {"survey_twin": 69.44, "beech_99": 80.0, "beaver": 55.0}


def flight(settings: dict[str, Any]) -> JsbsimFlight:
    """A fresh flight of the scenario crosswind."""
    made = build(load_scenario("crosswind", settings)).flight
    assert isinstance(made, JsbsimFlight)
    return made


def timed(work: Callable[[], object]) -> float:
    """Processor time, s."""
    started = time.process_time()
    work()
    return time.process_time() - started


def share(settings: dict[str, Any]) -> float:
    """What air and guidance add to the bare steps of the same aircraft, of these; both in turn, in short parts."""
    own, bare = flight(settings), flight(settings)

    def fly() -> None:
        for _ in range(PART // 6):
            own.advance(6)

    parts = [(timed(fly), timed(lambda: bare_loop(bare.aircraft, PART))) for _ in range(PARTS)]
    return statistics.median(a / b for a, b in parts) - 1.0


def start(model: str) -> float:
    """Creating, loading and trimming an aircraft in a crosswind, s."""
    scenario = load_scenario("crosswind", {"aircraft.model": model})

    def once() -> None:
        aircraft_of(scenario).start(0.64, -1.47, 3000.0, math.radians(90.0), AIRSPEED[model], (-10.0, 0.0, 0.0))

    return statistics.median(timed(once) for _ in range(ROUNDS))


def main() -> None:
    """Print the ratios."""
    kinds: dict[str, dict[str, Any]] = {
        "Dryden turbulence, slow wind, guidance": {},
        "von Karman turbulence, slow wind, guidance": {"air.turbulence.model": "von_karman"},
        "steady wind, guidance": {"air.turbulence.sigma_m_s": 0.0, "air.slow_wind.sigma_m_s": 0.0},
        "Dryden, wind that veers with height, guidance": {"air.shear.veer_deg_per_km": 5.0},
    }
    for name, settings in kinds.items():
        part = share(settings)
        print(f"{name}: {100.0 * part:.0f} % of the bare step, {part / LIMIT_SHARE:.2f} of the limit")
    for folder in sorted(assets.folder("aircraft").glob("*/limits.yaml")):
        model = folder.parent.name
        print(f"create, load, trim {model}: {start(model) / LIMIT_START_S:.3f} of the limit of 0.1 s")


if __name__ == "__main__":
    main()
