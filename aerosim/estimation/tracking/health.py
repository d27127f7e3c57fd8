"""Pixels of row II that see nothing: they do not change while the ground moves on."""

from __future__ import annotations

import numpy as np

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
        self._seen += 1
        share = max(1.0 / MEMORY, 1.0 / self._seen)
        off = row - self._mean if self._seen > 1 else np.zeros(len(row))
        if self._seen == 1:
            self._mean[:] = row
        self._mean += share * off
        self._variance += share * (off * off - self._variance)
        usual = float(np.median(self._variance))
        if self._seen < SURE or usual < 1.0:
            return np.ones(len(row), np.float32)
        return (self._variance > DEAD * usual).astype(np.float32)
