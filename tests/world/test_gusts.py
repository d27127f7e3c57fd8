"""1-cosine gusts against their closed form: integral, peak, ends."""

import numpy as np
import pytest

from aerosim.world.gusts import CosineGust


def test_peak_half_way_and_nothing_outside():
    gust = CosineGust(10.0, 4.0, 3.0, -2.0, 1.0)
    found = gust.at(np.array([0.0, 9.99, 10.0, 11.0, 12.0, 13.0, 14.0, 14.01, 99.0]))
    assert found[4] == pytest.approx((3.0, -2.0, 1.0))
    assert found[[3, 5]] == pytest.approx(np.tile((1.5, -1.0, 0.5), (2, 1)))
    assert not found[[0, 1, 2, 6, 7, 8]].any()


def test_air_moves_by_half_the_peak_times_the_duration():
    # int (1 - cos)/2 over the gust; the trapezoids of a whole period are exact
    t = np.arange(0.0, 30.0, 0.025)
    moved = CosineGust(7.3, 5.0, 2.0, 0.0, -4.0).at(t).sum(axis=0) * 0.025
    assert moved == pytest.approx((5.0, 0.0, -10.0), rel=1e-6)


def test_it_begins_without_a_jump():
    # (1 - cos)/2 starts like (pi s)^2, s the part of the duration
    small = CosineGust(0.0, 10.0, 1.0, 0.0, 0.0).at(np.array([0.01]))
    assert small[0, 0] == pytest.approx((np.pi * 0.001) ** 2, rel=1e-4)
