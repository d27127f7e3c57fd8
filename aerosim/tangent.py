"""Plane tangent to the ellipsoid: metres east and north around a place, for what is planned on some ten km."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.frames import Array, MapGrid, ecef_from_geodetic, geodetic_from_ecef, mat_ne
from aerosim.raster import Window, WindowedRaster, sample

# Points along a side at which the way from the plane to the map grid is computed; between them it is bilinear:
# its curvature is below 2e-7 per metre up to 60 deg of latitude, which leaves 2 cm at 50 km.
LATTICE = 65
# Cells along a side of a resampled relief.
MOST_CELLS = 2000


class TangentPlane:
    """Orthographic projection along the ellipsoid's normal at a place.  lat, lon: of the place, rad.

    A length is true in the middle and short by (d/R)^2 / 2 radially at a distance d: 8e-6 at 25 km.
    """

    def __init__(self, lat: float, lon: float) -> None:
        self.lat, self.lon = lat, lon
        self._origin = ecef_from_geodetic(lat, lon, 0.0)
        north, east, down = mat_ne(lat, lon)
        self._axes = np.stack([east, north, -down])

    @classmethod
    def around(cls, points: ArrayLike) -> TangentPlane:
        """The plane in the middle of points (n, 2), latitude and longitude, rad."""
        lat, lon = np.moveaxis(np.asarray(points, float), -1, 0)
        middle = ecef_from_geodetic(lat, lon, np.zeros(np.shape(lat))).mean(axis=0)
        return cls(*(float(angle) for angle in geodetic_from_ecef(middle)[:2]))

    def to_plane(self, points: ArrayLike) -> Array:
        """East and north, m, (..., 2), of points on the ellipsoid (..., 2), latitude and longitude, rad."""
        lat, lon = np.moveaxis(np.asarray(points, float), -1, 0)
        pos_e = ecef_from_geodetic(lat, lon, np.zeros(np.shape(lat)))
        return np.asarray((pos_e - self._origin) @ self._axes[:2].T)

    def to_geodetic(self, points: ArrayLike) -> Array:
        """Latitude and longitude, rad, (..., 2), of points (..., 2), east and north, m.  Inverse of `to_plane`."""
        level = np.asarray(points, float)
        up = np.zeros(level.shape[:-1])
        for _ in range(4):
            pos_e = self._origin + np.concatenate([level, up[..., None]], axis=-1) @ self._axes
            lat, lon, height = geodetic_from_ecef(pos_e)
            up = up - height
        return np.stack([lat, lon], axis=-1)


def relief_on(
    plane: TangentPlane,
    bounds: tuple[float, float, float, float],
    grid: MapGrid,
    elevation: Callable[[float], WindowedRaster],
    finest: float,
) -> Window:
    """Heights over a piece of the plane.

    bounds: east, north of its lowest and highest corner, m.  grid: of the elevation; elevation: raster of
    ellipsoidal heights for a wanted cell (m); finest: its own cell, m.  Returns a window in metres of the plane,
    cells of `finest` or as many as are kept along a side; NaN where there is no ground.
    Raises InputError for an empty piece.
    """
    east, north = bounds[2] - bounds[0], bounds[3] - bounds[1]
    if not (east > 0.0 and north > 0.0):
        raise InputError("an empty piece of land")
    step = max(finest, max(east, north) / MOST_CELLS)
    cols, rows = int(np.ceil(east / step)) + 1, int(np.ceil(north / step)) + 1
    x = bounds[0] + step * np.arange(cols)
    y = bounds[3] - step * np.arange(rows)
    nodes = np.linspace(0.0, 1.0, LATTICE)
    corners = np.stack(np.meshgrid(x[0] + (x[-1] - x[0]) * nodes, y[0] + (y[-1] - y[0]) * nodes), axis=-1)
    placed = grid.from_geodetic(*np.moveaxis(plane.to_geodetic(corners), -1, 0))
    easting, northing = (_bilinear(part, rows, cols) for part in placed)
    if not (np.isfinite(easting).all() and np.isfinite(northing).all()):  # off the map of this grid
        return Window.of(np.full((rows, cols), np.nan), x[0], y[0], step, -step)
    window = elevation(step).covering(easting.min(), northing.min(), easting.max(), northing.max())
    return Window.of(sample(window, easting, northing), x[0], y[0], step, -step)


def _bilinear(nodes: Array, rows: int, cols: int) -> Array:
    """Values between the nodes of a square lattice, (rows, cols)."""
    last = len(nodes) - 1
    down, right = np.linspace(0.0, last, rows), np.linspace(0.0, last, cols)
    i, j = (np.minimum(at.astype(int), last - 1) for at in (down, right))
    upper = nodes[i] + (down - i)[:, None] * (nodes[i + 1] - nodes[i])
    return np.asarray(upper[:, j] + (right - j) * (upper[:, j + 1] - upper[:, j]))
