"""Mesoscale wind: a horizontal field with an energy spectrum of k^(-5/3), flown through."""

from __future__ import annotations

from math import cos, gamma, pi, sin
from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.world.local import LocalPlane

MODES_PER_OCTAVE = 16
NEAR = 1.0 / 50.0  # of the shortest wavelength: so far a tangent plane of the field is good to 0.8 % of its wave
# integral of (1 - J0(x)) x^(-5/3) from 0 to infinity
_ALL_LAGS: float = -(2.0 ** (-5.0 / 3.0)) * gamma(-1.0 / 3.0) / gamma(4.0 / 3.0)


class Mesoscale(NamedTuple):
    """Strength and extent of the field.

    structure: a of <|v(x + r) - v(x)|^2> = a r^(2/3), north and east together, m^(4/3)/s^2; the default is the
    free atmosphere's, Lindborg, J. Fluid Mech. 388 (1999), from memory (see docs/air.md).
    longest, shortest: wavelengths between which there is energy, m.  Above the longest the spectrum is steeper and
    belongs to the weather; below the shortest turbulence takes over.
    """

    structure: float = 3.6e-3
    longest: float = 400e3
    shortest: float = 1000.0


def spectrum_level(structure: float) -> float:
    """c of E(k) = c k^(-5/3), m^(4/3)/s^2, from the structure coefficient.

    For isotropic two-dimensional flow <|dv|^2> = 4 int E(k) (1 - J0(kr)) dk: a = 4 c int (1 - J0(x)) x^(-5/3) dx.
    """
    return structure / (4.0 * _ALL_LAGS)


class MesoscaleWind:
    """One field, carried along by the mean wind as a whole (Taylor), without divergence and with no vertical part.

    A sum of plane waves of random direction and amplitude, their wave numbers drawn evenly over the logarithm
    within each of the narrow bands.  Transverse and longitudinal structure functions have the ratio 5/3 of
    two-dimensional flow without divergence (the atmosphere's lie between this and 1).
    """

    def __init__(self, scales: Mesoscale, plane: LocalPlane, rng: np.random.Generator) -> None:
        """plane: how the field is carried along.  Raises InputError for wavelengths in the wrong order."""
        if not 0.0 < scales.shortest < scales.longest:
            raise InputError(
                f"no wavelength between {scales.shortest:g} and {scales.longest:g} m",
                key="air.slow_wind.longest_m",
                allowed="more than shortest_m",
            )
        self._plane = plane
        octaves = np.log2(scales.longest / scales.shortest)
        count = int(np.ceil(MODES_PER_OCTAVE * octaves))
        edges = 2.0 * pi / scales.longest * 2.0 ** (np.linspace(0.0, octaves, count + 1))
        part, azimuth, real, imaginary = (
            rng.random(count),
            2.0 * pi * rng.random(count),
            rng.standard_normal(count),
            rng.standard_normal(count),
        )
        k = edges[:-1] * (edges[1:] / edges[:-1]) ** part
        # energy of a band, int E dk, is half of a wave's mean square
        c = spectrum_level(scales.structure)
        energy = 1.5 * c * (edges[:-1] ** (-2.0 / 3.0) - edges[1:] ** (-2.0 / 3.0))
        along = k * np.array([np.cos(azimuth), np.sin(azimuth)])
        across = np.sqrt(2.0 * energy) * np.array([-np.sin(azimuth), np.cos(azimuth)])
        self._waves = np.ascontiguousarray(np.vstack([along, across * real, across * imaginary]).T)

        self._near = (NEAR * scales.shortest) ** 2
        self._x, self._y = np.inf, np.inf
        self._tangent = (0.0,) * 6

    def at(self, t: float, lat: float, lon: float, height: float) -> tuple[float, float, float]:
        """Velocity of the air in n, m/s, at a time (s) and place (rad; the height does not matter)."""
        x, y = self._plane.at(t, lat, lon)
        dx, dy = x - self._x, y - self._y
        if not dx * dx + dy * dy < self._near:
            self._x, self._y, dx, dy = x, y, 0.0, 0.0
            self._tangent = _tangent(self._waves, x, y)
        north, north_x, north_y, east, east_x, east_y = self._tangent
        return north + north_x * dx + north_y * dy, east + east_x * dx + east_y * dy, 0.0


@njit(cache=True, nogil=True)
def _tangent(
    waves: Array, x: float, y: float
) -> tuple[float, float, float, float, float, float]:  # pragma: no cover - compiled
    """North and east wind at a point of the plane, each followed by its slopes northwards and eastwards."""
    north, north_x, north_y, east, east_x, east_y = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(waves.shape[0]):
        kx, ky = waves[i, 0], waves[i, 1]
        phase = kx * x + ky * y
        c, s = cos(phase), sin(phase)
        north += waves[i, 2] * c + waves[i, 4] * s
        east += waves[i, 3] * c + waves[i, 5] * s
        slope = waves[i, 4] * c - waves[i, 2] * s
        north_x += kx * slope
        north_y += ky * slope
        slope = waves[i, 5] * c - waves[i, 3] * s
        east_x += kx * slope
        east_y += ky * slope
    return north, north_x, north_y, east, east_x, east_y
