"""What a photo sees of the ground: rays over the relief, corners, mean height."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.frames import Array, LocalMap, MapGrid, ecef_from_geodetic, mat_ne
from aerosim.projection import Camera
from aerosim.raster import Window, WindowedRaster, point_on_ray, ray_length, sample
from aerosim.rasterfile import Values
from aerosim.truth import CameraPose

# Points along each side of the grid whose mean is the footprint's mean height.
MEAN_POINTS = 33
# A ray nearer to the horizon than this (down per metre) sees no ground that could be mapped.
LEAST_DOWN = 0.1


class Ground(NamedTuple):
    """The relief under the photos.  grid: map grid g; elevation: ellipsoidal heights on it, m."""

    grid: MapGrid
    elevation: WindowedRaster


class View:
    """A camera at a pose, in e.  pos_e: projection centre, (3,), m; mat_ec: c to e, (3, 3)."""

    def __init__(self, camera: Camera, pose: CameraPose) -> None:
        self.camera, self.pose = camera, pose
        self.mat_ne = mat_ne(pose.lat, pose.lon)
        self.pos_e = ecef_from_geodetic(pose.lat, pose.lon, pose.height)
        self.mat_ec = self.mat_ne.T @ pose.mat_nc

    def rays_n(self, pixel: Array) -> Array:
        """Unit rays of pixels (n, 2), px, in n.  (n, 3)."""
        los = self.camera.rays(pixel) @ self.pose.mat_nc.T
        return np.asarray(los / np.linalg.norm(los, axis=-1, keepdims=True))

    def to_ecef(self, offset_n: Array) -> Array:
        """Points given from the projection centre in n, (n, 3), m, in e."""
        return np.asarray(self.pos_e + offset_n @ self.mat_ne)

    def pixels_of(self, points_e: Array) -> Array:
        """Row and column (px) at which points (n, 3), m, in e appear; NaN behind the camera.  (n, 2)."""
        return self.camera.pixels((points_e - self.pos_e) @ self.mat_ec)


class Patch(NamedTuple):
    """The relief around a photo, with which its rays are met.

    window: ellipsoidal heights; origin: easting, northing, height of the projection centre, m; mat_grid: (2, 2),
    grid metres per metre east and north.
    """

    window: Window
    origin: Array
    mat_grid: Array

    def lengths(self, rays_n: Array) -> Array:
        """Metres along unit rays (n, 3) to the first ground, (n,); NaN where there is none."""
        found = np.empty(len(rays_n))
        _lengths(*self.window, self.origin, np.ascontiguousarray(rays_n), self.mat_grid, found)
        return found

    def points(self, rays_n: Array, lengths: Array) -> Array:
        """Easting, northing and ellipsoidal height (m) at lengths (n,), m, along unit rays.  (n, 3)."""
        found = np.empty((len(rays_n), 3))
        _points(self.origin, np.ascontiguousarray(rays_n), lengths, self.mat_grid, found)
        return found


class Footprint(NamedTuple):
    """The ground of one photo.

    corners_n: (4, 3), of the true outer corners from the projection centre, in n, m: front left, front right,
    rear right, rear left; centre_n: (3,), of the picture's middle; mean_height: ellipsoidal, m, of the ground
    within the corners; complete: whether the relief is known everywhere in it.  NaN where it is not known.
    """

    corners_n: Array
    centre_n: Array
    mean_height: float
    complete: bool


class Relief:
    """The ground under a flight: finds the patch of each photo."""

    def __init__(self, ground: Ground, lat: Array, lon: Array) -> None:
        """lat, lon: of the photos, (n,), rad.  Raises InputError for a region too large for its map grid."""
        self._ground, self._lat, self._lon = ground, lat, lon

    @cached_property
    def _map(self) -> LocalMap:
        return self._ground.grid.local(self._lat, self._lon)

    def under(self, view: View) -> Patch | None:
        """Relief around a photo, or None: no ground at all, or a photo that looks at the horizon."""
        pose = view.pose
        easting, northing, e_n, e_e, n_n, n_e = self._map(pose.lat, pose.lon)
        origin, mat_grid = np.array([easting, northing, pose.height]), np.array([[e_e, e_n], [n_e, n_n]])
        rays = view.rays_n(view.camera.corners)
        if rays[:, 2].min() < LEAST_DOWN:
            return None
        box = np.array([easting, northing, easting, northing])
        low = np.inf
        while True:
            window = self._ground.elevation.covering(*box)
            if np.isnan(window.low):
                return None
            if window.low >= low:
                return Patch(window, origin, mat_grid)
            low = window.low
            box = _box(origin, mat_grid, rays, low)


def footprint(view: View, patch: Patch | None) -> Footprint:
    """Corners, middle and mean height of a photo's ground."""
    if patch is None:
        return Footprint(np.full((4, 3), np.nan), np.full(3, np.nan), np.nan, False)
    rays = view.rays_n(np.vstack([view.camera.corners, view.camera.centre]))
    lengths = patch.lengths(rays)
    offsets = lengths[:, None] * rays
    heights, areas = _heights_within(patch, patch.points(rays[:4], lengths[:4])[:, :2])
    known = np.isfinite(heights)
    mean = float(np.average(heights[known], weights=areas[known])) if known.any() else np.nan
    return Footprint(offsets[:4], offsets[4], mean, bool(known.all() and np.isfinite(lengths).all()))


def _heights_within(patch: Patch, corners: Array) -> tuple[Array, Array]:
    """Ground within four corners (4, 2) easting, northing, m, in cells: heights (m) in their middles, areas."""
    share = (np.arange(MEAN_POINTS) + 0.5) / MEAN_POINTS
    back, right = share[:, None, None], share[None, :, None]
    front_left, front_right, rear_right, rear_left = corners
    front, rear = front_left + right * (front_right - front_left), rear_left + right * (rear_right - rear_left)
    points = front + back * (rear - front)
    # The sides of a cell of this bilinear grid: their cross product is its area.
    down, aside = rear - front, (1.0 - back) * (front_right - front_left) + back * (rear_right - rear_left)
    areas = np.abs(down[..., 0] * aside[..., 1] - down[..., 1] * aside[..., 0])
    return sample(patch.window, points[..., 0].ravel(), points[..., 1].ravel()), areas.ravel()


def _box(origin: Array, mat_grid: Array, rays: Array, low: float) -> Array:
    """Area (e_min, n_min, e_max, n_max, m) that the rays cross above the lowest ground, their foot included."""
    depth = max(origin[2] - low, 0.0)
    # The ground falls away below the tangent plane: a tenth of a per cent covers it out to 10 km.
    reach = 1.002 * depth / rays[:, 2] + 1.0
    level = np.vstack([np.zeros(2), (reach[:, None] * rays[:, 1::-1]) @ mat_grid.T])
    return np.concatenate([origin[:2] + level.min(axis=0), origin[:2] + level.max(axis=0)])


@njit(cache=True, nogil=True)
def _lengths(
    values: Values,
    x0: float,
    y0: float,
    dx: float,
    dy: float,
    low: float,
    high: float,
    origin: Array,
    rays_n: Array,
    grid: Array,
    out: Array,
) -> None:  # pragma: no cover - compiled
    ray = np.empty(3)
    for k in range(len(rays_n)):
        ray[0], ray[1], ray[2] = rays_n[k, 1], rays_n[k, 0], -rays_n[k, 2]
        out[k] = ray_length(values, x0, y0, dx, dy, low, high, origin, ray, grid)


@njit(cache=True, nogil=True)
def _points(
    origin: Array, rays_n: Array, lengths: Array, grid: Array, out: Array
) -> None:  # pragma: no cover - compiled
    for k in range(len(rays_n)):
        x, y, h = point_on_ray(origin[2], rays_n[k, 1], rays_n[k, 0], -rays_n[k, 2], lengths[k])
        out[k, 0] = origin[0] + grid[0, 0] * x + grid[0, 1] * y
        out[k, 1] = origin[1] + grid[1, 0] * x + grid[1, 1] * y
        out[k, 2] = h
