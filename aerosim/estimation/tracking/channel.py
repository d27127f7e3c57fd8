"""One quantity followed: a lag filter that takes blocks of strips and learns their noise from its innovations."""

from __future__ import annotations

import math

from aerosim.estimation.tracking.lag_filter import LagFilter, WalkModel

LEARN = 0.1  # share of an innovation's surprise that goes into the noise
GATE = 5.0


class Channel:
    """Means of a quantity over intervals, taken in blocks."""

    def __init__(
        self, model: WalkModel, step: float, reach: float, floor: float, noise: float, ends: bool = False
    ) -> None:
        """step: of the lags, s.  reach: longest interval back, s.  floor, noise: least and first variance of a
        block's mean.  ends: see LagFilter.
        """
        self.filter = LagFilter(model, step, reach, ends)
        self._floor = floor
        self._noise = noise
        self._block: list[tuple[float, float, float]] = []
        self.innovation = math.nan

    def start(self, t: float, value: float, scatter: float) -> None:
        """Begin with a value; scatter: variance of single strips about it.  The noise learned so far is kept."""
        self.filter.start(t, value, scatter)
        self._block.clear()

    @property
    def noise(self) -> float:
        """Variance of a block's mean, as learned."""
        return self._noise

    def surprise(self, t1: float, t2: float, value: float) -> float:
        """How far a strip lies from what is expected, in standard deviations."""
        expected, variance = self.filter.expect(t1, t2)
        return (value - expected) / math.sqrt(variance + self._noise)

    def spread(self, t1: float, t2: float) -> float:
        """Standard deviation of a strip to come."""
        return math.sqrt(self.filter.expect(t1, t2)[1] + self._noise)

    def add(self, t1: float, t2: float, value: float) -> None:
        """A strip of the present block."""
        self._block.append((t1, t2, value))

    def close(self, t: float) -> bool:
        """End of a block at time t (s): the filter moves on and takes the block's mean.  False if it was empty."""
        self.filter.advance(t)
        if not self._block:
            return False
        count = len(self._block)
        t1, t2, value = (sum(each[k] for each in self._block) / count for k in range(3))
        self._block.clear()
        expected, variance = self.filter.expect(t1, t2)
        off = value - expected
        self.innovation = off / math.sqrt(variance + self._noise)
        self.filter.update(t1, t2, value, self._noise)
        # innovations larger or smaller than expected are the noise's doing, as far as it makes them
        total = variance + self._noise
        surprise = min(self.innovation**2, 9.0) - 1.0
        self._noise = max(self._noise * (1.0 + LEARN * surprise * self._noise / total), self._floor)
        return True
