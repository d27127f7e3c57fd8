"""What can be said of a mission before it is flown: lines, times, drift, photos.  For `aerosim check`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aerosim import polygon
from aerosim.errors import InputError
from aerosim.forecast import coverage as covered
from aerosim.forecast import side_lap
from aerosim.forecast.land import Land
from aerosim.forecast.lines import line_figures
from aerosim.forecast.shots import Shots, planned
from aerosim.forecast.steady import Steady, steady
from aerosim.forecast.trackability import Stations, line_strips, stations
from aerosim.forecast.warned import warnings
from aerosim.frames import Array

if TYPE_CHECKING:
    from aerosim.flight.plan import FlightPlan, Forecast
    from aerosim.flight.replay.replay import Replay
    from aerosim.projection import Camera
    from aerosim.scenario.build import Route
    from aerosim.scenario.scenario import Scenario
    from aerosim.world.terrain import Terrain

# Columns of telemetry.parquet, 8 bytes each before compression.
TELEMETRY_BYTES = 31 * 8
PATH_POINTS = 3000


class Outlook(NamedTuple):
    """A plan with all that was found out about it.

    figures: as `forecast` returns them; wind: where it goes to, north, east, m/s; ring: outline of the counted
    area on the plane of the land, (n, 2), m, None if there is none; names: of the lines; seen: photos
    that see each cell of that area; track: what the rows will make of the land; path: of a replay, on the plane,
    (n, 2), m.
    """

    figures: dict[str, Any]
    plan: FlightPlan
    wind: tuple[float, float]
    land: Land
    terrain: Terrain
    shots: Shots
    ring: Array | None
    names: tuple[str, ...]
    seen: covered.Coverage | None
    track: Stations
    path: Array | None = None


def forecast(scenario: Scenario) -> dict[str, Any]:
    """Forecast of a scenario's flight in its steady wind, keys with their units; what is unknown is None.

    Nested one level: flight, photos, rows, storage, coverage, and lists of lines, side laps of neighbouring lines,
    warnings.  Durations include run-ins and turns.  Drift is track less heading (wind triangle), crab what the
    controller and the mount's limit leave of it; v/h, photo interval and GSD are over the mean terrain of each
    line's photos; gsd_min_m and gsd_max_m over their highest and lowest ground; blur_without_fmc_px is the image
    motion during the exposure, blur_px what forward-motion compensation, if it is on, leaves of it over the
    relief; photos_outside_m: how far the outermost photos reach beyond the terrain.  Coverage is of the area of
    the scenario, or of the hull of its lines.  Slow wind, gusts and tilt are left out.  Mode `fixed` keeps the
    interval of the planned v/h, which knows no wind, and leaves all drift.
    Raises InputError for whatever cannot be flown, with the place of its key.
    """
    return outlook(scenario).figures


def outlook(scenario: Scenario) -> Outlook:
    """Forecast of a scenario with the geometry behind it.  Raises InputError as `forecast`."""
    from aerosim.scenario.build import at, replayed, route_of, terrain_of
    from aerosim.scenario.build.air import air_of
    from aerosim.scenario.build.journey import REPLAY_SPAN
    from aerosim.world.air import AIR_RATE_HZ

    terrain = terrain_of(scenario)
    if scenario.flight.replay is not None:
        replay, route = replayed(scenario, terrain)
        wind = _wind(scenario, route)
        air_of(scenario, route.plan, route.ground, REPLAY_SPAN, 1.0 / AIR_RATE_HZ)
        found = _outlook(scenario, terrain, route, wind, replay.forecast(*wind), None)
        return found._replace(path=_path(found.land, replay))
    route = route_of(scenario, terrain)
    wind = _wind(scenario, route)
    with at(scenario, "air.wind"):
        flown = route.plan.forecast(*wind)
    return _outlook(scenario, terrain, route, wind, flown, steady(scenario, route, wind))


def _outlook(
    scenario: Scenario,
    terrain: Terrain,
    route: Route,
    wind: tuple[float, float],
    flown: Forecast,
    aircraft: Steady | None,
) -> Outlook:
    """Forecast of a route over its terrain.  aircraft: None if none is known."""
    from aerosim.scenario.build import at, camera_of, planned_vh, with_table
    from aerosim.scenario.build.observing import check_arithmetic
    from aerosim.scenario.build.route import key_of_line

    plan, ground, area = route.plan, route.ground, scenario.flight.area
    camera, vh = camera_of(scenario), planned_vh(plan, ground)
    check_arithmetic(with_table(scenario, plan.height - ground), vh)  # what a run refuses, a forecast does
    land = Land(plan, terrain, camera, route.corners)
    lines = []
    for index in range(len(plan.lines)):
        with at(scenario, key_of_line(scenario, index)):
            lines.append(line_figures(scenario, plan, flown, index, land, terrain, camera, vh))
    shots = planned(
        land,
        [line["photos"] for line in lines],
        [line["photo_base_m"] for line in lines],
        [math.radians(line["crab_deg"]) for line in lines],
    )
    # what lies between the lines of a trajectory was not meant to be covered
    ring = _ring(land, plan, route.corners) if scenario.flight.replay is None else None
    track = stations(scenario, plan, land, terrain, ground)
    lines = [
        {"name": name, **line, **line_strips(track, index)}
        for index, (name, line) in enumerate(zip(route.names, lines, strict=True))
    ]
    asked = None if area is None else ring  # the hull of given lines is nobody's area
    pairs = side_lap.figures(land, side_lap.pairs(land, asked), route.names)
    seen = None if ring is None else covered.coverage(land, shots, ring)
    found: dict[str, Any] = {
        "name": scenario.name,
        "flight": _flight(plan, flown, ground, aircraft),
        "air": _air(scenario, route),
        "lines": lines,
        "photos": _photos(scenario, camera, plan.height - ground, lines, pairs),
        "side_lap": pairs or None,
        "coverage": None if seen is None else covered.figures(land, seen),
        "rows": _rows(scenario, vh),
        "storage": _storage(scenario, camera, flown.duration, sum(line["photos"] for line in lines)),
    }
    found["warnings"] = warnings(scenario, found)
    return Outlook(found, plan, wind, land, terrain, shots, ring, route.names, seen, track)


def _wind(scenario: Scenario, route: Route) -> tuple[float, float]:
    """The wind of the forecast, where it goes to, north and east, m/s: the mean one at the planned height."""
    from aerosim.scenario.build import mean_wind

    return mean_wind(scenario, route.plan, route.ground)[:2]


def _ring(land: Land, plan: FlightPlan, corners: Array | None) -> Array | None:
    """Outline of the area that is counted, on the plane, (n, 2), m: as asked for, or the hull of the lines."""
    if corners is not None:
        return polygon.ring_of(land.plane.to_plane(corners))
    ends = land.plane.to_plane([point for line in plan.lines for point in (line.start, line.end)])
    try:
        return polygon.ring_of(polygon.hull(ends))
    except InputError:  # a single line, or lines on one track
        return None


def _path(land: Land, replay: Replay) -> Array:
    """The way that a replay flies, on the plane, (n, 2), m."""
    lat, lon = replay.path.place(np.linspace(replay.begin, replay.end, PATH_POINTS))[:2]
    return land.plane.to_plane(np.column_stack([lat, lon]))


def _flight(plan: FlightPlan, flown: Forecast, ground: float, aircraft: Steady | None) -> dict[str, Any]:
    trim = None if aircraft is None else aircraft.trim
    return {
        "duration_s": flown.duration,
        "lines": len(plan.lines),
        "line_length_m": sum(line.length for line in plan.lines),
        "turns_s": list(flown.turn_s),
        "height_m": plan.height,
        "terrain_mean_height_m": ground,
        "airspeed_m_s": plan.airspeed,
        "pitch_deg": None if trim is None else math.degrees(trim.pitch),
        "power_kw": None if trim is None else trim.power / 1e3,
        "power_available_kw": None if trim is None else trim.power_available / 1e3,
        "fuel_kg": None if aircraft is None else aircraft.fuel,
        "fuel_flow_kg_h": None if aircraft is None else 3600.0 * aircraft.fuel_flow,
        "fuel_needed_kg": None if aircraft is None else aircraft.fuel_flow * flown.duration,
    }


def _air(scenario: Scenario, route: Route) -> dict[str, Any]:
    """Section `air`: what holds on the whole flight at its height."""
    from aerosim.scenario.build.air import turbulence_of

    turbulence = turbulence_of(scenario, route.plan, route.ground)
    return {
        "turbulence_sigma_u_m_s": turbulence.sigma_u,
        "turbulence_sigma_w_m_s": turbulence.sigma_w,
        "turbulence_length_u_m": turbulence.length_u,
        "turbulence_length_w_m": turbulence.length_w,
    }


def _photos(
    scenario: Scenario, camera: Camera, agl: float, lines: list[dict[str, Any]], pairs: list[dict[str, Any]]
) -> dict[str, Any]:
    """Figures of all photos; intervals as wanted, whether the camera is fast enough or not."""
    wanted = [line["photo_interval_wanted_s"] for line in lines]
    laps = [pair["side_lap_mean_pct"] for pair in pairs if pair["side_lap_mean_pct"] is not None]
    least = [pair["side_lap_min_pct"] for pair in pairs if pair["side_lap_min_pct"] is not None]
    return {
        "count": sum(line["photos"] for line in lines),
        "rows_px": camera.rows,
        "columns_px": camera.cols,
        "footprint_along_m": agl * camera.rows / camera.focal_px,
        "footprint_across_m": agl * camera.cols / camera.focal_px,
        "gsd_m": agl / camera.focal_px,
        "gsd_min_m": min(line["gsd_min_m"] for line in lines),
        "gsd_max_m": max(line["gsd_max_m"] for line in lines),
        "wanted_end_lap_pct": scenario.control.end_lap_pct,
        "interval_wanted_min_s": min(wanted),
        "interval_wanted_max_s": max(wanted),
        "rate_wanted_max_per_min": 60.0 / min(wanted),
        "rate_wanted_min_per_min": 60.0 / max(wanted),
        "rate_camera_per_min": 60.0 / scenario.frame_camera.min_interval_s,
        "side_lap_mean_pct": float(np.mean(laps)) if laps else None,
        "side_lap_min_pct": min(least) if least else None,
        "written": scenario.frame_camera.write,
    }


def _rows(scenario: Scenario, vh: float) -> dict[str, Any]:
    from aerosim.scenario.build import planned_n

    return {"planned_vh_per_s": vh, "planned_n": planned_n(scenario, vh)}


def _storage(scenario: Scenario, camera: Camera, duration: float, count: int) -> dict[str, Any]:
    """Upper bounds, uncompressed.  Pictures: grey of 8 bits, whether they are written or not."""
    picture = camera.rows * camera.cols / 1e6
    return {
        "telemetry_mb": duration / scenario.record.period_s * TELEMETRY_BYTES / 1e6,
        "picture_mb": picture,
        "pictures_mb": count * picture,
    }
