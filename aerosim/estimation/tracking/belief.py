"""What mode `best` believes of track and v/h, and how strips change it."""

from __future__ import annotations

import math
from typing import NamedTuple

from aerosim.estimation.tracking.channel import Channel
from aerosim.estimation.tracking.lag_filter import LagFilter

LEAST_AHEAD = 0.1  # nobody flies sideways


class Motion(NamedTuple):
    """track: rad.  log_vh: of v/h in 1/s.  Their variances, rad^2 and 1."""

    track: float
    log_vh: float
    var_track: float
    var_log_vh: float


class Belief:
    """Track in the gyro's frame and logarithm of v/h, each followed for itself."""

    def __init__(self, first: Channel, second: Channel) -> None:
        """first: of the track, rad; second: of the logarithm of v/h."""
        self.first, self.second = first, second

    def start(self, t: float, track: float, log_vh: float, scatter: tuple[float, float]) -> None:
        """Begin at time t (s) with values and the variances of single strips about them."""
        for channel, value, variance in zip(self._channels, self._seen(track, log_vh), scatter, strict=True):
            channel.start(t, value, variance)

    def now(self, t: float) -> Motion:
        """What is believed for time t, s."""
        (a, var_a), (b, var_b) = self.first.filter.now(t), self.second.filter.now(t)
        return self._told(a, b, var_a, var_b)

    def strip(self, t1: float, t2: float) -> Motion:
        """What a strip over [t1, t2] (s) is expected to show, and its variances."""
        a, var_a = self.first.filter.expect(t1, t2)
        b, var_b = self.second.filter.expect(t1, t2)
        return self._told(a, b, var_a + self.first.noise, var_b + self.second.noise)

    def surprise(self, t1: float, t2: float, track: float, log_vh: float) -> float:
        """How far a strip lies from what is expected, in standard deviations: the larger of the two."""
        pairs = zip(self._channels, self._seen(track, log_vh), strict=True)
        return max(abs(channel.surprise(t1, t2, value)) for channel, value in pairs)

    def add(self, t1: float, t2: float, track: float, log_vh: float) -> None:
        """A strip of the present block."""
        for channel, value in zip(self._channels, self._seen(track, log_vh), strict=True):
            channel.add(t1, t2, value)

    def close(self, t: float) -> bool:
        """End of a block at time t, s.  False if it was empty."""
        taken = [channel.close(t) for channel in self._channels]
        return all(taken)

    def doubt(self) -> None:
        """Admit that all may be off by as much as strips scatter."""
        for channel in self._channels:
            channel.filter.inflate(channel.noise)

    @property
    def innovations(self) -> tuple[float, float]:
        """Of the last block, standardised."""
        return self.first.innovation, self.second.innovation

    @property
    def feigned_push(self) -> float:
        """Slope of the logarithm of v/h beside the accelerations, 1/s: what a wrong pitch makes of them."""
        return self.second.filter.slope if isinstance(self.second.filter, LagFilter) else 0.0

    @property
    def _channels(self) -> tuple[Channel, Channel]:
        return self.first, self.second

    def _seen(self, track: float, log_vh: float) -> tuple[float, float]:
        """Values of the channels; the track without whole turns."""
        turns = (self.first.filter.now(self.first.filter.t)[0] - track) / (2.0 * math.pi)
        return track + (2.0 * math.pi * round(turns) if math.isfinite(turns) else 0.0), log_vh

    def _told(self, a: float, b: float, var_a: float, var_b: float) -> Motion:
        return Motion(a, b, var_a, var_b)


class UnaidedBelief(Belief):
    """v/h to the right of the nose, and the time that it takes ahead, as shares of the planned ones.

    A roll between its two looks moves a strip across the airframe whatever the drift, and a pitch lengthens its
    time: so each of the two channels has the sway of one angle, and is linear in it.
    """

    def __init__(self, right: Channel, time: Channel, planned_vh: float) -> None:
        """right: v/h to the right; time: planned v/h over v/h ahead.  planned_vh: 1/s."""
        super().__init__(right, time)
        self._log_planned = math.log(planned_vh)

    def _seen(self, track: float, log_vh: float) -> tuple[float, float]:
        share = math.exp(log_vh - self._log_planned)
        return share * math.sin(track), 1.0 / (share * max(math.cos(track), LEAST_AHEAD))

    def _told(self, a: float, b: float, var_a: float, var_b: float) -> Motion:
        right, ahead = a, 1.0 / max(b, LEAST_AHEAD)
        var_ahead = ahead**4 * var_b
        square = right * right + ahead * ahead
        across = (ahead * ahead * var_a + right * right * var_ahead) / square**2
        along = (right * right * var_a + ahead * ahead * var_ahead) / square**2
        return Motion(math.atan2(right, ahead), 0.5 * math.log(square) + self._log_planned, across, along)
