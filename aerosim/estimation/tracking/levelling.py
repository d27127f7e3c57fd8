"""Roll and pitch for the rows: smooth as the gyro's, level in the long run if there is a vertical."""

from __future__ import annotations

import math

import numpy as np

from aerosim.frames import Array


class Levelled:
    """One angle: the gyro's, less its offset and drift as the vertical shows them in the long run.

    The gyro is right from one moment to the next and drifts; the vertical does not drift and wavers for a minute
    or so.  Their difference is a straight line in time seen through the vertical's error: a Kalman filter of two
    states.
    """

    def __init__(self, drift_sigma: float, level_sigma: float, level_time: float) -> None:
        """drift_sigma: of the gyro's drift, rad/s.  level_sigma, level_time: of the vertical's error, rad, s."""
        self._density = 2.0 * level_sigma**2 * level_time  # the slow error as white noise, rad^2 s
        self._x = np.zeros(2)
        self._cov: Array = np.diag([level_sigma**2, drift_sigma**2])
        self._t = math.nan

    def __call__(self, t: float, gyro: float, level: float) -> float:
        """Angle at time t (s), rad.  level NaN: there is no vertical, the gyro's start is taken as level."""
        if math.isnan(level):
            return gyro
        if not math.isnan(self._t):
            span = t - self._t
            x, p = self._x, self._cov
            x[0] += span * x[1]
            p00 = p[0, 0] + 2.0 * span * p[0, 1] + span * span * p[1, 1]
            p01 = p[0, 1] + span * p[1, 1]
            variance = p00 + self._density / span
            off = gyro - level - x[0]
            k0, k1 = p00 / variance, p01 / variance
            x[0] += k0 * off
            x[1] += k1 * off
            p[0, 0], p[1, 1] = p00 * (1.0 - k0), p[1, 1] - k1 * p01
            p[0, 1] = p[1, 0] = p01 * (1.0 - k0)
        self._t = t
        return gyro - float(self._x[0])
