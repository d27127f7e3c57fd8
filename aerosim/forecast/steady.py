"""The aircraft of a plan in steady flight: trim and fuel flow."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from aerosim.errors import RunFailure

if TYPE_CHECKING:
    from aerosim.flight.trim import Trim
    from aerosim.scenario.build import Route
    from aerosim.scenario.scenario import Scenario

FLOWN_S = 1.0


class Steady(NamedTuple):
    """Trim at the start of the first line; fuel: carried, kg; fuel_flow: in level flight, kg/s."""

    trim: Trim
    fuel: float
    fuel_flow: float


def steady(scenario: Scenario, route: Route, wind: tuple[float, float]) -> Steady:
    """Steady flight on a route's first line.  wind: where it goes to, north, east, m/s.

    Any model tells its fuel flow: it is flown for a second.  The air is made as for a flight, so that whatever
    it refuses is refused here.  Raises InputError for speeds, heights, fuel, power, air.
    """
    from aerosim.scenario.build import aircraft_of, at
    from aerosim.scenario.build.air import air_of
    from aerosim.world.air import AIR_RATE_HZ

    plan, aircraft = route.plan, aircraft_of(scenario)
    first = plan.lines[0]
    with at(scenario, "flight.airspeed_m_s"):
        aircraft.check_speed(plan.height, plan.airspeed)
        air_of(scenario, plan, route.ground, aircraft.span, 1.0 / AIR_RATE_HZ)
        trim = aircraft.start(*first.start, plan.height, first.course, plan.airspeed, (*wind, 0.0))
    fuel = aircraft.fuel
    try:
        aircraft.advance(max(round(FLOWN_S * aircraft.step_rate), 1))
    except RunFailure as error:
        raise scenario.error("aircraft", f"does not keep level: {error}", "") from error
    flown = aircraft.steps * aircraft.step_period
    return Steady(trim, fuel, (fuel - aircraft.fuel) / flown)
