"""Ground, poses and a slow ray caster of its own for the tests of photo geometry."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pyproj import Transformer
from scipy.interpolate import RegularGridInterpolator

from aerosim.frames import Array, MapGrid, ecef_from_geodetic, geodetic_from_ecef, mat_from_attitude, mat_ne
from aerosim.metrics.footprint import Ground, View
from aerosim.projection import Camera
from aerosim.raster import Window
from aerosim.truth import CameraPose, Shot

# Three degrees from its zone's middle meridian: north of the grid is 1.6 deg off.
UTM = MapGrid("EPSG:32616")
LAT, LON = np.radians(36.52), np.radians(-84.3)
CAMERA = Camera.of_frame(0.153, (0.230, 0.230), 12e-6)
HALF_ANGLE = np.arctan(CAMERA.rows / 2.0 / CAMERA.focal_px)


class Whole:
    """A raster held as one window."""

    def __init__(self, window: Window) -> None:
        self.window = window

    def covering(self, *_: float) -> Window:
        return self.window


class Tight(Whole):
    """A raster that never hands out more than it was asked for, but for the cells around."""

    def covering(self, *area: float) -> Window:
        w = self.window
        first, last = int((area[0] - w.x0) // w.dx), int(-((w.x0 - area[2]) // w.dx))
        top, bottom = int((area[3] - w.y0) // w.dy), int(-((w.y0 - area[1]) // w.dy))
        values = w.values[top : bottom + 1, first : last + 1]
        return Window.of(values, w.x0 + first * w.dx, w.y0 + top * w.dy, w.dx, w.dy)


def window_of(height: Callable[[Array, Array], Array], cell: float = 20.0, half: float = 8000.0) -> Window:
    """Heights, a function of metres east and north of the middle on the grid."""
    east, north = UTM.from_geodetic(LAT, LON)
    axis = np.arange(-half, half + cell / 2.0, cell)
    x, y = np.meshgrid(axis, axis[::-1])
    return Window.of(height(x, y), float(east) - half, float(north) + half, cell, -cell)


def ground_of(window: Window) -> Ground:
    return Ground(UTM, Whole(window))


def flat(height: float = 300.0) -> Ground:
    return ground_of(window_of(lambda x, y: np.full_like(x, height)))


def pose_at(
    offset_n: Array | tuple[float, float, float],
    attitude_deg: tuple[float, float, float] = (0.0, 0.0, 0.0),
    vel_n: tuple[float, float, float] = (70.0, 0.0, 0.0),
    rates: tuple[float, float, float] = (0.0, 0.0, 0.0),
    height: float = 3300.0,
) -> CameraPose:
    """Pose at north, east, down (m) from the middle at a height; axes (heading, pitch, roll) of the middle's n."""
    middle = mat_ne(LAT, LON)
    pos_e = ecef_from_geodetic(LAT, LON, height) + np.asarray(offset_n, float) @ middle
    lat, lon, own_height = (float(v) for v in geodetic_from_ecef(pos_e))
    mat_nc = mat_ne(lat, lon) @ middle.T @ mat_from_attitude(*np.radians(attitude_deg))
    return CameraPose(0.0, lat, lon, own_height, np.array(vel_n), mat_nc, np.array(rates))


def view_at(offset_n: Array | tuple[float, float, float], *attitude_deg: float) -> View:
    return View(CAMERA, pose_at(offset_n, attitude_deg or (0.0, 0.0, 0.0)))


def shot(pose: CameraPose, line: int = 0, fmc_rate: float = 0.0) -> Shot:
    return Shot(pose, line, 25.0, fmc_rate)


def march(window: Window, origin_e: Array, rays_e: Array, step: float = 4.0) -> Array:
    """Points in e where rays meet the raster: small steps, every height through PROJ, then bisection."""
    rows, cols = window.values.shape
    north, east = window.y0 + window.dy * np.arange(rows), window.x0 + window.dx * np.arange(cols)
    surface = RegularGridInterpolator((north[::-1], east), window.values[::-1].astype(float), bounds_error=False)
    to_grid = Transformer.from_crs("EPSG:4978", "EPSG:4979", always_xy=True)

    def above(t: Array, which: Array) -> Array:
        lon, lat, height = to_grid.transform(*(origin_e + t[:, None] * rays_e[which]).T)
        e, n = UTM.from_geodetic(np.radians(lat), np.radians(lon))
        return height - surface(np.column_stack([n, e]))

    t = np.zeros(len(rays_e))
    flying = np.arange(len(rays_e))
    _, _, h0 = to_grid.transform(*origin_e)
    t += h0 - float(window.values.max())  # no ray can meet the ground earlier
    while len(flying):
        flying = flying[above(t[flying] + step, flying) > 0.0]
        t[flying] += step
    everyone = np.arange(len(rays_e))
    for _ in range(18):
        step /= 2.0
        t = np.where(above(t + step, everyone) > 0.0, t + step, t)
    return origin_e + t[:, None] * rays_e
