"""A Kalman filter whose measurements are means over a past interval: the walk and its lags as states."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from aerosim.frames import Array

FOLLOW, TOGETHER = 0.2, 0.2  # growth of the walk by innovations that are correlated by more than TOGETHER


@dataclass(frozen=True)
class WalkModel:
    """What is assumed of a quantity: a random walk on a slope that wanders.

    walk: its intensity, unit^2/s; walk_most: to which it may grow if innovations hang together.  slope_sigma,
    slope_time: the slope's standard deviation, unit/s, and time constant, s, as a Gauss-Markov process: the
    error of a levelled acceleration is one.  rate_sigma: of a constant rate of the slope, unit/s^2, as a gyro's
    drift makes it.  lever: s^2, a strip is lower than the mean by so many rates: what tilts the acceleration
    tilts the two looks, one more than the other.
    """

    walk: float
    slope_sigma: float
    slope_time: float
    rate_sigma: float = 0.0
    lever: float = 0.0
    walk_most: float = 0.0


class LagFilter:
    """State x(t), x(t - step), ..., the slope and its rate; measured are means of x over intervals [t1, t2].

    Source: the stationary Riccati equation with the lags in the state, as in docs/best.md.
    """

    sway = 0.0  # what tilts the looks is known

    def __init__(self, model: WalkModel, step: float, reach: float) -> None:
        """step: of the lags, s.  reach: how far back a measured interval may begin, s."""
        self._model = model
        self._walk = model.walk
        self._step = step
        n = self._lags = math.ceil(reach / step) + 2
        self._keep = math.exp(-step / model.slope_time)
        self._x = np.zeros(n + 2)
        self._cov = np.zeros((n + 2, n + 2))
        self._half = np.zeros_like(self._cov)
        self._h = np.zeros(n + 2)
        self._h[n + 1] = -model.lever
        self.t = math.nan

    def start(self, t: float, value: float, variance: float) -> None:
        """Begin at time t with a value and its variance; the past is taken to have been the same, walked back."""
        n, model = self._lags, self._model
        self.t = t
        self._x[:n], self._x[n:] = value, 0.0
        ages = np.arange(n) * self._step
        self._cov[:] = 0.0
        self._cov[:n, :n] = variance + self._walk * np.minimum.outer(ages, ages)
        self._cov[n, n] = model.slope_sigma**2
        self._cov[n + 1, n + 1] = model.rate_sigma**2

    def advance(self, t: float) -> None:
        """Go on to time t, by whole steps; what is left of a step waits for the next call."""
        while t - self.t > self._step * (1.0 - 1e-9):
            self.t += self._step
            model = self._model
            _shift(
                self._x, self._cov, self._half, self._step, self._keep, self._walk * self._step,
                model.slope_sigma**2 * (1.0 - self._keep**2),
            )  # fmt: skip

    @property
    def slope(self) -> float:
        """The slope as believed, unit/s."""
        return float(self._x[self._lags])

    def hang_together(self, product: float) -> None:
        """Two successive standardised innovations, multiplied: if they have the same sign again and again, x walks
        further than is believed.
        """
        grown = self._walk * math.exp(FOLLOW * (min(max(product, -3.0), 3.0) - TOGETHER))
        self._walk = min(max(grown, self._model.walk), max(self._model.walk_most, self._model.walk))

    def inflate(self, variance: float) -> None:
        """Admit that the whole course may be off by a constant of this variance."""
        n = self._lags
        self._cov[:n, :n] += variance

    def expect(self, t1: float, t2: float) -> tuple[float, float]:
        """A strip over [t1, t2] (s) as believed, and its variance."""
        self._weigh(t1, t2)
        return expected(self._x, self._cov, self._h)

    def update(self, t1: float, t2: float, observed: float, noise: float) -> float:
        """Take a strip over [t1, t2] (s) as observed with a variance; returns the gain of the present value."""
        self._weigh(t1, t2)
        return float(updated(self._x, self._cov, self._h, observed, noise))

    def _weigh(self, t1: float, t2: float) -> None:
        mean = self._h[: self._lags + 1]
        interval_weights(mean, self._step, (self.t - t1) / self._step, (self.t - t2) / self._step)

    def now(self, t: float) -> tuple[float, float]:
        """Value and variance at time t (s), not before the last step."""
        ahead = t - self.t
        n = self._lags
        value = self._x[0] + self._x[n] * ahead
        variance = self._cov[0, 0] + 2.0 * ahead * self._cov[0, n] + ahead * ahead * self._cov[n, n]
        return float(value), float(variance + self._walk * max(ahead, 0.0))


@njit(cache=True)
def _shift(
    x: Array, cov: Array, half: Array, step: float, keep: float, walk: float, kick: float
) -> None:  # pragma: no cover - compiled
    """One step: x0 moves on by slope and walk, all lags grow by one, the last is dropped.  half: room like cov."""
    size = x.shape[0]
    _stepped(x.copy(), x, step, keep)
    for j in range(size):
        _stepped(cov[:, j], half[:, j], step, keep)
    for i in range(size):
        _stepped(half[i], cov[i], step, keep)
    cov[0, 0] += walk
    cov[size - 2, size - 2] += kick


@njit(cache=True)
def _stepped(old: Array, new: Array, step: float, keep: float) -> None:  # pragma: no cover - compiled
    """A state vector one step on, without noise."""
    n = old.shape[0] - 2
    new[0] = old[0] + step * old[n] + 0.5 * step * step * old[n + 1]
    for i in range(1, n):
        new[i] = old[i - 1]
    new[n] = keep * old[n] + step * old[n + 1]
    new[n + 1] = old[n + 1]


@njit(cache=True)
def interval_weights(h: Array, step: float, old: float, new: float) -> None:  # pragma: no cover - compiled
    """Weights of the lags in the mean over [old, new] (in steps back), x taken as straight between the lags.

    h: (lags + 1,), filled; the last is the slope's.
    What lies after the newest lag (new < 0) is x0 carried on along the slope.
    """
    n = h.shape[0] - 1
    h[:] = 0.0
    total = old - new
    if total <= 0.0:
        h[0] = 1.0
        return
    if new < 0.0:
        h[0] += -new
        h[n] += 0.5 * new * new * step
        new = 0.0
    first, last = int(new), min(int(old), n - 2)
    for i in range(first, last + 1):
        a, b = max(new, float(i)), min(old, i + 1.0)
        if b > a:
            middle = 0.5 * (a + b) - i
            h[i] += (b - a) * (1.0 - middle)
            h[i + 1] += (b - a) * middle
    if old > n - 1:  # older than what is kept: as the oldest
        h[n - 1] += old - max(new, n - 1.0)
    for i in range(n + 1):
        h[i] /= total


@njit(cache=True)
def expected(x: Array, cov: Array, h: Array) -> tuple[float, float]:  # pragma: no cover - compiled
    """Value and variance of what the weights h make of a state x with covariance cov; (n,), (n, n), (n,)."""
    value, variance = 0.0, 0.0
    n = x.shape[0]
    for i in range(n):
        if h[i] != 0.0:
            value += h[i] * x[i]
            for j in range(n):
                variance += h[i] * cov[i, j] * h[j]
    return value, variance


@njit(cache=True)
def updated(x: Array, cov: Array, h: Array, observed: float, noise: float) -> float:  # pragma: no cover - compiled
    """Take h x as observed with a variance: x (n,) and cov (n, n) are changed; returns the gain of x[0]."""
    n = x.shape[0]
    gain = np.zeros(n)
    for i in range(n):
        for j in range(n):
            gain[i] += cov[i, j] * h[j]
    variance, value = noise, 0.0
    for i in range(n):
        variance += h[i] * gain[i]
        value += h[i] * x[i]
    step = (observed - value) / variance
    for i in range(n):
        x[i] += gain[i] * step
    for i in range(n):
        for j in range(i, n):
            cov[i, j] -= gain[i] * gain[j] / variance
            cov[j, i] = cov[i, j]
    return float(gain[0] / variance)
