"""Fits of processes that are not known, on few series; the many-run proofs are marked slow."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.errors import InputError
from aerosim.estimation.ari import Prior, Process, filter_ari, fit_ari, select_order
from aerosim.estimation.ari.filter import filter_series
from aerosim.estimation.ari.likelihood import Strips
from aerosim.estimation.ari.modes import Mode, descend, find_modes, objective, process_of, strewn_starts
from aerosim.estimation.ari.posterior import average, effective_size, sample
from aerosim.estimation.ari.robust import quick_starts
from aerosim.estimation.ari.vce import theta_of
from estimation.ari.points import HELD_OUT, POINTS
from estimation.ari.proofs import pooled, quality


def test_descent_finds_the_minimum_of_a_curved_valley() -> None:
    """Rosenbrock's function: minimum 0 at (1, 1)."""

    def of(thetas: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a, b = thetas.T
        grad = np.stack([-400.0 * a * (b - a * a) - 2.0 * (1.0 - a), 200.0 * (b - a * a)], axis=1)
        return 100.0 * (b - a * a) ** 2 + (1.0 - a) ** 2, grad

    theta, value = descend(of, np.array([[-1.2, 1.0], [2.0, -1.0]]), enough=1e-14)
    np.testing.assert_allclose(theta, 1.0, atol=1e-5)
    assert np.all(value < 1e-10)


def test_modes_that_are_the_same_are_one() -> None:
    """x^4 - x^2 + 0.1 x: two minima, the left one lower by 0.141."""

    def of(thetas: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x = thetas[:, :1]
        return (10.0 * (x**4 - x**2 + 0.1 * x)).ravel(), 10.0 * (4.0 * x**3 - 2.0 * x + 0.1)

    modes = find_modes(of, np.array([[-2.0], [-1.0], [1.0], [2.0], [0.8]]))
    roots = np.roots([4.0, 0.0, -2.0, 0.1])
    assert [m.theta[0] for m in modes] == pytest.approx([roots.min(), roots.max()], abs=1e-4)
    for mode in modes:  # half of the second derivative
        assert mode.precision[0, 0] == pytest.approx(0.5 * 10.0 * (12.0 * mode.theta[0] ** 2 - 2.0), rel=1e-4)


def test_draws_have_the_moments_of_their_density() -> None:
    """Two normal hills of masses 0.75 and 0.25 at -3 and 3, far from spheres: mass, mean, covariance."""
    rng = np.random.default_rng(1)
    root = np.array([[1.0, 0.0, 0.0], [0.9, 0.3, 0.0], [0.0, 0.0, 2.0]])
    cov = root @ root.T
    precision = np.linalg.inv(cov)
    centres, mass = np.array([[-3.0, 0.0, 0.0], [3.0, 0.0, 0.0]]), np.array([0.75, 0.25])

    def value_of(thetas: np.ndarray) -> np.ndarray:
        off = thetas[:, None] - centres
        square = np.einsum("nki,ij,nkj->nk", off, precision, off)
        return np.asarray(-2.0 * np.log(np.exp(-0.5 * square) @ mass + 1e-300))

    # the sampler is told of equal masses and of hills that are too narrow
    modes = [Mode(c, 0.0, 3.0 * precision) for c in centres]
    draws = sample(value_of, modes, rng, walkers=60, steps=1200, burn=200)
    left = draws.thetas[draws.thetas[:, 0] < 0.0]
    assert draws.size > 600.0
    # masses of 600 independent draws: sqrt(0.75 * 0.25/600) = 0.018; four of them
    assert len(left) / len(draws.thetas) == pytest.approx(0.75, abs=0.07)
    np.testing.assert_allclose(left.mean(axis=0), centres[0], atol=4.0 * 2.0 / np.sqrt(450.0))
    # relative standard error of a variance of 450 draws: 6.7 %
    np.testing.assert_allclose(np.cov(left.T), cov, atol=4.0 * 0.067 * 4.0)


def test_average_has_the_total_covariance() -> None:
    """Three parameter sets: mean of the smoothed values; mean covariance plus covariance of the means."""
    point = POINTS["falcon_yaw"]
    y = point.series(15, 60)[1] / point.sigma_n
    w = np.ones(60)
    w[20] = 0.0
    thetas = np.array([[0.5, -0.2, -2.0, -1.0], [-0.9, 0.4, -3.0, 0.0], [0.0, 0.0, 0.5, 0.5]])
    outs = [filter_series(y, w, process_of(theta, 2)) for theta in thetas]
    got = average(thetas, y, w, 2, 5)
    np.testing.assert_allclose(got.x, np.mean([o.x for o in outs], axis=0), rtol=1e-9)
    spread = np.cov(np.array([o.x for o in outs]).T, bias=True)
    assert spread[30, 30] > 0.01 * outs[0].cov_band[30, 0]
    for h in range(5):
        within = np.mean([o.cov_band[: 60 - h, h] for o in outs], axis=0)
        np.testing.assert_allclose(got.cov_band[: 60 - h, h], within + np.diag(spread, h), rtol=1e-8)


def test_effective_size_of_an_autoregression() -> None:
    """Chains with correlation 0.8 a step: n (1 - 0.8)/(1 + 0.8), within 15 %: the sum stops at 0.05."""
    rng = np.random.default_rng(2)
    chains = np.zeros((2000, 50, 1))
    for k in range(1, 2000):
        chains[k] = 0.8 * chains[k - 1] + 0.6 * rng.normal(size=(50, 1))
    assert effective_size(chains) == pytest.approx(2000 * 50 * 0.2 / 1.8, rel=0.15)


def test_starts_lead_to_the_best_mode() -> None:
    """Six iterates of the paper and 12 of 200 strewn, against 20 others: within 0.5 of -2 log L, 3 in 4."""
    rng = np.random.default_rng(3)
    missed = 0
    for key in ("gps_x",):
        point = POINTS[key]
        for seed in range(4):
            _, y = point.series(seed)
            y = y / np.std(np.diff(y, n=point.d))
            strips, w = Strips([y], [np.ones(len(y))]), [np.ones(len(y))]
            of = objective(strips, point.d, Prior(flat=True))
            p = len(point.a)
            wide = np.c_[rng.normal(0.0, 0.7, (20, p)), rng.uniform(-9.0, 0.0, (20, 2))]
            _, theirs = descend(of, wide)
            starts = [quick_starts([y], w, p, point.d, 6), strewn_starts(strips, p, point.d, 12)]
            _, ours = descend(of, np.vstack(starts))
            missed += ours.min() > theirs.min() + 0.5
    assert missed <= 1


def test_statsmodels_is_not_better() -> None:
    """Its likelihood at its estimates, ours at ours: ours is at least as high (less 0.01)."""
    statespace = pytest.importorskip("statsmodels.tsa.statespace.sarimax")
    point = POINTS["falcon_yaw"]
    _, y = point.series(4)
    y = y / point.sigma_n
    theirs = statespace.SARIMAX(y, order=(2, 2, 0), measurement_error=True).fit(disp=False)
    fit = fit_ari(y, 2, 2, method="ml", robust="none", steps=False)
    a, (noise, error) = -theirs.params[:2], np.sqrt(theirs.params[2:])
    assert fit.loglik >= filter_ari(y, a, 2, noise, error).loglik - 0.01


def test_result_is_in_the_unit_of_the_series() -> None:
    """Metres or millimetres, with or without 4e6 m and a slope: the same fit."""
    point = POINTS["gps_x"]
    _, y = point.series(5)
    small, large = fit_ari(y, 5, 2), fit_ari(1e3 * (y + 4e6 + 70.0 * np.arange(len(y))), 5, 2)
    assert large.sigma_n.value == pytest.approx(1e3 * small.sigma_n.value, rel=1e-3)
    assert large.sigma_e.low == pytest.approx(1e3 * small.sigma_e.low, rel=1e-3)
    np.testing.assert_allclose(large.strip.sigma_x, 1e3 * small.strip.sigma_x, rtol=1e-3)
    np.testing.assert_allclose(large.x / 1e3 - 4e6 - 70.0 * np.arange(len(y)), small.x, atol=1e-3 * point.sigma_n)
    assert large.loglik == pytest.approx(small.loglik - (len(y) - 2) * np.log(1e3), abs=0.05)


def test_same_seed_same_result() -> None:
    _, y = POINTS["gps_x"].series(6)
    one, two, other = (fit_ari(y, 5, 2, seed=s) for s in (1, 1, 2))
    np.testing.assert_array_equal(one.x, two.x)
    assert not np.array_equal(one.x, other.x)
    # another seed of the draws moves x by little beside its own uncertainty
    assert np.sqrt(np.mean((one.x - other.x) ** 2)) < 0.25 * one.sigma_x


def test_gaps_are_bridged_with_larger_sigma() -> None:
    point = POINTS["falcon_yaw"]
    truth, y = point.series(7)
    y[300:312] = np.nan
    strip = fit_ari(y, 2, 2).strip
    assert strip.sigma_x[306] > 3.0 * strip.sigma_x[200]
    assert np.all(np.abs(strip.x[300:312] - truth[300:312]) < 4.0 * strip.sigma_x[300:312])
    assert np.isnan(strip.residuals[305])


def test_times_with_a_gap_give_back_their_rows() -> None:
    point = HELD_OUT["made_up"]
    _, y = point.series(8)
    keep = np.r_[0:100, 110:300]
    strip = fit_ari(y[keep], 3, 1, times=2.0 + 0.5 * keep).strip
    np.testing.assert_array_equal(strip.rows, keep)
    assert (strip.start, strip.dt) == (2.0, pytest.approx(0.5))
    value, sigma = strip.at(2.0 + 0.5 * np.array([50.0, 50.5, 105.0]))
    assert value[0] == pytest.approx(strip.x[50], rel=1e-12)
    assert sigma[0] == pytest.approx(strip.sigma_x[50], rel=1e-12)
    assert min(strip.x[50:52]) - 0.3 < value[1] < max(strip.x[50:52]) + 0.3
    assert sigma[2] > 1.5 * sigma[0]
    with pytest.raises(InputError, match=r"outside of the strip .*2 to 151.5"):
        strip.at([1.9])


def test_covariance_within_draws_is_the_plug_in_one() -> None:
    """Total covariance is at least the conditional one, and a long series leaves nearly nothing between them."""
    point = POINTS["falcon_yaw"]
    _, y = point.series(9, 1900)
    strip = fit_ari(y, 2, 2, robust="none", steps=False).strip
    middle = slice(100, 1800)
    ratio = np.mean(strip.sigma_x[middle] ** 2) / np.mean(strip.sigma_x_conditional[middle] ** 2)
    assert 0.95 < ratio < 1.12


def test_long_series_take_the_mode() -> None:
    """10,000 epochs: sigma_n within 4 Cramer-Rao deviations (1.0 % each, 4 % at N = 600 in the paper's case)."""
    point = POINTS["falcon_yaw"]
    truth, y = point.series(10, 10_000)
    fit = fit_ari(y, 2, 2, robust="none", steps=False)
    assert fit.method == "ml"
    assert fit.sigma_n.value == pytest.approx(point.sigma_n, rel=0.04)
    assert 0.02 < fit.sigma_n.high / fit.sigma_n.low - 1.0 < 0.05
    best = filter_ari(y, point.a, 2, point.sigma_n, point.sigma_e)
    assert np.std(fit.x - truth) < 1.005 * np.std(best.x - truth)


def test_pooled_strips_share_their_process() -> None:
    """Six Falcon strips: sigma_n within 4 times 4 %/sqrt(6) and 1 % of bias; each nearly as with the truth."""
    point = POINTS["falcon_yaw"]
    pairs = [point.series(seed, 300) for seed in range(6)]
    fit = fit_ari([y for _, y in pairs], 2, 2)
    assert fit.sigma_n.value == pytest.approx(point.sigma_n, rel=0.08)
    for strip, (truth, y) in zip(fit.strips, pairs, strict=True):
        best = filter_ari(y, point.a, 2, point.sigma_n, point.sigma_e)
        assert np.std(strip.x - truth) < 1.10 * np.std(best.x - truth)
    with pytest.raises(InputError, match="6 strips were pooled"):
        _ = fit.x


def test_order_of_a_long_series_is_found() -> None:
    """2000 epochs of (2, 2), seeds 11 to 13: BIC, consistent, takes d = 2 and at most one coefficient amiss."""
    point = POINTS["falcon_roll"]
    for seed in (11, 12):
        choice = select_order(point.series(seed, 2000)[1], p=(1, 2, 3), d=(1, 2), criterion="bic", robust="none")
        assert choice.d == 2
        assert choice.criterion[2, 2] < choice.criterion[2, 1] - 10.0
        assert len(choice.criterion) == 6


def test_prior_is_a_density_with_its_gradient() -> None:
    rng = np.random.default_rng(14)
    for prior in (Prior(), Prior(over="r"), Prior(flat=True)):
        theta = rng.normal(0.0, 2.0, (4, 5))
        theta[0, -1], theta[1, 0] = -35.0, 7.0  # beyond the walls
        _, grad = prior.deviance(theta)
        for k in range(5):
            h = 1e-5 * np.eye(5)[k]
            slope = (prior.deviance(theta + h)[0] - prior.deviance(theta - h)[0]) / 2e-5
            np.testing.assert_allclose(grad[:, k], slope, atol=1e-6)
    with pytest.raises(InputError, match="prior: no density"):
        Prior(s2=0.0)


def test_prior_draws_are_those_of_the_partial_autocorrelations() -> None:
    """Its density over atanh r is N(0, s2/k) over r: the ratio of two densities, worked out by hand."""
    prior = Prior(kn=0.0, ke=0.0, s2=0.25)
    r = np.array([[0.3, 0.5], [-0.6, 0.1]])
    theta = np.c_[np.arctanh(r), np.zeros((2, 2))]
    value, _ = prior.deviance(theta)
    log_density = -0.5 * (r[:, 0] ** 2 / 1.0 + r[:, 1] ** 2 * 2.0 / 0.25) + np.log(1.0 - r**2).sum(axis=1)
    assert value[0] - value[1] == pytest.approx(-2.0 * (log_density[0] - log_density[1]), rel=1e-10)


def test_theta_and_process_are_inverse() -> None:
    point = POINTS["shuttle_120"]
    process = process_of(theta_of(Process(np.array(point.a), 1, 0.006, 0.0019), 0.9999), 1)
    np.testing.assert_allclose(process.a, point.a, atol=1e-12)
    assert (process.sigma_n, process.sigma_e) == pytest.approx((0.006, 0.0019))


# bias 5 % and rms ratio 1.08 are goals, asserted with what 100 runs leave open: sigma_n scatters by 4 to 24 %
# a run, so its mean by 0.4 to 2.4 %, twice that is allowed; a median of ratios by about 0.01
SCATTER = {"gps_x": 0.24, "gps_y": 0.14, "shuttle_120": 0.11, "shuttle_400": 0.06, "shuttle_pitch": 0.06}


@pytest.mark.slow
@pytest.mark.parametrize("key", [*POINTS, *HELD_OUT])
def test_single_strips(key: str) -> None:
    found = quality((POINTS | HELD_OUT)[key], range(90_000, 90_100))
    assert abs(found.bias) < 0.05 + 2.0 * SCATTER.get(key, 0.05) / 10.0
    assert found.ratio < 1.08 + 0.01
    # short strips of high order have a tail of runs in which they are smoothed too much (docs/ari.md)
    assert found.ratio_95 < {"gps_y": 1.6, "shuttle_120": 1.35}.get(key, 1.25)
    assert 0.92 - 0.01 < found.coverage < 0.97 + 0.01
    # 5 % of GPS X in the long run: 100 strips scatter by 2.2 %
    assert found.flags.get("sigma_n_unidentified", 0.0) <= (0.1 if key == "gps_x" else 0.05)


@pytest.mark.slow
def test_21_pooled_strips() -> None:
    """The Shuttle's: 9660 points; sigma_n scatters by 1.2 % a run."""
    bias, _, ratio, coverage = pooled(POINTS["shuttle_400"], range(900, 910), 21)
    assert abs(bias) < 0.02
    assert ratio < 1.01
    assert 0.92 < coverage < 0.97
