"""Pixels that see nothing: they do not change while the ground moves on."""

from __future__ import annotations

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.signals import Grey

MEMORY = 64.0  # rows
SURE = 20  # rows before a pixel is given up
DEAD = 0.02  # of the median variance of all pixels


class Health:
    """Watches each pixel's variance over the rows of the last while."""

    def __init__(self, pixels: int) -> None:
        """All are taken for sound."""
        self._mean = np.zeros(pixels)
        self._variance = np.zeros(pixels)
        self._seen = 0

    def __call__(self, row: Grey) -> Grey:
        """Weights (pixels,) after one more row: 1 for a pixel that sees, 0 for one that does not.

        A row without any contrast in time (water, a blind row) says nothing about single pixels: all count.
        """
        if self._seen == 0:
            self._mean[:] = row
        self._seen += 1
        weights: Grey = _watched(row, self._mean, self._variance, max(1.0 / MEMORY, 1.0 / self._seen))
        return weights if self._seen >= SURE else np.ones(len(row), np.float32)


@njit(cache=True)
def _watched(row: Grey, mean: Array, variance: Array, share: float) -> Grey:  # pragma: no cover - compiled
    """Weights of the pixels; mean and variance (pixels,) take a share of the row."""
    for i in range(row.shape[0]):
        off = row[i] - mean[i]
        mean[i] += share * off
        variance[i] += share * (off * off - variance[i])
    usual = np.median(variance)
    weights = np.ones(row.shape[0], np.float32)
    for i in range(row.shape[0]):
        if usual >= 1.0 and variance[i] <= DEAD * usual:
            weights[i] = 0.0
    return weights


def mended(row: Grey, weights: Grey) -> Grey:
    """A row (pixels,) whose pixels of weight 0 lie on straight lines between their neighbours."""
    sound = weights > 0.0
    if sound.all() or not sound.any():
        return row
    places = np.arange(len(row))
    return np.interp(places, places[sound], row[sound]).astype(np.float32)
