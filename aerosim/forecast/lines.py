"""What each line of a plan takes: times, drift, photos, scale, blur."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from aerosim.flight.plan import FlightPlan, Forecast
from aerosim.forecast.land import Land, Track
from aerosim.frames import Array
from aerosim.projection import Camera
from aerosim.scenario.scenario import Scenario
from aerosim.world.terrain import Terrain


def line_figures(
    scenario: Scenario,
    plan: FlightPlan,
    flown: Forecast,
    index: int,
    land: Land,
    terrain: Terrain,
    camera: Camera,
    planned_vh: float,
) -> dict[str, Any]:
    """Forecast of one line, keys with their units.  Raises InputError where there is no ground under it."""
    line, speed, drift = plan.lines[index], flown.ground_speed[index], flown.drift[index]
    track, across = land.tracks[index], 0.5 * camera.cols / camera.focal_px
    half = across * (plan.height - land.heights(track, 100.0).mean)
    heights = land.heights(track, half)
    agl, follows = plan.height - heights.mean, scenario.control.mode != "fixed"
    limit = math.radians(scenario.mount.yaw_limit_deg) if follows else 0.0
    wanted = base_ratio(scenario, camera) / (speed / agl if follows else planned_vh)
    interval = max(wanted, scenario.frame_camera.min_interval_s)
    base, ahead = interval * speed, camera.rows / camera.focal_px
    exposure, focal = scenario.frame_camera.exposure_s, camera.focal_px
    blur = focal * exposure * speed / agl
    # what compensation by the mean v/h, as fast as the camera can, leaves over the highest and the lowest ground
    taken = min(1.0, scenario.frame_camera.fmc_limit * agl / speed)
    left = blur * max(abs(taken - agl / (plan.height - level)) for level in (heights.high, heights.low))
    return {
        "course_deg": math.degrees(line.course) % 360.0,
        "length_m": line.length,
        "duration_s": flown.line_s[index],
        "drift_deg": math.degrees(drift),
        "drift_spread_deg": math.degrees(_spread(scenario, flown.line_s[index]) / plan.airspeed),
        "crab_deg": math.degrees(math.copysign(max(abs(drift) - limit, 0.0), drift)),
        "ground_speed_m_s": speed,
        "vh_per_s": speed / agl,
        "photo_interval_s": interval,
        "photo_interval_wanted_s": wanted,
        "photos": math.floor(flown.line_s[index] / interval) + 1,
        "photo_base_m": base,
        "end_lap_pct": 100.0 * (1.0 - base / (ahead * agl)),
        "end_lap_highest_ground_pct": 100.0 * (1.0 - base / (ahead * (plan.height - heights.high))),
        "terrain_mean_height_m": heights.mean,
        "terrain_min_height_m": heights.low,
        "terrain_max_height_m": heights.high,
        "gsd_m": agl / focal,
        "gsd_min_m": (plan.height - heights.high) / focal,
        "gsd_max_m": (plan.height - heights.low) / focal,
        "blur_without_fmc_px": blur,
        "blur_px": left if scenario.control.fmc else blur,
        "photos_outside_m": _outside(land, terrain, track, 0.5 * ahead * agl, half),
    }


def _spread(scenario: Scenario, seconds: float) -> float:
    """Standard deviation (m/s) of the mean over a line of the slow wind across it.

    Of a Gauss-Markov process with correlation time tau over T: sigma^2 2 (tau/T)^2 (T/tau - 1 + exp(-T/tau)).
    """
    slow = scenario.air.slow_wind
    ratio = seconds / slow.time_constant_s
    return slow.sigma_m_s * math.sqrt(2.0 / ratio**2 * (ratio - 1.0 + math.exp(-ratio)))


def base_ratio(scenario: Scenario, camera: Camera) -> float:
    """Way between photos over the height, from the wanted end lap."""
    return (1.0 - scenario.control.end_lap_pct / 100.0) * camera.rows / camera.focal_px


def _outside(land: Land, terrain: Terrain, track: Track, along: float, across: float) -> float:
    """How far the outermost photos reach beyond the terrain, m.  along, across: half a photo, m."""
    ends = track.start - along * track.ahead, track.start + (track.length + along) * track.ahead
    outline: Array = np.array([end + side * across * track.right for end in ends for side in (-1.0, 1.0)])
    placed = terrain.grid.from_geodetic(*np.moveaxis(land.plane.to_geodetic(outline), -1, 0))
    return float(terrain.shortfall(*placed).max())
