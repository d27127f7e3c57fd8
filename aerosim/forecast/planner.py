"""From a file with an area or lines to a plan and its forecast.  For `aerosim plan`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from aerosim.errors import InputError
from aerosim.flight.block import Ground, Wanted, plan_block
from aerosim.flight.plan import FlightPlan, Line
from aerosim.flight.turns import turn_radius
from aerosim.forecast.check import Area, Outlook, outlook_of
from aerosim.formats.features import Feature, read
from aerosim.frames import Array
from aerosim.scenario import Scenario, from_mapping
from aerosim.world.terrain import Terrain

CLEARANCE = 150.0  # m, as a run asks for


class AreaWanted(NamedTuple):
    """How an area is to be covered, as options say it; course_deg: None takes the least number of lines."""

    side_lap_pct: float
    side_lap_min_pct: float
    course_deg: float | None
    photos_beyond: int
    order: str


def plan_file(file: Path, settings: Mapping[str, Any], wanted: AreaWanted) -> Outlook:
    """Plan of a file with one polygon, or with lines, and its forecast.

    settings: sections of a scenario without its lines; flight.height_m is above the mean terrain, of the area or
    under the lines.  Raises InputError with the place in the file, or the key of a setting.
    """
    features = read(file)
    areas = [each for each in features if each.kind == "area"]
    if areas and len(features) > 1:
        lines = len(features) - len(areas)
        raise InputError(
            f"holds {len(areas)} areas and {lines} lines",
            where=str(file),
            allowed="one area, or nothing but lines",
        )
    if areas:
        return _area(areas[0], settings, wanted)
    return _lines(features, settings)


def _scenario(settings: Mapping[str, Any], lines: Sequence[Line], **flight: Any) -> Scenario:
    """Scenario with lines put in.  flight: more of its section."""
    ends = [
        {name: [math.degrees(angle) for angle in point] for name, point in (("start_deg", a), ("end_deg", b))}
        for a, b in ((line.start, line.end) for line in lines)
    ]
    return from_mapping({**settings, "flight": {**settings["flight"], "lines": ends, **flight}})


def _lines(features: Sequence[Feature], settings: Mapping[str, Any]) -> Outlook:
    from aerosim.forecast.check import outlook

    made = []
    for each in features:
        try:
            made.append(Line(each.points[0], each.points[1]))
        except InputError as error:
            raise error.at(where=each.where) from error
    return outlook(_scenario(settings, made))


def _area(feature: Feature, settings: Mapping[str, Any], wanted: AreaWanted) -> Outlook:
    from aerosim.scenario.build import camera_of, terrain_of

    corners = np.array(feature.points)
    # the settings are checked, and the terrain opened, with a line that is replaced
    draft = _scenario(settings, [Line(*_far_apart(corners, feature.where))])
    terrain = terrain_of(draft)
    _check_place(corners, terrain, feature.where)
    flight = draft.flight
    wind = _still_or_wind(draft)

    def plan_of(lines: Sequence[Line], height: float) -> FlightPlan:
        return FlightPlan(lines, height, flight.airspeed_m_s, flight.run_in_s, math.radians(flight.bank_max_deg))

    bank = plan_of([Line(*_far_apart(corners, feature.where))], 0.0).bank_turn
    asked = Wanted(
        height=flight.height_m,
        side_lap=wanted.side_lap_pct / 100.0,
        side_lap_min=wanted.side_lap_min_pct / 100.0,
        end_lap=draft.control.end_lap_pct / 100.0,
        course=None if wanted.course_deg is None else math.radians(wanted.course_deg),
        beyond=wanted.photos_beyond,
        order=wanted.order,  # type: ignore[arg-type]  # checked where it is used
        turn_diameter=2.0 * turn_radius(flight.airspeed_m_s, bank),
        run_in=flight.run_in_s * flight.airspeed_m_s,
    )
    ground = Ground(terrain.grid, terrain.elevation, terrain.elevation_file.native_resolution(terrain.grid.crs))
    try:
        block = plan_block(
            corners,
            asked,
            camera_of(draft),
            ground,
            duration=lambda lines: plan_of(lines, 0.0).forecast(*wind).duration,
        )
    except InputError as error:
        raise error if error.key else error.at(where=feature.where) from error
    scenario = _scenario(settings, block.lines, height_above="ellipsoid", height_m=block.height)
    plan = plan_of(block.lines, block.height)
    found = outlook_of(scenario, terrain, plan, block.ground, Area(corners, wanted.side_lap_pct), block.names)
    highest = max(line["terrain_max_height_m"] for line in found.figures["lines"])
    if plan.height - highest < CLEARANCE:
        raise InputError(
            f"{flight.height_m:g} m above the mean is {plan.height - highest:.0f} m above the highest ground",
            key="flight.height_m",
            allowed=f"{math.ceil(flight.height_m + CLEARANCE - plan.height + highest)} m and more",
        )
    return found


def _still_or_wind(scenario: Scenario) -> tuple[float, float]:
    from aerosim.scenario.build import steady_wind

    return steady_wind(scenario)[:2]


def _far_apart(corners: Array, where: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """The first corner and the one farthest from it.  Raises InputError for an area without extent."""
    away = np.hypot(*(corners - corners[0]).T)
    first, last = (tuple(float(v) for v in corners[k]) for k in (0, int(np.argmax(away))))
    if float(away.max()) < 1e-7:
        raise InputError("polygon with an area of zero", where=where)
    return (first[0], first[1]), (last[0], last[1])


def _check_place(corners: Array, terrain: Terrain, where: str) -> None:
    """Raise InputError for corners beyond the terrain, with a guess at the reason."""
    beyond = terrain.shortfall(*terrain.grid.from_geodetic(*corners.T))
    if not beyond.max() > 0.0:
        return
    swapped = terrain.contains(*terrain.grid.from_geodetic(*corners[:, ::-1].T))
    number = int(np.argmax(beyond))
    raise InputError(
        f"corner {number} lies {beyond[number]:.0f} m beyond the terrain"
        + (": latitude and longitude are swapped" if swapped else ""),
        where=where,
        allowed="an area on the terrain: see aerosim terrain info",
    )
