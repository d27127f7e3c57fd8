"""The terrain as the sensor meets it: two windows that follow the aircraft, and mean heights below it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.raster import bilinear
from aerosim.rasterfile import Values
from aerosim.world.terrain import Terrain

Grid5 = tuple[Values, float, float, float, float]


class Below(NamedTuple):
    """Ellipsoidal heights below the aircraft, m: at the nadir, mean of the rows' footprint, mean of a strip."""

    nadir: float
    footprint: float
    strip: float


NOWHERE = Below(np.nan, np.nan, np.nan)


class GroundView:
    """Orthophoto and elevation around the aircraft, as fine as a row's pixel needs."""

    def __init__(self, terrain: Terrain, pixel_m: float) -> None:
        """pixel_m: a row's pixel on the ground; the picture is read at a third of it, heights at half."""
        self._ortho = terrain.orthophoto(pixel_m / 3.0)
        self._relief = terrain.elevation(pixel_m / 2.0)

    def windows(self, easting: float, northing: float, reach: float) -> tuple[Grid5, Grid5]:
        """Orthophoto (grey) and ellipsoidal heights covering +-reach around a point, all in m."""
        area = (easting - reach, northing - reach, easting + reach, northing + reach)
        return self._ortho.covering(*area)[:5], self._relief.covering(*area)[:5]

    def below(self, grid: Array, heading: float, along: float, across: float) -> Below:
        """Mean heights of the rectangle of +-along by +-across (m) under the aircraft, and of its middle line.

        grid: easting, northing and Jacobian of the map, (6,), as `LocalMap` returns them; heading: rad.
        """
        reach = along + across
        area = (grid[0] - reach, grid[1] - reach, grid[0] + reach, grid[1] + reach)
        return Below._make(_below(*self._relief.covering(*area)[:5], grid, heading, along, across))


@njit(cache=True)
def _below(
    heights: Values,
    x0: float,
    y0: float,
    dx: float,
    dy: float,
    grid: Array,
    heading: float,
    along: float,
    across: float,
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    ch, sh = np.cos(heading), np.sin(heading)
    nadir, strip, total = np.nan, 0.0, 0.0
    for i in range(-4, 5):
        row = 0.0
        for j in range(-8, 9):
            a, b = i / 4.0 * along, j / 8.0 * across
            north, east = a * ch - b * sh, a * sh + b * ch
            e = grid[0] + grid[2] * north + grid[3] * east
            n = grid[1] + grid[4] * north + grid[5] * east
            h = bilinear(heights, x0, y0, dx, dy, e, n)
            if i == 0 and j == 0:
                nadir = h
            row += h / 17.0
        if i == 0:
            strip = row
        total += row / 9.0
    return nadir, total, strip
