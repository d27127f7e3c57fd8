"""What can be said of a mission before it is flown: lines, times, drift, photos.  For `aerosim check`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from aerosim.frames import Array, MapGrid
from aerosim.projection import Camera

if TYPE_CHECKING:
    from aerosim.flight.plan import FlightPlan, Forecast, Line
    from aerosim.scenario.scenario import Scenario
    from aerosim.world.terrain import Terrain

# Columns of telemetry.parquet, 8 bytes each before compression.
TELEMETRY_BYTES = 31 * 8


def forecast(scenario: Scenario) -> dict[str, Any]:
    """Forecast of a scenario's flight in its steady wind, keys with their units; what is unknown is None.

    Nested one level: flight, photos, rows, storage, and a list of lines.  Durations include run-ins and turns.
    Drift is track less heading (wind triangle), crab what the controller and the mount's limit leave of it; v/h,
    photo interval and GSD are over the mean terrain of each line's photos; gsd_min_m and gsd_max_m over their
    highest and lowest ground; blur is the image motion during the exposure without forward-motion compensation,
    in pixels; photos_outside_m: how far the outermost photos reach beyond the terrain.  Slow wind, gusts and tilt
    are left out.  Mode `fixed` keeps the interval of the planned v/h, which knows no wind, and leaves all drift.
    Raises InputError for whatever cannot be flown, with the place of its key.
    """
    from aerosim.scenario.build import at, camera_of, plan_of, planned_n, planned_vh, steady_wind, terrain_of

    terrain = terrain_of(scenario)
    plan, ground = plan_of(scenario, terrain)
    _check_aircraft(scenario, plan)
    with at(scenario, "air.wind"):
        flown = plan.forecast(*steady_wind(scenario)[:2])
    camera, vh = camera_of(scenario), planned_vh(plan, ground)
    lines = []
    for index in range(len(plan.lines)):
        with at(scenario, f"flight.lines.{index}"):
            lines.append(_line(scenario, plan, flown, index, terrain, camera, vh))
    count = sum(line["photos"] for line in lines)
    return {
        "name": scenario.name,
        "flight": {
            "duration_s": flown.duration,
            "lines": len(lines),
            "line_length_m": sum(line["length_m"] for line in lines),
            "turns_s": list(flown.turn_s),
            "height_m": plan.height,
            "terrain_mean_height_m": ground,
            "airspeed_m_s": plan.airspeed,
        },
        "lines": lines,
        "photos": _photos(scenario, camera, plan.height - ground, count),
        "rows": {"planned_vh_per_s": vh, "planned_n": planned_n(scenario, vh)},
        "storage": _storage(scenario, camera, flown.duration, count),
    }


def _check_aircraft(scenario: Scenario, plan: FlightPlan) -> None:
    from aerosim.flight.limits import Limits
    from aerosim.scenario.build import aircraft_folder, at

    limits = Limits.read(aircraft_folder(scenario) / "limits.yaml")
    with at(scenario, "aircraft.fuel_kg"):
        limits.check_fuel(scenario.aircraft.fuel_kg)
    with at(scenario, "flight.airspeed_m_s"):
        limits.check_speed(plan.height, plan.airspeed, limits.mass_empty_kg + scenario.aircraft.fuel_kg)


def _line(
    scenario: Scenario,
    plan: FlightPlan,
    flown: Forecast,
    index: int,
    terrain: Terrain,
    camera: Camera,
    planned_vh: float,
) -> dict[str, Any]:
    """Forecast of one line."""
    line, speed, drift = plan.lines[index], flown.ground_speed[index], flown.drift[index]
    half = 0.5 * camera.cols / camera.focal_px * _above_ground(terrain, line, plan.height)
    east, north = terrain.grid.from_geodetic(*np.transpose([line.start, line.end]))
    heights = terrain.mean_height(east, north, half)
    agl, follows = plan.height - heights.mean, scenario.control.mode != "fixed"
    limit = math.radians(scenario.mount.yaw_limit_deg) if follows else 0.0
    interval = _interval(scenario, camera, speed / agl if follows else planned_vh)
    base, ahead = interval * speed, camera.rows / camera.focal_px
    outline = _outermost(terrain.grid, line, 0.5 * ahead * agl, half)
    return {
        "course_deg": math.degrees(line.course) % 360.0,
        "length_m": line.length,
        "duration_s": flown.line_s[index],
        "drift_deg": math.degrees(drift),
        "crab_deg": math.degrees(math.copysign(max(abs(drift) - limit, 0.0), drift)),
        "ground_speed_m_s": speed,
        "vh_per_s": speed / agl,
        "photo_interval_s": interval,
        "photos": math.floor(flown.line_s[index] / interval) + 1,
        "photo_base_m": base,
        "end_lap_pct": 100.0 * (1.0 - base / (ahead * agl)),
        "end_lap_highest_ground_pct": 100.0 * (1.0 - base / (ahead * (plan.height - heights.high))),
        "terrain_mean_height_m": heights.mean,
        "terrain_min_height_m": heights.low,
        "terrain_max_height_m": heights.high,
        "gsd_m": agl / camera.focal_px,
        "gsd_min_m": (plan.height - heights.high) / camera.focal_px,
        "gsd_max_m": (plan.height - heights.low) / camera.focal_px,
        "blur_without_fmc_px": speed * scenario.frame_camera.exposure_s / (agl / camera.focal_px),
        "photos_outside_m": float(terrain.shortfall(*outline.T).max()),
    }


def _interval(scenario: Scenario, camera: Camera, vh: float) -> float:
    """Time between photos at this v/h (1/s), s: that of the wanted end lap, or the camera's shortest."""
    base_ratio = (1.0 - scenario.control.end_lap_pct / 100.0) * camera.rows / camera.focal_px
    return max(base_ratio / vh, scenario.frame_camera.min_interval_s)


def _above_ground(terrain: Terrain, line: Line, height: float) -> float:
    """Height (m) over the mean of the ground right below a line."""
    east, north = terrain.grid.from_geodetic(*np.transpose([line.start, line.end]))
    return height - terrain.mean_height(east, north, 100.0).mean


def _outermost(grid: MapGrid, line: Line, along: float, across: float) -> Array:
    """Corners (4, 2) easting, northing, m, of the ground of a line's photos.  along, across: half a photo, m."""
    ends = np.column_stack(grid.from_geodetic(*np.transpose([line.start, line.end])))
    ahead = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    right = np.array([ahead[1], -ahead[0]])
    first, last = ends[0] - along * ahead, ends[1] + along * ahead
    return np.array([end + side * across * right for end in (first, last) for side in (-1.0, 1.0)])


def _photos(scenario: Scenario, camera: Camera, agl: float, count: int) -> dict[str, Any]:
    return {
        "count": count,
        "rows_px": camera.rows,
        "columns_px": camera.cols,
        "footprint_along_m": agl * camera.rows / camera.focal_px,
        "footprint_across_m": agl * camera.cols / camera.focal_px,
        "gsd_m": agl / camera.focal_px,
        "wanted_end_lap_pct": scenario.control.end_lap_pct,
        "side_lap_pct": None,
        "written": scenario.frame_camera.write,
    }


def _storage(scenario: Scenario, camera: Camera, duration: float, count: int) -> dict[str, Any]:
    """Upper bounds, uncompressed.  Pictures: grey of 8 bits; None if they are not written."""
    pictures = count * camera.rows * camera.cols / 1e6 if scenario.frame_camera.write else None
    return {"telemetry_mb": duration / scenario.record.period_s * TELEMETRY_BYTES / 1e6, "pictures_mb": pictures}
