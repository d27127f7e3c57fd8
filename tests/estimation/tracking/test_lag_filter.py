"""The filter whose measurements are means over the past, against algebra that knows nothing of lags."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import cho_factor, cho_solve

from aerosim.estimation.tracking.lag_filter import LagFilter, WalkModel

STEP = 0.5
MODEL = WalkModel(walk=0.02, slope_sigma=0.03, slope_time=40.0, rate_sigma=0.004, lever=3.0)
START, SPREAD = 1.5, 0.8


def weights(times: np.ndarray, t1: float, t2: float) -> np.ndarray:
    """Weights of values at `times` in the mean over [t1, t2] of the line through them, by fine sums."""
    fine = np.linspace(t1, t2, 20001)
    fine = 0.5 * (fine[1:] + fine[:-1])
    out = np.zeros(len(times))
    k = np.clip(np.searchsorted(times, fine) - 1, 0, len(times) - 2)
    part = (fine - times[k]) / (times[k + 1] - times[k])
    np.add.at(out, k, 1.0 - part)
    np.add.at(out, k + 1, part)
    return out / len(fine)


def batch(measured: list[tuple[float, float, float, float]], end: float) -> tuple[float, float]:
    """Estimate of x(end) and its variance by least squares on all values at once, as a joint Gaussian.

    x on the grid of STEP: x_{k+1} = x_k + STEP b_k + STEP^2/2 r + walk, b_{k+1} = keep b_k + STEP r + kick.  A
    strip is the mean of x less LEVER r.
    """
    n = round(end / STEP) + 1
    keep = np.exp(-STEP / MODEL.slope_time)
    transition = np.array([[1.0, STEP, STEP**2 / 2.0], [0.0, keep, STEP], [0.0, 0.0, 1.0]])
    noise = np.diag([MODEL.walk * STEP, MODEL.slope_sigma**2 * (1.0 - keep**2), 0.0])
    cov = np.zeros((3 * n, 3 * n))
    cov[:3, :3] = np.diag([SPREAD, MODEL.slope_sigma**2, MODEL.rate_sigma**2])
    for k in range(1, n):
        a, b = slice(3 * k - 3, 3 * k), slice(3 * k, 3 * k + 3)
        cov[b, : 3 * k] = transition @ cov[a, : 3 * k]
        cov[: 3 * k, b] = cov[b, : 3 * k].T
        cov[b, b] = transition @ cov[a, a] @ transition.T + noise
    mean = np.zeros(3 * n)
    mean[::3] = START
    times = np.arange(n) * STEP
    rows = np.zeros((len(measured), 3 * n))
    for row, (t1, t2, _, _) in zip(rows, measured, strict=True):
        row[::3] = weights(times, t1, t2)
        row[2] = -MODEL.lever
    values, noises = np.array([m[2] for m in measured]), np.diag([m[3] for m in measured])
    factor = cho_factor(rows @ cov @ rows.T + noises)
    gain = cho_solve(factor, rows @ cov).T
    state = mean + gain @ (values - rows @ mean)
    left = cov - gain @ rows @ cov
    return float(state[-3]), float(left[-3, -3])


def test_equals_least_squares_on_everything_at_once() -> None:
    """Measured at each second from 6 s on, means over the past 5.3 s, taken when they end."""
    rng = np.random.default_rng(5)
    measured = [(t - 5.3, t, float(START + rng.normal()), 0.05 + 0.1 * rng.random()) for t in np.arange(6.0, 15.0)]
    # the filter begins at the first measured interval's start with the value's prior and no correlated past
    found = LagFilter(MODEL, STEP, reach=16.0)
    found.start(0.0, START, SPREAD)
    # the start says that the past has walked; here there is none: all intervals begin after it
    for t1, t2, value, noise in measured:
        found.advance(t2)
        found.update(t1, t2, value, noise)
    value, variance = found.now(14.0)
    wanted, wanted_variance = batch(measured, 14.0)
    assert value == pytest.approx(wanted, abs=2e-4)  # the sums of `weights` are as fine as 1e-4 of the interval
    assert variance == pytest.approx(wanted_variance, rel=1e-3)


def test_between_two_steps_the_value_moves_along_the_slope() -> None:
    found = LagFilter(WalkModel(1e-6, 0.05, 1e6), STEP, reach=5.0)
    found.start(0.0, 2.0, 0.1)
    for t in np.arange(0.5, 60.0, 0.5):
        found.advance(t)
        found.update(t - 2.0, t, 2.0 + 0.05 * (t - 1.0), 1e-4)
    value, _ = found.now(59.5)
    later, _ = found.now(59.9)
    assert value == pytest.approx(2.0 + 0.05 * 59.5, abs=0.01)
    assert later - value == pytest.approx(0.4 * 0.05, rel=0.1)


def test_variance_grows_with_the_walk_while_nothing_is_measured() -> None:
    found = LagFilter(WalkModel(0.02, 1e-9, 1.0), STEP, reach=10.0)
    found.start(0.0, 0.0, 0.3)
    found.advance(50.0)
    assert found.now(50.0)[1] == pytest.approx(0.3 + 0.02 * 50.0, rel=1e-9)


def test_a_doubt_is_of_the_whole_course() -> None:
    found = LagFilter(WalkModel(0.02, 1e-9, 1.0), STEP, reach=10.0)
    found.start(0.0, 0.0, 0.3)
    before = found.expect(-6.0, -1.0)[1]
    found.inflate(0.5)
    assert found.expect(-6.0, -1.0)[1] == pytest.approx(before + 0.5)


def test_a_walk_grows_with_innovations_that_hang_together_and_no_further() -> None:
    found = LagFilter(WalkModel(0.02, 1e-9, 1.0, walk_most=2.0), STEP, reach=10.0)
    grown = []
    for product in [1.5] * 60 + [0.0] * 200:
        found.hang_together(product)
        found.start(0.0, 0.0, 0.3)
        found.advance(50.0)
        grown.append((found.now(50.0)[1] - 0.3) / 50.0)
    assert grown[0] > 0.02
    assert max(grown) == pytest.approx(2.0)
    assert grown[-1] == pytest.approx(0.02)


def test_a_walk_that_may_not_grow_stays() -> None:
    found = LagFilter(WalkModel(0.02, 1e-9, 1.0), STEP, reach=10.0)
    found.hang_together(3.0)
    found.start(0.0, 0.0, 0.3)
    found.advance(50.0)
    assert found.now(50.0)[1] == pytest.approx(0.3 + 0.02 * 50.0)
