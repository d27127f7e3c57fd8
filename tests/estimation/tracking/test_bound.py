"""The bound of any estimator of a walk that is seen as a mean over the past, late: a stationary Riccati equation.

x walks with intensity q.  Each `step` a mean of x over [t - T - late, t - late] is measured with white noise of
intensity S (variance S/step a measurement).  With the lags of x as states this is a linear system; what its
Riccati equation leaves as variance of x(t) no causal estimator can better.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from aerosim.estimation.tracking.lag_filter import LagFilter, WalkModel

STEP, LATE, SPAN = 0.5, 0.3, 12.9
WALK = 0.15**2  # deg^2/s


def bound(density: float) -> float:
    """Standard deviation of x now, deg, right after a measurement.  density: S, deg^2 s."""
    lags = round((SPAN + LATE) / STEP) + 3
    times = -STEP * np.arange(lags)
    fine = np.linspace(-SPAN - LATE, -LATE, 4001)
    place = -fine / STEP
    k = place.astype(int)
    row = np.zeros(lags)
    np.add.at(row, k, 1.0 - (place - k))
    np.add.at(row, k + 1, place - k)
    row /= row.sum()
    assert times[-1] < -SPAN - LATE
    transition = np.diag(np.ones(lags - 1), -1)
    transition[0, 0] = 1.0
    kick = np.zeros((lags, lags))
    kick[0, 0] = WALK * STEP
    noise = np.array([[density / STEP]])
    before = solve_discrete_are(transition.T, row[:, None], kick, noise)
    seen = before @ row
    after = before[0, 0] - seen[0] ** 2 / float(row @ seen + noise[0, 0])
    return float(np.sqrt(after))


# the study's table, computed by others: S (deg^2 s) and the best that is possible (deg)
@pytest.mark.parametrize(
    ("density", "best"),
    [(0.001, 0.25), (0.003, 0.28), (0.01, 0.31), (0.03, 0.35), (0.1, 0.40), (1.0, 0.53), (10.0, 0.78)],
)
def test_the_bound_is_the_studied_one(density: float, best: float) -> None:
    """To its two digits, and 2 %: on which side of a measurement it was taken is not told."""
    assert bound(density) == pytest.approx(best, abs=0.005 + 0.02 * best)


@pytest.mark.parametrize("density", [0.01, 0.1, 1.0])
def test_the_filter_stands_at_the_bound(density: float) -> None:
    found = LagFilter(WalkModel(WALK, 1e-9, 1.0), STEP, reach=16.0)
    found.start(0.0, 0.0, 1.0)
    for k in range(1, 800):
        t = k * STEP
        found.advance(t)
        found.update(t - LATE - SPAN, t - LATE, 0.0, density / STEP)
    assert np.sqrt(found.now(800 * STEP - STEP)[1]) == pytest.approx(bound(density), rel=0.01)


def test_flown_on_paper_the_error_is_what_the_filter_says() -> None:
    """40 walks of 400 s: mean square error over the told variance.

    Errors 30 s apart are independent for this filter (its memory is some 13 s), so 40 x 12 values: the mean of so
    many squares has a standard deviation of sqrt(2/480) = 6.5 %; three of them are allowed.
    """
    rng = np.random.default_rng(8)
    density, ratios = 0.1, []
    fine = 0.05
    for _ in range(40):
        walk = np.cumsum(rng.normal(0.0, np.sqrt(WALK * fine), round(400.0 / fine)))
        total = np.concatenate([[0.0], np.cumsum(walk) * fine])
        found = LagFilter(WalkModel(WALK, 1e-9, 1.0), STEP, reach=16.0)
        found.start(20.0, walk[round(20.0 / fine)], 0.5)
        for t in np.arange(20.5, 399.0, STEP):
            a, b = round((t - LATE - SPAN) / fine), round((t - LATE) / fine)
            mean = (total[b] - total[a]) / ((b - a) * fine)
            found.advance(t)
            found.update(
                t - LATE - SPAN, t - LATE, mean + rng.normal(0.0, np.sqrt(density / STEP)), density / STEP
            )
            if t > 60.0 and (t * 2) % 60 == 0:
                value, variance = found.now(t)
                ratios.append((value - walk[round(t / fine) - 1]) ** 2 / variance)
    assert len(ratios) >= 40 * 11
    assert np.mean(ratios) == pytest.approx(1.0, abs=3.0 * np.sqrt(2.0 / len(ratios)))
