"""How often each piece of an area is seen by planned photos, counted on a grid over the relief."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from aerosim import polygon
from aerosim.forecast.land import Land
from aerosim.forecast.shots import Shots
from aerosim.frames import Array
from aerosim.raster import EARTH_RADIUS, sample
from aerosim.rasterfile import Values

Counts = NDArray[np.uint16]
GAPS_TOLD = 20
LEAST_CELLS = 1000  # of an area
MOST_CELLS = 2000  # along a side of a grid that is finer than the relief


class Coverage(NamedTuple):
    """Photos that see each cell of the relief's grid.

    counts: (rows, cols); within: cells of the area whose height is known; unknown: share of the area without
    height; x, y: east and north of the columns and rows on the plane, m; area: of the polygon, m2.
    """

    counts: Counts
    within: NDArray[np.bool_]
    unknown: float
    x: Array
    y: Array
    area: float

    @property
    def cell_area(self) -> float:
        """Area of a cell, m2."""
        return float(abs((self.x[1] - self.x[0]) * (self.y[1] - self.y[0])))

    def share(self, number: int, *, or_more: bool = False) -> float:
        """Share of the area seen by so many photos."""
        seen = self.counts[self.within]
        return float(np.mean(seen >= number if or_more else seen == number)) if len(seen) else 0.0

    def gaps(self) -> list[tuple[float, float, float]]:
        """Pieces that no photo sees, the largest first: east, north of a cell in it, m, and area, m2."""
        from scipy.ndimage import label

        pieces, number = label(self.within & (self.counts == 0), structure=np.ones((3, 3)))
        if not number:
            return []
        cells = np.bincount(pieces.ravel(), minlength=number + 1)[1:]
        found = []
        for piece in np.argsort(-cells, kind="stable")[:GAPS_TOLD]:
            rows, cols = np.nonzero(pieces == piece + 1)
            nearest = int(np.argmin((rows - rows.mean()) ** 2 + (cols - cols.mean()) ** 2))
            place = float(self.x[cols[nearest]]), float(self.y[rows[nearest]])
            found.append((*place, float(cells[piece]) * self.cell_area))
        return found


def coverage(land: Land, shots: Shots, ring: Array) -> Coverage:
    """Count the photos over the cells of the relief within a ring (n, 2), m, on the plane.

    A cell counts if its middle, at its true height, appears in a level photo; that a ridge may stand between is
    left out.  Of an area of a few cells the grid is finer than the relief.
    """
    area = abs(polygon.area(ring))
    piece, x, y = _cells(land, ring, math.sqrt(area / LEAST_CELLS))
    counts = np.zeros(piece.shape, np.uint16)
    half = 0.5 * land.lens_along, 0.5 * land.lens_across
    reach = float(np.hypot(*half)) * (land.height - float(np.nanmin(piece, initial=land.height)))
    _count(piece, x, y, shots.place, shots.heading, land.height, *half, 1.01 * reach, counts)
    wanted = polygon.inside(ring, x, y)
    known = np.isfinite(piece)
    unknown = 1.0 - float(known[wanted].mean()) if wanted.any() else 0.0
    return Coverage(counts, wanted & known, unknown, x, y, area)


def _cells(land: Land, ring: Array, finest: float) -> tuple[Values, Array, Array]:
    """Heights over a ring (n, 2), m, their columns' east and rows' north, m.  finest: cell that suffices, m."""
    heights, x0, y0, dx, dy = land.relief[:5]
    low, high = ring.min(axis=0), ring.max(axis=0)
    step = max(finest, float((high - low).max()) / MOST_CELLS)
    if step < dx:
        x = np.arange(low[0] - 0.5 * step, high[0] + step, step)
        y = np.arange(high[1] + 0.5 * step, low[1] - step, -step)
        return sample(land.relief, *np.meshgrid(x, y)).astype(heights.dtype), x, y
    c0, c1 = (int(np.clip(round((at - x0) / dx), 0, heights.shape[1] - 1)) for at in (low[0], high[0]))
    r0, r1 = (int(np.clip(round((at - y0) / dy), 0, heights.shape[0] - 1)) for at in (high[1], low[1]))
    x = x0 + dx * np.arange(c0, max(c1, c0 + 1) + 1, dtype=np.float64)
    y = y0 + dy * np.arange(r0, max(r1, r0 + 1) + 1, dtype=np.float64)
    return np.ascontiguousarray(heights[r0 : r0 + len(y), c0 : c0 + len(x)]), x, y


@njit(cache=True, nogil=True)
def _count(
    heights: Values,
    x: Array,
    y: Array,
    place: Array,
    heading: Array,
    height: float,
    along: float,
    across: float,
    reach: float,
    counts: Counts,
) -> None:  # pragma: no cover - compiled
    """Add each photo to the cells that it shows.  along, across: half the picture over the distance."""
    step_x, step_y = x[1] - x[0], y[0] - y[1]
    for k in range(len(place)):
        px, py = place[k, 0], place[k, 1]
        s, c = np.sin(heading[k]), np.cos(heading[k])
        c0, c1 = max(int((px - reach - x[0]) / step_x), 0), min(int((px + reach - x[0]) / step_x) + 2, len(x))
        r0, r1 = max(int((y[0] - py - reach) / step_y), 0), min(int((y[0] - py + reach) / step_y) + 2, len(y))
        for i in range(r0, r1):
            north = y[i] - py
            for j in range(c0, c1):
                east, ground = x[j] - px, heights[i, j]
                if ground != ground or counts[i, j] == 65535:  # noqa: PLR0124  (NaN)
                    continue
                # ground away from the nadir lies below the photo's own level by the Earth's curve
                depth = height - ground + 0.5 * (east * east + north * north) / EARTH_RADIUS
                scale = 1.0 + ground / EARTH_RADIUS
                ahead, right = scale * (east * s + north * c), scale * (east * c - north * s)
                if abs(ahead) <= along * depth and abs(right) <= across * depth:
                    counts[i, j] += 1


def figures(land: Land, found: Coverage) -> dict[str, Any]:
    """Section `coverage` of the forecast."""
    gaps = []
    for east, north, size in found.gaps():
        lat, lon = np.degrees(land.plane.to_geodetic([east, north]))
        gaps.append({"lat_deg": float(lat), "lon_deg": float(lon), "area_m2": size})
    return {
        "area_km2": found.area / 1e6,
        "grid_m": float(found.x[1] - found.x[0]),
        "seen_0_pct": 100.0 * found.share(0),
        "seen_1_pct": 100.0 * found.share(1),
        "seen_2_pct": 100.0 * found.share(2),
        "seen_3_or_more_pct": 100.0 * found.share(3, or_more=True),
        "unknown_pct": 100.0 * found.unknown,
        "gaps": gaps,
    }
