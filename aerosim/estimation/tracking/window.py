"""MAD surface of one strip in its window: centred on the prediction, slanted by a known turn."""

from __future__ import annotations

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.signals import Grey

FLAT_GREY = 0.3  # standard deviation of a row that shows nothing
LEAST_SHARE = 0.5  # of the pixels of row II, compared at the outermost shifts


@njit(cache=True, fastmath=True)
def moments(row: Grey, weights: Grey) -> tuple[np.float32, np.float32]:  # pragma: no cover - compiled
    """Mean and standard deviation of the pixels that count, grey levels."""
    total, square, count = 0.0, 0.0, 0.0
    for i in range(row.shape[0]):
        total += weights[i] * row[i]
        square += weights[i] * row[i] * row[i]
        count += weights[i]
    if count == 0.0:
        return np.float32(0.0), np.float32(0.0)
    mean = total / count
    return np.float32(mean), np.float32(np.sqrt(max(square / count - mean * mean, 0.0)))


@njit(cache=True, fastmath=True)
def _differences(row1: Grey, row2: Grey, weights: Grey) -> np.float32:  # pragma: no cover - compiled
    """Weighted sum of absolute differences; of its own, so that it is taken several pixels at a time."""
    total = np.float32(0.0)
    for i in range(row2.shape[0]):
        total += weights[i] * abs(row1[i] - row2[i])
    return total


@njit(cache=True, fastmath=True)
def surface(
    row1: Grey,
    rows2: Grey,
    weights: Grey,
    first: int,
    steps: int,
    centre: int,
    half: int,
    slope: float,
    bow: Array,
) -> Grey:  # pragma: no cover - compiled
    """Mean absolute differences, (steps, 2 half + 1), of a strip of row I and exposures of row II.

    row1: (u + 2 j,).  rows2: ring, (ring, u), exposure number modulo the ring.  Each row is centred and scaled
    by its own mean and standard deviation, those of row II after it was put together.
    weights: (u,), 0 leaves a pixel of row II out.  first: exposure of the first row of the surface.  centre,
    half: shifts centre - half ... centre + half, px; beyond +-j fewer pixels face each other, below LEAST_SHARE
    the value is infinite.  slope: exposures by which each pixel of row II is read later than its left neighbour.
    bow: (u,) exposures by which it is read later besides, for the optics' distortion.
    """
    u, ring = rows2.shape[1], rows2.shape[0]
    margin, middle = (row1.shape[0] - u) // 2, (u - 1) / 2.0
    out = np.empty((steps, 2 * half + 1), np.float32)
    row2, at = np.empty(u, np.float32), np.empty(u, np.int64)  # at: places of its pixels in the ring
    mean1, spread1 = moments(row1[margin : margin + u], weights)
    row1 = row1 - mean1
    for i in range(u):
        at[i] = (first + int(np.round(slope * (i - middle) + bow[i]))) % ring
    for s in range(steps):
        for i in range(u):
            row2[i] = rows2[at[i], i]
            at[i] = at[i] + 1 if at[i] + 1 < ring else 0
        mean, spread = moments(row2, weights)
        scale = np.float32(spread1 / spread) if spread > FLAT_GREY else np.float32(0.0)
        for i in range(u):
            row2[i] = (row2[i] - mean) * scale
        for k in range(2 * half + 1):
            start = margin + centre - half + k  # element of row I that faces the first one of row II
            begin, end = max(0, -start), min(u, row1.shape[0] - start)
            pairs = weights[begin:end].sum() if begin < end else np.float32(0.0)
            if pairs < LEAST_SHARE * u:
                out[s, k] = np.inf
                continue
            facing = row1[start + begin : start + end]
            out[s, k] = _differences(facing, row2[begin:end], weights[begin:end]) / pairs
    return out
