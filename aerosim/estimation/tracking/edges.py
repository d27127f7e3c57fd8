"""What a shadow leaves of a row: the edges between neighbouring pixels, whatever the light and the gain."""

from __future__ import annotations

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.signals import Grey

DARKEST = 1.0  # grey: a pixel is not taken to be darker
CLIP = 3.0  # mean sizes; the rim of a shadow is an edge like any other and not a greater one
SIZE = 20.0  # mean size of an edge, so that the values are like grey levels
ODD = 4.0  # median differences from which on a pixel has nothing to do with the other row


@njit(cache=True)
def edges(row: Grey, weights: Grey, out: Grey) -> None:  # pragma: no cover - compiled
    """Fill `out` (pixels,) with the differences of the logarithms of each pixel's two neighbours.

    Light that is the same over three pixels falls out of them, a gain everywhere; they are scaled to the mean size
    SIZE and cut off at CLIP times it.  row: grey values; weights: 0 for a pixel that does not count, beside which
    there is no edge either.  The outermost pixels have none: 0.
    """
    last = row.shape[0] - 1
    out[0] = out[last] = np.float32(0.0)
    total, count = 0.0, 0.0
    for i in range(1, last):
        sound = weights[i - 1] * weights[i + 1]
        right, left = max(row[i + 1], np.float32(DARKEST)), max(row[i - 1], np.float32(DARKEST))
        out[i] = sound * np.log(right / left)
        total += abs(out[i])
        count += sound
    usual = total / max(count, 1.0)
    total = 0.0
    for i in range(1, last):
        total += min(abs(out[i]), CLIP * usual)
    most = np.float32(CLIP * total / max(count, 1.0))
    scale = np.float32(CLIP * SIZE) / most if most > 1e-6 else np.float32(0.0)
    for i in range(1, last):
        out[i] = min(max(out[i], -most), most) * scale


def beside(weights: Grey) -> Grey:
    """Weights (pixels,) of the edges of a row whose pixels have these: both neighbours must count."""
    out = np.zeros_like(weights)
    out[1:-1] = weights[:-2] * weights[2:]
    return out


@njit(cache=True)
def common(
    row1: Grey, rows2: Grey, weights: Grey, step: int, mu: int, slope: float, bow: Array
) -> Grey:  # pragma: no cover - compiled
    """Weights (u,) of the pixels of row II that show what row I shows, at a minimum in whole numbers.

    row1, rows2, weights, slope, bow: see `window.surface`.  A pixel that differs by more than ODD times the median
    difference lies under the rim of a shadow that was elsewhere when row I looked.
    """
    u, ring = rows2.shape[1], rows2.shape[0]
    margin, middle = (row1.shape[0] - u) // 2, (u - 1) / 2.0
    off = np.full(u, np.inf, np.float32)
    for i in range(u):
        place = i + margin + mu
        if weights[i] > 0.0 and 0 <= place < row1.shape[0]:
            off[i] = abs(rows2[(step + int(np.round(slope * (i - middle) + bow[i]))) % ring, i] - row1[place])
    usual = np.median(off[off < np.inf]) if (off < np.inf).any() else np.float32(0.0)
    out = np.zeros(u, np.float32)
    for i in range(u):
        out[i] = weights[i] if off[i] <= ODD * usual else np.float32(0.0)
    return out
