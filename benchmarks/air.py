"""The air against a bare JSBSim step: time of a state, and of making it, for each kind of air.

Prints ratios to three bare steps, which one state of the air is held for: the machine's speed cancels.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from functools import partial
from math import radians
from typing import Any

from aerosim import assets
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.jsbsim_flight import bare_loop
from aerosim.rng import generator
from aerosim.world.air import Air
from aerosim.world.atmosphere import GaussMarkov, make_air
from aerosim.world.mesoscale import Mesoscale
from aerosim.world.thermals import ThermalField
from aerosim.world.turbulence import Turbulence
from aerosim.world.wind import Level, WindField, steady_wind

RATE, HOLD = 120.0, 3
STATES, ROUNDS = 24_000, 5
LIMIT = 0.25
LAT, LON, HEIGHT, SPEED = radians(47.0), radians(8.0), 3000.0, 69.44

DRYDEN, VON_KARMAN = Turbulence.equal("dryden", 0.7, 533.4), Turbulence.equal("von_karman", 0.7, 762.0)
KINDS: dict[str, dict[str, Any]] = {
    "steady wind": {},
    "slow wind and Dryden": {"slow": GaussMarkov(1.0, 120.0), "turbulence": DRYDEN},
    "slow wind and von Karman": {"slow": GaussMarkov(1.0, 120.0), "turbulence": VON_KARMAN},
    "profile": {"wind": WindField([Level(0.0, 5.0, 0.0), Level(4000.0, 15.0, 1.0)])},
    "mesoscale wind": {"slow": Mesoscale()},
    "thermals": {"thermal_field": ThermalField(1e-6, 200.0, 2.0)},
    "all": {
        "wind": WindField([Level(0.0, 5.0, 0.0), Level(4000.0, 15.0, 1.0)]),
        "slow": Mesoscale(),
        "turbulence": VON_KARMAN,
        "thermal_field": ThermalField(1e-6, 200.0, 2.0),
    },
}


def air_of(parts: dict[str, Any]) -> Air:
    """One kind of air."""
    return make_air(
        **{"wind": steady_wind(8.0, 250.0), **parts},
        origin=(LAT, LON),
        height=HEIGHT,
        airspeed=SPEED,
        span=19.81,
        dt=HOLD / RATE,
        rng_of=partial(generator, 1),
    )


def microseconds(call: Callable[[], object], count: int) -> float:
    """Time of a call that does `count` things, us each."""
    started = time.perf_counter()
    call()
    return (time.perf_counter() - started) / count * 1e6


def flown(air: Air) -> None:
    """All states of ten minutes, made and asked for, the aircraft on its way east."""
    lon = LON

    def where() -> tuple[float, float, float]:
        return LAT, lon, HEIGHT

    at = air.at
    for index in range(STATES):
        lon += 4e-7
        at(index, where)


def looked_up(air: Air) -> None:
    """One state, asked for again and again."""
    at = air.at
    last = STATES

    def where() -> tuple[float, float, float]:
        return LAT, LON, HEIGHT

    for _ in range(STATES):
        at(last, where)


def jsbsim_alone() -> float:
    """A bare step of JSBSim under the model's autopilot, us."""
    aircraft = Aircraft(assets.folder("aircraft") / "survey_twin", RATE)
    aircraft.start(LAT, LON, HEIGHT, radians(90.0), SPEED)
    return microseconds(lambda: bare_loop(aircraft, STATES), STATES)


def main() -> None:
    """Print the ratios."""
    for parts in KINDS.values():
        air_of(parts).at(0, lambda: (LAT, LON, HEIGHT))  # compiled
    step = statistics.median(jsbsim_alone() for _ in range(ROUNDS))
    air = air_of({})
    again = statistics.median(microseconds(lambda: looked_up(air), STATES) for _ in range(ROUNDS))
    print(f"bare step of JSBSim: {step:.1f} us; a state looked up: {again:.2f} us, {again / step:.3f} of it")
    print(f"a state made and asked for, of the {HOLD} bare steps that it is held (goal, with guidance: {LIMIT}):")
    for name, parts in KINDS.items():
        cost = statistics.median(microseconds(partial(flown, air_of(parts)), STATES) for _ in range(ROUNDS))
        print(f"  {name:24s} {cost:5.2f} us  {cost / (HOLD * step):.3f}")


if __name__ == "__main__":
    main()
