"""Land made for the rows' tests, and where their rays meet it, worked out without the code under test."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from pyproj import Transformer
from scipy.interpolate import RegularGridInterpolator
from scipy.spatial.transform import Rotation

from aerosim.sensing.ccd_rows import CcdRows, RowParameters
from aerosim.truth import CameraPose
from aerosim.world.ground import Spot

FOCAL, SPACING, PIXELS, SHIFT = 132.6, 39.7, 96, 7
EAST, NORTH = 600_000.0, 5_600_000.0
LEVEL_GRID = (EAST, NORTH, 0.0, 1.0, 1.0, 0.0)  # grid north is true north, scale 1
RADIUS = 6_371_000.0


def rows(start_height=0.0, seed=1, **changes):
    """Rows of the 1988 camera without noise, sixteen bits, 10 ms: a grey level of land reads as 257."""
    parameters = RowParameters(PIXELS, SHIFT, SPACING, FOCAL, 1.0, 1.0, 0.01, 0.0, 0.0, 16)
    return CcdRows(parameters._replace(**changes), start_height, np.random.default_rng(seed))


def cells(surface, half=2500.0, cell=10.0):
    """Values of a function of easting and northing offsets (m) on a square window, and its place."""
    count = round(half / cell)
    x, y = np.meshgrid(np.arange(-count, count + 1) * cell, np.arange(count, -count - 1, -1) * cell)
    values = np.ascontiguousarray(surface(x, y) + 0.0 * x, np.float32)
    return values, np.array([EAST - count * cell, NORTH + count * cell, cell, -cell])


def spot(ortho, relief=lambda x, y: 0.0, grid=LEVEL_GRID, half=2500.0, cell=10.0):
    """Land of an orthophoto and a relief, both functions of easting and northing offsets."""
    return Spot(np.array(grid), *cells(ortho, half, cell), *cells(relief, half, cell))


def pose(
    heading=0.0, pitch=0.0, roll=0.0, height=3000.0, speed=0.0, omega=(0.0, 0.0, 0.0), t=0.0, lat=0.88, lon=0.2
):
    """Camera over the middle of the land, flying where it points.  rad, m, m/s."""
    mat = Rotation.from_euler("ZYX", [heading, pitch, roll]).as_matrix()
    vel = np.array([speed * math.cos(heading), speed * math.sin(heading), 0.0])
    return CameraPose(t, lat, lon, height, vel, np.ascontiguousarray(mat), np.array(omega, float))


def rays(row):
    """Rays of a row in c.  row 1 looks ahead (110 pixels), row 2 behind (96).  (pixels, 3)."""
    count = PIXELS + 2 * SHIFT if row == 1 else PIXELS
    y = np.arange(count) - (count - 1) / 2.0
    x = SPACING / 2.0 if row == 1 else -SPACING / 2.0
    return np.column_stack([np.full(count, x), y, np.full(count, FOCAL)])


def level_ground(where, row, ground=0.0):
    """Metres north and east of the camera where a row's rays meet a sphere `ground` m above the ellipsoid.

    The ray is cut with a sphere of the Earth's mean radius: (R + H - s down)^2 + (s level)^2 = (R + ground)^2.
    """
    d = rays(row) @ where.mat_nc.T
    d /= np.linalg.norm(d, axis=1)[:, None]
    top, half = RADIUS + where.height, (RADIUS + where.height) * d[:, 2]
    s = half - np.sqrt(half**2 - (top**2 - (RADIUS + ground) ** 2))
    return s * d[:, 0], s * d[:, 1]


@cache
def _transformers(crs):
    to_e = Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    return to_e, Transformer.from_crs("EPSG:4978", "EPSG:4979", always_xy=True), Transformer.from_crs(
        "EPSG:4326", crs, always_xy=True
    )  # fmt: skip


def march(where, direction_n, crs, relief, relief_place, step=1.0, reach=5000.0):
    """First meeting of a ray with a relief, by dense steps in ECEF, pyproj and bilinear heights of scipy.

    direction_n: (3,).  Returns easting, northing, height, length of the ray, m.
    """
    to_e, from_e, to_grid = _transformers(crs)
    n_rows, n_cols = relief.shape
    x = relief_place[0] + relief_place[2] * np.arange(n_cols)
    y = relief_place[1] + relief_place[3] * np.arange(n_rows)
    heights = RegularGridInterpolator((y[::-1], x), relief[::-1].astype(float), bounds_error=False)
    sp, cp, sl, cl = (f(a) for a in (where.lat, where.lon) for f in (math.sin, math.cos))
    mat_ne = np.array([[-sp * cl, -sp * sl, cp], [-sl, cl, 0.0], [-cp * cl, -cp * sl, -sp]])
    d = mat_ne.T @ (np.asarray(direction_n) / np.linalg.norm(direction_n))
    origin = np.array(to_e.transform(math.degrees(where.lon), math.degrees(where.lat), where.height))

    def above(s):
        lon, lat, h = from_e.transform(*(origin[:, None] + d[:, None] * s))
        e, n = to_grid.transform(lon, lat)
        return h - heights(np.column_stack([n, e])), e, n, h

    s = np.arange(0.0, reach, 20.0 * step)
    first = s[np.argmax(above(s)[0] < 0.0)] - 20.0 * step
    s = first + np.arange(0.0, 20.0 * step + 2.0 * step, step)
    gap, e, n, h = above(s)
    k = int(np.argmax(gap < 0.0))
    w = gap[k - 1] / (gap[k - 1] - gap[k])
    return tuple(float(v[k - 1] + w * (v[k] - v[k - 1])) for v in (e, n, h, s))
