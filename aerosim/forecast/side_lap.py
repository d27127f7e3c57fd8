"""Side lap of neighbouring lines over the relief."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from aerosim import polygon
from aerosim.forecast.land import Land, Track
from aerosim.frames import Array
from aerosim.raster import EARTH_RADIUS, bilinear
from aerosim.rasterfile import Values

PARALLEL = 0.1  # rad: lines more askew than this are no neighbours
FAR = 2.0  # widths of a photo: lines farther apart are no neighbours
SAME = 0.01  # widths: nearer lines are the same track
STATIONS = 400


class Pair(NamedTuple):
    """Two neighbouring lines.

    first, second: their indices; spacing: m on the ellipsoid, midway; mean, least: side lap as a share, over the
    stations along them; place: (2,) east, north of the least one, m.  NaN without ground.
    """

    first: int
    second: int
    spacing: float
    mean: float
    least: float
    place: Array


def pairs(land: Land, area: Array | None = None) -> list[Pair]:
    """Side lap of all neighbouring lines, from one side of the block to the other.

    At each station along both lines: 1 - spacing / (reach of the one + reach of the other), each towards the
    other, where a photo reaches to the first ground that its edge meets.  area: ring (n, 2), m, on the plane;
    only stations count at which both edges meet ground within it; if there are none, those with the middle
    between both edges within.  Pairs without any are left out.
    """
    width = land.width(land.relief.low)
    found = [_pair(land, *each, area) for each in _neighbours(land.tracks, width)]
    return [pair for pair in found if pair is not None]


def _neighbours(tracks: list[Track], width: float) -> Iterator[tuple[int, int, float, float]]:
    """Indices of lines on neighbouring tracks, and the stretch (m along the first) that they share."""
    left = set(range(len(tracks)))
    while left:
        lead = tracks[min(left)]
        group = [k for k in left if abs(tracks[k].ahead @ lead.right) < PARALLEL]
        left -= set(group)
        across = {
            k: float((tracks[k].start + 0.5 * tracks[k].length * tracks[k].ahead) @ lead.right) for k in group
        }
        group.sort(key=across.__getitem__)
        rows: list[list[int]] = []
        for k in group:
            if rows and across[k] - across[rows[-1][-1]] < SAME * width:
                rows[-1].append(k)
            else:
                rows.append([k])
        for row, following in pairwise(rows):
            for k, j in product(row, following):
                low, high = _shared(tracks[k], tracks[j])
                if high > low and across[j] - across[k] < FAR * width:
                    yield k, j, low, high


def _shared(track: Track, other: Track) -> tuple[float, float]:
    """Stretch along a line that lies beside another, m; empty if the second is not above the first."""
    ends = [float((other.start + d * other.ahead - track.start) @ track.ahead) for d in (0.0, other.length)]
    return max(0.0, min(ends)), min(track.length, max(ends))


def _pair(land: Land, first: int, second: int, low: float, high: float, area: Array | None) -> Pair | None:
    """Side lap of two lines between two places (m) along the first."""
    one, other = land.tracks[first], land.tracks[second]
    along = np.linspace(low, high, min(int((high - low) / land.relief.dx) + 2, STATIONS))
    here = one.start + along[:, None] * one.ahead
    # where the perpendicular of the first line meets the second
    shift = other.start - here
    side = 1.0 if float(shift[len(shift) // 2] @ one.right) > 0.0 else -1.0
    cosine = float(other.ahead @ one.ahead)
    there = other.start - ((shift @ one.ahead) / cosine)[:, None] * other.ahead
    spacing = np.abs((there - here) @ one.right)
    outward = side * one.right
    reaches = np.empty((2, len(along)))
    for row, (start, way) in enumerate(((here, outward), (there, -outward))):
        _reach(*land.relief[:5], start, way, land.height, 0.5 * land.lens_across, reaches[row])
    lap = 1.0 - spacing / reaches.sum(axis=0)
    if area is not None:
        counts = _within(area, here + reaches[0][:, None] * outward, there - reaches[1][:, None] * outward)
        if not (counts | ~np.isfinite(lap)).any():
            return None
        lap = np.where(counts, lap, np.nan)
    if not np.isfinite(lap).any():
        return Pair(first, second, float(spacing.mean()), np.nan, np.nan, here[0])
    at = int(np.nanargmin(lap))
    place = 0.5 * (here[at] + there[at])
    return Pair(first, second, float(np.median(spacing)), float(np.nanmean(lap)), float(lap[at]), place)


def _within(area: Array, one: Array, other: Array) -> NDArray[np.bool_]:
    """Stations that count.  one, other: where both photos' edges meet the ground, (n, 2), m, NaN if unknown."""
    both = polygon.holds(area, one) & polygon.holds(area, other)
    return both if both.any() else polygon.holds(area, 0.5 * (one + other))


@njit(cache=True, nogil=True)
def _reach(
    values: Values,
    x0: float,
    y0: float,
    dx: float,
    dy: float,
    start: Array,
    way: Array,
    height: float,
    angle: float,
    out: Array,
) -> None:  # pragma: no cover - compiled
    """Distance on the plane (m) from each start to the first ground outside of the photo; NaN where unknown."""
    for k in range(len(start)):
        at, before = 0.0, 1.0
        while True:
            ground = bilinear(values, x0, y0, dx, dy, start[k, 0] + at * way[0], start[k, 1] + at * way[1])
            # how far the picture's edge lies outside of this ground, m across
            after = angle * (height - ground + 0.5 * at * at / EARTH_RADIUS) - at * (1.0 + ground / EARTH_RADIUS)
            if not after > 0.0:
                out[k] = at + dx * after / (before - after) if at > 0.0 or after != after else 0.0  # noqa: PLR0124
                break
            before = after
            at += dx


def figures(land: Land, found: list[Pair], names: Sequence[str]) -> list[dict[str, Any]]:
    """Section `side_lap` of the forecast.  names: of the lines."""
    rows = []
    for pair in found:
        lat, lon = np.degrees(land.plane.to_geodetic(pair.place))
        known = np.isfinite(pair.least)
        rows.append(
            {
                "lines": f"{names[pair.first]}, {names[pair.second]}",
                "spacing_m": pair.spacing,
                "side_lap_mean_pct": 100.0 * pair.mean if known else None,
                "side_lap_min_pct": 100.0 * pair.least if known else None,
                "min_lat_deg": float(lat),
                "min_lon_deg": float(lon),
            }
        )
    return rows
