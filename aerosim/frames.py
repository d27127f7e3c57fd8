"""WGS-84, ECEF, NED, map grid, rotations (frames e, n, b, g of the conventions page)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from aerosim.errors import InputError

if TYPE_CHECKING:
    from pyproj import CRS

Array = NDArray[np.float64]

WGS84_A = 6378137.0
WGS84_F = 1.0 / 298.257223563
WGS84_E2 = WGS84_F * (2.0 - WGS84_F)
GRAVITY = 9.80665
EARTH_RATE = 7.292115e-5


def wrap_pi(angle: ArrayLike) -> Array:
    """Angle folded into (-pi, pi].  Any shape, rad."""
    folded: Array = np.pi - np.mod(np.pi - np.asarray(angle, float), 2.0 * np.pi)
    return folded


def radii(lat: ArrayLike) -> tuple[Array, Array]:
    """Radii of curvature of the ellipsoid, meridian and prime vertical.  lat: any shape, rad; m."""
    w2 = 1.0 - WGS84_E2 * np.sin(np.asarray(lat, float)) ** 2
    return WGS84_A * (1.0 - WGS84_E2) / w2**1.5, WGS84_A / np.sqrt(w2)


def ecef_from_geodetic(lat: ArrayLike, lon: ArrayLike, height: ArrayLike) -> Array:
    """Geodetic to ECEF.  lat, lon: rad, height: ellipsoidal, m, same shape (...).  Returns (..., 3), m."""
    lat, lon, height = np.asarray(lat, float), np.asarray(lon, float), np.asarray(height, float)
    _, normal = radii(lat)
    across = (normal + height) * np.cos(lat)
    up = (normal * (1.0 - WGS84_E2) + height) * np.sin(lat)
    return np.stack(np.broadcast_arrays(across * np.cos(lon), across * np.sin(lon), up), axis=-1)


def geodetic_from_ecef(pos_e: ArrayLike) -> tuple[Array, Array, Array]:
    """ECEF to geodetic, exact to 1e-9 m from 5 km below to 1000 km above the ellipsoid, poles included.

    pos_e: (..., 3), m.  Returns lat, lon (rad) and ellipsoidal height (m), each (...).
    Bowring (1976) with his reduced latitude, iterated.
    """
    pos_e = np.asarray(pos_e, float)
    x, y, z = pos_e[..., 0], pos_e[..., 1], pos_e[..., 2]
    b = WGS84_A * (1.0 - WGS84_F)
    across = np.hypot(x, y)
    reduced = np.arctan2(z * WGS84_A, across * b)
    lat = reduced
    for _ in range(3):
        lat = np.arctan2(
            z + WGS84_E2 / (1.0 - WGS84_E2) * b * np.sin(reduced) ** 3,
            across - WGS84_E2 * WGS84_A * np.cos(reduced) ** 3,
        )
        reduced = np.arctan2((1.0 - WGS84_F) * np.sin(lat), np.cos(lat))
    sin, cos = np.sin(lat), np.cos(lat)
    height = across * cos + z * sin - WGS84_A * np.sqrt(1.0 - WGS84_E2 * sin**2)
    return lat, np.arctan2(y, x), height


def mat_ne(lat: float, lon: float) -> Array:
    """Rotation that takes ECEF to north-east-down.  lat, lon: rad.  Returns (3, 3)."""
    sp, cp, sl, cl = np.sin(lat), np.cos(lat), np.sin(lon), np.cos(lon)
    return np.array([[-sp * cl, -sp * sl, cp], [-sl, cl, 0.0], [-cp * cl, -cp * sl, -sp]])


def rot_x(angle: float) -> Array:
    """Active right-handed rotation about x.  rad; (3, 3)."""
    s, c = np.sin(angle), np.cos(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def rot_y(angle: float) -> Array:
    """Active right-handed rotation about y.  rad; (3, 3)."""
    s, c = np.sin(angle), np.cos(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def rot_z(angle: float) -> Array:
    """Active right-handed rotation about z.  rad; (3, 3)."""
    s, c = np.sin(angle), np.cos(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def mat_from_attitude(heading: float, pitch: float, roll: float) -> Array:
    """mat_nb = Rz(heading) Ry(pitch) Rx(roll), frame b to n (also c to n).  rad; (3, 3)."""
    return rot_z(heading) @ rot_y(pitch) @ rot_x(roll)


def attitude_from_mat(mat_nb: ArrayLike) -> tuple[Array, Array, Array]:
    """Heading, pitch, roll (rad) of rotations b to n, the inverse of `mat_from_attitude`.  (..., 3, 3)."""
    m = np.asarray(mat_nb, float)
    heading = np.arctan2(m[..., 1, 0], m[..., 0, 0])
    pitch = -np.arcsin(np.clip(m[..., 2, 0], -1.0, 1.0))
    roll = np.arctan2(m[..., 2, 1], m[..., 2, 2])
    return heading, pitch, roll


class MapGrid:
    """Map grid g of a projected CRS in metres: easting, northing <-> latitude, longitude (rad)."""

    def __init__(self, crs: str | CRS | Any) -> None:
        """crs: whatever pyproj reads.  Raises InputError for a CRS that is not projected in metres."""
        from pyproj import CRS, Transformer

        full = CRS.from_user_input(crs)
        self.crs = full.sub_crs_list[0] if full.is_compound else full
        if not self.crs.is_projected or any(axis.unit_conversion_factor != 1.0 for axis in self.crs.axis_info):
            raise InputError(f"CRS {self.crs.name!r} is not a projected one in metres")
        self._to_grid = Transformer.from_crs("EPSG:4326", self.crs.to_2d(), always_xy=True)

    def from_geodetic(self, lat: ArrayLike, lon: ArrayLike) -> tuple[Array, Array]:
        """Easting and northing (m) of latitude and longitude (rad), same shape."""
        e, n = self._to_grid.transform(np.degrees(lon), np.degrees(lat))
        return np.asarray(e, float), np.asarray(n, float)

    def to_geodetic(self, easting: ArrayLike, northing: ArrayLike) -> tuple[Array, Array]:
        """Latitude and longitude (rad) of easting and northing (m), same shape."""
        lon, lat = self._to_grid.transform(easting, northing, direction="INVERSE")
        return np.radians(lat), np.radians(lon)

    def local(self, lat: ArrayLike, lon: ArrayLike, margin: float = 20_000.0) -> LocalMap:
        """A fast copy of this grid around the given points.  lat, lon: (n,), rad; margin: m.

        Raises InputError when the region is too large for a polynomial that is right to a millimetre.
        """
        lat, lon = np.atleast_1d(np.asarray(lat, float)), np.atleast_1d(np.asarray(lon, float))
        d_lat = margin / WGS84_A
        d_lon = d_lat / np.cos(lat).min()
        return LocalMap.fit(self, lat.min() - d_lat, lat.max() + d_lat, lon.min() - d_lon, lon.max() + d_lon)


@dataclass(frozen=True)
class LocalMap:
    """Map grid as a polynomial of latitude and longitude over a region, right to a millimetre.

    One call of pyproj costs more than a whole row of the sensor; this costs a fraction of a microsecond.
    origin: centre lat, lon (rad); scale: half widths (rad); coef: (2, d, d), m, powers of the two.
    """

    origin: Array
    scale: Array
    coef: Array

    MAX_ERROR = 1e-3

    @classmethod
    def fit(cls, grid: MapGrid, south: float, north: float, west: float, east: float) -> LocalMap:
        """Least squares on Chebyshev nodes, checked between them.  Bounds in rad."""
        origin = np.array([(south + north) / 2.0, (west + east) / 2.0])
        scale = np.array([(north - south) / 2.0, (east - west) / 2.0])
        for degree in (6, 9, 12):
            nodes = np.cos(np.pi * (np.arange(degree + 4) + 0.5) / (degree + 4))
            design, target = cls._sample(grid, origin, scale, nodes, degree)
            coef = np.linalg.lstsq(design, target, rcond=None)[0].T.reshape(2, degree + 1, degree + 1)
            check, truth = cls._sample(grid, origin, scale, np.linspace(-1.0, 1.0, 23), degree)
            if np.abs(check @ coef.reshape(2, -1).T - truth).max() < cls.MAX_ERROR:
                return cls(origin, scale, np.ascontiguousarray(coef))
        raise InputError("the flown region is too large for its map grid (one UTM zone is a good size)")

    @staticmethod
    def _sample(grid: MapGrid, origin: Array, scale: Array, nodes: Array, degree: int) -> tuple[Array, Array]:
        u, v = (a.ravel() for a in np.meshgrid(nodes, nodes, indexing="ij"))
        easting, northing = grid.from_geodetic(origin[0] + scale[0] * u, origin[1] + scale[1] * v)
        powers = np.arange(degree + 1)
        design = (u[:, None] ** powers)[:, :, None] * (v[:, None] ** powers)[:, None, :]
        return design.reshape(len(u), -1), np.column_stack([easting, northing])

    def __call__(self, lat: float, lon: float) -> tuple[float, float, float, float, float, float]:
        """Easting, northing (m) of one point (rad) and d(easting)/d(north), d(easting)/d(east),
        d(northing)/d(north), d(northing)/d(east): grid metres per metre on the ellipsoid."""
        found: tuple[float, float, float, float, float, float] = local_map(
            self.origin, self.scale, self.coef, lat, lon
        )
        return found


@njit(cache=True, nogil=True)
def local_map(
    origin: Array, scale: Array, coef: Array, lat: float, lon: float
) -> tuple[float, float, float, float, float, float]:  # pragma: no cover - compiled
    """`LocalMap.__call__` for other kernels: one point and the map's Jacobian in ellipsoid metres."""
    u = (lat - origin[0]) / scale[0]
    v = (lon - origin[1]) / scale[1]
    size = coef.shape[1]
    value = np.empty(2)
    d_lat = np.empty(2)
    d_lon = np.empty(2)
    for k in range(2):
        f, fu, fv = 0.0, 0.0, 0.0
        for i in range(size - 1, -1, -1):
            g, gv = 0.0, 0.0
            for j in range(size - 1, -1, -1):
                gv = gv * v + g
                g = g * v + coef[k, i, j]
            fu = fu * u + f
            f = f * u + g
            fv = fv * u + gv
        value[k] = f
        d_lat[k] = fu / scale[0]
        d_lon[k] = fv / scale[1]
    w2 = 1.0 - WGS84_E2 * np.sin(lat) ** 2
    meridian = WGS84_A * (1.0 - WGS84_E2) / w2**1.5
    parallel = WGS84_A / np.sqrt(w2) * np.cos(lat)
    return (
        value[0],
        value[1],
        d_lat[0] / meridian,
        d_lon[0] / parallel,
        d_lat[1] / meridian,
        d_lon[1] / parallel,
    )
