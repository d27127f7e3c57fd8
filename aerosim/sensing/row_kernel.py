"""What a CCD row sees: rays to the relief, footprint, smear and motion, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.raster import bilinear
from aerosim.signals import Grey

EARTH_RADIUS = 6_371_000.0
STEPS = 12


@njit(cache=True, fastmath={"contract", "nsz"})
def relief_depth(
    d_north: float,
    d_east: float,
    d_down: float,
    height: float,
    guess: float,
    grid: Array,
    elevation: Grey,
    e0: float,
    n0: float,
    de: float,
    dn: float,
) -> tuple[float, float]:  # pragma: no cover - compiled
    """Length s of the ray s (d_north, d_east, d_down) to the relief, and the height there; NaN if it misses.

    grid: easting, northing of the camera and the map's Jacobian, as `LocalMap` returns them.
    Fixed point on the height, which converges for slopes below the cotangent of the view angle (here 24 deg);
    the last term lifts a point that lies s ahead by the Earth's curvature.
    """
    h = guess
    s = np.nan
    if d_down <= 0.0:
        return s, np.nan
    for _ in range(STEPS):
        level = (height - h) / d_down
        level_n, level_e = level * d_north, level * d_east
        s = level + (level_n * level_n + level_e * level_e) / (2.0 * EARTH_RADIUS * d_down)
        north, east = s * d_north, s * d_east
        found = bilinear(
            elevation,
            e0,
            n0,
            de,
            dn,
            grid[0] + grid[2] * north + grid[3] * east,
            grid[1] + grid[4] * north + grid[5] * east,
        )
        if abs(found - h) < 0.05:
            return s, found
        if np.isnan(found):
            return np.nan, np.nan
        h = found
    return s, h


@njit(cache=True, fastmath={"contract", "nsz"})
def spread(width2: float, smear2: float, motion2: float, cell2: float) -> tuple[float, float]:
    """Three-point rule (-a, 0, a; w, 1-2w, w) of box x smear x motion, right to the fifth moment.

    Arguments: squared widths of the three boxes and of the raster's cell, px^2.  The raster's own blur
    (a cell's box and the bilinear hat: cell^2/4) is taken off, since the samples bring it along.
    """  # pragma: no cover - compiled
    variance = (width2 + smear2 + motion2) / 12.0
    fourth = (width2 * width2 + smear2 * smear2 + motion2 * motion2) / 80.0 + (
        width2 * smear2 + width2 * motion2 + smear2 * motion2
    ) / 24.0
    a2 = fourth / variance
    rest = max(variance - cell2 / 4.0, 0.0)
    scale = rest / variance
    return np.sqrt(a2 * scale), variance / (2.0 * a2)


@njit(cache=True, fastmath={"contract", "nsz"})
def radiance(
    out: Array,
    ahead_px: float,
    focal_px: float,
    smear_along: float,
    smear_across: float,
    exposure: float,
    height: float,
    mat_nc: Array,
    vel_n: Array,
    omega: Array,
    grid: Array,
    ortho: Grey,
    oe0: float,
    on0: float,
    ode: float,
    odn: float,
    relief: Grey,
    re0: float,
    rn0: float,
    rde: float,
    rdn: float,
    guess: float,
) -> float:  # pragma: no cover - compiled
    """Mean radiance of each pixel of a row, in the orthophoto's grey levels; returns the mean ground height.

    out: (pixels,), filled.  ahead_px: the row's place along x of c; exposure: s; vel_n, omega: of the camera.
    Each pixel's centre is brought down to the relief; around it the picture is weighted with pixel box,
    optical smear and the motion during the exposure (`spread`), on the plane through that point.
    """
    pixels = out.shape[0]
    m = mat_nc
    total = 0.0
    h = guess
    for i in range(pixels):
        y = i - (pixels - 1) / 2.0
        d0 = m[0, 0] * ahead_px + m[0, 1] * y + m[0, 2] * focal_px
        d1 = m[1, 0] * ahead_px + m[1, 1] * y + m[1, 2] * focal_px
        d2 = m[2, 0] * ahead_px + m[2, 1] * y + m[2, 2] * focal_px
        s, found = relief_depth(d0, d1, d2, height, h, grid, relief, re0, rn0, rde, rdn)
        if np.isnan(s):
            out[i] = np.nan
            total = np.nan
            continue
        h = found
        total += h
        # ground vectors of one pixel along (x) and across (y), on the level plane through the point
        k = s / d2
        xn, xe = s * m[0, 0] - k * m[2, 0] * d0, s * m[1, 0] - k * m[2, 0] * d1
        yn, ye = s * m[0, 1] - k * m[2, 1] * d0, s * m[1, 1] - k * m[2, 1] * d1
        # how fast the footprint moves over the ground, in px/s: by the camera's path and by its rotation
        zoom = (omega[0] * y - omega[1] * ahead_px) / focal_px
        rot_x = omega[1] * focal_px - omega[2] * y - zoom * ahead_px
        rot_y = omega[2] * ahead_px - omega[0] * focal_px - zoom * y
        vn = vel_n[0] - vel_n[2] * d0 / d2
        ve = vel_n[1] - vel_n[2] * d1 / d2
        det = xn * ye - xe * yn
        move_x = ((vn * ye - ve * yn) / det + rot_x) * exposure
        move_y = ((xn * ve - xe * vn) / det + rot_y) * exposure
        cell2 = ode * ode / abs(det)
        ax, wx = spread(1.0, smear_along * smear_along, move_x * move_x, cell2)
        ay, wy = spread(1.0, smear_across * smear_across, move_y * move_y, cell2)
        value = 0.0
        for ix in range(-1, 2):
            weight_x = wx if ix != 0 else 1.0 - 2.0 * wx
            for iy in range(-1, 2):
                weight = weight_x * (wy if iy != 0 else 1.0 - 2.0 * wy)
                north = s * d0 + ix * ax * xn + iy * ay * yn
                east = s * d1 + ix * ax * xe + iy * ay * ye
                value += weight * bilinear(
                    ortho,
                    oe0,
                    on0,
                    ode,
                    odn,
                    grid[0] + grid[2] * north + grid[3] * east,
                    grid[1] + grid[4] * north + grid[5] * east,
                )
        out[i] = value
    return float(total / pixels)


@njit(cache=True)
def convert(
    radiance_row: Array, gain: float, dark: float, noise: Grey, sigma: float, most: float, out: Grey
) -> int:  # pragma: no cover - compiled
    """Radiance to whole grey levels; returns how many pixels saw no terrain (they read 0)."""
    missing = 0
    for i in range(out.shape[0]):
        if np.isnan(radiance_row[i]):
            missing += 1
            out[i] = 0.0
            continue
        grey = np.floor(gain * radiance_row[i] + dark + sigma * noise[i] + 0.5)
        out[i] = min(max(grey, 0.0), most)
    return missing
