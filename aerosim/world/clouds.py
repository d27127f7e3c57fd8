"""Shadows of clouds that move over the ground: a seeded field without end, drawn along by the wind."""

from __future__ import annotations

import math

import numpy as np

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.rasterfile import Values

CELLS = 64  # after which the field repeats itself
POINTS = 8  # of the field in a cell
EDGE_M = 30.0  # from light to dark, typically: the sun's half degree from some 2 km, and a cloud's soft rim


class CloudShadows:
    """What the ground's brightness is multiplied by, as a window that moves over the map and repeats itself.

    shade: (n, n) float32, light before it is cut off at 1 and at the darkest; n is 512.
    """

    def __init__(
        self, rng: np.random.Generator, cover: float, cell: float, velocity: tuple[float, float], darkness: float
    ) -> None:
        """cover: share of the ground in shadow, 0 to 1, between both.

        cell: mean length (m) of a shadow, and of a gap, on a straight line at half cover; velocity: where the
        shadows go to, easting and northing, m/s; darkness: share of the light that a shadow takes.
        Raises InputError for a cover or a cell that no field can have.
        """
        if not (0.0 < cover < 1.0 and cell > 0.0):
            raise InputError(f"cover of {cover:g} and cells of {cell:g} m", allowed="between 0 and 1, above 0 m")
        size = CELLS * POINTS
        # A Gaussian field of correlation exp(-r^2 / 2 l^2) crosses its mean once in pi l (Rice, 1944)
        length = POINTS / math.pi
        wave = 2.0 * math.pi * np.fft.fftfreq(size)
        response = np.exp(-0.25 * length**2 * (wave[:, None] ** 2 + wave[None, : size // 2 + 1] ** 2))
        field = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((size, size))) * response, s=(size, size))
        field /= field.std()
        # its gradient is sqrt(2) / l rms, so that an edge is EDGE_M wide
        step = cell / POINTS
        edge = math.sqrt(2.0) / length * EDGE_M / step
        depth = 0.5 + (field - np.quantile(field, 1.0 - cover)) / edge
        self.shade: Values = np.ascontiguousarray(1.0 - darkness * depth, np.float32)
        self._place = np.array([0.0, 0.0, step, -step, 1.0 - darkness])
        self._velocity = np.array(velocity, float)

    def place(self, t: float) -> Array:
        """Easting and northing of the first cell at time t (s), the steps (m), and the light in a shadow, (5,)."""
        place = self._place.copy()
        place[:2] += self._velocity * t
        return place
