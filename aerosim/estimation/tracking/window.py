"""MAD surface of one strip in its window: centred on the prediction, slanted by a known turn."""

from __future__ import annotations

import numpy as np
from numba import njit

from aerosim.signals import Grey

LEAST_SHARE = 0.5  # of the pixels of row II, compared at the outermost shifts


@njit(cache=True, fastmath=True)
def surface(
    row1: Grey, rows2: Grey, weights: Grey, first: int, steps: int, centre: int, half: int, slope: float
) -> Grey:  # pragma: no cover - compiled
    """Mean absolute differences, (steps, 2 half + 1), of a strip of row I and exposures of row II.

    row1: (u + 2 j,).  rows2: ring, (ring, u), exposure number modulo the ring.  Both centred and scaled alike.
    weights: (u,), 0 leaves a pixel of row II out.  first: exposure of the first row of the surface.  centre,
    half: shifts centre - half ... centre + half, px; beyond +-j fewer pixels face each other, below LEAST_SHARE
    the value is infinite.  slope: exposures by which each pixel of row II is read later than its left neighbour.
    """
    u, ring = rows2.shape[1], rows2.shape[0]
    margin, middle = (row1.shape[0] - u) // 2, (u - 1) / 2.0
    out = np.empty((steps, 2 * half + 1), np.float32)
    row2 = np.empty(u, np.float32)
    late = np.empty(u, np.int64)
    for i in range(u):
        late[i] = int(np.round(slope * (i - middle)))
    for s in range(steps):
        for i in range(u):
            row2[i] = rows2[(first + s + late[i]) % ring, i]
        for k in range(2 * half + 1):
            shift = centre - half + k
            begin = max(0, -(margin + shift))
            end = min(u, row1.shape[0] - margin - shift)
            total, pairs = np.float32(0.0), np.float32(0.0)
            for i in range(begin, end):
                total += weights[i] * abs(row1[margin + shift + i] - row2[i])
                pairs += weights[i]
            out[s, k] = total / pairs if pairs >= LEAST_SHARE * u else np.inf
    return out
