"""What a fit cannot know, it says; the iteration of 1988 and where it goes."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.estimation.ari import Process, filter_ari, fit_ari
from aerosim.estimation.ari.diagnostics import innovations, limits, two_hills, whiteness
from aerosim.estimation.ari.filter import filter_series
from aerosim.estimation.ari.modes import Mode
from aerosim.estimation.ari.vce import autoregression, components, estimate_components, spectral_components
from estimation.ari.points import POINTS
from estimation.ari.proofs import quality


@pytest.mark.parametrize("key", ["gps_x", "shuttle_120", "falcon_yaw"])
def test_components_of_known_coefficients_are_unbiased(key: str) -> None:
    """20 series: the mean of sigma_n within 4 of its standard errors, redundancies summing up to N - m."""
    point = POINTS[key]
    found = []
    for seed in range(20):
        _, y = point.series(seed)
        start = Process(np.array(point.a), point.d, 2.0 * point.sigma_n, 0.5 * point.sigma_e)
        process = estimate_components([y], [np.ones(len(y))], start)
        found.append(process.sigma_n / point.sigma_n)
        _, step, _ = components([y], [np.ones(len(y))], process)
        assert step.redundancy_n + step.redundancy_e == pytest.approx(len(y) - len(point.a) - point.d, rel=1e-8)
    assert np.mean(found) == pytest.approx(1.0, abs=4.0 * np.std(found) / np.sqrt(20.0) + 0.005)


def test_fixed_point_of_the_components_is_the_likelihoods_maximum() -> None:
    point = POINTS["falcon_yaw"]
    _, y = point.series(1)
    w = np.ones(len(y))
    best = estimate_components([y], [w], Process(np.array(point.a), 2, point.sigma_n, point.sigma_e))
    top = filter_series(y, w, best, start="diffuse").loglik
    for n, e in ((1.02, 1.0), (0.98, 1.0), (1.0, 1.1), (1.0, 0.9)):
        other = Process(best.a, 2, n * best.sigma_n, e * best.sigma_e)
        assert filter_series(y, w, other, start="diffuse").loglik < top


def test_a_component_that_vanishes_stays_finite() -> None:
    """A walk without noise, its noise estimated: nothing, not an error."""
    y = np.cumsum(np.random.default_rng(8).normal(size=300))
    process = estimate_components([y], [np.ones(300)], Process(np.zeros(0), 1, 1.0, 1.0))
    assert process.sigma_n < 0.3
    assert process.sigma_e == pytest.approx(1.0, rel=0.2)
    line = np.random.default_rng(9).normal(size=300)
    process = estimate_components([line], [np.ones(300)], Process(np.zeros(0), 2, 1.0, 1.0))
    assert process.sigma_e < 0.01
    assert process.sigma_n == pytest.approx(1.0, rel=0.2)


def test_frequency_domain_says_the_same() -> None:
    """4000 epochs: both within 5 % of the truth and of one another (Cramer-Rao: 1.6 %)."""
    point = POINTS["falcon_yaw"]
    _, y = point.series(2, 4000)
    spectral = spectral_components(y, point.a, 2)
    timed = estimate_components([y], [np.ones(4000)], Process(np.array(point.a), 2, 0.002, 0.001))
    assert spectral.sigma_n == pytest.approx(point.sigma_n, rel=0.05)
    assert spectral.sigma_e == pytest.approx(point.sigma_e, rel=0.10)
    assert spectral.sigma_n == pytest.approx(timed.sigma_n, rel=0.05)


def test_autoregression_is_least_squares() -> None:
    """An exact recursion is found to rounding."""
    u = [np.array([1.0, 0.5]), np.array([0.2, -1.0])]
    for k, series in enumerate(u):
        values = list(series)
        for _ in range(30):
            values.append(0.9 * values[-1] - 0.5 * values[-2])
        u[k] = np.array(values)
    np.testing.assert_allclose(autoregression(u, 2), [-0.9, 0.5], atol=1e-10)


def test_the_papers_iteration_runs_away_and_says_so() -> None:
    """Near the truth on its way, then sigma_e vanishes, a root nears one, and the likelihood falls."""
    point = POINTS["falcon_yaw"]
    flagged = 0
    for seed in range(5):
        _, y = point.series(seed)
        fit = fit_ari(y, 2, 2, method="vce", robust="none", steps=False)
        flagged += "run_away" in fit.flags
        early = fit.iterates[9].process
        assert early.sigma_n == pytest.approx(point.sigma_n, rel=0.15)
        assert fit.sigma_e.value < 0.3 * point.sigma_e
        assert fit.sigma_n.value > 1.03 * point.sigma_n
        assert max(step.loglik for step in fit.iterates) > fit.iterates[-1].loglik + 2.0
        assert np.isnan(fit.sigma_n.low)
    assert flagged == 5


def test_the_papers_iteration_ends_on_a_series_that_breaks_it() -> None:
    """Strips on which the coefficients explode before sigma_e has vanished: an answer with its flag, no fault."""
    point = POINTS["shuttle_120"]
    for seed in range(70_000, 70_012):
        assert "run_away" in fit_ari(point.series(seed)[1], 6, 1, method="vce", robust="none", steps=False).flags


def test_limits_are_those_of_the_whittle_likelihood() -> None:
    """The study's table for N = 1000, computed apart from this code: (2, 2) Falcon yaw, (5, 2) GPS X."""
    table = {"falcon_yaw": {0.1: (0.18, 0.038), 1.0: (0.036, 0.12), 3.0: (0.031, 0.36)}}
    table["gps_x"] = {0.1: (0.18, 0.039), 1.0: (0.046, 0.21), 3.0: (0.040, 1.1)}
    for key, rows in table.items():
        for ratio, expected in rows.items():
            point = POINTS[key]
            found = limits(Process(np.array(point.a), point.d, ratio, 1.0), 1000 + point.d)
            # printed with two digits
            assert found == pytest.approx(expected, rel=0.06)


def test_innovations_are_white_and_of_unit_variance() -> None:
    point = POINTS["falcon_yaw"]
    _, y = point.series(3, 4000)
    y[1000:1010] = np.nan
    z = innovations(filter_ari(y, point.a, 2, point.sigma_n, point.sigma_e))
    assert np.isnan(z[1000:1008]).all()
    known = z[np.isfinite(z)]
    # 4000 values: the variance of a variance is 2/4000, of a correlation 1/4000; four standard errors
    assert np.var(known) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / 4000.0))
    assert abs(np.mean(known[1:] * known[:-1])) < 4.0 / np.sqrt(4000.0)
    assert whiteness([z], 0) > 1e-3
    wrong = innovations(filter_ari(y, [], 2, point.sigma_n, 2.0 * point.sigma_e))
    assert whiteness([wrong], 0) < 1e-3


def test_whiteness_of_white_series_is_uniform() -> None:
    """200 white series: 5 % quantile and mean of a uniform variable (0.5 +- 4 * 0.289/sqrt(200))."""
    rng = np.random.default_rng(4)
    chance = [whiteness([rng.normal(size=400)], 0) for _ in range(200)]
    assert np.mean(chance) == pytest.approx(0.5, abs=0.082)
    assert np.mean(np.array(chance) < 0.05) < 0.05 + 4.0 * np.sqrt(0.05 * 0.95 / 200.0)


def test_hills_that_say_the_same_are_no_warning() -> None:
    one = Mode(np.array([0.3, -1.0, 0.0]), 10.0, np.eye(3))
    noisier = Mode(np.array([0.3, -1.0, 1.0]), 12.0, np.eye(3))
    assert two_hills([one, noisier], 1)
    assert not two_hills([one, Mode(noisier.theta, 17.0, np.eye(3))], 1)
    assert not two_hills([one, Mode(one.theta + 0.01, 10.5, np.eye(3))], 1)


def test_noise_that_cannot_be_seen_is_flagged() -> None:
    """sigma_n of a twentieth of sigma_e; the same strips with the paper's noise raise no such flag."""
    point = POINTS["falcon_yaw"]
    for seed in range(3):
        _, y = point._replace(sigma_n=0.05 * point.sigma_e).series(seed)
        assert "sigma_n_unidentified" in fit_ari(y, 2, 2).flags
        assert "sigma_n_unidentified" not in fit_ari(point.series(seed)[1], 2, 2).flags


def test_pure_noise_has_no_process() -> None:
    y = np.random.default_rng(5).normal(size=150)
    fit = fit_ari(y, 2, 2)
    assert "sigma_e_unidentified" in fit.flags
    assert fit.sigma_n.value == pytest.approx(1.0, rel=0.2)


def test_wrong_order_is_not_white() -> None:
    """A slow oscillation filtered as a random walk."""
    rng = np.random.default_rng(6)
    x = 10.0 * np.sin(0.5 * np.arange(400)) + rng.normal(size=400)
    assert "not_white" in fit_ari(x, 0, 1).flags


def test_root_near_one_is_flagged() -> None:
    """The same oscillation with enough coefficients: its roots lie on the unit circle."""
    rng = np.random.default_rng(7)
    x = 10.0 * np.sin(0.5 * np.arange(400)) + rng.normal(size=400)
    assert "root_near_one" in fit_ari(x, 2, 1).flags


@pytest.mark.slow
@pytest.mark.parametrize("key", ["gps_x", "shuttle_120", "falcon_yaw"])
def test_lost_noise_is_flagged_nearly_always(key: str) -> None:
    point = POINTS[key]._replace(sigma_n=0.05 * POINTS[key].sigma_e)
    found = quality(point, range(90_000, 90_100), robust="none", steps=False)
    assert found.flags["sigma_n_unidentified"] >= 0.95
