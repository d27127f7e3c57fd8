"""Where the rows look: ground vectors per height, in a level frame whose north is the gyro's."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from aerosim.estimation.tracking.rays import SHARE, SPREAD
from aerosim.frames import Array

# columns of the attitude ring
TIME, ROLL, PITCH, YAW, MOUNT, TURNED, PUSHED = range(7)


@njit(cache=True)
def attitude(roll: float, pitch: float, yaw: float, level: float, mount: float) -> Array:  # pragma: no cover
    """Camera to level frame, (3, 3): Rz(yaw) Ry(pitch) Rx(roll) of the airframe, Ry(level) Rz(mount)."""
    sr, cr, sp, cp = np.sin(roll), np.cos(roll), np.sin(pitch), np.cos(pitch)
    sh, ch, sl, cl = np.sin(yaw), np.cos(yaw), np.sin(level), np.cos(level)
    sy, cy = np.sin(mount), np.cos(mount)
    b = np.array(
        [
            [ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr],
            [sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    m = np.array([[cl * cy, -cl * sy, sl], [sy, cy, 0.0], [-sl * cy, sl * sy, cl]])
    out = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                out[i, j] += b[i, k] * m[k, j]
    return out


@njit(cache=True)
def ground(mat: Array, x: float, y: float, focal: float) -> tuple[float, float]:  # pragma: no cover - compiled
    """Where the ray of an image point (x to the front, y right, px) meets the plane one height below: (2,)."""
    down = mat[2, 0] * x + mat[2, 1] * y + mat[2, 2] * focal
    ahead = mat[0, 0] * x + mat[0, 1] * y + mat[0, 2] * focal
    right = mat[1, 0] * x + mat[1, 1] * y + mat[1, 2] * focal
    return ahead / down, right / down


@njit(cache=True)
def looks(rays: Array, place: float) -> tuple[float, float]:  # pragma: no cover - compiled
    """Ray of a place in a row, from its first pixel: between two pixels, or carried on beyond the ends."""
    k = min(max(int(np.floor(place)), 0), rays.shape[1] - 2)
    part = place - k
    return (
        rays[0, k] + part * (rays[0, k + 1] - rays[0, k]),
        rays[1, k] + part * (rays[1, k + 1] - rays[1, k]),
    )


@njit(cache=True)
def passed(
    at1: Array, at2: Array, mu: float, level: float, rays1: Array, rays2: Array, focal: float
) -> tuple[float, float]:  # pragma: no cover - compiled
    """Way of the camera over height between two exposures that saw the same ground shifted by mu, (2,).

    at1, at2: rows of the attitude ring.  rays1, rays2: see `Rays`.  Row I looked ahead at at1, row II back at at2;
    the mean over SPREAD pixels of the row, so that a rotation between the two drops out.
    """
    mat1 = attitude(at1[ROLL], at1[PITCH], at1[YAW], level, at1[MOUNT])
    mat2 = attitude(at2[ROLL], at2[PITCH], at2[YAW], level, at2[MOUNT])
    north, east = 0.0, 0.0
    pixels = rays2.shape[1]
    margin, middle = (rays1.shape[1] - pixels) // 2, (pixels - 1) / 2.0
    for k in range(SPREAD):
        i = middle + pixels * SHARE * (k / (SPREAD - 1.0) - 0.5)
        x1, y1 = looks(rays1, margin + i + mu)
        x2, y2 = looks(rays2, i)
        a, b = ground(mat1, x1, y1, focal)
        c, d = ground(mat2, x2, y2, focal)
        north += (a - c) / SPREAD
        east += (b - d) / SPREAD
    return north, east


@njit(cache=True)
def between(ring: Array, number: float) -> Array:  # pragma: no cover - compiled
    """Row of the attitude ring at an exposure number that may lie between two exposures."""
    k = int(np.floor(number))
    a, b = ring[k % ring.shape[0]], ring[(k + 1) % ring.shape[0]]
    out: Array = a + (number - k) * (b - a)
    return out


@njit(cache=True)
def ahead(at: Array, spacing: float, focal: float, level: float) -> tuple[float, float]:  # pragma: no cover
    """Where the middle of row I looks at a row of the attitude ring, north and east of the camera over height."""
    return ground(attitude(at[ROLL], at[PITCH], at[YAW], level, at[MOUNT]), 0.5 * spacing, 0.0, focal)


@njit(cache=True)
def mismatch(
    ring: Array,
    number: int,
    number1: NDArray[np.int64],
    seen: Array,
    track: float,
    speed: float,
    spacing: float,
    focal: float,
    level: float,
    out: Array,
) -> None:  # pragma: no cover - compiled
    """By how much row II misses the ground of strips in flight now: along and across the camera, px.

    number: exposure now.  number1: (strips,) exposure of each strip's row I, negative: none.  seen: (strips, 2),
    where it looked, see `ahead`.  track (rad) and speed (1/s): estimates of track and v/h less what accelerations
    have added.  out: (strips, 2), filled: along > 0: the ground is still ahead of row II; across: the shift mu at
    which it will be met.
    """
    now = ring[number % ring.shape[0]]
    mat_now = attitude(now[ROLL], now[PITCH], now[YAW], level, now[MOUNT])
    behind_n, behind_e = ground(mat_now, -0.5 * spacing, 0.0, focal)
    heading = np.arctan2(mat_now[1, 0], mat_now[0, 0])
    ch, sh = np.cos(heading), np.sin(heading)
    for s in range(number1.shape[0]):
        if number1[s] < 0:
            continue
        then = ring[number1[s] % ring.shape[0]]
        span = now[TIME] - then[TIME]
        if span <= 0.0:
            out[s, 0], out[s, 1] = spacing, 0.0
            continue
        angle = track + (now[TURNED] - then[TURNED]) / span
        way = speed * np.exp((now[PUSHED] - then[PUSHED]) / span) * span
        north, east = seen[s, 0] - behind_n - way * np.cos(angle), seen[s, 1] - behind_e - way * np.sin(angle)
        out[s, 0] = focal * (ch * north + sh * east)
        # row I index = row II index + mu: the ground of row II's middle lies -east px right of row I's
        out[s, 1] = -focal * (-sh * north + ch * east)
