"""One quantity followed: a filter with lags takes blocks of strips and learns their noise from its innovations."""

from __future__ import annotations

import math

from aerosim.estimation.tracking.lag_filter import LagFilter
from aerosim.estimation.tracking.sway_filter import SwayFilter

LEARN = 0.1  # share of an innovation's surprise that goes into the noise
SURPRISE_MOST = 8.0  # of one block: nine times the expected square
GATE = 5.0
COARSE = 0.05  # of the sway's variance: what its model leaves, as measured on JSBSim flights


class Channel:
    """Means of a quantity over intervals, taken in blocks."""

    def __init__(self, filter_: LagFilter | SwayFilter, floor: float, noise: float) -> None:
        """floor, noise: least and first variance of a block's mean.

        Learned is the noise or, if the filter follows it, the variance of the sway: then the noise is the floor.
        """
        self.filter = filter_
        self._floor = floor
        self._noise = noise if isinstance(filter_, LagFilter) else floor
        self._block: list[tuple[float, float, float]] = []
        self.innovation = math.nan

    def start(self, t: float, value: float, scatter: float) -> None:
        """Begin with a value; scatter: variance of single strips about it.  The noise learned so far is kept."""
        self.filter.start(t, value, scatter)
        self._block.clear()

    @property
    def noise(self) -> float:
        """Variance of a block's mean beside what the filter follows, as learned."""
        return self._noise + COARSE * self.filter.sway

    @property
    def scatter(self) -> float:
        """Variance of a block's mean about a known course: the noise, and the sway at its two looks."""
        return self.noise + 2.0 * self.filter.sway

    def surprise(self, t1: float, t2: float, value: float) -> float:
        """How far a strip lies from what is expected, in standard deviations.

        Beside sway, the noise is not learned: single strips scatter about twice as much as a block.
        """
        expected, variance = self.filter.expect(t1, t2)
        single = self.noise if isinstance(self.filter, LagFilter) else self.noise + 3.0 * self._noise
        return (value - expected) / math.sqrt(variance + single)

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
        total = variance + self.noise
        before, self.innovation = self.innovation, (value - expected) / math.sqrt(total)
        if isinstance(self.filter, LagFilter) and math.isfinite(before):
            self.filter.hang_together(before * self.innovation)
        self.filter.update(t1, t2, value, self.noise)
        self._learn(total)
        return True

    def _learn(self, total: float) -> None:
        """Innovations larger or smaller than expected are the noise's doing, as far as it makes them."""
        surprise = min(self.innovation**2 - 1.0, SURPRISE_MOST)
        if isinstance(self.filter, SwayFilter):
            self.filter.learn(LEARN * surprise, total, self._floor)
        else:
            self._noise = max(self._noise * (1.0 + LEARN * surprise * self._noise / total), self._floor)
