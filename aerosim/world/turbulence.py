"""Continuous turbulence: how strong and how long it is, and the span filters of its rates."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np

from aerosim.world.forming import filtered_noise
from aerosim.world.process import GaussProcess

RngOf = Callable[[str], np.random.Generator]
Spectrum = Literal["dryden", "von_karman"]


class Turbulence(NamedTuple):
    """Standard deviations (m/s) and scale lengths (m) of the gusts: of u and v, and of w.

    Lengths as MIL-F-8785C counts them, for which high up all three are equal.
    """

    spectrum: Spectrum
    sigma_u: float
    sigma_w: float
    length_u: float
    length_w: float

    @classmethod
    def equal(cls, spectrum: Spectrum, sigma: float, length: float) -> Turbulence:
        """The same in all axes: sigma in m/s, length in m."""
        return cls(spectrum, sigma, sigma, length, length)


def pitch_rate(airspeed: float, span: float) -> tuple[float, float]:
    """Factor and time constant of q = -dw/dx, filtered over the span: (-s/V)/(1 + 4b/(pi V) s) of w."""
    return -1.0 / airspeed, 4.0 * span / (np.pi * airspeed)


def yaw_rate(airspeed: float, span: float) -> tuple[float, float]:
    """Factor and time constant of r = +dv/dx, filtered over the span: (s/V)/(1 + 3b/(pi V) s) of v."""
    return 1.0 / airspeed, 3.0 * span / (np.pi * airspeed)


def roll_process(
    air: Turbulence, airspeed: float, span: float, dt: float, rng: np.random.Generator
) -> GaussProcess:
    """Rolling gust p, rad/s, independent of the others; the same for both spectra (MIL-F-8785C, 3.7.2)."""
    length, tau = air.length_w, 4.0 * span / (np.pi * airspeed)
    # density at zero over sigma^2
    density = 0.8 * (np.pi * length / (4.0 * span)) ** (1.0 / 3.0) / (airspeed * length)
    return filtered_noise(air.sigma_w * np.sqrt(np.pi * density), [(0.0, tau)], dt, rng)
