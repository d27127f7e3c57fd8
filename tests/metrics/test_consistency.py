"""Verdicts on simulated filters of known tuning, and the statistics by hand."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats

from aerosim.estimation.kalman import ScalarFilter
from aerosim.frames import Array
from aerosim.metrics.consistency import (
    COLOURED,
    CONSISTENT,
    FEWEST,
    LEVEL,
    OVER,
    UNDER,
    autocorrelation,
    judge,
    overconfident,
    portmanteau,
)

WALK, NOISE = 0.2, 1.0  # variances: of one step, of one observation


def innovations(seed: int, count: int, noise: float = 1.0, walk: float = 1.0, overlap: int = 1) -> Array:
    """Standardised innovations of the scalar filter over a random walk.

    noise, walk: variances that the filter believes in, over the true ones.  overlap: observations that share
    their noise, as strips in flight together do.
    """
    rng = np.random.default_rng(seed)
    state = np.cumsum(np.sqrt(WALK) * rng.standard_normal(count))
    white = rng.standard_normal(count + overlap)
    shared = np.convolve(white, np.ones(overlap) / np.sqrt(overlap), "valid")[:count]
    observed = state + np.sqrt(NOISE) * shared
    filtered = ScalarFilter(WALK * walk / (NOISE * noise), NOISE * noise)
    return np.array([filtered.update(each) for each in observed])[1:]


def one_line(values: Array) -> NDArray[np.int64]:
    return np.zeros(len(values), np.int64)


def verdicts(count: int, runs: int, in_flight: int = 1, **wrong: Any) -> Counter[str | None]:
    found = (innovations(seed, count, **wrong) for seed in range(runs))
    return Counter(judge(each, one_line(each), in_flight).verdict for each in found)


@pytest.mark.parametrize(("count", "in_flight"), [(60, 1), (250, 13)])
def test_a_consistent_filter_is_seldom_called_something_else(count: int, in_flight: int) -> None:
    # 5 % nominal of 200 runs: more than 20 (10 %), or none at all, has a chance below 0.1 % each
    low, high = stats.binom.ppf([0.001, 0.999], 200, LEVEL)
    assert low <= 200 - verdicts(count, 200, in_flight)[CONSISTENT] <= high


@pytest.mark.parametrize("count", [100, 250])
def test_half_the_variance_believed_is_over_confident(count: int) -> None:
    """Noise and walk are twice what the filter believes: gain and whiteness stay, the variance is 2."""
    found = verdicts(count, 100, noise=0.5, walk=0.5)
    # the mean square of 100 exceeds its upper bound of 1.37 with a chance of 0.998
    assert found[OVER] >= 97


def test_twice_the_variance_believed_is_under_confident() -> None:
    assert verdicts(250, 100, noise=2.0, walk=2.0)[UNDER] >= 97


def test_a_filter_that_is_too_slow_is_not_consistent() -> None:
    """It believes in a hundredth of the walk: what it did not follow comes again in the next innovation."""
    found = verdicts(250, 50, walk=0.01)
    assert found[CONSISTENT] == 0
    assert found[OVER] >= 48


def test_observations_that_share_their_noise_are_coloured_or_worse() -> None:
    found = verdicts(250, 50, in_flight=6, overlap=6)
    assert found[CONSISTENT] == 0


def test_coloured_innovations_of_the_right_size_are_no_more_than_coloured() -> None:
    def filtered(seed: int) -> Array:
        white = np.random.default_rng(seed).standard_normal(255)
        return np.convolve(white, np.ones(6) / np.sqrt(6.0), "valid")

    found = Counter(judge(filtered(seed), one_line(filtered(seed)), 6).verdict for seed in range(100))
    assert found[CONSISTENT] == 0
    # the mean square of so few independent ones leaves its widened bound seldom: 1.7 % nominal of 100 is at most 6
    # (0.1 %); Bartlett's freedom from estimated correlations is only roughly right
    assert found[OVER] + found[UNDER] <= 8


def test_an_offset_is_not_consistent() -> None:
    values = 0.3 + np.random.default_rng(1).standard_normal(300) * np.sqrt(1.0 - 0.09)
    found = judge(values, one_line(values))
    assert found.verdict == COLOURED
    assert found.mean == pytest.approx(0.3, abs=4.0 / np.sqrt(300))


def test_figures_by_hand() -> None:
    values = np.array([1.0, -1.0, 2.0, -2.0] * 4)
    found = judge(values, one_line(values))
    assert (found.strips, found.mean, found.variance) == (16, 0.0, 2.5)
    # neighbours: 4 x (1*-1 + -1*2 + 2*-2) + 3 x (-2*1), over the sum of squares
    assert found.lag1 == pytest.approx((4 * (-1 - 2 - 4) - 6) / 40.0)


def test_pairs_across_two_lines_do_not_count() -> None:
    values = np.array([1.0, 1.0, 1.0, -1.0, -1.0, -1.0])
    found, pairs = autocorrelation(values, np.array([0, 0, 0, 1, 1, 1]), 3)
    assert pairs.tolist() == [4, 2, 0]
    assert found == pytest.approx([4 / 6, 2 / 6, 0.0])


def test_portmanteau_is_ljung_and_box() -> None:
    values = np.random.default_rng(2).standard_normal(120)
    found, pairs = autocorrelation(values, one_line(values), 8)
    q = 120 * 122 * sum(r * r / (120 - k) for k, r in enumerate(found, 1))
    assert portmanteau(found, pairs, 120) == pytest.approx(stats.chi2.sf(q, 8))


def test_bounds_are_those_of_chi_squared() -> None:
    values = innovations(3, 201)
    found = judge(values, one_line(values))
    assert found.verdict == CONSISTENT
    each = 1.0 - 0.95 ** (1.0 / 3.0)
    assert found.variance_min == pytest.approx(stats.chi2.ppf(each / 2.0, 200) / 200)
    assert found.variance_max == pytest.approx(stats.chi2.isf(each / 2.0, 200) / 200)


def test_too_few_are_not_judged() -> None:
    few = judge(np.ones(FEWEST - 1), np.zeros(FEWEST - 1, np.int64))
    assert few.strips == FEWEST - 1
    assert few.verdict is few.variance is None
    assert judge(np.zeros(FEWEST), np.zeros(FEWEST, np.int64)).verdict == UNDER


def test_an_over_confident_filter_says_so() -> None:
    values = 2.0 * innovations(5, 201)
    drift = judge(values, one_line(values))._asdict()
    calm = judge(values / 2.0, one_line(values))._asdict()
    told = overconfident({"consistency": {"drift": drift, "vh": calm}})
    assert list(told) == ["drift"]
    assert told["drift"].startswith("the drift filter is over-confident: its innovations have ")
    assert overconfident({}) == {}
    assert overconfident({"consistency": {"drift": None, "vh": {"verdict": None}}}) == {}
