"""Roll and pitch for the rows: smooth as the gyro's, level in the long run if there is a vertical."""

from __future__ import annotations

import math


class Levelled:
    """One angle: the gyro's, less its offset and drift as the vertical shows them in the long run.

    The gyro is right from one moment to the next and drifts; the vertical does not drift and wavers for a minute
    or so.  Their difference is a straight line in time seen through the vertical's error: a Kalman filter of two
    states.
    """

    def __init__(self, drift_sigma: float, level_sigma: float, level_time: float) -> None:
        """drift_sigma: of the gyro's drift, rad/s.  level_sigma, level_time: of the vertical's error, rad, s."""
        self._density = 2.0 * level_sigma**2 * level_time  # the slow error as white noise, rad^2 s
        # plain numbers: two states are too few for arrays
        self._offset = self._drift = 0.0
        self._cov = (level_sigma**2, 0.0, drift_sigma**2)
        self._t = math.nan
        self._held: tuple[float, float, float] | None = None

    def hold(self) -> None:
        """From now on take the offset and the drift for known: what they miss is a straight line in time.

        Who follows that line elsewhere (a track that must agree with its accelerations) does not want it bent by
        every new reading of the vertical.
        """
        self._held = self._t, self._offset, self._drift

    def release(self) -> None:
        """Go with the vertical again."""
        self._held = None

    def __call__(self, t: float, gyro: float, level: float) -> float:
        """Angle at time t (s), rad.  level NaN: there is no vertical, the gyro's start is taken as level."""
        if math.isnan(level):
            return gyro
        if not math.isnan(self._t):
            span = t - self._t
            p00, p01, p11 = self._cov
            offset = self._offset + span * self._drift
            p00, p01 = p00 + 2.0 * span * p01 + span * span * p11, p01 + span * p11
            variance = p00 + self._density / span
            off = gyro - level - offset
            k0, k1 = p00 / variance, p01 / variance
            self._offset = offset + k0 * off
            self._drift += k1 * off
            self._cov = (p00 * (1.0 - k0), p01 * (1.0 - k0), p11 - k1 * p01)
        self._t = t
        if self._held is not None:
            since, offset, drift = self._held
            return gyro - offset - drift * (t - since)
        return gyro - self._offset
