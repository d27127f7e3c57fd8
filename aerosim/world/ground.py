"""The terrain as the sensor meets it: two windows that follow the aircraft, and mean heights below it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.frames import Array, LocalMap
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
        self._local = local
        self._rasters = terrain.orthophoto(pixel_m / 2.0), terrain.elevation(pixel_m / 2.0)
        nothing, nowhere = np.empty((0, 0), np.float32), np.zeros(4)
        self._windows: tuple[Values, Array, Values, Array] = nothing, nowhere, nothing, nowhere
        self._e_min = self._n_min = np.inf
        self._e_max = self._n_max = -np.inf

    def around(self, lat: float, lon: float, reach: float, t: float = 0.0) -> Spot:
        """The ground within reach (m) of a point (rad) at time t (s)."""
        grid = self._local(lat, lon)
        e, n = grid[0], grid[1]
        if not (
            e - reach >= self._e_min and n - reach >= self._n_min
            and e + reach <= self._e_max and n + reach <= self._n_max
        ):  # fmt: skip
            self._look(e - reach, n - reach, e + reach, n + reach)
        if self._clouds is None:
            return Spot(np.array(grid), *self._windows)
        return Spot(np.array(grid), *self._windows, self._clouds.shade, self._clouds.place(t))

    def _look(self, e_min: float, n_min: float, e_max: float, n_max: float) -> None:
        """Take the windows that hold the area (m), and the area that both of them hold."""
        ortho, relief = (raster.covering(e_min, n_min, e_max, n_max) for raster in self._rasters)
        self._windows = ortho.values, np.array(ortho[1:5]), relief.values, np.array(relief[1:5])
        bounds = np.array([ortho.bounds, relief.bounds])
        self._e_min, self._n_min = bounds[:, :2].max(axis=0).tolist()
        self._e_max, self._n_max = bounds[:, 2:].min(axis=0).tolist()


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
