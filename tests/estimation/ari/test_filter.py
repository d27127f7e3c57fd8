"""The filter for a known process, against dense algebra, closed forms and statsmodels."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.errors import InputError
from aerosim.estimation.ari import Process, filter_ari, simulate_ari
from aerosim.estimation.ari.likelihood import Strips
from aerosim.estimation.ari.process import partial_from_ar, start_precision
from estimation.ari.points import POINTS

KEYS = ["gps_x", "shuttle_120", "falcon_yaw"]


def difference_matrix(n: int, d: int) -> np.ndarray:
    """(1 - B)^d as a matrix, (n - d, n)."""
    out = np.eye(n)
    for _ in range(d):
        out = np.diff(out, axis=0)
    return out


def ar_covariance(a: np.ndarray, n: int) -> np.ndarray:
    """Covariance of n values of a stationary AR(p) with unit innovations, by summing its impulse response."""
    length = 6000
    impulse = np.zeros(length)
    impulse[0] = 1.0
    for t in range(1, length):
        for i, coefficient in enumerate(a[:t], 1):
            impulse[t] -= coefficient * impulse[t - i]
    lags = np.array([impulse[: length - h] @ impulse[h:] for h in range(n)])
    return lags[np.abs(np.subtract.outer(np.arange(n), np.arange(n)))]


def gappy(n: int, seed: int) -> np.ndarray:
    """Weights: some missing, others unequal."""
    rng = np.random.default_rng(seed)
    w = rng.uniform(0.3, 3.0, n)
    w[20:31] = w[50] = w[n - 1] = 0.0
    return w


@pytest.mark.parametrize("key", KEYS)
@pytest.mark.parametrize("gaps", [False, True])
def test_dense_algebra_agrees(key: str, gaps: bool) -> None:
    point, n = POINTS[key], 90
    _, y = point.series(1, n)
    y = y / point.sigma_n
    ratio = point.sigma_e / point.sigma_n
    w = gappy(n, 2) if gaps else np.ones(n)
    out = filter_ari(y, point.a, point.d, 1.0, ratio, weights=w)
    # x = start values (flat) + integrated AR: precision of x from the covariance of its differences
    D = difference_matrix(n, point.d)
    precision = D.T @ np.linalg.inv(ratio**2 * ar_covariance(np.array(point.a), n - point.d)) @ D
    cov = np.linalg.inv(precision + np.diag(w))
    x = cov @ (w * y)
    np.testing.assert_allclose(out.x, x, atol=1e-6)
    for h in range(point.d + len(point.a) + 1):
        np.testing.assert_allclose(out.cov_band[: n - h, h], np.diag(cov, h), rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(
        out.correlation(5), cov[45, 45:51] / np.sqrt(cov[45, 45] * np.diag(cov)[45:51]), atol=1e-7
    )


@pytest.mark.parametrize("key", KEYS)
def test_likelihood_is_that_of_the_differences(key: str) -> None:
    """The marginal density with flat first values is that of the differenced observations."""
    point, n = POINTS[key], 90
    _, y = point.series(3, n)
    D = difference_matrix(n, point.d)
    w = np.random.default_rng(4).uniform(0.3, 3.0, n)
    cov = point.sigma_e**2 * ar_covariance(np.array(point.a), n - point.d)
    cov += point.sigma_n**2 * D @ np.diag(1.0 / w) @ D.T
    u = D @ y
    expected = -0.5 * (np.linalg.slogdet(2.0 * np.pi * cov)[1] + u @ np.linalg.solve(cov, u))
    out = filter_ari(y, point.a, point.d, point.sigma_n, point.sigma_e, weights=w)
    assert out.loglik == pytest.approx(expected, rel=1e-9)
    partial = partial_from_ar(np.array(point.a), 0.9999)
    theta = np.r_[np.arctanh(partial), 2.0 * np.log([point.sigma_e, point.sigma_n])]
    two_l, _ = Strips([y], [w]).deviance(theta[None], point.d)
    assert -0.5 * two_l[0] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("key", KEYS)
def test_statsmodels_agrees(key: str) -> None:
    statespace = pytest.importorskip("statsmodels.tsa.statespace.sarimax")
    point, n = POINTS[key], 300
    _, y = point.series(5, n)
    y = y / point.sigma_n
    y[50:60] = y[71] = np.nan
    ratio = point.sigma_e / point.sigma_n
    out = filter_ari(y, point.a, point.d, 1.0, ratio)
    model = statespace.SARIMAX(y, order=(len(point.a), point.d, 0), measurement_error=True, use_exact_diffuse=True)
    theirs = model.smooth(np.r_[-np.array(point.a), 1.0, ratio**2])
    row = model.ssm["design"][0]
    np.testing.assert_allclose(out.x, row @ theirs.smoothed_state, atol=1e-6)  # in units of sigma_n
    variance = np.einsum("i,ijt,j->t", row, theirs.smoothed_state_cov, row)
    np.testing.assert_allclose(out.sigma_x, np.sqrt(variance), atol=1e-6)
    # they count a factor (2 pi)^(-1/2) for each flat value too
    assert out.loglik == pytest.approx(theirs.llf + 0.5 * point.d * np.log(2.0 * np.pi), rel=1e-9)


def test_gradient_is_the_derivative_of_the_likelihood() -> None:
    rng = np.random.default_rng(6)
    for key in KEYS:
        point = POINTS[key]
        series = [point.series(seed, n)[1] / point.sigma_n for seed, n in ((7, 60), (8, 90))]
        strips = Strips(series, [np.ones(60), gappy(90, 9)])
        for _ in range(3):
            theta = rng.normal(0.0, 0.7, len(point.a) + 2)
            _, gradient = strips.deviance(theta[None], point.d, gradient=True)
            # fourth-order differences: error of the formula below 1e-10, rounding 1e-13 * 1e3/1e-3
            h = 1e-3 * np.eye(len(theta))
            shifted = [strips.deviance(theta + k * h, point.d)[0] for k in (-2, -1, 1, 2)]
            slope = (shifted[0] - 8.0 * shifted[1] + 8.0 * shifted[2] - shifted[3]) / 12e-3
            np.testing.assert_allclose(gradient[0], slope, rtol=1e-6, atol=1e-4)


def test_local_level_has_its_closed_form() -> None:
    """p = 0, d = 1: a random walk in noise; error variance far from the ends q/sqrt(1 + 4/q) ... for sn = 1."""
    q = 0.3**2
    out = filter_ari(np.zeros(400), [], 1, 1.0, 0.3)
    # H = I + D'D/q: inverse of a Toeplitz tridiagonal matrix, (z/(1 - z^2)) q with z + 1/z = 2 + q
    z = 1.0 + q / 2.0 - np.sqrt(q + q * q / 4.0)
    assert out.sigma_x[200] ** 2 == pytest.approx(q * z / (1.0 - z * z), rel=1e-12)
    np.testing.assert_allclose(out.correlation(6, at=200), z ** np.arange(7), rtol=1e-10)


@pytest.mark.parametrize("key", KEYS)
def test_far_from_the_ends_the_spectrum_says_the_same(key: str) -> None:
    point = POINTS[key]
    out = filter_ari(np.zeros(2000), point.a, point.d, point.sigma_n, point.sigma_e)
    sigma, correlation = Process(np.array(point.a), point.d, point.sigma_n, point.sigma_e).filtered(8)
    assert out.sigma_x[1000] == pytest.approx(sigma, rel=1e-9)
    np.testing.assert_allclose(out.correlation(8), correlation, atol=1e-9)


def test_table_5_of_the_paper() -> None:
    """Yaw of the Falcon: sigma_x and four correlations from two coefficients, as printed."""
    point = POINTS["falcon_yaw"]
    out = filter_ari(np.zeros(1000), point.a, point.d, point.sigma_n, point.sigma_e)
    assert out.sigma_x[500] == pytest.approx(0.0011, abs=0.00005)
    # the table's sigmas have one or two digits: the correlations follow within one unit of the second decimal
    np.testing.assert_allclose(out.correlation(4)[1:], [0.86, 0.57, 0.29, 0.09], atol=0.01)


@pytest.mark.parametrize("key", KEYS)
def test_redundancies_add_up(key: str) -> None:
    point, n = POINTS[key], 150
    _, y = point.series(10, n)
    w = gappy(n, 11)
    out = filter_ari(y, point.a, point.d, point.sigma_n, point.sigma_e, weights=w, start="diffuse")
    m = len(point.a) + point.d
    assert out.redundancy_n.sum() + out.redundancy_e.sum() == pytest.approx(np.count_nonzero(w) - m, rel=1e-9)
    assert np.all(out.redundancy_n >= -1e-12)
    assert np.all(out.redundancy_e <= 1.0)


def test_errors_are_as_large_as_claimed() -> None:
    """sum of squares of L'(x - x_true), 60 series: chi-squared of n degrees, here over the middle epoch alone."""
    point = POINTS["falcon_yaw"]
    standard = []
    for seed in range(60):
        truth, y = point.series(seed, 200)
        out = filter_ari(y, point.a, point.d, point.sigma_n, point.sigma_e)
        # every 20th error: correlations over 20 epochs are below 0.01
        standard.extend(((out.x - truth) / out.sigma_x)[10::20])
    # 600 values: the variance of their mean square is 2/600, four standard errors
    assert np.mean(np.square(standard)) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / 600.0))


def test_process_weights_free_an_equation() -> None:
    """An equation of weight zero lets the series jump: what lies on either side does not know the other."""
    y = np.r_[np.zeros(50), np.full(50, 10.0)]
    u = np.ones(99)
    u[49] = 0.0
    out = filter_ari(y, [], 1, 1.0, 0.1, process_weights=u, start="diffuse")
    np.testing.assert_allclose(out.x, y, atol=1e-12)
    assert out.cov_band[49, 1] == pytest.approx(0.0, abs=1e-15)


def test_long_series_keep_their_digits() -> None:
    """Integrated twice, 1e5 epochs wander to 1e7 of the noise; the middle is as when filtered alone."""
    point = POINTS["falcon_roll"]
    truth, y = point.series(12, 100_000)
    out = filter_ari(y, point.a, point.d, point.sigma_n, point.sigma_e)
    cut = slice(50_000, 50_600)
    alone = filter_ari(y[cut], point.a, point.d, point.sigma_n, point.sigma_e)
    # correlations die within 60 epochs to below 1e-9
    np.testing.assert_allclose(out.x[cut][200:400] - alone.x[200:400], 0.0, atol=1e-6 * point.sigma_n)
    assert np.std(out.x - truth) < 0.7 * point.sigma_n


def test_start_is_the_stationary_law() -> None:
    a = np.array(POINTS["shuttle_120"].a)
    G = np.zeros((6, 6))
    start_precision(a, G)
    np.testing.assert_allclose(np.linalg.inv(G), ar_covariance(a, 6), rtol=1e-8)


def test_simulated_series_have_their_covariance() -> None:
    """Lag-one and lag-zero covariance of the differences over many short series: their start is stationary."""
    point = POINTS["falcon_yaw"]
    rng = np.random.default_rng(13)
    first, last = [], []
    for _ in range(4000):
        x, _ = simulate_ari(8, point.a, point.d, 1.0, 1.0, rng=rng)
        u = np.diff(x, n=2)
        first.append(u[:2])
        last.append(u[-2:])
    expected = ar_covariance(np.array(point.a), 2)
    for values in (np.array(first), np.array(last)):
        # standard error of a variance: sqrt(2/4000) = 2.2 %; four of them
        np.testing.assert_allclose(values.T @ values / 4000.0, expected, atol=0.09 * expected[0, 0])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"a": [-1.2]}, "not stationary"),
        ({"a": [np.nan]}, "not finite"),
        ({"d": 4}, "4 differences"),
        ({"sigma_n": 0.0}, "no standard deviation"),
        ({"sigma_e": -1.0}, "no standard deviation"),
        ({"y": np.full(50, np.nan)}, "0 points for order"),
        ({"y": np.r_[np.zeros(40), 1e300]}, "1e\\+300"),
        ({"y": np.r_[np.zeros(40), np.inf]}, "inf"),
        ({"y": np.zeros((4, 10))}, "shape"),
        ({"weights": -np.ones(50)}, "weights do not fit"),
        ({"process_weights": np.ones(7)}, "process weights do not fit"),
    ],
)
def test_bad_arguments_are_named(change: dict[str, object], words: str) -> None:
    arguments: dict[str, object] = {"y": np.arange(50.0) % 7, "a": [-0.5], "d": 1, "sigma_n": 1.0, "sigma_e": 1.0}
    with pytest.raises(InputError, match=words):
        filter_ari(**(arguments | change))  # type: ignore[arg-type]
