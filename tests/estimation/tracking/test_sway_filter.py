"""The filter that follows the tilt it is not told, against Gaussian algebra that knows no states."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from aerosim.estimation.tracking.sway_filter import SwayFilter

STEP, SPAN, WALK, SWAY, TIME, START = 0.5, 6.0, 0.02, 0.4, 1.5, 0.8


def matern(apart: np.ndarray) -> np.ndarray:
    """Covariance of a critically damped oscillation, its variance one."""
    scaled = np.abs(apart) / TIME
    return np.asarray((1.0 + scaled) * np.exp(-scaled))


@pytest.mark.parametrize("ends", [True, False])
def test_equals_conditioning_a_gaussian_on_everything_at_once(ends: bool) -> None:
    """x: walks both ways from its start at t = 0, where it is known to START; s: stationary."""
    times = np.arange(-20, 61) * STEP
    walked = WALK * np.where(np.outer(times, times) > 0, np.minimum.outer(abs(times), abs(times)), 0.0)
    cov_x, cov_s = START + walked, SWAY * matern(np.subtract.outer(times, times))
    rng = np.random.default_rng(2)
    rows_x, rows_s, values, noises = [], [], [], []
    found = SwayFilter(WALK, STEP, 9.0, SWAY, TIME, ends=ends)
    found.start(0.0, 1.0, START)
    for t2 in np.arange(1, 56) * STEP:
        first, last = np.flatnonzero(times == t2 - SPAN)[0], np.flatnonzero(times == t2)[0]
        row_x, row_s = np.zeros(len(times)), np.zeros(len(times))
        if ends:
            row_x[[first, last]] = 0.5
        else:
            row_x[first : last + 1] = STEP / SPAN
            row_x[[first, last]] /= 2.0
        row_s[first], row_s[last] = 1.0, -1.0
        value, noise = float(rng.normal(1.0, 1.0)), float(rng.uniform(0.05, 0.1))
        rows_x.append(row_x), rows_s.append(row_s), values.append(value), noises.append(noise)
        found.advance(float(t2))
        found.update(float(t2 - SPAN), float(t2), value, noise)
    x, s = np.array(rows_x), np.array(rows_s)
    seen = x @ cov_x @ x.T + s @ cov_s @ s.T + np.diag(noises)
    now = np.flatnonzero(times == found.t)[0]
    gain = np.linalg.solve(seen, x @ cov_x[:, now])
    value, variance = found.now(found.t)
    assert value == pytest.approx(1.0 + gain @ (np.array(values) - 1.0), abs=1e-8)
    assert variance == pytest.approx(cov_x[now, now] - gain @ x @ cov_x[:, now], abs=1e-8)


def bound(noise: float) -> float:
    """Standard deviation of x that the stationary Riccati equation leaves: own matrices, after a measurement."""
    lags = round(SPAN / STEP) + 1
    size = 2 * lags + 1
    fine = 2000  # the oscillation in small steps: nothing of its closed form is used
    move, kick = np.eye(2), np.zeros((2, 2))
    drift = np.array([[0.0, 1.0], [-1.0 / TIME**2, -2.0 / TIME]])
    density = 4.0 * SWAY / TIME**3
    small = np.eye(2) + drift * STEP / fine + drift @ drift * (STEP / fine) ** 2 / 2.0
    for _ in range(fine):
        move, kick = small @ move, small @ kick @ small.T + np.diag([0.0, density * STEP / fine])
    transition = np.zeros((size, size))
    transition[0, 0] = 1.0
    for i in range(1, lags):
        transition[i, i - 1] = transition[lags + i, lags + i - 1] = 1.0
    pair = [lags, size - 1]
    transition[np.ix_(pair, pair)] = move
    noise_state = np.zeros((size, size))
    noise_state[0, 0] = WALK * STEP
    noise_state[np.ix_(pair, pair)] = kick
    row = np.zeros(size)
    row[0] = row[lags - 1] = 0.5
    row[lags], row[2 * lags - 1] = -1.0, 1.0
    before = solve_discrete_are(transition.T, row[:, None], noise_state, np.array([[noise]]))
    seen = before @ row
    return float(np.sqrt(before[0, 0] - seen[0] ** 2 / (row @ seen + noise)))


@pytest.mark.parametrize("noise", [0.01, 0.1])
def test_the_filter_stands_at_the_riccati_bound(noise: float) -> None:
    found = SwayFilter(WALK, STEP, 9.0, SWAY, TIME, ends=True)
    found.start(0.0, 0.0, 1.0)
    for k in range(1, 600):
        found.advance(k * STEP)
        found.update(k * STEP - SPAN, k * STEP, 0.0, noise)
    assert np.sqrt(found.now(found.t)[1]) == pytest.approx(bound(noise), rel=2e-3)  # the small steps: 1/2000


def test_knowing_the_tilt_of_the_first_look_is_worth_more_than_noise_of_the_same_size() -> None:
    """The same scatter as white noise, each block anew, leaves more than the sway that is followed."""
    found = SwayFilter(WALK, STEP, 9.0, 1e-12, TIME, ends=True)
    found.start(0.0, 0.0, 1.0)
    for k in range(1, 600):
        found.advance(k * STEP)
        # white noise of the sway's intensity: twice the variance over its correlation time, 4 TIME
        found.update(k * STEP - SPAN, k * STEP, 0.0, 2.0 * SWAY * 4.0 * TIME / STEP)
    assert found.now(found.t)[1] > 1.3 * bound(0.01) ** 2


def test_a_doubt_leaves_the_tilts_alone() -> None:
    found = SwayFilter(WALK, STEP, 9.0, SWAY, TIME, ends=True)
    found.start(0.0, 0.0, 0.3)
    before = found.expect(-6.0, 0.0)[1]
    found.inflate(0.5)
    assert found.expect(-6.0, 0.0)[1] == pytest.approx(before + 0.5)
