"""Where row II will meet the ground of row I."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerosim.estimation.tracking.geometry import ahead, mismatch

SPACING, FOCAL, VH = 39.7, 132.6, 0.025


def missed(track: float, span: float, roll1: float = 0.0, pitch1: float = 0.0) -> tuple[float, float]:
    """Along and across, px, of one strip `span` s old; the attitude (rad) is level but for row I's."""
    ring = np.zeros((8, 7))
    ring[0, 1:3] = roll1, pitch1
    ring[1, 0] = span
    out = np.zeros((1, 2))
    seen = np.array([ahead(ring[0], SPACING, FOCAL, 0.0)])
    mismatch(ring, 1, np.zeros(1, np.int64), seen, track, VH, SPACING, FOCAL, 0.0, out)
    return float(out[0, 0]), float(out[0, 1])


def test_the_ground_is_ahead_then_met_then_behind() -> None:
    span = SPACING / (FOCAL * VH)
    assert missed(0.0, 0.5 * span)[0] == pytest.approx(0.5 * SPACING)
    assert missed(0.0, span)[0] == pytest.approx(0.0, abs=1e-9)
    assert missed(0.0, 1.5 * span)[0] == pytest.approx(-0.5 * SPACING)


@pytest.mark.parametrize("track_deg", [-7.0, 7.0])
def test_a_track_to_the_right_is_met_at_a_positive_shift(track_deg: float) -> None:
    """mu = d tan(angle), the row's own reading of a track to the right."""
    angle = math.radians(track_deg)
    span = SPACING / (FOCAL * VH * math.cos(angle))
    along, across = missed(angle, span)
    assert along == pytest.approx(0.0, abs=1e-9)
    assert across == pytest.approx(SPACING * math.tan(angle))


def test_roll_of_the_first_look_is_expected_in_the_shift() -> None:
    """1.5 deg of roll read as 5 deg of drift (the paper): f tan(1.5 deg) = d tan(5 deg), right wing down first.

    A ray of row I then hits further left, and the ground is met further right in row I.
    """
    across = missed(0.0, SPACING / (FOCAL * VH), roll1=math.radians(1.5))[1]
    assert abs(across) == pytest.approx(SPACING * math.tan(math.radians(5.0)), rel=0.02)
    assert across > 0.0
