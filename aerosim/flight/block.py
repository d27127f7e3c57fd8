"""An area covered by parallel lines: course, spacing over the relief, ends, order."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from aerosim import polygon
from aerosim.errors import InputError
from aerosim.flight.order import ORDERS, Order, flown
from aerosim.flight.plan import Line
from aerosim.frames import Array, MapGrid
from aerosim.projection import Camera
from aerosim.raster import EARTH_RADIUS, WindowedRaster
from aerosim.tangent import TangentPlane, relief_on

SHORTEST = 500.0  # m: on a shorter line no strip is recognised
# Beyond the last photo, as a part of the base: an interval that is a per cent off costs no photo.
RUN_OUT = 0.5
MOST_TRACKS = 1000
SLICES = 60  # across a line's spacing, in each of which the highest ground is known
__all__ = ["ORDERS", "Block", "Ground", "Wanted", "plan_block"]


class Ground(NamedTuple):
    """The land of a plan.

    grid: map grid; elevation: ellipsoidal heights, m, for a wanted cell (m); cell: of the file, m.
    """

    grid: MapGrid
    elevation: Callable[[float], WindowedRaster]
    cell: float


@dataclass(frozen=True)
class Wanted:
    """How an area is to be covered.

    height: m, above the area's mean ground, or ellipsoidal if not `above_ground`.  side_lap: over the mean ground;
    side_lap_min: nowhere less, over the highest ground between two lines, and beyond the area's edges; end_lap:
    shares.  course: rad, None: along the area.  beyond: photos before and after the area on each line.
    turn_diameter: m, for race tracks.  run_in: m; parts of a line nearer to each other are flown through.
    Raises InputError for values that make no plan.
    """

    height: float
    above_ground: bool = True
    side_lap: float = 0.3
    side_lap_min: float = 0.1
    end_lap: float = 0.6
    course: float | None = None
    beyond: int = 1
    order: Order = "sequential"
    turn_diameter: float = 3000.0
    run_in: float = 4200.0

    def __post_init__(self) -> None:
        for name, value in (("side lap", self.side_lap), ("least side lap", self.side_lap_min)):
            if not 0.0 <= value <= 0.9:
                raise InputError(f"{name} of {100.0 * value:g} %", allowed="0 to 90 %")
        if self.side_lap_min > self.side_lap:
            raise InputError(
                f"least side lap of {100.0 * self.side_lap_min:g} %",
                allowed=f"at most {100.0 * self.side_lap:g} %",
            )
        if not 0.0 <= self.end_lap <= 0.95:
            raise InputError(f"end lap of {100.0 * self.end_lap:g} %", allowed="0 to 95 %")
        if not 0 <= self.beyond <= 20:
            raise InputError(f"{self.beyond} photos beyond the area", allowed="0 to 20")


class Block(NamedTuple):
    """A planned block.

    lines: in the order flown; tracks: of each, its number across the area from 1, parts with letters.  height:
    ellipsoidal, ground: mean of the area, m.  course: of the first line in the area's middle, rad.  spacing:
    between neighbouring tracks, base: between photos, both on the ellipsoid, m.
    """

    lines: tuple[Line, ...]
    tracks: tuple[str, ...]
    height: float
    ground: float
    course: float
    spacing: tuple[float, ...]
    base: float


class _Area:
    """The polygon in the plane, and the relief within it."""

    def __init__(self, corners: Array, ground: Ground) -> None:
        self._corners, self._ground = corners, ground
        # points on one parallel enclose something on the plane, but no area was meant
        polygon.ring_of(EARTH_RADIUS * corners * [1.0, math.cos(float(corners[:, 0].mean()))])
        self.plane = TangentPlane.around(corners)
        self.ring = polygon.ring_of(self.plane.to_plane(corners))
        if (at := polygon.crossing(self.ring)) is not None:
            lat, lon = np.degrees(self.plane.to_geodetic(at))
            raise InputError(
                f"polygon crosses or touches itself at latitude {lat:.5f}, longitude {lon:.5f} deg",
                allowed="corners in their order around the area",
            )
        low, high = self.ring.min(axis=0), self.ring.max(axis=0)
        if float((high - low).max()) > 500e3:
            raise InputError(
                f"area {(high - low).max() / 1e3:.0f} km across",
                allowed="at most 500 km; corners as latitude, longitude",
            )
        self.relief = relief_on(self.plane, (*low, *high), ground.grid, ground.elevation, ground.cell)

    @cached_property
    def cells(self) -> tuple[Array, Array]:
        """Places (n, 2), m, and heights (n,), m, of the cells within; if none is, of all."""
        heights, x0, y0, dx, dy = self.relief[:5]
        x = x0 + dx * np.arange(heights.shape[1], dtype=np.float64)
        y = y0 + dy * np.arange(heights.shape[0], dtype=np.float64)
        within = polygon.inside(self.ring, x, y)
        if not within.any():
            within[:] = True
        rows, cols = np.nonzero(within)
        return np.column_stack([x[cols], y[rows]]), heights[rows, cols].astype(float)

    def _swapped(self) -> str:
        """A guess at the reason why an area lies beyond the terrain."""
        other = TangentPlane.around(self._corners[:, ::-1])
        placed = other.to_plane(self._corners[:, ::-1])
        bounds = (*placed.min(axis=0), *placed.max(axis=0))
        relief = relief_on(other, bounds, self._ground.grid, self._ground.elevation, self._ground.cell)
        return "" if np.isnan(relief.low) else ": latitude and longitude are swapped"

    def levels(self, wanted: Wanted) -> tuple[float, float]:
        """Flying height and mean ground, ellipsoidal, m.  Raises InputError: ground unknown or too high."""
        where, heights = self.cells
        if np.isnan(heights).any():
            missing = where[int(np.argmax(np.isnan(heights)))]
            lat, lon = np.degrees(self.plane.to_geodetic(missing))
            raise InputError(
                f"{100.0 * np.isnan(heights).mean():.3g} % of the area lie beyond the terrain, "
                f"as at latitude {lat:.5f}, longitude {lon:.5f} deg{self._swapped()}",
                allowed="an area on the terrain; corners as latitude, longitude",
            )
        mean = float(heights.mean())
        height = wanted.height + (mean if wanted.above_ground else 0.0)
        if height - heights.max() <= 0.0:
            raise InputError(
                f"{height:.0f} m above the ellipsoid is not above the area's highest ground",
                "flight.height_m",
                f"more than {heights.max():.0f} m",
            )
        return height, mean


def plan_block(
    corners: Array,
    wanted: Wanted,
    camera: Camera,
    ground: Ground,
    *,
    duration: Callable[[Sequence[Line]], float] | None = None,
) -> Block:
    """Parallel lines that cover an area with photos, everywhere twice along the line, without a gap.

    corners: (n, 2) latitude, longitude, rad; its sides are straight on the plane that touches the Earth in its
    middle.  duration: of a flight along lines, s, by which order `shortest` chooses.
    Lines are spaced by the side lap over the mean ground, nearer where the relief asks for it.  Without a course
    they run along the area's narrowest width, which makes their number least; the wind is not considered.
    Raises InputError for a polygon that is none, ground that is not known, a height below the ground.
    """
    area = _Area(corners, ground)
    height, mean = area.levels(wanted)
    where, heights = area.cells
    course = polygon.narrowest(area.ring) if wanted.course is None else wanted.course
    axes = np.array([[math.sin(course), math.cos(course)], [math.cos(course), -math.sin(course)]])
    ring = area.ring @ axes.T
    swath = _Swath(ring, where @ axes[1], heights, height, mean, camera.cols / camera.focal_px, wanted)
    tracks = swath.tracks()
    base = (1.0 - wanted.end_lap) * camera.rows / camera.focal_px * (height - mean) / (1.0 + height / EARTH_RADIUS)
    parts = _parts(ring, tracks, base, wanted)

    def line(track: int, part: int, forward: bool) -> Line:
        middle, bases = parts[track][part]
        first, last = middle - 0.5 * bases * base, middle + (0.5 * bases + RUN_OUT) * base
        along = (first, last) if forward else (2.0 * middle - first, 2.0 * middle - last)
        ends = area.plane.to_geodetic(np.array([[u, tracks[track]] for u in along]) @ axes)
        return Line((float(ends[0, 0]), float(ends[0, 1])), (float(ends[1, 0]), float(ends[1, 1])))

    spacing = tuple(float(step) for step in np.diff(tracks))
    order = flown([len(each) for each in parts], spacing, wanted.order, wanted.turn_diameter, line, duration)
    names = [f"{track + 1}{chr(97 + part) if len(parts[track]) > 1 else ''}" for track, part, _ in order]
    lines = tuple(line(*each) for each in order)
    return Block(lines, tuple(names), height, mean, course + (0.0 if order[0][2] else math.pi), spacing, base)


class _Swath:
    """What a line's photos reach across, over the highest ground there.  Lengths on the ellipsoid, m."""

    def __init__(
        self, ring: Array, across: Array, heights: Array, height: float, mean: float, angle: float, wanted: Wanted
    ) -> None:
        """ring: (n, 2) along, across; across, heights: of the ground's cells, (n,); angle: width over distance."""
        self.low, self.high = float(ring[:, 1].min()), float(ring[:, 1].max())
        self._height, self._angle, self._wanted = height, angle, wanted
        self._usual = (1.0 - wanted.side_lap) * self._width(mean)
        least = self._width(float(heights.max()))
        if (self.high - self.low) / least > MOST_TRACKS:
            raise InputError(
                f"area {(self.high - self.low) / 1e3:.4g} km wide needs more than {MOST_TRACKS} lines",
                allowed="a greater height or a smaller area",
            )
        self._slice = max(least / SLICES, (self.high - self.low) / 100_000.0)
        number = int((self.high - self.low) / self._slice) + 1
        index = np.clip(((across - self.low) / self._slice).astype(int), 0, number - 1)
        self._highest = np.full(number, -np.inf)
        np.maximum.at(self._highest, index, heights)

    def _width(self, ground: float) -> float:
        return self._angle * (self._height - ground) / (1.0 + ground / EARTH_RADIUS)

    def _least(self, low: float, high: float) -> float:
        """Width over the highest ground between two places; beyond the area, over its nearest ground."""
        end = len(self._highest) - 1
        first, last = (min(max(int((at - self.low) / self._slice), 0), end) for at in (low, high))
        # a slice to either side: the relief between two cells may lie on the other side of the limit
        top = float(self._highest[max(first - 1, 0) : last + 2].max())
        return self._width(top if math.isfinite(top) else float(self._highest.max()))

    def _fit(self, low: float, share: float, most: float) -> float:
        """Greatest step up to `most` that is at most a share of the width over the ground it crosses."""
        if most <= share * self._least(low, low + most):
            return most
        short, long = 0.0, most
        for _ in range(24):
            step = 0.5 * (short + long)
            short, long = (step, long) if step <= share * self._least(low, low + step) else (short, step)
        return short

    def _edge(self) -> float:
        """Share of the width by which a line may lie inside of the area's edge."""
        return max(0.5 - self._wanted.side_lap_min, 0.0)

    def _covers(self, track: float) -> float:
        """Where a line's photos surely end on its right."""
        reach = self._fit(track, self._edge(), self._edge() * self._width(-1000.0))
        return track + reach

    def tracks(self) -> Array:
        """Places of the tracks across, rising, the surplus of the outer ones shared by both edges."""
        first = self.low + self._fit(self.low, self._edge(), 0.5 * self._usual / (1.0 - self._wanted.side_lap))
        first = min(first, 0.5 * (self.low + self.high))
        found = self._from(first)
        if len(found) == 1:
            return np.array([0.5 * (self.low + self.high)])
        surplus = self._covers(found[-1]) - self.high
        shared = self._from(first - 0.5 * surplus, len(found))
        # over other ground the lines may lie nearer to each other and fall short of the edge
        return np.array(shared if self._covers(shared[-1]) >= self.high else found)

    def _from(self, first: float, number: int | None = None) -> list[float]:
        """Tracks from a first one on, until the area is covered, or so many."""
        found, share = [first], 1.0 - self._wanted.side_lap_min
        while len(found) < number if number else self._covers(found[-1]) < self.high:
            found.append(found[-1] + self._fit(found[-1], share, self._usual))
        return found


def _parts(ring: Array, tracks: Array, base: float, wanted: Wanted) -> list[list[tuple[float, int]]]:
    """Of each track its parts: middle (m, along) and number of bases.

    A line covers what is nearer to it than to its neighbours; what lies beyond the outer ones is theirs.
    """
    limits = np.concatenate([[ring[:, 1].min()], 0.5 * (tracks[1:] + tracks[:-1]), [ring[:, 1].max()]])
    found = []
    for low, high in pairwise(limits):
        stretches = polygon.merged(polygon.strip(ring, low, high), wanted.run_in + 2.0 * wanted.beyond * base)
        parts = []
        for start, end in stretches:
            bases = math.ceil((end - start) / base + 2.0 * wanted.beyond - 1e-6)
            bases = max(bases, 1, math.ceil(SHORTEST / base - RUN_OUT))
            parts.append((0.5 * (start + end), bases))
        found.append(parts)
    return found
