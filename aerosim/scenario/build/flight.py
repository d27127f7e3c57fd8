"""Plan, aircraft and air of a scenario."""

from __future__ import annotations

from math import radians
from pathlib import Path

import numpy as np

from aerosim import assets
from aerosim.errors import InputError
from aerosim.flight.plan import FlightPlan, Line
from aerosim.scenario.air import SteadyWind
from aerosim.scenario.build.placing import at
from aerosim.scenario.scenario import Scenario
from aerosim.world.air import wind_n
from aerosim.world.terrain import Terrain

CLEARANCE = 150.0  # m, least height above the ground under a line: the legal one over open land
CORRIDOR = 1000.0  # m, half width of the ground whose mean height the flying height is above


def steady_wind(scenario: Scenario) -> tuple[float, float, float]:
    """Velocity of the steady wind in n, m/s."""
    wind = scenario.air.wind
    assert isinstance(wind, SteadyWind)
    return wind_n(wind.speed_m_s, radians(wind.from_deg))


def plan_of(scenario: Scenario, terrain: Terrain) -> tuple[FlightPlan, float]:
    """The flight plan, and the mean height of the ground under its lines (ellipsoidal, m).  Raises InputError."""
    flight = scenario.flight
    lines = []
    for index, wanted in enumerate(flight.lines):
        with at(scenario, f"flight.lines.{index}"):
            start, end = wanted.start_deg, wanted.end_deg
            lines.append(Line((radians(start[0]), radians(start[1])), (radians(end[0]), radians(end[1]))))
    under = []
    for index, line in enumerate(lines):
        with at(scenario, f"flight.lines.{index}"):
            lat, lon = np.transpose([line.start, line.end])
            east, north = terrain.grid.from_geodetic(lat, lon)
            outside = float(terrain.shortfall(east, north).max())
            if outside > 0.0 and scenario.terrain.outside == "fail":
                raise InputError(
                    f"line {index} leaves the terrain by {outside:.0f} m", allowed="terrain.outside: mask flies it"
                )
            under.append(terrain.mean_height(east, north, CORRIDOR))
    ground = float(np.average([heights.mean for heights in under], weights=[line.length for line in lines]))
    height = flight.height_m + (ground if flight.height_above == "mean_terrain" else 0.0)
    with at(scenario, "flight.height_m"):
        for index, heights in enumerate(under):
            if height - heights.high < CLEARANCE:
                raise InputError(
                    f"{height:.0f} m above the ellipsoid is {height - heights.high:.0f} m "
                    f"above the highest ground under line {index}",
                    allowed=f"{CLEARANCE:.0f} m and more: flight.height_m from "
                    f"{np.ceil(flight.height_m + CLEARANCE - height + heights.high):.0f} on",
                )
        plan = FlightPlan(lines, height, flight.airspeed_m_s, flight.run_in_s, radians(flight.bank_max_deg))
    return plan, ground


def planned_vh(plan: FlightPlan, ground: float) -> float:
    """Speed-to-height ratio that the crew expects without knowing the wind, 1/s."""
    return plan.airspeed / (plan.height - ground)


def aircraft_folder(scenario: Scenario) -> Path:
    """Folder of the shipped aircraft that a scenario names.  Raises InputError."""
    root, name = assets.folder("aircraft"), scenario.aircraft.model
    names = sorted(p.parent.name for p in root.glob("*/limits.yaml"))
    if name not in names:
        raise scenario.error("aircraft.model", f"no aircraft {name!r} ships", f"allowed: {', '.join(names)}")
    return root / name
