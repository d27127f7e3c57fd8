"""Gauss processes: covariance over time against closed forms, whatever the sampling step."""

import math

import numpy as np
import pytest

from aerosim.world.process import GaussProcess

OSCILLATOR = {"a": [[0.0, 1.0], [-4.0, -0.8]], "b": [[0.0], [1.0]], "c": [[1.0, 0.0]]}  # omega 2, zeta 0.2


class Impulse:
    """Stands for a generator: one unit number among zeros, in the first draw (start) or later."""

    def __init__(self, column, start):
        self.column, self.start, self.draws = column, start, 0

    def standard_normal(self, shape):
        out = np.zeros(shape)
        self.draws += 1
        if self.start and self.draws == 1:
            out[self.column] = 1.0
        if not self.start and self.draws == 2:
            out[0, self.column] = 1.0
        return out


def autocovariance(system, dt, steps, lags, start=False):
    """Exact covariance of y(t) and y(t + lag dt) of what is made, from its answers to unit numbers.

    start: at the first step, from the answers to the stationary start alone.
    """
    n = len(system["a"])
    found = 0.0
    for column in range(n):
        y = GaussProcess(**system, dt=dt, rng=Impulse(column, start)).draw(steps)
        if start:
            found = found + np.array([y[0] * y[lag] for lag in lags])
        else:
            found = found + np.array([(y[: steps - lag] * y[lag:]).sum(axis=0) for lag in lags])
    return found[:, 0]


def first_order(time_constant, sigma):
    return {"a": [[-1.0 / time_constant]], "b": [[sigma * math.sqrt(2.0 / time_constant)]], "c": [[1.0]]}


@pytest.mark.parametrize("rate", [1.0, 60.0, 240.0])
@pytest.mark.parametrize("start", [True, False])
def test_first_order_is_exponential_at_every_rate(rate, start):
    lags = np.array([0, 1, 2, 5]) * max(1, round(rate / 10))
    # 40 time constants: what is cut off is e^-80
    found = autocovariance(first_order(3.0, 1.7), 1.0 / rate, round(120 * rate), lags, start)
    assert found == pytest.approx(1.7**2 * np.exp(-lags / rate / 3.0), rel=1e-9)


@pytest.mark.parametrize("rate", [5.0, 60.0, 240.0])
@pytest.mark.parametrize("start", [True, False])
def test_damped_oscillator_at_every_rate(rate, start):
    # x'' + 2 zeta omega x' + omega^2 x = white: variance 1/(4 zeta omega^3) (Crandall & Mark 1963)
    omega, zeta = 2.0, 0.2
    damped = omega * math.sqrt(1.0 - zeta**2)
    lags = np.array([0, 1, 2, 4, 8]) * round(rate / 5)
    tau = lags / rate
    wave = np.cos(damped * tau) + zeta / math.sqrt(1.0 - zeta**2) * np.sin(damped * tau)
    expected = np.exp(-zeta * omega * tau) * wave / (4.0 * zeta * omega**3)
    found = autocovariance(OSCILLATOR, 1.0 / rate, round(60 * rate), lags, start)
    assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("rate", [60.0, 240.0])
def test_made_series_has_the_covariance(rate):
    # Bartlett: var of a sample covariance over D seconds is at most 2/D int R^2 = 2 T/D R(0)^2 for a first order
    # of T.  T 0.1 s, D 4000 s: sd 0.7 %; 4.5 of them.
    time_constant, duration = 0.1, 4000.0
    rng = np.random.default_rng(11)
    y = GaussProcess(**first_order(time_constant, 2.0), dt=1.0 / rate, rng=rng).draw(round(duration * rate))[:, 0]
    bound = 4.5 * 4.0 * math.sqrt(2.0 * time_constant / duration)
    for lag in (0, 3, 6, 12, 60):
        steps = lag * round(rate / 60.0)
        found = float(np.mean(y[: len(y) - steps] * y[steps:]))
        assert found == pytest.approx(4.0 * math.exp(-lag / 60.0 / time_constant), abs=bound)


def test_blocks_join_without_a_seam():
    whole = GaussProcess(**OSCILLATOR, dt=0.1, rng=np.random.default_rng(4)).draw(300)
    parts = GaussProcess(**OSCILLATOR, dt=0.1, rng=np.random.default_rng(4))
    assert np.array_equal(np.vstack([parts.draw(100), parts.draw(1), parts.draw(199)]), whole)


@pytest.mark.parametrize("a", [[[0.0]], [[0.1]], [[0.0, 1.0], [-4.0, 0.0]], [[0.0, 1.0], [-4.0, 0.1]]])
def test_unstable_system_is_refused(a):
    n = len(a)
    with pytest.raises(ValueError, match="not stable"):
        GaussProcess(a, np.ones((n, 1)), np.ones((1, n)), 0.1, np.random.default_rng(1))
