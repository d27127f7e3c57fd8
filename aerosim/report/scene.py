"""The 3D scene of a run for the viewer: land, lines, path, aircraft, camera, footprints."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerosim.frames import Array
from aerosim.raster import Window, sample
from aerosim.report.chart import extent
from aerosim.report.source import Source, middle

TEXTURE_PX = 2048
MESH_CELLS = 220
# The viewer clips at 0.01 units: in metres its depth buffer could not tell a line from the land below it
KM = 1e-3
POSE_PERIOD = 0.2
PATH_RGB, LINE_RGB = (86, 180, 233), (20, 20, 20)
SHOT_RGB, SEEN_RGB, CAMERA_RGB = (255, 140, 0), (255, 255, 255), (255, 214, 0)


class Scene:
    """Coordinates for the viewer: grid east, north, up in km from a point on the mean ground."""

    def __init__(self, source: Source) -> None:
        """Looks at nothing yet; the land is read when asked for."""
        self.source = source
        self.bounds = extent(source)
        e_min, n_min, e_max, n_max = self.bounds
        self.centre = np.array([(e_min + e_max) / 2.0, (n_min + n_max) / 2.0])
        self.size = max(e_max - e_min, n_max - n_min)

    @cached_property
    def window(self) -> Window | None:
        """Heights under the scene, coarse."""
        land = self.source.terrain
        if land is None:
            return None
        margin = 0.05 * self.size
        e_min, n_min, e_max, n_max = self.bounds
        low = np.maximum([e_min - margin, n_min - margin], land.bounds[:2])
        high = np.minimum([e_max + margin, n_max + margin], land.bounds[2:])
        if (high <= low).any():
            return None
        # a window of its own: the terrain's would read far around, for a flight that goes on
        # cells are whole ones of the file, down to half of what is wanted
        heights = land.elevation(self.size / (2.0 * MESH_CELLS), size=3 * MESH_CELLS)
        return heights.covering(*map(float, (*low, *high)))

    @cached_property
    def ground(self) -> float:
        """Height that is zero in the scene, m: the mean ground, or what the record says is below."""
        if self.window is not None:
            return middle(self.window.values)
        tel = self.source.telemetry
        return middle(tel["height_m"] - tel["agl_m"]) if self.source.count(tel) else 0.0

    def local(self, east: Any, north: Any, height: Any) -> NDArray[np.float32]:
        """Scene coordinates (km) of map points (m), (n, 3)."""
        metres = np.column_stack(
            [
                np.asarray(east) - self.centre[0],
                np.asarray(north) - self.centre[1],
                np.asarray(height) - self.ground,
            ]
        )
        return np.asarray(KM * metres, np.float32)

    def draped(self, points: Array, above: float = 60.0) -> NDArray[np.float32]:
        """Points (n, 2), m, laid on the ground, a little above it; on the mean ground where there is none."""
        height = np.full(len(points), self.ground)
        if self.window is not None:
            found = sample(self.window, points[:, 0], points[:, 1])
            height = np.where(np.isfinite(found), found, self.ground)
        return self.local(points[:, 0], points[:, 1], height + above)

    @cached_property
    def convergence(self) -> float:
        """Azimuth of the grid's north in the middle of the scene, rad: grid bearing = true bearing - this."""
        lat, lon = self.source.grid.to_geodetic(*self.centre)
        east, north = self.source.grid.from_geodetic(np.array([lat, lat + 1e-4]), np.array([lon, lon]))
        return float(-np.arctan2(east[1] - east[0], north[1] - north[0]))


def subdivided(corners: Array, pieces: int = 8) -> Array:
    """A closed outline with points between its corners.  (4, 2) to (4 pieces + 1, 2)."""
    ring = np.concatenate([corners, corners[:1]])
    s = np.linspace(0.0, 4.0, 4 * pieces + 1)
    return np.column_stack([np.interp(s, np.arange(5.0), ring[:, k]) for k in (0, 1)])


def land_mesh(scene: Scene) -> dict[str, Any]:
    """Arguments of a textured mesh of the land, empty if there is none."""
    window, land = scene.window, scene.source.terrain
    if window is None or land is None:
        return {}
    e_min, n_min, e_max, n_max = window.bounds
    margin = 0.05 * scene.size
    b = scene.bounds
    low = np.max([(e_min, n_min), (b[0] - margin, b[1] - margin), land.bounds[:2]], axis=0)
    high = np.min([(e_max, n_max), (b[2] + margin, b[3] + margin), land.bounds[2:]], axis=0)
    cut = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))
    step = max(cut[2] - cut[0], cut[3] - cut[1]) / MESH_CELLS
    east = np.linspace(cut[0], cut[2], max(2, round((cut[2] - cut[0]) / step)))
    north = np.linspace(cut[3], cut[1], max(2, round((cut[3] - cut[1]) / step)))
    grid_e, grid_n = (a.ravel() for a in np.meshgrid(east, north))
    height = sample(window, grid_e, grid_n)
    picture, place = land.picture(TEXTURE_PX, cut)
    left, top = place.x0 - place.dx / 2.0, place.y0 - place.dy / 2.0
    rows, cols = picture.shape[:2]
    uv = np.column_stack([(grid_e - left) / (place.dx * cols), (grid_n - top) / (place.dy * rows)])
    return {
        "vertex_positions": scene.local(grid_e, grid_n, np.nan_to_num(height, nan=scene.ground)),
        "triangle_indices": _triangles(len(north), len(east), np.isfinite(height)),
        "vertex_texcoords": uv.astype(np.float32),
        "albedo_texture": picture,
    }


def _triangles(rows: int, cols: int, known: NDArray[np.bool_]) -> NDArray[np.uint32]:
    """Two triangles a cell, without those that touch a missing height."""
    a = (np.arange(rows - 1)[:, None] * cols + np.arange(cols - 1)).ravel()
    quads = np.concatenate(
        [np.column_stack([a, a + cols, a + 1]), np.column_stack([a + 1, a + cols, a + cols + 1])]
    )
    return np.asarray(quads[known[quads].all(axis=1)], np.uint32)


def aircraft_mesh(span: float) -> dict[str, Any]:
    """A twin seen from afar, in body axes (x forward, y right, z down).  span: in the scene's unit."""
    half = span / 2.0
    wing, body, fin = (230, 80, 20), (250, 250, 250), (200, 60, 10)
    plates: list[tuple[list[tuple[float, float, float]], tuple[int, int, int]]] = [
        ([(0.16, 0, 0), (0.06, 1, -0.03), (-0.08, 1, -0.03), (-0.14, 0, 0)], wing),
        ([(0.16, 0, 0), (0.06, -1, -0.03), (-0.08, -1, -0.03), (-0.14, 0, 0)], wing),
        ([(-0.62, 0, -0.05), (-0.70, 0.36, -0.05), (-0.80, 0.36, -0.05), (-0.82, 0, -0.05)], wing),
        ([(-0.62, 0, -0.05), (-0.70, -0.36, -0.05), (-0.80, -0.36, -0.05), (-0.82, 0, -0.05)], wing),
        ([(-0.55, 0, -0.04), (-0.76, 0, -0.34), (-0.86, 0, -0.34), (-0.84, 0, -0.04)], fin),
    ]
    ring = [(0.0, 0.085), (0.085, 0.0), (0.0, -0.085), (-0.085, 0.0)]
    for (y0, z0), (y1, z1) in zip(ring, [*ring[1:], ring[0]], strict=True):
        plates.append(([(0.55, 0, 0), (0.3, y0, z0), (0.3, y1, z1), (0.55, 0, 0)], body))
        plates.append(([(0.3, y0, z0), (-0.3, y0, z0), (-0.3, y1, z1), (0.3, y1, z1)], body))
        plates.append(([(-0.3, y0, z0), (-0.86, 0, -0.03), (-0.86, 0, -0.03), (-0.3, y1, z1)], body))
    points = np.array([corner for plate, _ in plates for corner in plate], np.float32) * half
    colours = np.repeat(np.array([colour for _, colour in plates], np.uint8), 4, axis=0)
    first = 4 * np.arange(len(plates), dtype=np.uint32)[:, None]
    triangles = np.concatenate([first + np.array([0, 1, 2], np.uint32), first + np.array([0, 2, 3], np.uint32)])
    return {"vertex_positions": points, "triangle_indices": triangles, "vertex_colors": colours}


def quaternions(heading: Array, pitch: Array, roll: Array, convergence: float) -> Array:
    """Rotations of body axes in the scene (east, north, up): x, y, z, w.  Angles (n,), rad.  Returns (n, 4)."""
    half = np.stack([np.asarray(heading) - convergence, pitch, roll]) / 2.0
    (sh, sp, sr), (ch, cp, cr) = np.sin(half), np.cos(half)
    w, x = ch * cp * cr + sh * sp * sr, ch * cp * sr - sh * sp * cr
    y, z = ch * sp * cr + sh * cp * sr, sh * cp * cr - ch * sp * sr
    # north-east-down to east-north-up: half a turn about the line between north and east
    return np.asarray(np.column_stack([w + z, w - z, y - x, -x - y]) * np.sqrt(0.5))


def upright(azimuth: Array) -> Array:
    """Rotations about up that bring x to grid azimuths (n,), rad: x, y, z, w.  (n, 4)."""
    half = (np.pi / 2.0 - np.unwrap(azimuth)) / 2.0
    return np.column_stack([0.0 * half, 0.0 * half, np.sin(half), np.cos(half)])


def camera_attitude(source: Source, keep: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """Heading, pitch, roll (rad) of the camera at telemetry rows, as drawn.

    Heading is exact (track less crab).  The record has no tilt of the camera between photos: it is drawn with
    the airframe's, less the mean pitch where the mount takes the trim out, and level if it is stabilised.
    """
    tel, level = source.telemetry, source.scenario.mount.level
    heading = np.radians(tel["track_deg"] - tel["crab_true_deg"])[keep]
    pitch, roll = np.radians(tel["pitch_deg"])[keep], np.radians(tel["roll_deg"])[keep]
    if level == "stabilised":
        return heading, 0.0 * pitch, 0.0 * roll
    if level == "static":
        on_line = tel["line"] >= 0
        pitch = pitch - np.radians(middle(tel["pitch_deg"][on_line]))
    return heading, pitch, roll
