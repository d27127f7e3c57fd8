"""The land under a plan, on one plane: lines, relief, heights of corridors."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerosim.errors import InputError
from aerosim.flight.plan import FlightPlan, Line
from aerosim.frames import Array
from aerosim.projection import Camera
from aerosim.raster import EARTH_RADIUS, Window, sample
from aerosim.tangent import TangentPlane, relief_on
from aerosim.world.terrain import Terrain

MOST_SAMPLES = 200  # across a corridor
MOST_STATIONS = 2000  # along one


class Track(NamedTuple):
    """A line on the plane.  start: (2,) east, north, m; ahead, right: unit vectors; length: m on the ellipsoid."""

    start: Array
    ahead: Array
    right: Array
    length: float


class Heights(NamedTuple):
    """Ground of a corridor, ellipsoidal, m; missing: share of it without data."""

    mean: float
    low: float
    high: float
    missing: float


class Land:
    """Plane around a plan, its tracks, and the relief as far as photos reach.

    plane; tracks; relief: heights in metres of the plane; height: of the flight, ellipsoidal, m; lens_along,
    lens_across: size of a photo over the distance.  Raises InputError if there is no ground.
    """

    def __init__(self, plan: FlightPlan, terrain: Terrain, camera: Camera, corners: Array | None = None) -> None:
        """corners: (n, 2) latitude, longitude, rad, of an area that is to be seen as well."""
        ends = np.array([point for line in plan.lines for point in (line.start, line.end)])
        points = ends if corners is None else np.vstack([ends, corners])
        self.plane = TangentPlane.around(points)
        self.height = plan.height
        self.lens_along, self.lens_across = camera.rows / camera.focal_px, camera.cols / camera.focal_px
        self.tracks = [self._track(line) for line in plan.lines]
        placed = self.plane.to_plane(points)
        cell = terrain.elevation_file.native_resolution(terrain.grid.crs)
        lowest = self._under(placed, terrain)
        reach = 0.55 * float(np.hypot(self.lens_along, self.lens_across)) * max(plan.height - lowest, 0.0) + cell
        bounds = (*(placed.min(axis=0) - reach), *(placed.max(axis=0) + reach))
        self.relief: Window = relief_on(self.plane, bounds, terrain.grid, terrain.elevation, cell)

    def _track(self, line: Line) -> Track:
        start, end = self.plane.to_plane([line.start, line.end])
        ahead = (end - start) / np.hypot(*(end - start))
        return Track(start, ahead, np.array([ahead[1], -ahead[0]]), line.length)

    def _under(self, points: Array, terrain: Terrain) -> float:
        """Lowest ground between the points, m."""
        low, high = points.min(axis=0) - 500.0, points.max(axis=0) + 500.0
        window = relief_on(
            self.plane, (*low, *high), terrain.grid, terrain.elevation, float((high - low).max()) / 200.0
        )
        if np.isnan(window.low):
            raise InputError("there is no elevation under the lines", key="terrain.source")
        return window.low - 100.0

    def heights(self, track: Track, half_width: float) -> Heights:
        """Heights of a line's corridor.  half_width: m to either side.  Raises InputError if there are none."""
        step = 2.0 * self.relief.dx
        along = np.linspace(0.0, track.length, min(int(np.ceil(track.length / step)) + 1, MOST_STATIONS))
        number = min(2 * int(np.ceil(half_width / step)) + 1, MOST_SAMPLES + 1)
        aside = np.linspace(-half_width, half_width, number)
        place = track.start + along[:, None, None] * track.ahead + aside[:, None] * track.right
        found = sample(self.relief, place[..., 0], place[..., 1])
        known = found[np.isfinite(found)]
        if not len(known):
            raise InputError("there is no elevation under the line", key="terrain.source")
        missing = 1.0 - len(known) / found.size
        return Heights(float(known.mean()), float(known.min()), float(known.max()), missing)

    def width(self, ground: float) -> float:
        """Width of a photo across over ground (m), in metres of the plane."""
        return self.lens_across * (self.height - ground) / (1.0 + ground / EARTH_RADIUS)
