"""A ground of plane waves: exact between the pixels, without a period, so a known shift is a known shift."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerosim.estimation.mad import mad, prepared

WAVES = 300


class Ground:
    """Grey values at any place.  Wave numbers from 1/64 to 0.7 per px, as many in each octave: a fractal.

    Each wave is damped as a square pixel damps it.  contrast: standard deviation, grey levels.
    """

    def __init__(self, seed: int, contrast: float = 25.0, mean: float = 110.0) -> None:
        rng = np.random.default_rng(seed)
        number = np.exp(rng.uniform(np.log(1 / 64), np.log(0.7), WAVES))
        angle = rng.uniform(0.0, 2.0 * np.pi, WAVES)
        self._along, self._across = number * np.cos(angle), number * np.sin(angle)
        amplitude = np.sinc(self._along) * np.sinc(self._across)
        self._amplitude = amplitude * contrast / np.sqrt((amplitude**2).sum() / 2.0)
        self._phase = rng.uniform(0.0, 1.0, WAVES)
        self._mean = mean

    def row(self, along: float, across: NDArray[np.float64]) -> NDArray[np.float64]:
        """Grey values of a row at `along`, its pixels at `across`, px."""
        turns = self._along * along + self._across * across[:, None] + self._phase
        return self._mean + np.cos(2.0 * np.pi * turns) @ self._amplitude


def surface(
    ground: Ground, n: float, mu: float, steps: int, steps_per_px: float, noise: float, seed: int
) -> NDArray[np.float32]:
    """MAD surface (steps, 15) of 96 pixels over the ground, its true minimum at step n and shift mu (px).

    noise: grey levels; with noise the converter counts in whole grey levels too.
    """
    rng = np.random.default_rng(seed)

    def read(along: float, across: NDArray[np.float64]) -> NDArray[np.float32]:
        row = ground.row(along, across)
        if noise > 0.0:
            row = np.round(row + noise * rng.standard_normal(len(row)))
        return row.astype(np.float32)

    row1 = prepared(read(0.0, np.arange(-7.0, 103.0)), 7)
    pixels = np.arange(96.0) + mu  # index in row I = index in row II + mu
    return np.array([mad(row1, prepared(read((s - n) / steps_per_px, pixels), 0)) for s in range(steps)])
