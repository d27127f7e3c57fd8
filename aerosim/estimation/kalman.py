"""The scalar Kalman filter of the 1988 paper, equations (13) to (17), for n and for the drift."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Series = Literal["riccati", "halving"]


def next_gain_riccati(q: float, gamma: float) -> float:
    """Equation (15): q_j from q_{j-1}, q = K/N0 and gamma = b2 T/N0, both without unit."""
    return (q + gamma) / (q + gamma + 1.0)


def stationary_gain(gamma: float) -> float:
    """Limit q_inf of (15): (-gamma + sqrt(gamma^2 + 4 gamma))/2."""
    return float((-gamma + np.sqrt(gamma * gamma + 4.0 * gamma)) / 2.0)


def next_gain_halving(q: float, q_inf: float) -> float:
    """Equation (17): halfway to the limit, by an addition and a shift."""
    return (q + q_inf) / 2.0


def next_variance(variance: float, walk: float, noise: float) -> float:
    """Equation (14): K_j from K_{j-1}, walk = b2 T and noise = N0, all in one unit squared."""
    predicted = variance + walk
    return noise * predicted / (noise + predicted)


@dataclass
class ScalarFilter:
    """A state that walks at random, observed with white noise: (13) in the shape of (16).

    gamma: b2 T/N0 of one step.  noise: N0, unit squared; it scales the variance, not the gain.
    The first observation is taken as it is (q_0 = 1).
    """

    gamma: float
    noise: float
    series: Series = "riccati"
    estimate: float = float("nan")
    gain: float = 1.0
    started: bool = False

    def update(self, observed: float) -> float:
        """Take one observation; returns its innovation over its standard deviation (NaN for the first)."""
        if not self.started:
            self.estimate, self.gain, self.started = observed, 1.0, True
            return float("nan")
        innovation = observed - self.estimate
        spread = float(np.sqrt(self.noise * (self.gain + self.gamma + 1.0)))
        if self.series == "riccati":
            self.gain = next_gain_riccati(self.gain, self.gamma)
        else:
            self.gain = next_gain_halving(self.gain, stationary_gain(self.gamma))
        self.estimate += self.gain * innovation
        return innovation / spread

    @property
    def variance(self) -> float:
        """K = q N0."""
        return self.gain * self.noise

    def restart(self) -> None:
        """Forget the state: the next observation starts anew."""
        self.estimate, self.gain, self.started = float("nan"), 1.0, False
