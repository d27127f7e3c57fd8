"""Latitude and longitude to the cells of a raster in its own grid, fast enough for every ray."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aerosim.errors import InputError
from aerosim.frames import WGS84_A, Array, wrap_pi
from aerosim.geolocation.compiled import kernel

if TYPE_CHECKING:
    from affine import Affine
    from pyproj import CRS

# Of the cubic between nodes, in cells and in metres of a projected grid.
MAX_ERROR_CELLS, MAX_ERROR = 1e-4, 5e-4
MOST_NODES = 1025
# Around the raster, m; a piece of a ray that begins or ends further off has no part over the raster.
MARGIN = 40_000.0


class GridMap(NamedTuple):
    """Cell coordinates x (columns), y (rows), centre of the first cell (0, 0).

    linear: (2, 3), cells per rad of longitude and latitude, and offset, for a geographic grid on WGS-84; empty
    where the lattice serves.  lattice: (2, n, m) x and y at nodes of latitude and longitude; box: first
    latitude, step, first longitude (from the middle), step, rad.  middle: longitude from which others count, rad.
    """

    linear: Array
    lattice: Array
    box: Array
    middle: float
    geographic: bool

    @classmethod
    def of(cls, crs: CRS, transform: Affine, width: int, height: int) -> GridMap:
        """crs: horizontal; transform: of cell corners to crs, x before y.  Raises InputError without a map."""
        from pyproj import CRS, Transformer

        if crs.is_geographic and crs.equals(CRS("EPSG:4326"), ignore_axis_order=True):
            return cls._linear(transform, width, height)
        to_crs = Transformer.from_crs("EPSG:4326", crs, always_xy=True)
        return cls._lattice(to_crs, ~transform, _outline(transform, width, height), (width, height))

    @classmethod
    def _linear(cls, transform: Affine, width: int, height: int) -> GridMap:
        inverse = ~transform
        middle = np.radians(applied(transform, width / 2.0, height / 2.0)[0])
        per = np.degrees(np.array([[inverse.a, inverse.b], [inverse.d, inverse.e]]))
        offset = np.array([inverse.c, inverse.f]) - 0.5 + per[:, 0] * middle
        linear = np.ascontiguousarray(np.column_stack([per, offset]))
        return cls(linear, np.zeros((2, 0, 0)), np.zeros(4), float(middle), geographic=True)

    @classmethod
    def _lattice(cls, to_crs: Any, inverse: Affine, outline: Array, size: tuple[int, int]) -> GridMap:
        lon, lat = (np.radians(v) for v in to_crs.transform(*outline.T, direction="INVERSE"))
        if not (np.isfinite(lon).all() and np.isfinite(lat).all()):
            raise InputError("the raster reaches beyond what its map grid can show")
        middle = float(np.angle(np.exp(1j * lon).mean()))
        east = wrap_pi(lon - middle)
        low, high = float(lat.min()), float(lat.max())
        half = float(np.abs(east).max())
        for pole in (90.0, -90.0):
            x, y = applied(inverse, *to_crs.transform(0.0, pole))
            if 0.0 <= x <= size[0] and 0.0 <= y <= size[1]:
                low, high, half = min(low, np.radians(pole)), max(high, np.radians(pole)), np.pi
        step = MARGIN / WGS84_A
        low, high = max(low - step, -np.pi / 2.0), min(high + step, np.pi / 2.0)
        half = min(half + step / max(np.cos(max(abs(low), abs(high))), 1e-3), np.pi)
        cell = max(abs(inverse.a), abs(inverse.e), abs(inverse.b), abs(inverse.d))
        allowed = (
            min(MAX_ERROR_CELLS, MAX_ERROR * cell) if not to_crs.target_crs.is_geographic else MAX_ERROR_CELLS
        )
        count = 9
        while count <= MOST_NODES:
            box = np.array([low, (high - low) / (count - 1), -half, 2.0 * half / (count - 1)])
            nodes = cls._nodes(to_crs, inverse, middle, box, (count, count), 0.0)
            found = cls(np.zeros((0, 0)), nodes, box, middle, geographic=False)
            between = cls._nodes(to_crs, inverse, middle, box, (count - 1, count - 1), 0.5)
            lats, lons = np.meshgrid(
                low + box[1] * (np.arange(count - 1) + 0.5), box[2] + box[3] * (np.arange(count - 1) + 0.5),
                indexing="ij",
            )  # fmt: skip
            error = found.cells(lats, middle + lons) - between
            if np.abs(error).max() < allowed:
                return found
            count = 2 * count - 1
        raise InputError("the raster's map grid is not smooth enough over its area", allowed="a grid made for it")

    @staticmethod
    def _nodes(
        to_crs: Any, inverse: Affine, middle: float, box: Array, shape: tuple[int, int], shift: float
    ) -> Array:
        lat = box[0] + box[1] * (np.arange(shape[0]) + shift)
        lon = middle + box[2] + box[3] * (np.arange(shape[1]) + shift)
        lats, lons = np.meshgrid(lat, lon, indexing="ij")
        e, n = to_crs.transform(np.degrees(lons), np.clip(np.degrees(lats), -90.0, 90.0))
        if not (np.isfinite(e).all() and np.isfinite(n).all()):
            raise InputError("the raster lies at the edge of what its map grid can show")
        x, y = applied(inverse, e, n)
        return np.ascontiguousarray(np.stack([x, y]) - 0.5)

    def cells(self, lat: Array, lon: Array) -> Array:
        """x and y, cells, (2, ...), of latitude and longitude (rad), same shape; NaN far off the raster."""
        lat, lon = np.broadcast_arrays(np.asarray(lat, float), np.asarray(lon, float))
        out = np.empty((2, lat.size))
        _cells(self.linear, self.lattice, self.box, self.middle, lat.ravel(), lon.ravel(), out)
        return out.reshape(2, *lat.shape)


def applied(transform: Affine, x: Any, y: Any) -> tuple[Any, Any]:
    """x and y through an affine transform, numbers or arrays."""
    t = transform
    return t.a * x + t.b * y + t.c, t.d * x + t.e * y + t.f


def _outline(transform: Affine, width: int, height: int) -> Array:
    """Points along the raster's outer edge in its CRS, (n, 2)."""
    t = np.linspace(0.0, 1.0, 33)
    zero, one = np.zeros(33), np.ones(33)
    x = np.concatenate([t, one, t, zero]) * width
    y = np.concatenate([zero, t, one, t]) * height
    return np.column_stack(applied(transform, x, y))


@kernel
def cell_of(
    linear: Array, lattice: Array, box: Array, middle: float, lat: float, lon: float
) -> tuple[float, float]:  # pragma: no cover - compiled
    """x and y of one point (rad); NaN where the lattice ends."""
    east = lon - middle
    if east > np.pi:
        east -= 2.0 * np.pi
    elif east < -np.pi:
        east += 2.0 * np.pi
    if linear.size > 0:
        return (
            linear[0, 0] * east + linear[0, 1] * lat + linear[0, 2],
            linear[1, 0] * east + linear[1, 1] * lat + linear[1, 2],
        )
    rows, cols = lattice.shape[1], lattice.shape[2]
    v, u = (lat - box[0]) / box[1], (east - box[2]) / box[3]
    if not (0.0 <= v <= rows - 1.0 and 0.0 <= u <= cols - 1.0):
        return np.nan, np.nan
    i, j = min(max(int(v) - 1, 0), rows - 4), min(max(int(u) - 1, 0), cols - 4)
    v -= i
    u -= j
    # Lagrange's weights on 0, 1, 2, 3
    a0, a1, a2, a3 = (
        -(v - 1.0) * (v - 2.0) * (v - 3.0) / 6.0,
        v * (v - 2.0) * (v - 3.0) / 2.0,
        -v * (v - 1.0) * (v - 3.0) / 2.0,
        v * (v - 1.0) * (v - 2.0) / 6.0,
    )
    b0, b1, b2, b3 = (
        -(u - 1.0) * (u - 2.0) * (u - 3.0) / 6.0,
        u * (u - 2.0) * (u - 3.0) / 2.0,
        -u * (u - 1.0) * (u - 3.0) / 2.0,
        u * (u - 1.0) * (u - 2.0) / 6.0,
    )
    x, y = 0.0, 0.0
    for k in range(4):
        a = a0 if k == 0 else a1 if k == 1 else a2 if k == 2 else a3
        x += a * (
            b0 * lattice[0, i + k, j]
            + b1 * lattice[0, i + k, j + 1]
            + b2 * lattice[0, i + k, j + 2]
            + b3 * lattice[0, i + k, j + 3]
        )
        y += a * (
            b0 * lattice[1, i + k, j]
            + b1 * lattice[1, i + k, j + 1]
            + b2 * lattice[1, i + k, j + 2]
            + b3 * lattice[1, i + k, j + 3]
        )
    return x, y


@kernel
def _cells(
    linear: Array, lattice: Array, box: Array, middle: float, lat: Array, lon: Array, out: Array
) -> None:  # pragma: no cover - compiled
    for k in range(len(lat)):
        out[0, k], out[1, k] = cell_of(linear, lattice, box, middle, lat[k], lon[k])
