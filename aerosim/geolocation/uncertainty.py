"""How far off a target may be: ellipse, CE90 and LE90 from pose, angles, calibration and elevation.

Linear: a ray that errs by dS at its camera and by dv in its direction meets the ground at
dX = P (dS + R dv) + v dh / (n v), P = 1 - v n^T / (n v), with the arriving ray v, the distance R, the ground's
normal n and the error dh of its height.  Near grazing, where the ground's slope changes within the ellipse or
where further slopes lie behind the target, rays are drawn and followed to the ground instead.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerosim.errors import InputError
from aerosim.frames import WGS84_A, Array
from aerosim.geolocation.calibrated import Calibration, Sights, Sigmas, guard, sights
from aerosim.geolocation.chain import (
    NO_CORRECTION,
    ObliqueCamera,
    Poses,
    Rays,
    e_from_n,
    n_from_e,
    projection_centres,
)
from aerosim.geolocation.ground import HIT, Hits, on_height, on_relief
from aerosim.geolocation.refraction import Atmosphere
from aerosim.geolocation.relief import Relief

# 90 % of a normal variable, two-sided.
NORMAL_90 = 1.6448536
DRAWS = 200
# Drawn instead of linear: the height of the target along the ray would change by more than this part of a
# change of the ground within one sigma; or the ray is this near to the slope (sine).
CHANGES, GRAZING = 0.2, 0.1
# Targets that are drawn at once.
TARGETS = 1000


class Uncertainty(NamedTuple):
    """Of n targets; NaN for those that are no hit.

    ce90: radius of the horizontal circle about the target that holds 90 %, m; le90: 1.645 sigma of height, m;
    covariance: (n, 3, 3) north, east, down, linear, m^2; major, minor: semi-axes of the horizontal ellipse of 1
    sigma, m; azimuth: of the major axis, rad; drawn: (n,) where ce90 and le90 are of drawn rays; unseen: (n,)
    where the calibration has not seen such a geometry.
    """

    ce90: Array
    le90: Array
    covariance: Array
    major: Array
    minor: Array
    azimuth: Array
    drawn: NDArray[np.bool_]
    unseen: NDArray[np.bool_]


def circle_90(major: ArrayLike, minor: ArrayLike) -> Array:
    """Radius that holds 90 % of a bivariate normal distribution of these sigmas, any shape.

    P(r < R) = 1 - mean over theta of exp(-R^2 / (2 g^2)), g the ellipse's radius at theta; solved by Newton.
    """
    a, b = np.broadcast_arrays(np.asarray(major, float), np.asarray(minor, float))
    ratio = np.clip(b / np.where(a > 0.0, a, 1.0), 0.0, 1.0)[..., None]
    theta = (np.arange(64) + 0.5) * np.pi / 64
    g2 = np.cos(theta) ** 2 + (ratio * np.sin(theta)) ** 2
    r = NORMAL_90 + 0.5011 * ratio**2
    for _ in range(6):
        outside = np.exp(-(r**2) / (2.0 * g2))
        excess = outside.mean(axis=-1, keepdims=True) - 0.1
        r = r + excess / (r * (outside / g2).mean(axis=-1, keepdims=True))
    return np.asarray(a * r[..., 0])


def uncertainty(
    camera: ObliqueCamera,
    poses: Poses,
    pixel: ArrayLike,
    hits: Hits,
    sigmas: Sigmas,
    *,
    calibration: Calibration | None = None,
    relief: Relief | None = None,
    atmosphere: Atmosphere | None = Atmosphere.STANDARD,
    draw: Literal["auto", "never", "always"] = "auto",
    seed: int = 0,
) -> Uncertainty:
    """Errors of targets that `on_height` or `on_relief` found.

    pixel: (n, 2) row, column, px, of the hits.  calibration: with whose corrections they were found; None: without
    any.  relief: that they lie on; None: a surface of one height.  draw: which targets are computed by drawn rays;
    seed: of the draws.  Raises InputError: lengths that differ, another word for draw.
    """
    sigmas = sigmas.checked()
    if draw not in ("auto", "never", "always"):
        raise InputError(f"draw {draw!r}", allowed="auto, never, always")
    if len(hits.lat) != poses.count:
        raise InputError(f"{len(hits.lat)} hits of {poses.count} poses", allowed="one of each")
    corrections = calibration.corrections if calibration else NO_CORRECTION
    fields = calibration.fields if calibration else ("yaw",)
    root = np.linalg.cholesky(calibration.covariance) if calibration else np.zeros((1, 1))
    found = sights(camera, poses, pixel, sigmas, corrections, fields)
    found = found._replace(of_corrections=found.of_corrections @ root)
    good = hits.status == HIT
    cov, doubtful = _linear(poses, hits, sigmas, found, relief)
    half, square = 0.5 * (cov[:, 0, 0] + cov[:, 1, 1]), cov[:, 0, 0] * cov[:, 1, 1] - cov[:, 0, 1] ** 2
    apart = np.sqrt(np.maximum(half**2 - square, 0.0))
    major, minor = np.sqrt(half + apart), np.sqrt(np.maximum(half - apart, 0.0))
    azimuth = 0.5 * np.arctan2(2.0 * cov[:, 0, 1], cov[:, 0, 0] - cov[:, 1, 1])
    ce90, le90 = circle_90(major, minor), NORMAL_90 * np.sqrt(cov[:, 2, 2])
    drawn = good & ((draw == "always") | (doubtful & (draw == "auto")))
    pos_e = projection_centres(camera, poses)
    rng = np.random.default_rng(seed)
    rows = np.flatnonzero(drawn)
    for first in range(0, len(rows), TARGETS):
        some = rows[first : first + TARGETS]
        ce90[some], le90[some] = _drawn(some, pos_e, poses, hits, sigmas, found, relief, atmosphere, rng)
    unseen = guard(calibration, camera, poses, pixel, sigmas).unseen if calibration else np.zeros(len(good), bool)
    return Uncertainty(ce90, le90, cov, major, minor, azimuth, drawn, unseen)


def _linear(
    poses: Poses, hits: Hits, sigmas: Sigmas, found: Sights, relief: Relief | None
) -> tuple[Array, NDArray[np.bool_]]:
    """Covariance (n, 3, 3) north, east, down at the target, and where it is not to be trusted."""
    count = len(hits.lat)
    errors = np.concatenate(
        [
            np.broadcast_to(np.diag(sigmas.position), (count, 3, 3)),
            found.own * hits.distance[:, None, None],
            found.of_corrections * hits.distance[:, None, None],
        ],
        axis=-1,
    )
    errors = _to_target(poses, hits, errors)
    v = n_from_e(hits.lat, hits.lon, hits.arriving_e)
    flat = np.broadcast_to([0.0, 0.0, -1.0], (count, 3))
    moved = _on_ground(errors, v, flat, sigmas.elevation)
    doubtful = np.zeros(count, bool)
    if relief is not None:
        reach = np.sqrt(np.maximum((moved[:, :2] ** 2).sum(axis=(1, 2)), 1.0))
        near, far = _normals(relief, hits, 0.5 * reach), _normals(relief, hits, 1.5 * reach)
        moved = _on_ground(errors, v, near, sigmas.elevation)
        slant, other = -(near * v).sum(axis=-1), -(far * v).sum(axis=-1)
        steep = slant / np.linalg.norm(near, axis=-1) < GRAZING
        doubtful = steep | ~(np.abs(other - slant) < CHANGES * slant) | (hits.crossings > 1)
        moved = np.where((slant > 0.0)[:, None, None], moved, np.nan)
    return moved @ np.swapaxes(moved, 1, 2), doubtful


def _to_target(poses: Poses, hits: Hits, vectors: Array) -> Array:
    """Columns of (n, 3, m) in n at the cameras turned to n at the targets."""
    rows = np.swapaxes(vectors, 1, 2)
    in_e = e_from_n(poses.lat[:, None], poses.lon[:, None], rows)
    return np.swapaxes(n_from_e(hits.lat[:, None], hits.lon[:, None], in_e), 1, 2)


def _on_ground(errors: Array, v: Array, normal: Array, elevation: float) -> Array:
    """Errors (n, 3, m) of a ray moved along it onto the ground, with that of the ground itself beside them."""
    slant = (v * normal).sum(axis=-1)[:, None, None]
    along = (normal[:, None, :] @ errors) / slant
    height = v[:, :, None] * (-normal[:, 2, None, None]) * elevation / slant
    return np.concatenate([errors - v[:, :, None] * along, height], axis=-1)


def _normals(relief: Relief, hits: Hits, reach: Array) -> Array:
    """Upward normals (n, 3), north, east, down, not of unit length, of secants over `reach` m to each side."""
    d_lat, d_lon = reach / WGS84_A, reach / WGS84_A / np.maximum(np.cos(hits.lat), 1e-6)
    north = (relief.heights(hits.lat + d_lat, hits.lon) - relief.heights(hits.lat - d_lat, hits.lon)) / (
        2.0 * reach
    )
    east = (relief.heights(hits.lat, hits.lon + d_lon) - relief.heights(hits.lat, hits.lon - d_lon)) / (
        2.0 * reach
    )
    return np.stack([-north, -east, np.full(len(reach), -1.0)], axis=-1)


def _drawn(
    rows: NDArray[np.int64],
    pos_e: Array,
    poses: Poses,
    hits: Hits,
    sigmas: Sigmas,
    found: Sights,
    relief: Relief | None,
    atmosphere: Atmosphere | None,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """CE90 and LE90 of some targets from DRAWS rays each.  A ray that meets nothing counts as far off."""
    lat, lon = poses.lat[rows, None], poses.lon[rows, None]
    columns = np.concatenate([found.own, found.of_corrections], axis=-1)[rows]
    moves = rng.standard_normal((len(rows), DRAWS, columns.shape[-1])) @ np.swapaxes(columns, 1, 2)
    los = e_from_n(lat, lon, found.los_n[rows, None] + moves)
    shift = rng.standard_normal((len(rows), DRAWS, 3)) * np.asarray(sigmas.position)
    lift = sigmas.elevation * rng.standard_normal((len(rows), DRAWS))
    up = -e_from_n(hits.lat[rows], hits.lon[rows], np.broadcast_to([0.0, 0.0, 1.0], (len(rows), 3)))
    pos = pos_e[rows, None] + e_from_n(lat, lon, shift) - lift[..., None] * up[:, None]
    rays = Rays(pos.reshape(-1, 3), los.reshape(-1, 3))
    height = np.repeat(hits.height[rows], DRAWS)
    there = on_height(rays, height, atmosphere) if relief is None else on_relief(rays, relief, atmosphere)
    off = there.pos_e.reshape(len(rows), DRAWS, 3) + lift[..., None] * up[:, None] - hits.pos_e[rows, None]
    north, east, down = np.moveaxis(n_from_e(hits.lat[rows, None], hits.lon[rows, None], off), -1, 0)
    circle = np.nan_to_num(np.hypot(north, east), nan=np.inf)
    return _quantile_90(circle), _quantile_90(np.nan_to_num(np.abs(down), nan=np.inf))


def _quantile_90(values: Array) -> Array:
    """The value that 90 % of the last axis stay below, without interpolating to infinity."""
    ordered = np.sort(values, axis=-1)
    return np.asarray(ordered[..., int(np.ceil(0.9 * (values.shape[-1] + 1))) - 1])
