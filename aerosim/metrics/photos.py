"""Photos as geometry: the table photos.parquet out of the shots of a flight."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from aerosim.frames import Array, attitude_from_mat, geodetic_from_ecef, wrap_pi
from aerosim.metrics.blur import blur
from aerosim.metrics.end_lap import end_lap, end_lap_terrain
from aerosim.metrics.footprint import Footprint, Ground, Patch, Relief, View, footprint
from aerosim.projection import Camera
from aerosim.truth import Shot

CORNERS = ("front_left", "front_right", "rear_right", "rear_left")


class Tolerances(NamedTuple):
    """What a photo may be off.  end_lap: from the wanted one, as a share; tilt, crab: rad; blur: px."""

    end_lap: float
    tilt: float
    crab: float
    blur: float


# Practice of the period: end lap 60 +- 5 % and tilt at most 3 deg (specifications of mapping organisations,
# inquiry of the International Society for Photogrammetry), half a pixel of blur (the cameras' makers).  They give
# no figure for crab; 5 deg is ours: it turns 8.7 % of a square picture's width out of the strip.
PERIOD_PRACTICE = Tolerances(end_lap=0.05, tilt=math.radians(3.0), crab=math.radians(5.0), blur=0.5)


class _Measures(NamedTuple):
    """Figures of one photo.  SI, rad; laps as shares."""

    ground: Footprint
    lap: float
    lap_terrain: float
    crab: float
    tilt: float
    blur: float
    gsd: float


def photo_table(
    shots: Sequence[Shot],
    camera: Camera,
    exposure: float,
    ground: Ground,
    *,
    wanted_end_lap: float = 0.6,
    tolerances: Tolerances = PERIOD_PRACTICE,
) -> dict[str, Any]:
    """Columns of photos.parquet, each as long as the shots, which are in order of time.

    camera: of the pictures whose pixels count; exposure: s; ground: relief in ellipsoidal heights;
    wanted_end_lap: share.  Definitions: `end_lap`, `end_lap_terrain`, `blur`; crab = track - camera heading, the
    latter from 0 to 360 deg; tilt: of the optical axis against the vertical; gsd: height above the footprint's
    mean height over focal_px.
    Numbers are arrays with NaN for what is not there: measured and smoothed poses, end lap of a line's first photo
    and in turns (line -1), ground outside of the terrain.  `verdict`: list, ok or the first of outside_terrain,
    end_lap, tilt, crab, blur that is out of tolerance; `file`: list of None, no picture is written yet.
    Raises InputError for a flight over a region too large for its map grid, RunFailure if the relief cannot be
    read.
    """
    measures = _measure(shots, camera, exposure, ground) if shots else []
    table = _pose_columns(shots)
    table["interval_s"] = np.array([shot.interval for shot in shots], float)
    table["end_lap_pct"] = 100.0 * np.array([m.lap for m in measures])
    table["end_lap_terrain_pct"] = 100.0 * np.array([m.lap_terrain for m in measures])
    table["crab_deg"] = np.degrees([m.crab for m in measures])
    table["tilt_deg"] = np.degrees([m.tilt for m in measures])
    table["blur_px"] = np.array([m.blur for m in measures])
    table["fmc_deg_s"] = np.degrees([shot.fmc_rate for shot in shots])
    table["gsd_m"] = np.array([m.gsd for m in measures])
    table.update(_corner_columns(shots, camera, measures))
    table["terrain_mean_height_m"] = np.array([m.ground.mean_height for m in measures])
    table["verdict"] = [_verdict(m, wanted_end_lap, tolerances) for m in measures]
    table["file"] = [None] * len(shots)
    return table


def _measure(shots: Sequence[Shot], camera: Camera, exposure: float, ground: Ground) -> list[_Measures]:
    lat, lon = np.transpose([(shot.pose.lat, shot.pose.lon) for shot in shots])
    relief = Relief(ground, lat, lon)
    found: list[_Measures] = []
    last, last_line = None, -1
    for shot in shots:
        view = View(camera, shot.pose)
        previous = last if shot.line >= 0 and shot.line == last_line else None
        found.append(_measure_one(shot, view, previous, relief.under(view), exposure))
        last, last_line = view, shot.line
    return found


def _measure_one(shot: Shot, view: View, previous: View | None, patch: Patch | None, exposure: float) -> _Measures:
    pose = shot.pose
    seen = footprint(view, patch)
    heading = math.atan2(pose.mat_nc[1, 0], pose.mat_nc[0, 0])
    ground_n = np.vstack([seen.corners_n, seen.centre_n])
    laps = (math.nan, math.nan)
    if previous is not None and patch is not None:
        laps = end_lap(view, previous, seen.mean_height), end_lap_terrain(view, previous, patch)
    return _Measures(
        seen,
        *laps,
        crab=float(wrap_pi(math.atan2(pose.vel_n[1], pose.vel_n[0]) - heading)),
        tilt=math.atan2(math.hypot(pose.mat_nc[0, 2], pose.mat_nc[1, 2]), pose.mat_nc[2, 2]),
        blur=blur(view.camera, pose, ground_n, exposure, shot.fmc_rate),
        gsd=(pose.height - seen.mean_height) / view.camera.focal_px,
    )


def _pose_columns(shots: Sequence[Shot]) -> dict[str, Any]:
    """Number, time, line, and the three poses; measured and smoothed ones need navigation devices."""
    poses = [shot.pose for shot in shots]
    heading, pitch, roll = attitude_from_mat(np.array([p.mat_nc for p in poses]).reshape(-1, 3, 3))
    table: dict[str, Any] = {
        "photo": np.arange(len(shots)),
        "t_s": np.array([p.t for p in poses], float),
        "line": np.array([shot.line for shot in shots], np.int64),
        "lat_true_deg": np.degrees([p.lat for p in poses]),
        "lon_true_deg": np.degrees([p.lon for p in poses]),
        "height_true_m": np.array([p.height for p in poses], float),
        "roll_true_deg": np.degrees(roll),
        "pitch_true_deg": np.degrees(pitch),
        "heading_true_deg": np.degrees(np.mod(heading, 2.0 * np.pi)),
    }
    true = [name for name in table if "_true_" in name]
    for kind in ("measured", "smoothed"):
        table.update({name.replace("true", kind): np.full(len(shots), np.nan) for name in true})
    return table


def _corner_columns(shots: Sequence[Shot], camera: Camera, measures: list[_Measures]) -> dict[str, Array]:
    """Latitude and longitude of the footprints' corners, deg."""
    corners = [View(camera, s.pose).to_ecef(m.ground.corners_n) for s, m in zip(shots, measures, strict=True)]
    lat, lon, _ = geodetic_from_ecef(np.array(corners).reshape(-1, 4, 3))
    table = {}
    for k, name in enumerate(CORNERS):
        table[f"corner_{name}_lat_deg"] = np.degrees(lat[:, k])
        table[f"corner_{name}_lon_deg"] = np.degrees(lon[:, k])
    return table


def _verdict(found: _Measures, wanted_end_lap: float, limit: Tolerances) -> str:
    """The first thing that is out of tolerance, or ok."""
    faults = {
        "outside_terrain": not found.ground.complete,
        "end_lap": abs(found.lap - wanted_end_lap) > limit.end_lap,
        "tilt": found.tilt > limit.tilt,
        "crab": abs(found.crab) > limit.crab,
        "blur": found.blur > limit.blur,
    }
    return next((name for name, wrong in faults.items() if wrong), "ok")
