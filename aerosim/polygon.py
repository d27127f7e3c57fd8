"""Polygons in a plane: checked, cut into strips, measured."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerosim.errors import InputError
from aerosim.frames import Array

MOST_CORNERS = 2000
NEAR = 1e-3  # m: corners nearer to each other are one
FLAT = 1e-5  # of the perimeter's square: a polygon of less area is none


def ring_of(points: ArrayLike) -> Array:
    """Corners of a polygon, each once, in order.  points: (n, 2), m, closed or not.  Returns (m, 2), m.

    Raises InputError for fewer than three corners, an area of zero, too many corners.  Whether it crosses itself:
    `crossing`.
    """
    ring = np.asarray(points, float).reshape(-1, 2)
    if not np.isfinite(ring).all():
        raise InputError("a corner is not a number")
    if len(ring):
        ring = ring[np.hypot(*(ring - np.roll(ring, 1, axis=0)).T) > NEAR]
    distinct = len(np.unique(np.round(ring / NEAR), axis=0)) if len(ring) else 0
    if distinct < 3:
        raise InputError(f"polygon with {distinct} distinct corners", allowed="at least 3")
    if len(ring) > MOST_CORNERS:
        raise InputError(f"polygon with {len(ring)} corners", allowed=f"at most {MOST_CORNERS}")
    perimeter = float(np.hypot(*(ring - np.roll(ring, 1, axis=0)).T).sum())
    if abs(area(hull(ring))) <= FLAT * perimeter**2:
        raise InputError("polygon with an area of zero", allowed="corners that are not on one line")
    return ring


def area(ring: Array) -> float:
    """Area, m2, of a ring (n, 2), m; positive if it runs counter-clockwise."""
    x, y = (ring - ring[0]).T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def crossing(ring: Array) -> Array | None:
    """A point (2,), m, at which a ring (n, 2), m, crosses, touches or retraces itself; None if it does not."""
    start, way = ring, np.roll(ring, -1, axis=0) - ring
    n = len(ring)
    after = np.roll(way, -1, axis=0)
    back = (np.abs(_cross(way, after)) <= 1e-12 * np.hypot(*way.T) * np.hypot(*after.T)) & (
        (way * after).sum(axis=1) < 0.0
    )
    if back.any():
        return np.asarray(np.roll(ring, -1, axis=0)[int(np.argmax(back))])
    between = start[None, :] - start[:, None]
    det = _cross(way[:, None], way[None, :])
    with np.errstate(divide="ignore", invalid="ignore"):
        mine = _cross(between, way[None, :]) / det
        other = _cross(between, way[:, None]) / det
    meet = (mine >= 0.0) & (mine <= 1.0) & (other >= 0.0) & (other <= 1.0)
    i, j = np.indices((n, n))
    meet &= (j > i + 1) & ~((i == 0) & (j == n - 1))
    if not meet.any():
        return None
    first = np.unravel_index(int(np.argmax(meet)), meet.shape)
    return np.asarray(start[first[0]] + mine[first] * way[first[0]])


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def inside(ring: Array, x: Array, y: Array) -> NDArray[np.bool_]:
    """Which points of a grid lie within a ring (n, 2), m.  x: (cols,), rising, y: (rows,), m.  (rows, cols)."""
    found = np.zeros((len(y), len(x)), bool)
    for row, level in enumerate(y):
        for low, high in section(ring, float(level)):
            found[row, np.searchsorted(x, low) : np.searchsorted(x, high, side="right")] = True
    return found


def holds(ring: Array, points: Array) -> NDArray[np.bool_]:
    """Which points (n, 2), m, lie within a ring (m, 2), m; unknown ones (NaN) do not.  (n,)."""
    found = np.zeros(len(points), bool)
    x, y = points.T
    for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        if y0 != y1:
            found ^= ((y0 <= y) != (y1 <= y)) & (x < x0 + (y - y0) / (y1 - y0) * (x1 - x0))
    return found


def section(ring: Array, level: float) -> list[tuple[float, float]]:
    """Stretches of x, m, within a ring (n, 2), m, on the line y = level, m."""
    x, y = ring.T
    x_next, y_next = np.roll(x, -1), np.roll(y, -1)
    cut = (y <= level) != (y_next <= level)
    at = np.sort(x[cut] + (level - y[cut]) / (y_next[cut] - y[cut]) * (x_next[cut] - x[cut]))
    return [(float(low), float(high)) for low, high in zip(at[::2], at[1::2], strict=True)]


def strip(ring: Array, low: float, high: float) -> list[tuple[float, float]]:
    """Stretches of x, m, that a ring (n, 2), m, takes up between y = low and y = high, m, in rising order.

    The outline of what lies in the strip consists of pieces of the ring and of the strip's two sides.
    """
    found = [*section(ring, low), *section(ring, high)]
    x, y = ring.T
    x_next, y_next = np.roll(x, -1), np.roll(y, -1)
    for x0, y0, x1, y1 in zip(x, y, x_next, y_next, strict=True):
        if max(y0, y1) < low or min(y0, y1) > high:
            continue
        cut = np.clip([y0, y1], low, high)
        ends = [x0, x1] if y0 == y1 else list(x0 + (cut - y0) / (y1 - y0) * (x1 - x0))
        found.append((float(min(ends)), float(max(ends))))
    return merged(found, 0.0)


def merged(stretches: list[tuple[float, float]], gap: float) -> list[tuple[float, float]]:
    """Stretches (m) in rising order, those at most a gap (m) apart joined."""
    found: list[tuple[float, float]] = []
    for low, high in sorted(stretches):
        if found and low <= found[-1][1] + gap:
            found[-1] = (found[-1][0], max(found[-1][1], high))
        else:
            found.append((low, high))
    return found


def hull(points: Array) -> Array:
    """Convex hull of points (n, 2), m, counter-clockwise.  (m, 2).  Andrew's monotone chain (1979)."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    half: list[list[tuple[float, float]]] = []
    for way in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for p in way:
            while len(chain) > 1 and (
                (chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1])
                <= (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])
            ):
                chain.pop()
            chain.append(p)
        half.append(chain[:-1])
    return np.array(half[0] + half[1])


def narrowest(ring: Array) -> float:
    """Azimuth (rad, 0 to pi, from +y towards +x) along which a ring (n, 2), m, is seen narrowest.

    The least width of a convex polygon is across one of its sides.
    """
    corners = hull(ring)
    sides = np.roll(corners, -1, axis=0) - corners
    right = np.stack([sides[:, 1], -sides[:, 0]]) / np.hypot(*sides.T)
    width = np.ptp(corners @ right, axis=0)
    ahead = sides[int(np.argmin(np.round(width, 6)))]
    return float(np.mod(np.arctan2(ahead[0], ahead[1]), np.pi))
