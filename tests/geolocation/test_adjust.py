"""Least squares with shared errors: against the dense covariance of everything at once."""

import numpy as np
import pytest

from aerosim.geolocation.adjust import Equations, adjust, variance_factors

PRIOR = np.array([0.5, 2.0, 1.0])


def equations(count=60, seed=1):
    rng = np.random.default_rng(seed)
    n = rng.standard_normal
    return Equations(n((count, 2)), n((count, 2, 3)), n((count, 2, 6)), n((count, 2, 2)), n((count, 2, 3)), 0.7)


@pytest.mark.parametrize("factors", [(0.0, 1.0), (0.7, 0.3), (1.5, 0.0)])
@pytest.mark.parametrize("points", [60, 7])
def test_is_the_dense_solution(factors, points):
    eq, count = equations(), 60
    point, lines = np.arange(count) % points, np.arange(count) % 5
    at = np.array([0.1, -0.2, 0.3])
    cov = 0.7**2 * np.eye(2 * count)
    for i in range(count):
        for j in range(count):
            here = slice(2 * i, 2 * i + 2), slice(2 * j, 2 * j + 2)
            if i == j:
                cov[here] += eq.own[i] @ eq.own[j].T + factors[1] * eq.shared[i] @ eq.shared[j].T
            if lines[i] == lines[j]:
                cov[here] += factors[0] * eq.shared[i] @ eq.shared[j].T
            if point[i] == point[j]:
                cov[here] += eq.of_point[i] @ eq.of_point[j].T
    design, seen = eq.design.reshape(-1, 3), (eq.misfit + eq.design @ at).reshape(-1)
    inverse = np.linalg.inv(cov)
    information = design.T @ inverse @ design
    covariance = np.linalg.inv(information + np.diag(PRIOR**-2))
    values = covariance @ design.T @ inverse @ seen
    fit = adjust(eq, at, PRIOR, point, lines, factors, np.ones(count))
    assert fit.values == pytest.approx(values, rel=1e-9)
    assert fit.covariance == pytest.approx(covariance, rel=1e-9)
    assert fit.information == pytest.approx(information, rel=1e-9)
    # -2 log probability of the rows, but for a constant
    whole = cov + design @ np.diag(PRIOR**2) @ design.T
    other = adjust(eq, at, PRIOR, point, lines, (0.2, 0.5), np.ones(count))
    assert fit.evidence == pytest.approx(
        np.linalg.slogdet(whole)[1] + seen @ np.linalg.solve(whole, seen) - np.log(np.prod(PRIOR**2)), rel=1e-9
    )
    assert other.evidence != fit.evidence


def test_rows_without_weight_do_not_count():
    eq = equations()
    weight = np.ones(60)
    weight[50:] = 0.0
    eq.misfit[55] = np.nan
    none = np.zeros(60, int)
    fit = adjust(eq, np.zeros(3), PRIOR, none, none, (0.5, 0.5), weight)
    less = Equations(*(v[:50] for v in eq[:5]), eq.pixel)
    assert fit.values == pytest.approx(
        adjust(less, np.zeros(3), PRIOR, none[:50], none[:50], (0.5, 0.5), np.ones(50)).values
    )
    assert np.isfinite(fit.distance[56:]).all()


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_factors_are_found(share):
    """40 lines of 25 rows with unit errors of the navigation: 0.16 of a variance from 6 x 40 numbers, less the
    belief."""
    rng = np.random.default_rng(4)
    eq, lines = equations(1000, 3), np.arange(1000) % 40
    line_error, own = rng.standard_normal((40, 6)), rng.standard_normal((1000, 6))
    error = np.sqrt(share) * line_error[lines] + np.sqrt(1.0 - share) * own
    misfit = (eq.shared @ error[..., None])[..., 0] + (eq.own @ rng.standard_normal((1000, 2, 1)))[..., 0]
    eq = eq._replace(misfit=misfit + 0.7 * rng.standard_normal((1000, 2)))
    shared, white = variance_factors(eq, np.zeros(3), PRIOR, np.zeros(1000, int), lines, np.ones(1000))
    assert shared == pytest.approx(share, abs=0.3)
    assert white == pytest.approx(1.0 - share, abs=0.2)
