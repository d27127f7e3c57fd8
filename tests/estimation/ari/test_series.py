"""Series as they come: grids, gaps, angles, and everything that is refused in one line."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.errors import InputError
from aerosim.estimation.ari import filter_ari, fit_ari, resample, select_order, unwrap
from aerosim.estimation.ari.series import checked_series, points_needed, scaled
from estimation.ari.points import POINTS

NOISE = np.random.default_rng(1).normal(size=200)


def test_gaps_become_missing_epochs() -> None:
    times = np.array([10.0, 10.5, 11.0, 12.5, 13.0])
    strip = checked_series([1.0, 2.0, np.nan, 4.0, 5.0], times, None, 1.0, None)
    assert strip.dt == pytest.approx(0.5)
    assert strip.start == 10.0
    np.testing.assert_array_equal(strip.rows, [0, 1, 2, 5, 6])
    np.testing.assert_array_equal(strip.w, [1, 1, 0, 0, 0, 1, 1])
    np.testing.assert_array_equal(strip.y, [1, 2, 0, 0, 0, 4, 5])


def test_rounded_time_stamps_are_equal_steps() -> None:
    """0.6 s from a receiver that writes milliseconds since midnight: within a thousandth of a step."""
    times = 45_000.0 + np.round(0.6 * np.arange(500) + 0.00017, 3)
    assert checked_series(np.tile(NOISE, 3)[:500], times, None, 1.0, None).dt == pytest.approx(0.6, rel=1e-6)


def test_angle_through_north_is_that_of_a_turned_axis() -> None:
    point = POINTS["falcon_yaw"]
    _, y = point.series(2, 200)
    calm = filter_ari(y, point.a, point.d, point.sigma_n, point.sigma_e)
    wrapped = filter_ari(np.mod(y - y[100], 360.0), point.a, point.d, point.sigma_n, point.sigma_e, period=360.0)
    np.testing.assert_allclose(wrapped.x - wrapped.x[0], calm.x - calm.x[0], atol=1e-9)


def test_unwrap_passes_gaps() -> None:
    np.testing.assert_allclose(unwrap([350.0, np.nan, 5.0, 20.0], 360.0), [350.0, np.nan, 365.0, 380.0])


def test_resample_is_straight_between_points_and_empty_in_gaps() -> None:
    times = np.array([0.0, 0.9, 2.1, 3.0, 9.0])
    grid, values = resample(times, 2.0 * times, 1.0)
    np.testing.assert_allclose(grid, np.arange(10.0))
    np.testing.assert_allclose(values, [0, 2, 4, 6, *[np.nan] * 5, 18])


def test_scale_and_trend_leave_numbers_near_one() -> None:
    strip = checked_series(4e6 + 70.0 * np.arange(200.0) + 0.02 * NOISE, None, None, 1.0, None)
    ready = scaled([strip], 2, 2)
    assert np.std(np.diff(ready.y[0], n=2)) == pytest.approx(1.0, rel=0.01)
    # 4e6 m in double precision: 1e-9 m
    np.testing.assert_allclose(ready.y[0] * ready.scale + ready.trend[0], strip.y, atol=2e-9)


def series(**change: object) -> dict[str, object]:
    return {"y": NOISE, "p": 2, "d": 1} | change


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (series(y=NOISE[:19]), "y: 19 points for order \\(2,1\\) \\(at least 20\\)"),
        (series(y=np.r_[NOISE[:19], np.full(50, np.nan)]), "19 points"),
        (series(p=30), "order 30"),
        (series(p=2.5), "order 2.5"),
        (series(p=20, y=NOISE[:90]), "90 points for order \\(20,1\\) \\(at least 92\\)"),
        (series(d=7), "7 differences"),
        (series(y=np.full(100, 3.7)), "does not vary"),
        (series(y=np.linspace(0.0, 1.0, 100) * 2.0, d=2), "does not vary"),
        (series(y=np.r_[NOISE, 1e300]), "value 200 is 1e\\+300"),
        (series(y=np.r_[NOISE, -np.inf]), "value 200 is -inf"),
        (series(y=[]), "0 points"),
        (series(y=NOISE.reshape(2, 100)), "shape"),
        (series(times=np.r_[0.0, np.arange(199.0)]), "time 0 of row 1 appears twice"),
        (series(times=np.r_[1.0, np.arange(199.0)]), "time 0 of row 1 goes back"),
        (series(times=np.cumsum(1.0 + 0.1 * np.sin(np.arange(200.0)))), "unequal steps: .* resample"),
        (series(times=np.r_[np.arange(199.0), 1e6]), "mostly gaps"),
        (series(times=np.arange(150.0)), "times do not fit"),
        (series(times=np.r_[np.nan, np.arange(199.0)]), "times do not fit"),
        (series(weights=np.ones(3)), "weights do not fit"),
        (series(weights=np.full(200, np.nan)), "weights do not fit"),
        (series(dt=0.0), "no step"),
        (series(method="best"), "method: 'best' is unknown \\(auto, average, ml, vce\\)"),
        (series(robust="huber"), "robust: 'huber' is unknown"),
        (series(y=[NOISE, NOISE[:4]]), "strip 1 has 4 points"),
        (series(y=[NOISE, np.zeros(50)]), "strip 1 does not vary"),
        (series(y=[NOISE, NOISE], times=[np.arange(200.0)]), "1 of them for 2 strips"),
        (series(y=[NOISE, NOISE], times=[np.arange(200.0), 2.0 * np.arange(200.0)]), "different steps"),
        (series(y=np.mod(359.9 + 0.01 * NOISE + 0.001 * np.arange(200.0), 360.0)), "jumps by 360 .*period=360"),
        (series(y=np.mod(0.01 * NOISE, 2.0 * np.pi)), "jumps by 6.283 .*period=6.28319"),
    ],
)
def test_bad_input_is_told_in_one_line(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        fit_ari(**arguments)  # type: ignore[arg-type]
    assert "\n" not in str(caught.value)


def test_outliers_only_are_refused() -> None:
    """Half of the values anything within 1e6 noise: no noise level that the series agrees with."""
    rng = np.random.default_rng(3)
    y = rng.normal(size=300)
    wild = rng.uniform(size=300) < 0.5
    y[wild] = rng.choice([-1.0, 1.0], wild.sum()) * 10.0 ** rng.uniform(2.0, 6.0, wild.sum())
    with pytest.raises(InputError, match=r"are outliers of the rest .*robust='none'"):
        fit_ari(y, 1, 1)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"criterion": "best"}, "criterion: 'best' is unknown"),
        ({"p": []}, "no order"),
        ({"p": [1, 25]}, "order 25"),
        ({"y": NOISE[:45]}, "too few points for orders up to \\(6,2\\) \\(at least 48\\)"),
    ],
)
def test_bad_orders_are_told(change: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        select_order(**({"y": NOISE} | change))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("times", "dt", "words"),
    [
        (np.arange(5.0), 9.0, "no step"),
        (np.arange(5.0), np.nan, "no step"),
        (np.array([0.0, 1.0, 1.0, 2.0, 3.0]), 1.0, "appears twice"),
        (np.arange(4.0), 1.0, "times do not fit"),
    ],
)
def test_bad_resampling_is_told(times: np.ndarray, dt: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        resample(times, np.arange(5.0), dt)


def test_points_needed_are_those_named() -> None:
    assert points_needed(5, 2) == 36
