"""What strips make of track and v/h, and that a tilt of the unaided camera goes where it belongs."""

from __future__ import annotations

import math

import pytest

from aerosim.estimation.tracking.belief import Belief, UnaidedBelief
from aerosim.estimation.tracking.channel import Channel
from aerosim.estimation.tracking.lag_filter import LagFilter, WalkModel
from aerosim.estimation.tracking.sway_filter import SwayFilter

VH = 0.03
DEG = math.radians(1.0)


def unaided() -> UnaidedBelief:
    channels = [Channel(SwayFilter(1e-5, 0.5, 20.0, 1e-4, 1.5, ends=True), 1e-6, 1e-4) for _ in range(2)]
    return UnaidedBelief(channels[0], channels[1], VH)


def aided() -> Belief:
    channels = [Channel(LagFilter(WalkModel(1e-5, 1e-6, 100.0), 0.5, 20.0), 1e-6, 1e-4) for _ in range(2)]
    return Belief(channels[0], channels[1])


@pytest.mark.parametrize("drift", [-20.0 * DEG, 0.0, 8.0 * DEG])
@pytest.mark.parametrize("make", [unaided, aided])
def test_a_strip_as_begun_with_changes_nothing(make: type[Belief], drift: float) -> None:
    belief = make()
    belief.start(0.0, drift, math.log(1.1 * VH), (1e-4, 1e-4))
    for k in range(1, 10):
        belief.add(0.5 * k - 13.0, 0.5 * k, drift, math.log(1.1 * VH))
        assert belief.close(0.5 * k)
    now = belief.now(4.5)
    assert now.track == pytest.approx(drift, abs=1e-12)
    assert math.exp(now.log_vh) == pytest.approx(1.1 * VH)


def test_whole_turns_of_the_gyro_do_not_count() -> None:
    belief = aided()
    belief.start(0.0, 3.0, math.log(VH), (1e-4, 1e-4))
    assert belief.surprise(-13.0, 0.0, 3.0 - 2.0 * math.pi, math.log(VH)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_pitch_between_the_looks_of_a_drifting_camera_is_no_surprise_across(side: float) -> None:
    """Aircraft drifting by 8 deg: a pitch lengthens the strip's time by 5 %; way and shift follow from it.

    The strip's vector is then that of the true v/h, shortened by 5 % along the nose and not across it: across, the
    rows see less drift way, as v/h to the right times a time that is no longer the way's.
    """
    drift = side * 8.0 * DEG
    belief = unaided()
    belief.start(0.0, drift, math.log(VH), (1e-6, 1e-6))
    ahead, right = math.cos(drift) / 1.05, math.sin(drift)
    belief.add(-13.0, 0.0, math.atan2(right, ahead), math.log(VH * math.hypot(right, ahead)))
    belief.close(0.5)
    assert abs(belief.innovations[0]) < 0.05
    assert belief.innovations[1] > 1.0
    assert belief.now(0.5).track == pytest.approx(drift, abs=1e-3)
