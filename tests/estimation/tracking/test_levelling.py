"""Roll and pitch out of a gyro that drifts and a vertical that wavers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerosim.estimation.tracking.levelling import Levelled

DEG = math.radians(1.0)
PERIOD = 0.05


def test_without_a_vertical_the_gyro_counts() -> None:
    assert Levelled(1e-5, 0.1 * DEG, 60.0)(3.0, 0.02, math.nan) == 0.02


@pytest.mark.parametrize("drift_deg_per_h", [-20.0, 20.0])
def test_the_gyros_drift_is_found_and_its_swings_are_kept(drift_deg_per_h: float) -> None:
    """Half an hour: the gyro is off by 10 deg at its end, the angle that comes out by a tenth of a degree.

    The vertical's error is of 0.1 deg and 60 s.  A straight line through it over a time t is known at its end to
    2 sqrt(S/t), S = 2 x 0.1^2 x 60 deg^2 s: 0.05 deg after 1800 s; three times that are allowed.
    """
    rng, found = np.random.default_rng(6), Levelled(20.0 * DEG / 3600.0, 0.1 * DEG, 60.0)
    keep, wrong = math.exp(-PERIOD / 60.0), 0.1 * DEG * rng.standard_normal()
    off = []
    for k in range(round(1800.0 / PERIOD)):
        t = k * PERIOD
        roll = 2.0 * DEG * math.sin(t)
        wrong = keep * wrong + 0.1 * DEG * math.sqrt(1.0 - keep**2) * rng.standard_normal()
        off.append(found(t, roll + drift_deg_per_h * DEG * t / 3600.0, roll + wrong) - roll)
    last = np.degrees(off[-2400:])
    assert abs(last).max() < 0.15
    assert last.std() < 0.02  # neither the swings of 2 deg nor the vertical's come through


def test_held_it_misses_a_straight_line_whatever_the_vertical_says() -> None:
    """Held at t = 10 s, a vertical that then leaps by 5 deg changes nothing; released, it counts again."""
    found = Levelled(20.0 * DEG / 3600.0, 0.1 * DEG, 60.0)
    drift = 0.01 * DEG
    before = [found(k * PERIOD, drift * k * PERIOD, 0.0) for k in range(201)][-1]
    found.hold()
    held = [found(10.0 + k * PERIOD, drift * (10.0 + k * PERIOD), 5.0 * DEG) for k in range(1, 401)]
    assert np.diff(held, 2) == pytest.approx(0.0, abs=1e-12)
    assert held[0] == pytest.approx(before, abs=1e-3 * DEG)
    found.release()
    assert abs(found(30.05, drift * 30.05, 5.0 * DEG) - held[-1]) > 0.01 * DEG
