"""Single gusts of 1-cosine shape."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerosim.frames import Array


class CosineGust(NamedTuple):
    """One gust in n: from nothing at `start` (s after the start of the flight) over its peak to nothing.

    duration: of the whole, s; north, east, down: peak velocity of the air, m/s.  MIL-F-8785C 3.7.1.3 has half of
    it, the rise; the falling half is its mirror image.
    """

    start: float
    duration: float
    north: float
    east: float
    down: float

    def at(self, t: Array) -> Array:
        """Velocity of the air in n at times t (n,), s.  Returns (n, 3), m/s."""
        part = (t - self.start) / self.duration
        shape = np.where((part > 0.0) & (part < 1.0), (1.0 - np.cos(2.0 * np.pi * part)) / 2.0, 0.0)
        found: Array = shape[:, None] * np.array([self.north, self.east, self.down])
        return found
