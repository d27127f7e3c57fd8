"""How fast the nose turns now, from a gyro that tells integrated angles."""

from __future__ import annotations

import math

SMOOTH_S = 0.15  # differences of readings 0.05 s apart scatter by 0.4 deg/s, the nose turns by 0.1 to 0.5


class YawRate:
    """Differences of the gyro's readings, smoothed exponentially."""

    def __init__(self) -> None:
        """The nose is at rest until two readings say otherwise."""
        self.rate = 0.0  # rad/s
        self._t = self._yaw = math.nan

    def __call__(self, t: float, yaw: float) -> None:
        """Take a reading at time t (s): yaw, rad, not wrapped."""
        span = t - self._t
        if span > 0.0:  # not at the first reading
            self.rate += (1.0 - math.exp(-span / SMOOTH_S)) * ((yaw - self._yaw) / span - self.rate)
        self._t, self._yaw = t, yaw
