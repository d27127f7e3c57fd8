"""Geometry of the rows in the 1988 paper, and how strips become drift and v/h."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerosim.estimation.motion import UNUSED, MotionEstimator, MotionParameters, strip_motion
from aerosim.signals import Reason, StripMatch

VH = 250.0 / 3.6 / 3000.0  # the paper's flight, 1/s
PAPER = MotionParameters(
    spacing_px=39.70,
    focal_px=132.64,
    period=0.05,
    on_camera=False,
    right_cosine=False,
    series="riccati",
    walk_drift=0.225 * math.radians(1.0) ** 2,
    sigma_drift=math.radians(5.0),
    gamma_drift=None,
    walk_vh=0.5e-4,
    sigma_vh=0.05,
    gamma_vh=None,
    strip_period=None,
)


def strip(
    n: float = 258.6,
    mu: float = 0.0,
    yaws: tuple[float, float] = (0.0, 0.0),
    t: float = 0.0,
    duration: float = 12.93,
    reason: Reason = Reason.ACCEPTED,
) -> StripMatch:
    """A strip kept at t, met after `duration`, decided a second later."""
    surface = np.zeros((1, 15), np.float32)
    return StripMatch(0, 0, t, t + duration, t + duration + 1.0, n, mu, 3.0, *yaws, reason, 1, surface)


def test_geometry_of_the_paper(vectors: dict[str, Any]) -> None:
    """Seven pixels are 10 deg; a roll of 1.5 deg reads 5 deg; 3000 m, 250 km/h and 50 ms make n 258.6."""
    given_ = vectors["geometry"]
    spacing = 7.0 / math.tan(math.radians(10.0))
    focal = spacing * math.tan(math.radians(5.0)) / math.tan(math.radians(1.5))
    assert spacing == pytest.approx(given_["row_spacing_px"]) == pytest.approx(39.70, abs=0.005)
    assert focal == pytest.approx(given_["focal_px"]) == pytest.approx(132.64, abs=0.005)
    par = replace(PAPER, spacing_px=spacing, focal_px=focal)
    seen = strip_motion(strip(given_["n_at_3000m_250kmh_50ms"], 7.0), par)
    assert math.degrees(seen.drift) == pytest.approx(10.0)
    assert seen.vh == pytest.approx(VH, rel=1e-9)
    assert round(given_["n_at_3000m_250kmh_50ms"], 1) == 258.6
    rolled = strip_motion(strip(mu=focal * math.tan(math.radians(1.5))), par)
    assert math.degrees(rolled.drift) == pytest.approx(5.0)
    # the defaults, rounded in their last digit, keep the paper's three numbers
    assert math.degrees(strip_motion(strip(mu=7.0), PAPER).drift) == pytest.approx(10.0, abs=0.01)
    assert strip_motion(strip(258.6), PAPER).vh == pytest.approx(VH, rel=1e-3)


@given(mu=st.floats(-7.0, 7.0), n=st.floats(50.0, 400.0))
def test_track_to_the_right_is_positive(mu: float, n: float) -> None:
    seen = strip_motion(strip(n, mu), PAPER)
    assert 39.70 * math.tan(seen.angle) == pytest.approx(mu, abs=1e-12)
    assert seen.drift == seen.angle
    assert seen.vh * 132.64 * 0.05 * n == pytest.approx(39.70)


def test_rows_on_the_camera_add_the_mean_of_the_end_yaws() -> None:
    """Track 8 deg right of the nose, camera turned by 3 deg, then 6: crab 3.5 deg on the mean of the ends."""
    mu = 39.70 * math.tan(math.radians(3.5))
    ends = strip(mu=mu, yaws=(math.radians(3.0), math.radians(6.0)))
    seen = strip_motion(ends, replace(PAPER, on_camera=True))
    assert math.degrees(seen.angle) == pytest.approx(3.5)
    assert math.degrees(seen.drift) == pytest.approx(8.0)
    assert math.degrees(strip_motion(ends, PAPER).drift) == pytest.approx(3.5)  # rows on the airframe do not turn


def test_cosine_only_when_it_is_put_right() -> None:
    """The study: (1) measures (v/h) cos(crab), -1.05 % at 8.3 deg."""
    aside = strip(mu=39.70 * math.tan(math.radians(8.3)))
    printed, right = (strip_motion(aside, replace(PAPER, right_cosine=r)).vh for r in (False, True))
    assert printed / right - 1.0 == pytest.approx(-0.0105, abs=5e-5)
    assert right == pytest.approx(printed / math.cos(math.radians(8.3)), rel=1e-12)


def test_not_valid_before_the_first_strip() -> None:
    estimator = MotionEstimator(PAPER)
    assert not estimator.now().valid
    assert math.isnan(estimator.now().vh)


def test_first_strip_is_taken_as_it_is() -> None:
    estimator = MotionEstimator(PAPER)
    use = estimator.add(strip(250.0, 2.0, t=100.0))
    now = estimator.now()
    assert now.valid
    assert now.t == 113.93  # decided
    assert now.drift == pytest.approx(math.atan(2.0 / 39.70), rel=1e-14)
    assert now.vh == pytest.approx(39.70 / (132.64 * 0.05 * 250.0), rel=1e-12)
    assert (use.gain_drift, use.gain_vh) == (1.0, 1.0)
    assert math.isnan(use.innovation_drift)
    # q = 1: the variances are the assumed noise
    assert now.sigma_drift == pytest.approx(math.radians(5.0))
    assert now.sigma_vh == pytest.approx(0.05 * now.vh)
    assert use.variance_drift == pytest.approx(math.radians(5.0) ** 2)
    assert use.variance_vh == pytest.approx(now.sigma_vh**2)


@pytest.mark.parametrize(
    ("change", "gamma_drift", "gamma_vh"),
    [
        ({}, 0.225 * 12.93 / 25.0, 0.5e-4 * 12.93 / 0.05**2),  # own duration
        ({"strip_period": 1.0}, 0.225 / 25.0, 0.5e-4 / 0.05**2),
        ({"gamma_drift": 0.01, "gamma_vh": 0.02}, 0.01, 0.02),
        ({"gamma_drift": 0.01, "strip_period": 1.0}, 0.01, 0.5e-4 / 0.05**2),
    ],
)
def test_gamma_is_given_or_from_period_or_duration(
    change: dict[str, float], gamma_drift: float, gamma_vh: float
) -> None:
    estimator = MotionEstimator(replace(PAPER, **change))
    estimator.add(strip(mu=0.0))
    use = estimator.add(strip(mu=1.0))
    # second step of (15) from q = 1
    assert use.gain_drift == pytest.approx((1.0 + gamma_drift) / (2.0 + gamma_drift), rel=1e-12)
    assert use.gain_vh == pytest.approx((1.0 + gamma_vh) / (2.0 + gamma_vh), rel=1e-12)
    drift = math.atan(1.0 / 39.70)
    assert estimator.now().drift == pytest.approx(use.gain_drift * drift, rel=1e-12)
    # innovation over sqrt(N0 (q + gamma + 1)), the variance of prediction and observation together
    spread = math.radians(5.0) * math.sqrt(2.0 + gamma_drift)
    assert use.innovation_drift == pytest.approx(drift / spread, rel=1e-12)


def test_n_is_what_is_filtered() -> None:
    """The paper's state is n: two strips of 200 and 300 at equal weight give 250, not the mean of the v/h."""
    estimator = MotionEstimator(replace(PAPER, gamma_drift=0.0, gamma_vh=0.0))
    estimator.add(strip(200.0))
    estimator.add(strip(300.0))
    assert estimator.now().vh == pytest.approx(39.70 / (132.64 * 0.05 * 250.0), rel=1e-12)


@pytest.mark.parametrize("reason", [r for r in Reason if r is not Reason.ACCEPTED])
def test_refused_strips_change_nothing(reason: Reason) -> None:
    estimator, other = MotionEstimator(PAPER), MotionEstimator(PAPER)
    for each in (estimator, other):
        each.add(strip(250.0, 2.0))
    before = estimator.now()
    lost = reason in {Reason.TIMEOUT, Reason.OUTSIDE_TERRAIN}
    refused = strip(math.nan if lost else 300.0, math.nan if lost else -6.0, reason=reason)
    assert estimator.add(refused) is UNUSED
    assert estimator.now() == before
    assert estimator.add(strip(260.0, 3.0)) == other.add(strip(260.0, 3.0))
    assert estimator.now() == other.now()


def test_another_line_forgets() -> None:
    estimator = MotionEstimator(PAPER)
    for mu in (2.0, 3.0, 2.5):
        estimator.add(strip(250.0, mu))
    estimator.begin_line()
    assert not estimator.now().valid
    assert math.isnan(estimator.now().vh)
    use = estimator.add(strip(300.0, -4.0))
    assert use.gain_drift == use.gain_vh == 1.0
    assert estimator.now().drift == pytest.approx(math.atan(-4.0 / 39.70), rel=1e-14)


def test_halving_series_reaches_both_filters() -> None:
    estimator = MotionEstimator(replace(PAPER, series="halving", gamma_drift=0.01, gamma_vh=0.01))
    estimator.add(strip())
    use = estimator.add(strip())
    assert use.gain_drift == use.gain_vh == pytest.approx((1.0 + 0.09512492197250393) / 2.0)


def test_drift_through_the_whole_estimator_is_as_good_as_it_claims() -> None:
    """Strips of a wandering drift, 60 runs of 150: error and innovations of the MotionEstimator.

    gamma 0.116: q 0.288, r = 0.71; 60 x 120 squared errors count as 7200 x 0.33 = 2400 independent ones, relative
    standard deviation 2.9 %, bound 4 sigma = 12 %; innovations sqrt(2/7200) = 1.7 %, bound 7 %.
    mu is made of the drift by the closed form, so its tangent adds nothing.
    """
    rng = np.random.default_rng(42)
    gamma = 0.225 * 12.93 / 25.0
    q = (-gamma + math.sqrt(gamma * gamma + 4.0 * gamma)) / 2.0
    errors, innovations, claims = [], [], []
    for _ in range(60):
        estimator = MotionEstimator(PAPER)
        drift = 0.0
        for j in range(150):
            drift += math.sqrt(PAPER.walk_drift * 12.93) * rng.standard_normal()
            seen = drift + PAPER.sigma_drift * rng.standard_normal()
            use = estimator.add(strip(mu=39.70 * math.tan(seen)))
            if j >= 30:
                errors.append(estimator.now().drift - drift)
                innovations.append(use.innovation_drift)
                claims.append(estimator.now().sigma_drift)
    assert claims == pytest.approx(np.full(7200, math.radians(5.0) * math.sqrt(q)), rel=1e-6)
    assert np.mean(np.square(errors)) == pytest.approx(math.radians(5.0) ** 2 * q, rel=0.12)
    assert np.mean(np.square(innovations)) == pytest.approx(1.0, abs=0.07)


def seek_after(*mus: float, on_camera: bool = True, yaws: tuple[float, float] = (0.0, 0.0)) -> float:
    """Where the camera is sent, deg, after refused strips with these shifts at the rows' end."""
    estimator = MotionEstimator(replace(PAPER, on_camera=on_camera))
    for mu in mus:
        estimator.add(strip(mu=mu, yaws=yaws, reason=Reason.BORDER_MU))
    assert not estimator.now().valid
    return math.degrees(estimator.now().seek)


def test_three_strips_beyond_the_same_end_say_where_to_turn() -> None:
    assert seek_after(7.0, 7.0) == 0.0
    assert seek_after(7.0, 7.0, 7.0) == pytest.approx(10.0, abs=0.01)
    assert seek_after(-7.0, -7.0, -7.0) == pytest.approx(-10.0, abs=0.01)
    assert seek_after(7.0, -7.0, 7.0, -7.0) == 0.0


def test_looking_goes_on_from_where_the_camera_is() -> None:
    turned = (math.radians(10.0), math.radians(10.0))
    assert seek_after(7.0, 7.0, 7.0, yaws=turned) == pytest.approx(20.0, abs=0.01)
    assert seek_after(-7.0, -7.0, -7.0, yaws=turned) == pytest.approx(0.0, abs=0.01)


def test_rows_on_the_airframe_do_not_turn_with_the_camera() -> None:
    assert seek_after(7.0, 7.0, 7.0, on_camera=False) == 0.0


def test_a_track_that_was_wrong_is_looked_for_again() -> None:
    estimator = MotionEstimator(replace(PAPER, on_camera=True))
    estimator.add(strip(mu=-5.0))
    turned = (math.radians(-7.0), math.radians(-7.0))
    for _ in range(9):
        estimator.add(strip(mu=7.0, yaws=turned, reason=Reason.BORDER_MU))
    assert estimator.now().valid
    estimator.add(strip(mu=7.0, yaws=turned, reason=Reason.BORDER_MU))
    assert not estimator.now().valid
    assert math.degrees(estimator.now().seek) == pytest.approx(10.0 - 7.0, abs=0.01)
    # what is accepted next counts alone
    estimator.add(strip(mu=2.0))
    assert estimator.now().drift == pytest.approx(math.atan2(2.0, 39.70))


def test_a_strip_accepted_between_keeps_the_track() -> None:
    estimator = MotionEstimator(replace(PAPER, on_camera=True))
    for _ in range(4):
        estimator.add(strip(mu=5.0))
        for _ in range(9):
            estimator.add(strip(mu=7.0, reason=Reason.BORDER_MU))
    assert estimator.now().valid


def test_nothing_is_looked_for_once_the_track_is_known() -> None:
    estimator = MotionEstimator(replace(PAPER, on_camera=True))
    estimator.add(strip(mu=3.0))
    for _ in range(4):
        estimator.add(strip(mu=7.0, reason=Reason.BORDER_MU))
    assert estimator.now().valid
    assert estimator.now().drift == pytest.approx(math.atan2(3.0, 39.70))
