"""Georeferenced grid in windows: values at points, rays that meet the ground (map grid g)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from aerosim.errors import InputError, RunFailure
from aerosim.frames import Array
from aerosim.rasterfile import RasterFile, Values

if TYPE_CHECKING:
    from pyproj import CRS

# Mean radius of the Earth for the drop of the ground below the tangent plane; 0.3 % off costs 2 mm at 3 km.
EARTH_RADIUS = 6_371_000.0
WINDOW = 3072  # cells along a side of a window


class Window(NamedTuple):
    """A piece of a raster in memory.

    values: (rows, cols) float32, C order, NaN where there is nothing.  Value (row, col) belongs to easting
    x0 + col dx, northing y0 + row dy (m; dy < 0): centres of cells.  low, high: least and greatest value.
    """

    values: Values
    x0: float
    y0: float
    dx: float
    dy: float
    low: float = np.nan
    high: float = np.nan

    @classmethod
    def of(cls, values: ArrayLike, x0: float, y0: float, dx: float, dy: float) -> Window:
        """A window with its range filled in."""
        grid = np.ascontiguousarray(values, np.float32)
        low, high = value_range(grid)
        return cls(grid, float(x0), float(y0), float(dx), float(dy), low, high)

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """e_min, n_min, e_max, n_max (m) of the centres of the outermost cells: where it can be sampled."""
        rows, cols = self.values.shape
        return self.x0, self.y0 + (rows - 1) * self.dy, self.x0 + (cols - 1) * self.dx, self.y0


class WindowedRaster:
    """A raster seen through one window, re-read only when something outside of it is asked for.

    Holds size**2 float32 (38 MB at 3072), three times that while reading.
    """

    def __init__(
        self,
        file: RasterFile,
        crs: CRS,
        resolution_m: float,
        *,
        weights: dict[int, float] | None = None,
        convert: Callable[[Window], Values] | None = None,
        size: int = WINDOW,
    ) -> None:
        """crs: working grid, projected, m.  resolution_m: wanted cell, averaged to it, never finer than the file.

        weights: of bands from 1 (the first alone).  convert: new values of a window just read.  size: cells
        along a side of the window.
        """
        self._file, self._crs, self.resolution_m = file, crs, float(resolution_m)
        self._weights, self._convert = weights or {1: 1.0}, convert
        cell = file.cell_size(crs, self.resolution_m)
        self._side = min(size * cell, file.max_side(crs, self.resolution_m))
        self._limit = 2.0 * size * cell
        outline = file.outline(crs)
        self._extent = np.array([outline.min(axis=0), outline.max(axis=0)])
        self._e_min = self._n_min = np.inf
        self._e_max = self._n_max = -np.inf
        self._window: Window | None = None

    def covering(self, e_min: float, n_min: float, e_max: float, n_max: float) -> Window:
        """A window that holds the area (m), NaN outside of the raster.

        Raises InputError for an area larger than two windows; RunFailure for one that is not a number, or if the
        file cannot be read any more.
        """
        if (
            self._window is not None
            and e_min >= self._e_min
            and e_max <= self._e_max
            and n_min >= self._n_min
            and n_max <= self._n_max
        ):
            return self._window
        return self._reread(e_min, n_min, e_max, n_max)

    def _grown(self, low: float, high: float, extent: Array) -> tuple[float, float]:
        """A stretch as long as the window that holds low to high: on the raster if it can, else around them."""
        half = max(self._side, high - low) / 2.0
        middle = (low + high) / 2.0
        first, last = extent[0] + half, extent[1] - half
        inside = min(max(middle, first), last) if first < last else float(extent.mean())
        if inside - half <= low and high <= inside + half:
            middle = inside
        # beyond the raster there is nothing to keep, but room for the next few requests
        room = high - low
        first, last = max(middle - half, extent[0] - room), min(middle + half, extent[1] + room)
        return (first, last) if first <= low and high <= last else (middle - half, middle + half)

    def _reread(self, e_min: float, n_min: float, e_max: float, n_max: float) -> Window:
        wide, high = e_max - e_min, n_max - n_min
        if not (math.isfinite(wide) and math.isfinite(high)):
            raise RunFailure("the ground was asked for at a place that is not a number")
        if not (0.0 <= wide <= self._limit and 0.0 <= high <= self._limit):
            raise InputError(f"an area of {wide:.0f} x {high:.0f} m is too large to be read at once")
        west, east = self._grown(e_min, e_max, self._extent[:, 0])
        south, north = self._grown(n_min, n_max, self._extent[:, 1])
        area = (west, south, east, north)
        try:
            cells = self._file.read(self._crs, area, self.resolution_m, self._weights)
        except InputError as error:
            raise RunFailure(str(error)) from error
        values = cells.values if self._convert is None else self._convert(Window(*cells))
        self._window = Window.of(values, *cells[1:])
        self._e_min, self._n_min, self._e_max, self._n_max = self._window.bounds
        return self._window


def sample(window: Window, easting: ArrayLike, northing: ArrayLike) -> Array:
    """Values between the cells' centres, bilinear.  easting, northing: m, any shape; NaN where there is none."""
    e, n = np.broadcast_arrays(np.asarray(easting, float), np.asarray(northing, float))
    out = np.empty(e.size)
    _sample(window.values, window.x0, window.y0, window.dx, window.dy, e.ravel(), n.ravel(), out)
    return out.reshape(e.shape)


def intersect(
    window: Window, origin: ArrayLike, directions: ArrayLike, mat_grid: ArrayLike | None = None
) -> Array:
    """First points of the ground that rays meet, over the Earth's curve; bilinear ground.

    window: of ellipsoidal heights.  origin: (3,) easting, northing, height, m.  directions: (n, 3) east, north,
    up, any length.  mat_grid: (2, 2), grid metres per metre east and north on the ellipsoid at the origin, with
    which directions are those of true north; without it they are along the axes of the grid, whose scale is 1.
    Returns (n, 3) easting, northing, height, m; NaN for a ray that leaves the window or meets missing ground.
    """
    rays = np.ascontiguousarray(np.atleast_2d(np.asarray(directions, float)))
    grid = np.ascontiguousarray(np.eye(2) if mat_grid is None else np.asarray(mat_grid, float))
    if np.isnan(window.high):
        window = Window.of(*window[:5])
    out = np.full((len(rays), 3), np.nan)
    _intersect(*window, np.asarray(origin, float), rays, grid, out)
    return out


@njit(cache=True, nogil=True)
def value_range(values: Values) -> tuple[float, float]:  # pragma: no cover - compiled
    """Least and greatest value of (rows, cols), missing ones left out; NaN if there is none."""
    low, high = np.inf, -np.inf
    for stored in values.flat:
        value = float(stored)
        if value == value:  # noqa: PLR0124  (not NaN)
            low, high = min(low, value), max(high, value)
    if low > high:
        return np.nan, np.nan
    return low, high


@njit(cache=True, nogil=True)
def bilinear(
    values: Values, x0: float, y0: float, dx: float, dy: float, e: float, n: float
) -> float:  # pragma: no cover - compiled
    """Value of a window at one point (m), for other kernels; NaN outside of the cells' centres."""
    rows, cols = values.shape
    x, y = (e - x0) / dx, (n - y0) / dy
    if not (0.0 <= x <= cols - 1 and 0.0 <= y <= rows - 1) or rows < 2 or cols < 2:
        return np.nan
    j, i = min(int(x), cols - 2), min(int(y), rows - 2)
    x -= j
    y -= i
    top = values[i, j] * (1.0 - x) + values[i, j + 1] * x
    bottom = values[i + 1, j] * (1.0 - x) + values[i + 1, j + 1] * x
    return float(top * (1.0 - y) + bottom * y)


@njit(cache=True, nogil=True)
def _sample(
    values: Values, x0: float, y0: float, dx: float, dy: float, e: Array, n: Array, out: Array
) -> None:  # pragma: no cover - compiled
    for k in range(len(e)):
        out[k] = bilinear(values, x0, y0, dx, dy, e[k], n[k])


@njit(cache=True, nogil=True)
def point_on_ray(
    height: float, east: float, north: float, up: float, t: float
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """East and north on the ellipsoid from the origin's foot, and height, at t m along a ray over a sphere."""
    radius = EARTH_RADIUS + height + t * up
    level = t * np.hypot(east, north)
    rise = 0.5 * level * level / radius
    # The angle at the Earth's centre, taken on the ellipsoid: a metre up here is less than a metre down there.
    shrink = EARTH_RADIUS / radius * (1.0 - level * level / (3.0 * radius * radius))
    return t * east * shrink, t * north * shrink, height + t * up + rise


@njit(cache=True, nogil=True)
def _above(
    values: Values, x0: float, y0: float, dx: float, dy: float, origin: Array, ray: Array, grid: Array, t: float
) -> float:  # pragma: no cover - compiled
    """Height of a ray's point above the ground, m; NaN where there is no ground."""
    x, y, h = point_on_ray(origin[2], ray[0], ray[1], ray[2], t)
    e = origin[0] + grid[0, 0] * x + grid[0, 1] * y
    n = origin[1] + grid[1, 0] * x + grid[1, 1] * y
    return float(h - bilinear(values, x0, y0, dx, dy, e, n))


@njit(cache=True, nogil=True)
def _march(
    height: float, ray: Array, low: float, high: float, reach: float, stride: float
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """Where a ray can first and last meet ground from low to high, and its step for a stride on the map, m."""
    level = max(np.hypot(ray[0], ray[1]), 1e-9)
    start, end, step = 0.0, 2.0 * reach / level, stride / level
    if ray[2] < 0.0:
        start = max(0.0, (height - high) / -ray[2])
        fall = (high - low + 1.0 + 0.5 * (2.0 * reach) ** 2 / EARTH_RADIUS) / -ray[2]
        end = min(end, max(start, (height - low) / -ray[2]) + fall)
        step = min(step, max(fall, 1.0))
    return start, end, step


@njit(cache=True, nogil=True)
def ray_length(
    values: Values,
    x0: float,
    y0: float,
    dx: float,
    dy: float,
    low: float,
    high: float,
    origin: Array,
    ray: Array,
    grid: Array,
) -> float:  # pragma: no cover - compiled
    """Metres along a unit ray (east, north, up) to the first ground; NaN if there is none.  As `intersect`.

    Steps of half a cell from the height of the highest ground down, then bisection to a hundredth of a
    millimetre.
    """
    reach = np.hypot(values.shape[0] * dy, values.shape[1] * dx)
    t, end, step = _march(origin[2], ray, low, high, reach, 0.5 * min(abs(dx), abs(dy)))
    before = _above(values, x0, y0, dx, dy, origin, ray, grid, t)
    if before < 0.0:
        return np.nan
    while t < end:
        after = _above(values, x0, y0, dx, dy, origin, ray, grid, t + step)
        if before >= 0.0 and after <= 0.0:
            for _ in range(60):
                step *= 0.5
                if _above(values, x0, y0, dx, dy, origin, ray, grid, t + step) > 0.0:
                    t += step
                if step < 1e-5:
                    break
            return float(t + 0.5 * step)
        if after < 0.0:
            return np.nan
        before = after
        t += step
    return np.nan


@njit(cache=True, nogil=True)
def _intersect(
    values: Values,
    x0: float,
    y0: float,
    dx: float,
    dy: float,
    low: float,
    high: float,
    origin: Array,
    directions: Array,
    grid: Array,
    out: Array,
) -> None:  # pragma: no cover - compiled
    for k in range(len(directions)):
        ray = directions[k] / np.sqrt((directions[k] ** 2).sum())
        t = ray_length(values, x0, y0, dx, dy, low, high, origin, ray, grid)
        x, y, h = point_on_ray(origin[2], ray[0], ray[1], ray[2], t)
        out[k, 0] = origin[0] + grid[0, 0] * x + grid[0, 1] * y
        out[k, 1] = origin[1] + grid[1, 0] * x + grid[1, 1] * y
        out[k, 2] = h
