"""Whether a filter knows how wrong it is: its standardised innovations against what they should be.

Of a filter whose model holds they are white, of mean 0 and variance 1 (Bar-Shalom, Li, Kirubarajan, Estimation
with Applications to Tracking and Navigation, 2001, section 5.4).  White means here: from one accepted strip to
the next, over as many strips as are in flight together.  Strips in flight together share ground and attitude:
row II of one is exposed when row I of a later one is, so that one roll is in both, with opposite signs.  A filter
that takes such strips as independent has coloured innovations, and is told so.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, gammaincinv, stdtr

from aerosim.frames import Array

LEVEL = 0.05  # share of consistent runs that are called something else
EACH = 1.0 - (1.0 - LEVEL) ** (1.0 / 3.0)  # of the three tests: variance, whiteness, mean
FEWEST = 12  # strips
LAGS = (5, 40)
CONSISTENT, OVER, UNDER, COLOURED = "consistent", "over-confident", "under-confident", "coloured"


class Judgement(NamedTuple):
    """Innovations of one filter, judged.

    strips: how many.  mean; variance: mean square about 0, where the mean should be; variance_min, variance_max:
    within which a consistent filter's lies; lag1: correlation from one strip to the next.  All without unit; None
    if there are too few strips.
    """

    strips: int
    mean: float | None
    variance: float | None
    variance_min: float | None
    variance_max: float | None
    lag1: float | None
    verdict: str | None


def autocorrelation(innovations: Array, run: NDArray[np.int64], lags: int) -> tuple[Array, NDArray[np.int64]]:
    """Autocorrelation at lags 1..lags, (lags,), about the mean, and how many pairs each rests on, (lags,).

    run: (n,), number of the line of each innovation (n,); pairs across two lines are none.
    """
    centred = innovations - innovations.mean()
    power = float(centred @ centred)
    found, pairs = np.zeros(lags), np.zeros(lags, np.int64)
    for k in range(1, lags + 1):
        same = run[k:] == run[:-k]
        pairs[k - 1] = same.sum()
        found[k - 1] = (centred[k:] * centred[:-k])[same].sum() / power if power > 0.0 else 0.0
    return found, pairs


def portmanteau(found: Array, pairs: NDArray[np.int64], count: int) -> float:
    """Chance of an autocorrelation at least this large from white innovations: Ljung and Box (1978).

    found, pairs: of `autocorrelation`; count: innovations.  The variance of a white sequence's correlation is
    pairs/(n (n + 2)), which with pairs = n - k is theirs.
    """
    some = pairs > 0
    q = float(np.sum(found[some] ** 2 * count * (count + 2.0) / pairs[some]))
    return float(chdtrc(int(some.sum()), q)) if some.any() else 1.0


def judge(innovations: Array, run: NDArray[np.int64], in_flight: int = 1) -> Judgement:
    """Judge standardised innovations (n,) in their order.

    run: (n,), number of the line of each.  in_flight: strips that are in flight together: correlation is looked
    for at least so far.  The three tests are two-sided of the variance (chi squared), of the mean (Student), and
    Ljung and Box's; together they call 5 % of consistent filters something else.  Coloured innovations tell less
    than as many white ones: their mean square has the freedom n/(1 + 2 sum of squared correlations) (Bartlett).
    """
    count = len(innovations)
    if count < FEWEST:
        return Judgement(count, None, None, None, None, None, None)
    mean, square = float(innovations.mean()), float(np.mean(innovations**2))
    lags = max(1, min(max(LAGS[0], in_flight + 2), LAGS[1], count // 4))
    found, pairs = autocorrelation(innovations, run, lags)
    coloured = portmanteau(found, pairs, count) < EACH
    freedom = count / (1.0 + 2.0 * float(np.sum(found**2))) if coloured else float(count)
    # quantiles of chi squared over its degrees of freedom
    low, high = (float(gammaincinv(freedom / 2.0, p) * 2.0 / freedom) for p in (EACH / 2.0, 1.0 - EACH / 2.0))
    error = float(innovations.std(ddof=1)) / np.sqrt(count)
    offset = bool(2.0 * stdtr(count - 1, -abs(mean) / error) < EACH) if error > 0.0 else mean != 0.0
    verdict = CONSISTENT
    if square > high:
        verdict = OVER
    elif square < low:
        verdict = UNDER
    elif coloured or offset:
        verdict = COLOURED
    return Judgement(count, mean, square, low, high, float(found[0]), verdict)


MEANING = {
    CONSISTENT: "the errors are as large as the filter believes, and independent from strip to strip",
    OVER: "the errors are larger than the filter believes: it trusts its strips or its model too much",
    UNDER: "the errors are smaller than the filter believes: it could follow its strips faster",
    COLOURED: "as large as the filter believes, but not independent from strip to strip, or one-sided",
}


def overconfident(summary: Mapping[str, Any]) -> dict[str, str]:
    """Sentences about the filters (drift, vh) of a summary that are wrong by more than they say."""
    found = summary.get("consistency") or {}
    return {name: sentence(name, each) for name, each in found.items() if (each or {}).get("verdict") == OVER}


def sentence(name: str, found: Mapping[str, Any]) -> str:
    """What was found about one filter (drift, vh), in a sentence."""
    what = {"vh": "v/h"}.get(name, name)
    return (
        f"the {what} filter is {found['verdict']}: its innovations have {found['variance']:.2g} times the "
        f"variance that it expects ({found['variance_min']:.2g} to {found['variance_max']:.2g} would do, "
        f"{found['strips']} strips)"
    )
