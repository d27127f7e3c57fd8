"""The flight of a scenario: flown by JSBSim, or a trajectory flown again."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import radians
from typing import NamedTuple

import numpy as np

from aerosim.flight.interface import Flight, FlightSource, Sortie, fresh
from aerosim.flight.jsbsim_flight import JsbsimFlight
from aerosim.flight.navigator import Navigator, NavigatorParameters
from aerosim.flight.plan import FlightPlan, wind_triangle
from aerosim.flight.replay.replay_flight import ReplayFlight
from aerosim.flight.steering import Law, Tracking
from aerosim.frames import Array
from aerosim.rng import generator
from aerosim.scenario.build.air import air_of, mean_wind
from aerosim.scenario.build.content import content_flown, content_replayed
from aerosim.scenario.build.flight import aircraft_of
from aerosim.scenario.build.placing import at
from aerosim.scenario.build.replay import replayed
from aerosim.scenario.build.route import Route, route_of
from aerosim.scenario.scenario import Scenario
from aerosim.world.air import AIR_RATE_HZ
from aerosim.world.terrain import Terrain

# Beyond the last line's end, run-ins and turns stay within this of the lines, for the local map
MAP_MARGIN = 40_000.0
REPLAY_MARGIN = 5_000.0
# m; of a replayed aircraft nothing is known, and its rate gusts move nothing
REPLAY_SPAN = 15.0


class Journey(NamedTuple):
    """A flight, its route, how long it takes (s), and the pitch that a static mount takes out (rad).

    around: (2, n) latitude, longitude, rad, of points about which it stays within `margin`, m.
    """

    flight: Flight
    route: Route
    duration: float
    level_pitch: float
    around: Array
    margin: float


def journey_of(scenario: Scenario, terrain: Terrain, flights: FlightSource = fresh) -> Journey:
    """The flight of a scenario.  flights: where it comes from.  Raises InputError for whatever cannot be flown."""
    rate = scenario.aircraft.step_rate_hz
    hold = max(1, round(rate / AIR_RATE_HZ))
    return (_flown if scenario.flight.replay is None else _replayed)(scenario, terrain, flights, rate, hold)


def _flown(scenario: Scenario, terrain: Terrain, flights: FlightSource, rate: int, hold: int) -> Journey:
    route = route_of(scenario, terrain)
    plan = route.plan
    wind_north, wind_east, _ = mean_wind(scenario, plan, route.ground)
    with at(scenario, "air.wind"):
        for line in plan.lines:
            wind_triangle(line.course, plan.airspeed, wind_north, wind_east)
        duration = plan.forecast(wind_north, wind_east).duration

    def fly() -> JsbsimFlight:
        aircraft = aircraft_of(scenario)
        with at(scenario, "flight.airspeed_m_s"):
            aircraft.check_speed(plan.height, plan.airspeed)
        air = air_of(scenario, plan, route.ground, aircraft.span, hold / rate)
        with at(scenario, "air.wind"):
            return JsbsimFlight(aircraft, plan, air, hold, pilot_of(scenario))

    flight = flights(Sortie(rate, duration, lambda: content_flown(scenario, route)), fly)
    around = np.transpose([point for line in plan.lines for point in (line.start, line.end)])
    return Journey(flight, route, duration, flight.state().pitch, around, MAP_MARGIN)


def pilot_of(scenario: Scenario) -> Callable[[FlightPlan, float], Law]:
    """How the pilot keeps to the lines."""
    if scenario.flight.pilot == "tracking":
        return Tracking
    crew = scenario.flight.navigator
    parameters = NavigatorParameters(
        look=crew.look_s,
        look_scatter=crew.look_scatter_pct / 100.0,
        settle=crew.settle_s,
        track_sigma=radians(crew.track_sigma_deg),
        offset_sigma=crew.offset_sigma_m,
        average=crew.average_s,
        closing=crew.closing_m,
        least=crew.least_deg,
        reaction=crew.reaction_s,
        hold_sigma=radians(crew.hold_sigma_deg),
        hold_time=crew.hold_time_s,
    )
    rng = generator(scenario.seed, "flight.navigator")
    return partial(Navigator, parameters=parameters, rng=rng)


def _replayed(scenario: Scenario, terrain: Terrain, flights: FlightSource, rate: int, hold: int) -> Journey:
    replay, route = replayed(scenario, terrain)

    def fly() -> ReplayFlight:
        air = air_of(scenario, route.plan, route.ground, REPLAY_SPAN, hold / rate)
        return ReplayFlight(replay, air, hold, rate)

    flight = flights(Sortie(rate, replay.duration, lambda: content_replayed(scenario, route, replay)), fly)
    t = np.linspace(replay.begin, replay.end, 500)
    around = np.array(replay.path.place(t)[:2])
    return Journey(flight, route, replay.duration, replay.level_pitch, around, REPLAY_MARGIN)
