"""Blunders and steps: closed forms of the statistics, and searches in a few series."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.errors import InputError
from aerosim.estimation.ari import fit_ari
from aerosim.estimation.ari.filter import filter_series
from aerosim.estimation.ari.process import Process
from aerosim.estimation.ari.robust import deletion_residuals, rejection_limit, step_statistics
from estimation.ari.points import POINTS, Point
from estimation.ari.proofs import blunders, steps


def process(point: Point) -> Process:
    return Process(np.array(point.a), point.d, point.sigma_n, point.sigma_e)


@pytest.mark.parametrize("weight", [1.0, 0.3, 0.0])
def test_deletion_residual_is_that_without_the_point(weight: float) -> None:
    """Whatever weight it has just now: y less the smoothed value of the others, over both standard deviations."""
    point = POINTS["gps_x"]
    _, y = point.series(1)
    own, used = np.ones(len(y)), np.ones(len(y))
    own[40], used[40] = 0.8, weight
    without = used.copy()
    without[40] = 0.0
    alone = filter_series(y, without, process(point))
    expected = (y[40] - alone.x[40]) / np.sqrt(point.sigma_n**2 / 0.8 + alone.cov_band[40, 0])
    assert deletion_residuals(filter_series(y, used, process(point)), own)[40] == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("key", ["gps_x", "shuttle_120", "falcon_yaw"])
def test_step_statistic_is_generalised_least_squares(key: str) -> None:
    """Dense: w = A y has covariance S = sn^2 A A' + se^2 I; a step adds A h."""
    point, n = POINTS[key], 80
    _, y = point.series(2, n)
    known = process(point)
    c, m = known.c, len(known.c) - 1
    A = np.array([np.r_[np.zeros(t - m), c[::-1], np.zeros(n - 1 - t)] for t in range(m, n)])
    S = known.sigma_n**2 * A @ A.T + known.sigma_e**2 * np.eye(n - m)
    t, sigma = step_statistics(filter_series(y, np.ones(n), known, start="diffuse", width=2 * m))
    for at in (m, 30, 55, n - m - 1):
        g = A @ (np.arange(n) >= at).astype(float)
        information = g @ np.linalg.solve(S, g)
        assert sigma[at] == pytest.approx(information**-0.5, rel=1e-7)
        assert t[at] == pytest.approx(g @ np.linalg.solve(S, A @ y) * information**-0.5, rel=1e-6, abs=1e-8)


def test_a_step_that_nothing_shows_has_no_statistic() -> None:
    """sigma_n of 1e5 sigma_e: what a step leaves in the equations cancels to rounding; no number, no warning."""
    point = POINTS["falcon_yaw"]
    _, y = point.series(3, 100)
    known = Process(np.array(point.a), 2, 1.0, 1e-5)
    t, sigma = step_statistics(filter_series(y, np.ones(100), known, width=8))
    assert not np.any(np.abs(t) > 1e6)
    assert not np.any(sigma > 1e6)


def test_level_flight_in_steps_of_the_altimeter_is_answered() -> None:
    """A held height read in whole steps, changing seldom: an answer with its flag, or one line; never a fault."""
    rng, answers = np.random.default_rng(4), []
    for seed in range(6):
        held = 25.0 * np.round(0.4 * rng.normal(size=300).cumsum() / (1.0 + seed))
        try:
            assert "quantised" in fit_ari(held, 2, 2).flags
        except InputError as error:
            answers.append(str(error))
    assert all("outliers" in answer for answer in answers)
    assert len(answers) < 6


def test_rejection_limit_knows_how_many_there_are() -> None:
    """One of 600 must be rarer than 0.05/600 (3.93); 40 clear ones let the limit fall to its floor."""
    t = np.random.default_rng(3).uniform(-2.0, 2.0, 600)
    assert rejection_limit(t) == np.inf
    t[7] = 3.9
    assert rejection_limit(t) == np.inf
    t[7] = 3.95
    assert rejection_limit(t) == pytest.approx(3.95)
    t[100:140] = 9.0
    t[7] = 3.31
    assert rejection_limit(t) == pytest.approx(3.31)
    t[8] = 3.29
    assert rejection_limit(t) == pytest.approx(3.3)


def test_blunders_do_not_reach_the_result() -> None:
    point = POINTS["falcon_yaw"]
    truth, y = point.series(4)
    at = np.array([50, 51, 200, 333, 480])
    spoilt = y.copy()
    spoilt[at] += 10.0 * point.sigma_n * np.array([1.0, -1.0, 1.0, -1.0, 1.0])
    clean, fit = fit_ari(y, 2, 2), fit_ari(spoilt, 2, 2)
    assert set(at) <= set(fit.strip.outliers)
    assert np.all(fit.strip.weights[at] == 0.0)
    assert fit.sigma_n.value == pytest.approx(clean.sigma_n.value, rel=0.03)
    assert np.std(fit.x - truth) < 1.05 * np.std(clean.x - truth)
    kept = fit_ari(spoilt, 2, 2, robust="none", steps=False)
    assert not len(kept.strip.outliers)
    assert kept.sigma_n.value > 1.2 * clean.sigma_n.value


def test_a_step_is_carried_through() -> None:
    point = POINTS["falcon_yaw"]
    truth, y = point.series(5)
    jump = 12.0 * point.sigma_n * (np.arange(600) >= 250)
    fit = fit_ari(y + jump, 2, 2)
    (step,) = fit.strip.steps
    assert abs(step.index - 250) <= 1
    assert abs(step.size - 12.0 * point.sigma_n) < 4.0 * step.sigma
    assert np.max(np.abs(fit.x - truth - jump)[[*range(230, 249), *range(252, 270)]]) < 2.0 * point.sigma_n
    # beside it less is known than elsewhere
    assert fit.strip.sigma_x[250] > 1.2 * fit.strip.sigma_x[150]
    blind = fit_ari(y + jump, 2, 2, steps=False, robust="none")
    assert np.max(np.abs(blind.x - truth - jump)[240:260]) > 3.0 * point.sigma_n


def test_one_blunder_is_no_step_and_a_clean_strip_has_neither() -> None:
    point = POINTS["shuttle_400"]
    _, y = point.series(6)
    assert not fit_ari(y, 6, 1).strip.steps
    y[100] += 10.0 * point.sigma_n
    strip = fit_ari(y, 6, 1).strip
    assert 100 in strip.outliers
    assert not strip.steps


@pytest.mark.slow
@pytest.mark.parametrize("key", ["gps_x", "falcon_yaw", "shuttle_400"])
def test_most_blunders_are_found(key: str) -> None:
    """Binomial scatter of 600 to 3000 blunders: 0.8 to 0.4 %."""
    for share in (0.01, 0.05):
        found, false = blunders(POINTS[key], range(90_000, 90_100), share)
        assert found > (0.93 if key == "gps_x" else 0.96)
        assert false < 0.003


@pytest.mark.slow
@pytest.mark.parametrize("key", ["falcon_yaw", "shuttle_120"])
def test_most_steps_are_found(key: str) -> None:
    found, other = steps(POINTS[key], range(90_000, 90_100), 10.0)
    assert found >= 0.95
    assert other <= 0.1
