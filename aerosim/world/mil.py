"""How strong and how long turbulence is by MIL-F-8785C: low, medium and high altitude."""

from __future__ import annotations

from math import log10
from typing import Literal

import numpy as np

from aerosim.errors import InputError
from aerosim.world.turbulence import Spectrum, Turbulence

FOOT = 0.3048
KNOT = 0.514444
LOWEST = 10.0 * FOOT
LOW, MEDIUM = 1000.0 * FOOT, 2000.0 * FOOT
TOP = 80000.0 * FOOT
HIGH_LENGTH: dict[Spectrum, float] = {"dryden": 1750.0 * FOOT, "von_karman": 2500.0 * FOOT}

Severity = Literal["light", "moderate", "severe"]
EXCEEDANCE: dict[Severity, float] = {"light": 1e-2, "moderate": 1e-3, "severe": 1e-5}
"""Probability that a severity's sigma is exceeded, figure 7."""
WIND_20FT: dict[Severity, float] = {"light": 15.0 * KNOT, "moderate": 30.0 * KNOT, "severe": 45.0 * KNOT}
"""Wind 20 ft above the ground that a severity means near the ground, m/s."""

# Standard deviation, ft/s, by altitude, ft, and probability of exceedance: MIL-F-8785C figure 7 as JSBSim's
# FGWinds.cpp has read it off.
_ALTITUDES = (500, 1750, 3750, 7500, 15000, 25000, 35000, 45000, 55000, 65000, 75000, 80000)
_PROBABILITIES = (2e-1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
_SIGMAS = (
    (3.2, 2.2, 1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (4.2, 3.6, 3.3, 1.6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (6.6, 6.9, 7.4, 6.7, 4.6, 2.7, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0),
    (8.6, 9.6, 10.6, 10.1, 8.0, 6.6, 5.0, 4.2, 2.7, 0.0, 0.0, 0.0),
    (11.8, 13.0, 16.0, 15.1, 11.6, 9.7, 8.1, 8.2, 7.9, 4.9, 3.2, 2.1),
    (15.6, 17.6, 23.0, 23.6, 22.1, 20.0, 16.0, 15.1, 12.1, 7.9, 6.2, 5.1),
    (18.7, 21.5, 28.4, 30.2, 30.7, 31.0, 25.2, 23.1, 17.5, 10.7, 8.4, 7.2),
)


def high_sigma(height: float, exceedance: float) -> float:
    """Standard deviation of u, v and w (m/s) at an altitude (m) that is exceeded with a probability.

    Linear in height and in the logarithm of the probability between the curves; below 500 ft as there.
    Raises InputError above 80000 ft and outside of 1e-6 to 0.2.
    """
    if height > TOP:
        raise InputError(
            f"no severity is known at {height:.0f} m",
            key="air.turbulence",
            allowed=f"up to {TOP:.0f} m, or sigma_m_s",
        )
    if not _PROBABILITIES[-1] <= exceedance <= _PROBABILITIES[0]:
        raise InputError(
            f"{exceedance:g} is off the standard's curves", key="air.turbulence.exceedance", allowed="1e-6 to 0.2"
        )
    here = [float(np.interp(height / FOOT, _ALTITUDES, curve)) for curve in _SIGMAS]
    rarity = [-log10(probability) for probability in _PROBABILITIES]
    return FOOT * float(np.interp(-log10(exceedance), rarity, here))


def low_turbulence(spectrum: Spectrum, agl: float, wind_20ft: float) -> Turbulence:
    """Rule of the lowest 1000 ft: all from the height above ground (m) and the wind at 20 ft (m/s)."""
    feet = agl / FOOT
    shape = 0.177 + 0.000823 * feet
    sigma_w = 0.1 * wind_20ft
    return Turbulence(spectrum, sigma_w / shape**0.4, sigma_w, agl / shape**1.2, agl)


def mil_turbulence(
    spectrum: Spectrum,
    *,
    height: float,
    agl: float,
    severity: Severity | None = None,
    exceedance: float | None = None,
    wind_20ft: float | None = None,
) -> Turbulence:
    """Turbulence of a flight at one height, by MIL-F-8785C 3.7.2 and 3.7.3; taken once, for the planned height.

    height: ellipsoidal, taken for the altitude of figure 7; agl: over the ground, m.  Up to 1000 ft above ground
    the wind at 20 ft (m/s; by default the severity's) says all, from 2000 ft the probability of exceedance (by
    default the severity's); between, both ends are interpolated linearly.  Raises InputError for what is missing.
    """
    if agl < LOWEST:
        raise InputError(f"the standard knows no turbulence {agl:.1f} m above ground", key="air.turbulence")
    if wind_20ft is None and severity is not None:
        wind_20ft = WIND_20FT[severity]
    if exceedance is None and severity is not None:
        exceedance = EXCEEDANCE[severity]
    if agl < MEDIUM and wind_20ft is None:
        raise InputError(
            f"turbulence at {agl:.0f} m above ground follows the wind near the ground",
            key="air.turbulence.wind_20ft_m_s",
            allowed="a wind speed, or severity as a word",
        )
    if agl > LOW and exceedance is None:
        raise InputError(
            f"turbulence at {agl:.0f} m above ground does not follow the wind near the ground",
            key="air.turbulence.severity" if wind_20ft is None else "air.turbulence.wind_20ft_m_s",
            allowed=f"besides it severity or exceedance; alone it holds up to {LOW:.0f} m (1000 ft)",
        )
    if agl <= LOW:
        assert wind_20ft is not None
        return low_turbulence(spectrum, agl, wind_20ft)
    assert exceedance is not None
    high = Turbulence.equal(spectrum, high_sigma(height, exceedance), HIGH_LENGTH[spectrum])
    if agl >= MEDIUM:
        return high
    assert wind_20ft is not None
    low, part = low_turbulence(spectrum, LOW, wind_20ft), (agl - LOW) / (MEDIUM - LOW)
    sigma_u, sigma_w, length_u, length_w = (a + part * (b - a) for a, b in zip(low[1:], high[1:], strict=True))
    return Turbulence(spectrum, sigma_u, sigma_w, length_u, length_w)
