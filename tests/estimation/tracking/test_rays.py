"""Ray tables: straight ones, and what bent ones say of the distance of the rows."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.estimation.tracking.geometry import looks, passed
from aerosim.estimation.tracking.rays import Rays, sampled

PIXELS, MARGIN, SPACING, FOCAL, K1 = 96, 7, 39.7, 132.6, 0.1


def bent() -> Rays:
    """Distances that grow with the square of the place in the row, symmetric about its middle."""
    rows = []
    for x, y in Rays.straight(PIXELS, MARGIN, SPACING):
        rows.append(np.stack([x * (1.0 + K1 * (y / FOCAL) ** 2), y]))
    return Rays(*rows)


def test_straight_rows_are_parallel() -> None:
    rays = Rays.straight(PIXELS, MARGIN, SPACING)
    assert rays.apart == pytest.approx(SPACING)
    assert np.abs(rays.bow).max() < 1e-12
    assert rays.row1[1, MARGIN] == rays.row2[1, 0] == -(PIXELS - 1) / 2.0


def test_bow_has_no_mean_where_a_strip_is_read() -> None:
    """So that the step of a strip stays the time at which the mean of its pixels was met."""
    rays = bent()
    y = sampled(PIXELS) - (PIXELS - 1) / 2.0
    # between two pixels the table is a chord of the parabola: at most 1/4 px^2 above it
    assert rays.apart == pytest.approx(SPACING * (1.0 + K1 * (y**2).mean() / FOCAL**2), abs=SPACING * 6e-6 / 4.0)
    assert np.interp(sampled(PIXELS), np.arange(PIXELS), rays.bow).mean() == pytest.approx(0.0, abs=1e-12)
    assert rays.bow[0] == pytest.approx(rays.bow[-1])
    assert rays.bow[0] > 0.0 > rays.bow[PIXELS // 2]


def test_a_place_beyond_the_row_is_carried_on() -> None:
    rays = Rays.straight(PIXELS, MARGIN, SPACING)
    for place in (-3.0, 0.25, 40.5, PIXELS + 4.0):
        assert looks(rays.row2, place) == pytest.approx((-SPACING / 2.0, place - (PIXELS - 1) / 2.0))


@pytest.mark.parametrize("mu", [-3.3, 0.0, 5.0])
def test_way_between_two_level_looks(mu: float) -> None:
    """Distance of the rows along, the shift across, over the focal length."""
    level = np.zeros(7)
    straight = passed(level, level, mu, 0.0, *Rays.straight(PIXELS, MARGIN, SPACING), FOCAL)
    assert straight == pytest.approx((SPACING / FOCAL, mu / FOCAL), rel=1e-12)
    if mu == 0.0:
        rays = bent()
        assert passed(level, level, mu, 0.0, *rays, FOCAL) == pytest.approx((rays.apart / FOCAL, 0.0), abs=1e-12)
