"""The lag filter of an unaided camera: what it follows, and the roll or pitch that it is not told."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from aerosim.estimation.tracking.lag_filter import expected, interval_weights, updated
from aerosim.frames import Array


class SwayFilter:
    """State x(t), x(t - step), ..., s(t), s(t - step), ..., and the rate of s.

    x walks.  s is the sway: what the camera's tilt adds to a look, a critically damped oscillation driven by white
    noise.  A strip over [t1, t2] tells the mean of x plus s(t1) - s(t2): the tilt of its first look was that of
    the second look of a strip before, so much of it is known.  Source: docs/best.md.
    """

    def __init__(self, walk: float, step: float, reach: float, sway: float, sway_time: float, ends: bool) -> None:
        """walk: intensity of x, unit^2/s.  step: of the lags, s.  reach: how far back an interval may begin, s.

        sway: first belief of the variance of s, unit^2.  sway_time: of its oscillation, over 2 pi, s.  ends: what
        is measured is the mean of the two end values of x and not of all that lies between.
        """
        self._walk, self._step, self._ends = walk, step, ends
        n = self._lags = math.ceil(reach / step) + 2
        self._per_s = 1.0 / sway_time
        # one step of s and its rate, and what the noise adds meanwhile for a variance of one
        w, fade = step * self._per_s, math.exp(-step * self._per_s)
        self._move = fade * np.array([[1.0 + w, step], [-w * self._per_s, 1.0 - w]])
        rest = np.diag([1.0, self._per_s**2])
        self._kick = rest - self._move @ rest @ self._move.T
        self._x = np.zeros(2 * n + 1)
        self._cov = np.zeros((2 * n + 1, 2 * n + 1))
        self._half = np.zeros_like(self._cov)
        self._h = np.zeros(2 * n + 1)
        self._mean = np.zeros(n + 1)
        self.sway = sway
        self.t = math.nan

    def start(self, t: float, value: float, variance: float) -> None:
        """Begin at time t with a value and its variance; the past is taken to have been the same, walked back."""
        n = self._lags
        self.t = t
        self._x[:n], self._x[n:] = value, 0.0
        ages = np.arange(n) * self._step
        self._cov[:] = 0.0
        self._cov[:n, :n] = variance + self._walk * np.minimum.outer(ages, ages)
        apart = self._per_s * np.abs(np.subtract.outer(ages, ages))
        self._cov[n:-1, n:-1] = self.sway * (1.0 + apart) * np.exp(-apart)
        with_rate = -self.sway * self._per_s**2 * ages * np.exp(-self._per_s * ages)
        self._cov[-1, n:-1] = self._cov[n:-1, -1] = with_rate
        self._cov[-1, -1] = self.sway * self._per_s**2

    def advance(self, t: float) -> None:
        """Go on to time t, by whole steps; what is left of a step waits for the next call."""
        while t - self.t > self._step * (1.0 - 1e-9):
            self.t += self._step
            _shift(self._x, self._cov, self._half, self._move, self._walk * self._step, self.sway * self._kick)

    def inflate(self, variance: float) -> None:
        """Admit that the whole course of x may be off by a constant of this variance."""
        n = self._lags
        self._cov[:n, :n] += variance

    def expect(self, t1: float, t2: float) -> tuple[float, float]:
        """A strip over [t1, t2] (s) as believed, its tilts included, and the variance."""
        self._weigh(t1, t2)
        value, variance = expected(self._x, self._cov, self._h)
        return float(value), float(variance)

    def update(self, t1: float, t2: float, observed: float, noise: float) -> float:
        """Take a strip over [t1, t2] (s) as observed with a variance; returns the gain of the present value."""
        self._weigh(t1, t2)
        return float(updated(self._x, self._cov, self._h, observed, noise))

    def now(self, t: float) -> tuple[float, float]:
        """Value and variance of x at time t (s), not before the last step."""
        return float(self._x[0]), float(self._cov[0, 0] + self._walk * max(t - self.t, 0.0))

    def learn(self, surprise: float, total: float, least: float) -> None:
        """Correct the variance of the sway by what an innovation says of it.

        surprise: square of the standardised innovation less one, as far as it is believed.  total: variance of the
        innovation as expected.  least: variance that is not gone below.
        """
        part = min(2.0 * self.sway / total, 1.0)
        self.sway = max(self.sway * (1.0 + surprise * part), least)

    def _weigh(self, t1: float, t2: float) -> None:
        n, old, new = self._lags, (self.t - t1) / self._step, (self.t - t2) / self._step
        self._h[:] = 0.0
        if self._ends:
            _at(self._h, 0, n, old, 0.5)
            _at(self._h, 0, n, new, 0.5)
        else:
            interval_weights(self._mean, self._step, old, new)
            self._h[:n] = self._mean[:n]
        _at(self._h, n, n, old, 1.0)
        _at(self._h, n, n, new, -1.0)


@njit(cache=True)
def _at(h: Array, first: int, count: int, back: float, weight: float) -> None:  # pragma: no cover - compiled
    """Add the weights of the value `back` steps ago, straight between the lags h[first ... first + count]."""
    back = min(max(back, 0.0), count - 1.0)
    i = min(int(back), count - 2)
    h[first + i] += weight * (1.0 - (back - i))
    h[first + i + 1] += weight * (back - i)


@njit(cache=True)
def _shift(
    x: Array, cov: Array, half: Array, move: Array, walk: float, kick: Array
) -> None:  # pragma: no cover - compiled
    """One step: x walks on, s and its rate move and are kicked, lags grow by one, the last of each is dropped.

    half: room like cov.
    """
    last = x.shape[0] - 1
    n = last // 2
    _stepped(x.copy(), x, move, n)
    for j in range(last + 1):
        _stepped(cov[:, j], half[:, j], move, n)
    for i in range(last + 1):
        _stepped(half[i], cov[i], move, n)
    cov[0, 0] += walk
    cov[n, n] += kick[0, 0]
    cov[n, last] += kick[0, 1]
    cov[last, n] += kick[1, 0]
    cov[last, last] += kick[1, 1]


@njit(cache=True)
def _stepped(old: Array, new: Array, move: Array, n: int) -> None:  # pragma: no cover - compiled
    """A state vector one step on, without noise; n: lags of each."""
    last = 2 * n
    new[0] = old[0]
    for i in range(1, n):
        new[i], new[n + i] = old[i - 1], old[n + i - 1]
    new[n] = move[0, 0] * old[n] + move[0, 1] * old[last]
    new[last] = move[1, 0] * old[n] + move[1, 1] * old[last]
