"""Equations (13) to (17) against the study's numbers, the Riccati equation of another library, and statistics."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from aerosim.estimation.kalman import (
    ScalarFilter,
    Series,
    next_gain_halving,
    next_gain_riccati,
    next_variance,
    stationary_gain,
)

CONSISTENT = 0.225 * 12.93 / 25.0  # b2 T/N0 of one recognition at 3000 m: 0.116


def test_series_15_and_its_limit(vectors: dict[str, Any]) -> None:
    gain = vectors["gain"]
    assert stationary_gain(gain["gamma"]) == pytest.approx(gain["q_inf"], rel=1e-14)
    assert round(gain["q_inf"], 4) == 0.0951
    for q, following in pairwise(gain["series_15"]):
        assert next_gain_riccati(q, gain["gamma"]) == pytest.approx(following, rel=1e-14)


def test_series_17_reaches_the_same_limit_sooner(vectors: dict[str, Any]) -> None:
    gain = vectors["gain"]
    for q, following in pairwise(gain["series_17"]):
        assert next_gain_halving(q, gain["q_inf"]) == pytest.approx(following, rel=1e-14)
    slow, fast = 1.0, 1.0
    for _ in range(10):
        slow, fast = next_gain_riccati(slow, 0.01), next_gain_halving(fast, stationary_gain(0.01))
    assert (round(slow, 4), round(fast, 4)) == (0.1201, 0.0960)  # the study


def test_variance_14(vectors: dict[str, Any]) -> None:
    given = vectors["variance_14"]
    for variance, following in pairwise(given["K"]):
        assert next_variance(variance, given["b2T"], given["N0"]) == pytest.approx(following, rel=1e-14)


@pytest.mark.parametrize("gamma", [0.001, 0.01, CONSISTENT, 1.0, 30.0])
def test_limit_solves_the_riccati_equation(gamma: float) -> None:
    """A walk seen with noise of variance 1: scipy gives the variance before the observation, P; q = P/(P + 1)."""
    one = np.ones((1, 1))
    before = float(solve_discrete_are(one, one, gamma * one, one)[0, 0])
    assert stationary_gain(gamma) == pytest.approx(before / (before + 1.0), rel=1e-9)


def test_filter_16(vectors: dict[str, Any]) -> None:
    given = vectors["filter_16"]
    state = ScalarFilter(given["gamma"], noise=25.0)
    for observed, gain, estimate in zip(given["y"], given["q"], given["estimate"], strict=True):
        state.update(observed)
        assert state.gain == pytest.approx(gain, rel=1e-14)
        assert state.estimate == pytest.approx(estimate, rel=1e-14)
        assert state.variance == pytest.approx(25.0 * gain, rel=1e-14)


@pytest.mark.parametrize("series", ["riccati", "halving"])
def test_first_observation_is_taken_as_it_is(series: Series) -> None:
    state = ScalarFilter(0.01, 25.0, series)
    assert math.isnan(state.estimate)
    assert math.isnan(state.update(7.0))
    assert (state.estimate, state.gain) == (7.0, 1.0)
    state.update(9.0)
    state.restart()
    assert math.isnan(state.estimate)
    state.update(-3.0)
    assert (state.estimate, state.gain) == (-3.0, 1.0)


def test_halving_inside_the_filter(vectors: dict[str, Any]) -> None:
    state = ScalarFilter(0.01, 25.0, "halving")
    for gain in vectors["gain"]["series_17"]:
        state.update(0.0)
        assert state.gain == pytest.approx(gain, rel=1e-14)


@pytest.mark.parametrize(("gamma", "strips"), [(0.01, 10.0), (CONSISTENT, 2.9)])
def test_time_constant_in_strips(gamma: float, strips: float) -> None:
    """After a step of the state the error falls to 1/e: 10 strips for the printed gamma, 3 for the consistent."""
    state = ScalarFilter(gamma, 25.0)
    for _ in range(300):
        state.update(0.0)
    errors = []
    for _ in range(60):
        state.update(1.0)
        errors.append(1.0 - state.estimate)
    constant = np.interp(-1.0, np.log(errors)[::-1], np.arange(60.0, 0.0, -1.0))
    assert constant == pytest.approx(strips, abs=0.1)


def test_error_and_innovations_as_the_filter_claims() -> None:
    """Random walk and white noise, 200 runs of 400 steps, the first 50 left out.

    The errors of the stationary filter follow e_j = (1 - q) e_{j-1} + white, correlation r = 1 - q = 0.71, so
    squares are correlated by r^2 and M of them count as M (1 - r^2)/(1 + r^2) = 70000 x 0.33 = 23000
    independent ones: relative standard deviation sqrt(2/23000) = 0.9 %, bound 4 sigma = 3.7 %.
    Innovations are white: 70000 squares, sqrt(2/70000) = 0.53 %, bound 2.1 %; their correlation from
    one to the next has a standard deviation of 1/sqrt(70000) = 0.0038, bound 0.015.
    """
    rng = np.random.default_rng(1988)
    noise = 25.0
    errors, innovations = np.empty((200, 400)), np.empty((200, 400))
    for run in range(200):
        walk = np.cumsum(math.sqrt(CONSISTENT * noise) * rng.standard_normal(400))
        seen = walk + math.sqrt(noise) * rng.standard_normal(400)
        state = ScalarFilter(CONSISTENT, noise)
        for j in range(400):
            innovations[run, j] = state.update(float(seen[j]))
            errors[run, j] = state.estimate - walk[j]
    before = float(solve_discrete_are(*np.reshape([1.0, 1.0, CONSISTENT * noise, noise], (4, 1, 1)))[0, 0])
    stationary = before * noise / (before + noise)
    assert state.variance == pytest.approx(stationary, rel=1e-9)
    assert np.mean(errors[:, 50:] ** 2) == pytest.approx(stationary, rel=0.037)
    late = innovations[:, 50:]
    assert np.mean(late**2) == pytest.approx(1.0, abs=0.021)
    assert abs(np.mean(late[:, 1:] * late[:, :-1])) < 0.015


def test_a_wrong_gamma_is_worse() -> None:
    """The optimum is one: the printed gamma on a walk ten times faster loses, and so does a hasty one."""
    rng = np.random.default_rng(7)
    loss = dict.fromkeys((0.01, CONSISTENT, 1.0), 0.0)
    for _ in range(50):
        walk = np.cumsum(math.sqrt(CONSISTENT) * rng.standard_normal(300))
        seen = walk + rng.standard_normal(300)
        for gamma in loss:
            state = ScalarFilter(gamma, 1.0)
            for j in range(300):
                state.update(float(seen[j]))
                loss[gamma] += (state.estimate - walk[j]) ** 2
    assert loss[CONSISTENT] < 0.9 * min(loss[0.01], loss[1.0])
