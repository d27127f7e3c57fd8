"""The flight plan of a scenario: lines given, read from a file, or laid over an area."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.flight.block import Ground, Wanted, plan_block
from aerosim.flight.plan import TURN_BANK, FlightPlan, Line
from aerosim.flight.turns import turn_radius
from aerosim.formats.files import read
from aerosim.frames import Array
from aerosim.scenario.area import Area
from aerosim.scenario.build.air import wind_field
from aerosim.scenario.build.devices import camera_of
from aerosim.scenario.build.placing import at
from aerosim.scenario.scenario import Scenario
from aerosim.world.terrain import GroundHeights, Terrain

CLEARANCE = 150.0  # m, least height above the ground under a line: the legal one over open land
CORRIDOR = 1000.0  # m, half width of the ground whose mean height the flying height is above


class Route(NamedTuple):
    """A plan and what it was made from.

    ground: mean height of the land under the lines, ellipsoidal, m.  names: of the lines.  corners: of the area,
    (n, 2) latitude, longitude, rad, None without one.
    """

    plan: FlightPlan
    ground: float
    names: tuple[str, ...]
    corners: Array | None = None

    def columns(self) -> dict[str, NDArray[Any]]:
        """Columns of lines.parquet, one row per line."""
        lines = self.plan.lines
        ends = np.degrees([[*line.start, *line.end] for line in lines])
        return {
            "line": np.arange(len(lines)),
            "name": np.array(self.names, object),
            "start_lat_deg": ends[:, 0],
            "start_lon_deg": ends[:, 1],
            "end_lat_deg": ends[:, 2],
            "end_lon_deg": ends[:, 3],
            "height_m": np.full(len(lines), self.plan.height),
            "length_m": np.array([line.length for line in lines]),
        }


def route_of(scenario: Scenario, terrain: Terrain) -> Route:
    """The flight plan over a terrain.  Raises InputError."""
    flight = scenario.flight
    if flight.area is not None:
        with at(scenario, "flight.area"):
            return _over_area(scenario, terrain, flight.area)
    lines, names, keys = given_lines(scenario)
    under = []
    for line, key in zip(lines, keys, strict=True):
        with at(scenario, key):
            under.append(ground_under(scenario, terrain, line))
    ground = float(np.average([heights.mean for heights in under], weights=[line.length for line in lines]))
    height = flight.height_m + (ground if flight.height_above == "mean_terrain" else 0.0)
    plan = _checked(scenario, lines, height, under, names)
    for line, key in zip(lines, keys, strict=True):
        with at(scenario, key):
            _check_length(scenario, line, height - ground)
    return Route(plan, ground, names)


def given_lines(scenario: Scenario) -> tuple[list[Line], tuple[str, ...], list[str]]:
    """Lines of the scenario or of its file, their names, and the key that is to blame for each."""
    flight, lines, keys = scenario.flight, [], []
    if flight.file is None:
        for index, wanted in enumerate(flight.lines or ()):
            keys.append(f"flight.lines.{index}")
            with at(scenario, keys[-1]):
                start, end = wanted.start_deg, wanted.end_deg
                lines.append(Line((radians(start[0]), radians(start[1])), (radians(end[0]), radians(end[1]))))
        return lines, tuple(str(index) for index in range(len(lines))), keys
    with at(scenario, "flight.file"):
        found = [feature for feature in read(Path(flight.file)) if feature.kind == "line"]
        if not found:
            raise InputError("holds no line", "", "lines; an area is named in flight.area.file", flight.file)
        for feature in found:
            try:
                lines.append(Line(*feature.points))
            except InputError as error:
                raise InputError(error.problem, "", error.allowed, feature.where) from error
    names = tuple(feature.name or str(index) for index, feature in enumerate(found))
    return lines, names, ["flight.file"] * len(lines)


def key_of_line(scenario: Scenario, index: int) -> str:
    """The key that is to blame for a line."""
    flight = scenario.flight
    if flight.replay is not None:
        return "flight.replay"
    return "flight.area" if flight.area else "flight.file" if flight.file else f"flight.lines.{index}"


def corners_of(area: Area) -> Array:
    """Corners of an area, (n, 2) latitude, longitude, rad.  Raises InputError."""
    if area.corners_deg is not None:
        return np.radians(area.corners_deg)
    assert area.file is not None
    found = [feature for feature in read(Path(area.file)) if feature.kind == "area"]
    if len(found) != 1:
        allowed = "one polygon; lines are named in flight.file"
        raise InputError(f"holds {len(found)} areas", "flight.area.file", allowed, area.file)
    return np.array(found[0].points)


def _plan(scenario: Scenario, lines: list[Line], height: float) -> FlightPlan:
    flight = scenario.flight
    return FlightPlan(lines, height, flight.airspeed_m_s, flight.run_in_s, radians(flight.bank_max_deg))


def _over_area(scenario: Scenario, terrain: Terrain, area: Area) -> Route:
    flight = scenario.flight
    corners = corners_of(area)
    wanted = Wanted(
        height=flight.height_m,
        above_ground=flight.height_above == "mean_terrain",
        side_lap=area.side_lap_pct / 100.0,
        side_lap_min=area.side_lap_min_pct / 100.0,
        end_lap=scenario.control.end_lap_pct / 100.0,
        course=None if area.course_deg == "auto" else radians(area.course_deg),
        beyond=area.photos_beyond,
        order=area.order,
        turn_diameter=2.0 * turn_radius(flight.airspeed_m_s, TURN_BANK * radians(flight.bank_max_deg)),
        run_in=flight.run_in_s * flight.airspeed_m_s,
    )
    cell = terrain.elevation_file.native_resolution(terrain.grid.crs)
    wind = wind_field(scenario, 0.0).at(flight.height_m)[:2]
    block = plan_block(
        corners,
        wanted,
        camera_of(scenario),
        Ground(terrain.grid, terrain.elevation, cell),
        duration=lambda lines: _plan(scenario, list(lines), flight.height_m).forecast(*wind).duration,
    )
    lines = list(block.lines)
    under = [ground_under(scenario, terrain, line) for line in lines]
    plan = _checked(scenario, lines, block.height, under, block.tracks)
    return Route(plan, block.ground, block.tracks, corners)


def ground_under(scenario: Scenario, terrain: Terrain, line: Line) -> GroundHeights:
    """Heights of the ground under a line.  Raises InputError for one that leaves the terrain."""
    east, north = terrain.grid.from_geodetic(*np.transpose([line.start, line.end]))
    outside = float(terrain.shortfall(east, north).max())
    if outside > 0.0 and scenario.terrain.outside == "fail":
        turned = ": latitude and longitude are swapped" if _fits_swapped(terrain, line) else ""
        raise InputError(
            f"the line leaves the terrain by {outside:.0f} m{turned}",
            allowed="latitude, longitude" if turned else "terrain.outside: mask flies it",
        )
    return terrain.mean_height(east, north, CORRIDOR)


def _fits_swapped(terrain: Terrain, line: Line) -> bool:
    """Whether a line would lie on the terrain with latitude and longitude exchanged."""
    lon, lat = np.transpose([line.start, line.end])
    return bool((np.abs(lat) < np.pi / 2).all()) and terrain.contains(*terrain.grid.from_geodetic(lat, lon))


def _checked(
    scenario: Scenario, lines: list[Line], height: float, under: list[GroundHeights], names: Sequence[str]
) -> FlightPlan:
    """The plan, if it keeps clear of the ground."""
    with at(scenario, "flight.height_m"):
        for name, heights in zip(names, under, strict=True):
            if height - heights.high < CLEARANCE:
                least = scenario.flight.height_m + CLEARANCE - height + heights.high
                raise InputError(
                    f"{height:.0f} m above the ellipsoid is {height - heights.high:.0f} m "
                    f"above the highest ground under line {name}",
                    allowed=f"{CLEARANCE:.0f} m and more: flight.height_m from {np.ceil(least):.0f} on",
                )
        return _plan(scenario, lines, height)


def _check_length(scenario: Scenario, line: Line, agl: float) -> None:
    """Raise InputError for a line that ends before the rows have seen any ground twice."""
    rows = scenario.ccd_rows
    least = rows.spacing_px / rows.focal_px * agl
    if line.length < least:
        raise InputError(
            f"line of {line.length:.0f} m ends before a first strip is recognised {agl:.0f} m above the ground",
            allowed=f"at least {np.ceil(least):.0f} m",
        )
