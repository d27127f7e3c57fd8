"""Where the pixels of the rows look, as they are believed to: straight, or bent by the calibrated optics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerosim.frames import Array

SPREAD = 9  # pixels of a row that its mean is taken from
SHARE = 0.9  # of the row that they cover


def sampled(pixels: int) -> Array:
    """Places in row II, from its first pixel, that a strip's mean is taken from, (SPREAD,), px."""
    return (pixels - 1) / 2.0 + pixels * SHARE * np.linspace(-0.5, 0.5, SPREAD)


class Rays(NamedTuple):
    """Ray tables of the two rows: image points without distortion, px, x ahead, y to the right.

    row1: (2, u + 2 j), its element j + i facing element i of row II; row2: (2, u).
    """

    row1: Array
    row2: Array

    @classmethod
    def straight(cls, pixels: int, max_shift: int, spacing: float) -> Rays:
        """Rays of optics without distortion.  pixels: u; max_shift: j; spacing: row I ahead of row II, px."""
        rows = []
        for count, x in ((pixels + 2 * max_shift, 0.5 * spacing), (pixels, -0.5 * spacing)):
            rows.append(np.stack([np.full(count, x), np.arange(count) - (count - 1) / 2.0]))
        return cls(*rows)

    @property
    def apart(self) -> float:
        """Distance of the rows where a strip's mean is taken from, px of ground motion."""
        return float(self._sampled().mean())

    @property
    def bow(self) -> Array:
        """By how much the rows are further apart at each pixel of row II than in the mean, (u,), px."""
        return self._distances() - self.apart

    def _distances(self) -> Array:
        margin = (self.row1.shape[1] - self.row2.shape[1]) // 2
        return np.asarray(self.row1[0, margin : margin + self.row2.shape[1]] - self.row2[0])

    def _sampled(self) -> Array:
        pixels = self.row2.shape[1]
        return np.interp(sampled(pixels), np.arange(pixels), self._distances())
