"""What a user's aircraft has to show before it flies a mission: properties, trim, response, a few seconds."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from aerosim.errors import InputError, RunFailure
from aerosim.flight import fdm
from aerosim.flight.aircraft import FOOT, POUND, Aircraft
from aerosim.flight.own.contract import OWN, PROPERTIES
from aerosim.truth import AircraftState

# Places in the envelope, as parts of its range of heights and speeds: one of them must do.
_POINTS = ((0.3, 0.4), (0.3, 0.25), (0.3, 0.6), (0.1, 0.4))
_HEIGHT_MAX = 3000.0
_LAT, _LON = 0.89, 0.23
_STEADY_S, _ROLLING_S = 1.0, 3.0
_ROLL = math.radians(6.0)
_RATE = 0.05
_DAMPING = 0.02  # 1/s, a tenth of what the least damped axis of a light aircraft has
_AXES = (
    ("gust/p-rad_sec", "accelerations/pdot-rad_sec2"),
    ("gust/q-rad_sec", "accelerations/qdot-rad_sec2"),
    ("gust/r-rad_sec", "accelerations/rdot-rad_sec2"),
)
Heard = Callable[[str], None]


def try_out(folder: Path, step_rate_hz: float, fuel_kg: float | None, stage: Heard, heard: Heard) -> None:
    """Raise InputError for a model that does not keep the contract, or does not fly.

    stage: is told `load`, `trim` and `fly` before each; heard: JSBSim's warnings.  JSBSim may end the process.
    """
    stage("load")
    model, _ = fdm.load(folder, step_rate_hz, heard)
    _check_there(model)
    _check_written(model)
    # From here on each part takes an aircraft of its own: none may feel what was done to another.
    _check_size(Aircraft(folder, step_rate_hz, fuel_kg))
    stage("trim")
    aircraft = Aircraft(folder, step_rate_hz, fuel_kg)
    start = _trim(aircraft)
    stage("fly")
    _check_gusts(aircraft)
    _fly(Aircraft(folder, step_rate_hz, fuel_kg), start)


def _begin(model: Any) -> None:
    """Initial conditions that every aircraft stands: never at rest, where b/2V is not finite."""
    model["ic/vn-fps"] = 200.0
    model.run_ic()


def _check_there(model: Any) -> None:
    manager = model.get_property_manager()
    for each in PROPERTIES:
        if manager.get_node(each.name) is None:
            raise InputError(f"the model lacks the property {each.name}", allowed=f"{each.meaning}, {each.unit}")


def _near(found: float, wanted: float, part: float) -> bool:
    return math.isfinite(found) and abs(found - wanted) <= part * abs(wanted)


def _check_size(aircraft: Aircraft) -> None:
    """Wing and mass of model and limits file have to be the same aircraft's."""
    limits, get = aircraft.limits, aircraft._fdm.get_property_value
    area = get("metrics/Sw-sqft") * FOOT**2
    if not _near(area, limits.wing_area_m2, 0.01):
        raise InputError(
            f"wing area of {area:.4g} m2 in the model, wing_area_m2 of {limits.wing_area_m2:.4g} in limits.yaml",
            allowed="the same within 1 %",
        )
    _begin(aircraft._fdm)
    mass, wanted = get("inertia/weight-lbs") * POUND, limits.mass_empty_kg + aircraft.fuel
    if not _near(mass, wanted, 0.01):
        raise InputError(
            f"mass of {mass:.5g} kg in the model with {aircraft.fuel:.4g} kg of fuel, "
            f"mass_empty_kg and fuel of {wanted:.5g} kg in limits.yaml",
            allowed="the same within 1 %",
        )


def _trim(aircraft: Aircraft) -> AircraftState:
    """Trim at one of a few points of the envelope.  Returns the state there; raises InputError if none does."""
    limits, first = aircraft.limits, ""
    for up, fast in _POINTS:
        height = min(limits.height_min_m + up * (limits.height_max_m - limits.height_min_m), _HEIGHT_MAX)
        low, high = limits.speed_range(height, limits.mass_empty_kg + aircraft.fuel)
        speed = low + fast * (high - low)
        try:
            aircraft.start(_LAT, _LON, height, 0.0, speed)
            return aircraft.state()
        except InputError as error:
            first = first or f"{height:.0f} m and {speed:.1f} m/s: {error.problem}"
        except (np.linalg.LinAlgError, RuntimeWarning) as error:
            first = first or f"{height:.0f} m and {speed:.1f} m/s: {error}"
        if wrong := _not_finite(aircraft):
            raise InputError(f"not finite at {height:.0f} m and {speed:.1f} m/s: {', '.join(wrong)}")
    raise InputError(
        f"cannot be trimmed within limits.yaml, for example at {first}", allowed="a steady level flight"
    )


def _not_finite(aircraft: Aircraft) -> list[str]:
    """The first functions and forces that are not finite."""
    names = aircraft._fdm.query_property_catalog("").splitlines()
    wanted = [name.split(" ")[0] for name in names if name.startswith(("aero/", "forces/", "power/", "fcs/"))]
    return [n for n in wanted if not math.isfinite(aircraft._fdm.get_property_value(n))][:3]


def _check_written(model: Any) -> None:
    """What is written must stay written while the model computes."""
    manager = model.get_property_manager()
    _begin(model)
    for each in OWN:
        if not each.written:
            continue
        node = manager.get_node(each.name)
        before = node.get_double_value()
        wanted = before + max(1e-3, 1e-3 * abs(before))
        node.set_double_value(wanted)
        model.run_ic()
        # Not to the last digit: the model itself burns the fuel.
        if not abs(node.get_double_value() - wanted) <= 0.1 * (wanted - before):
            raise InputError(
                f"the property {each.name} cannot be written", allowed=f"a plain <property>: {each.meaning}"
            )
        node.set_double_value(before)


def _check_gusts(aircraft: Aircraft) -> None:
    """Air that turns must take the aircraft along."""
    for gust, acceleration in _AXES:
        node = aircraft._fdm.get_property_manager().get_node(gust)
        found = []
        for rate in (0.0, _RATE, 0.0):
            node.set_double_value(rate)
            aircraft.advance(1)
            found.append(aircraft._fdm.get_property_value(acceleration))
        if not found[1] - (found[0] + found[2]) / 2.0 > _DAMPING * _RATE:
            raise InputError(
                f"the property {gust} does not take the aircraft along",
                allowed="the aerodynamics see the aircraft's rate less the air's",
            )


def _fly(aircraft: Aircraft, start: AircraftState) -> None:
    """A second hands off, then a roll to the right: finite, level, and with the sign that it was told."""
    try:
        aircraft.start(start.lat, start.lon, start.height, 0.0, start.airspeed)
        _advance(aircraft, _STEADY_S)
        held = aircraft.state()
        aircraft.command_roll(held.roll + _ROLL)
        _advance(aircraft, _ROLLING_S)
        rolled = aircraft.state()
    except RunFailure as failure:
        raise InputError(str(failure), allowed="a flight with the autopilot on") from failure
    if abs(held.height - start.height) > 10.0 or abs(held.airspeed - start.airspeed) > 3.0:
        raise InputError(
            f"the autopilot lost {start.height - held.height:.1f} m and {start.airspeed - held.airspeed:.1f} m/s "
            f"in {_STEADY_S:g} s of still air",
            allowed="below 10 m and 3 m/s",
        )
    turned = math.degrees(rolled.roll - held.roll)
    if not 0.2 < turned / math.degrees(_ROLL) < 2.0:
        raise InputError(
            f"the autopilot rolled by {turned:.1f} deg in {_ROLLING_S:g} s, ap/roll-cmd-rad rose by "
            f"{math.degrees(_ROLL):.1f} deg",
            allowed="the same roll, right wing down positive",
        )


def _advance(aircraft: Aircraft, seconds: float) -> None:
    for _ in range(math.ceil(seconds * aircraft.step_rate)):
        aircraft.advance(1)
        if not all(math.isfinite(value) for value in aircraft.state()):
            raise InputError(f"not finite after {aircraft.steps * aircraft.step_period:.2f} s of flight")
