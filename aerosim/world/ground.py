"""The terrain as the sensor meets it: two windows that follow the aircraft, and mean heights below it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.frames import Array, LocalMap, local_map
from aerosim.rasterfile import Values
from aerosim.truth import Below
from aerosim.world.clouds import CloudShadows
from aerosim.world.terrain import Terrain


class Spot(NamedTuple):
    """The ground around a point.

    grid: easting, northing and Jacobian of the map, (6,), see `LocalMap`; ortho, relief: values of the windows
    there; *_place: easting, northing of the first cell and the steps, (4,), m.  shade, shade_place: what the light
    is multiplied by, see `CloudShadows`; None without clouds.
    """

    grid: Array
    ortho: Values
    ortho_place: Array
    relief: Values
    relief_place: Array
    shade: Values | None = None
    shade_place: Array | None = None


class GroundView:
    """Orthophoto and elevation around the aircraft, as fine as a row's pixel needs."""

    def __init__(
        self, terrain: Terrain, local: LocalMap, pixel_m: float, clouds: CloudShadows | None = None
    ) -> None:
        """local: map grid around the flight.  pixel_m: a row's pixel on the ground; windows are read at half."""
        self._clouds = clouds
        self._local = local.origin, local.scale, local.coef
        self._rasters = terrain.orthophoto(pixel_m / 2.0), terrain.elevation(pixel_m / 2.0)
        nothing, nowhere = np.empty((0, 0), np.float32), np.zeros(4)
        self._windows: tuple[Values, Array, Values, Array] = nothing, nowhere, nothing, nowhere
        self._bounds = np.array([np.inf, np.inf, -np.inf, -np.inf])  # e_min, n_min, e_max, n_max, m

    def around(self, lat: float, lon: float, reach: float, t: float = 0.0) -> Spot:
        """The ground within reach (m) of a point (rad) at time t (s)."""
        grid = np.empty(6)
        if not _placed(grid, *self._local, lat, lon, reach, self._bounds):
            e, n = float(grid[0]), float(grid[1])
            self._look(e - reach, n - reach, e + reach, n + reach)
        if self._clouds is None:
            return Spot(grid, *self._windows)
        return Spot(grid, *self._windows, self._clouds.shade, self._clouds.place(t))

    def _look(self, e_min: float, n_min: float, e_max: float, n_max: float) -> None:
        """Take the windows that hold the area (m), and the area that both of them hold."""
        ortho, relief = (raster.covering(e_min, n_min, e_max, n_max) for raster in self._rasters)
        self._windows = ortho.values, np.array(ortho[1:5]), relief.values, np.array(relief[1:5])
        self._bounds[:2] = np.maximum(ortho.bounds[:2], relief.bounds[:2])
        self._bounds[2:] = np.minimum(ortho.bounds[2:], relief.bounds[2:])


@njit(cache=True)
def _placed(
    grid: Array, origin: Array, scale: Array, coef: Array, lat: float, lon: float, reach: float, bounds: Array
) -> bool:  # pragma: no cover - compiled
    """Fill in the point's map grid, see `local_map`; whether all within reach (m) lies within the bounds."""
    e, n, e_north, e_east, n_north, n_east = local_map(origin, scale, coef, lat, lon)
    grid[0], grid[1], grid[2], grid[3], grid[4], grid[5] = e, n, e_north, e_east, n_north, n_east
    return bool(
        e - reach >= bounds[0] and n - reach >= bounds[1] and e + reach <= bounds[2] and n + reach <= bounds[3]
    )


def below(spot: Spot, heading: float, along: float, across: float) -> Below:
    """Mean heights of the rectangle of +-along by +-across (m) under the aircraft, and of its middle line.

    heading: rad, clockwise from north.
    """
    return Below._make(_below(spot.relief, spot.relief_place, spot.grid, heading, along, across))


@njit(cache=True)
def _below(
    heights: Values, place: Array, grid: Array, heading: float, along: float, across: float
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """Bilinear samples in the middles of nine by five parts."""
    ch, sh = np.cos(heading), np.sin(heading)
    nadir, strip, total = np.nan, 0.0, 0.0
    for i in range(-2, 3):
        line = 0.0
        for j in range(-4, 5):
            a, b = i / 2.5 * along, j / 4.5 * across
            north, east = a * ch - b * sh, a * sh + b * ch
            col = (grid[0] + grid[2] * north + grid[3] * east - place[0]) / place[2]
            row = (grid[1] + grid[4] * north + grid[5] * east - place[1]) / place[3]
            h = np.nan
            if row >= 0.0 and col >= 0.0 and row < heights.shape[0] - 1 and col < heights.shape[1] - 1:
                r, c = int(row), int(col)
                u, v = row - r, col - c
                upper = (1.0 - v) * heights[r, c] + v * heights[r, c + 1]
                lower = (1.0 - v) * heights[r + 1, c] + v * heights[r + 1, c + 1]
                h = (1.0 - u) * upper + u * lower
            if i == 0 and j == 0:
                nadir = h
            line += h / 9.0
        if i == 0:
            strip = line
        total += line / 5.0
    return nadir, total, strip
