"""Mesoscale wind: structure functions against closed forms, no divergence, carried along by the wind."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j0, j1

from aerosim.errors import InputError
from aerosim.world.local import LocalPlane
from aerosim.world.mesoscale import Mesoscale, MesoscaleWind, spectrum_level

STRUCTURE, LONGEST, SHORTEST = 3.6e-3, 400e3, 1000.0


class Flat(LocalPlane):
    """A plane whose latitude and longitude are metres."""

    def __init__(self, drift=(0.0, 0.0)):
        super().__init__(0.0, 0.0, 0.0, drift)

    def at(self, t, lat, lon):
        return lat - self._drift[0] * t, lon - self._drift[1] * t


def field(seed, scales=None, drift=(0.0, 0.0)):
    return MesoscaleWind(
        scales or Mesoscale(STRUCTURE, LONGEST, SHORTEST), Flat(drift), np.random.default_rng(seed)
    )


def closed_form(r, longest=LONGEST, shortest=SHORTEST):
    """D_LL + D_NN and D_LL of E = c k^(-5/3) between two wavelengths, two-dimensional and without divergence.

    The longitudinal one from <v_L v_L'> = int 2 E J1(kr)/(kr) dk (the transverse then follows by continuity).
    """
    c, low, high = spectrum_level(STRUCTURE), 2 * math.pi / longest, 2 * math.pi / shortest

    def over_log(f):
        return quad(lambda s: f(math.exp(s)) * math.exp(s), math.log(low), math.log(high), limit=400)[0]

    total = over_log(lambda k: 4 * c * k ** (-5 / 3) * (1 - j0(k * r)))
    along = over_log(lambda k: 2 * c * k ** (-5 / 3) * (1 - 2 * j1(k * r) / (k * r)))
    return total, along


def test_level_of_the_spectrum_gives_the_two_thirds_law():
    # An endless spectrum: 4 c int (1 - J0(kr)) k^(-5/3) dk = a r^(2/3), here with kr up to 600; above, J0 and J1
    # average out, and 4 c 3/2 k^(-2/3) is left of the sum, half of that of the longitudinal one.
    r = 2e4
    total, along = closed_form(r, longest=2e10, shortest=200.0)
    rest = 6 * spectrum_level(STRUCTURE) * (2 * math.pi / 200.0) ** (-2 / 3)
    assert total + rest == pytest.approx(STRUCTURE * r ** (2 / 3), rel=1e-3)
    # D_NN = d(r D_LL)/dr = 5/3 D_LL
    assert along + rest / 2 == pytest.approx((total + rest) * 3 / 8, rel=1e-3)


def test_both_remembered_numbers_of_lindborg_belong_together():
    # a1 = 3.6e-3 of the structure functions and d1 = 9.1e-4 of the one-dimensional spectra d1 k^(-5/3) of both
    # components: a1 = 2 d1 int (1 - cos x) x^(-5/3) dx = 2 d1 * 2.009
    integral = -math.gamma(-2 / 3) * math.cos(math.pi / 3)
    assert 2 * 9.1e-4 * integral == pytest.approx(3.6e-3, rel=0.02)


@pytest.mark.parametrize("r", [500.0, 2000.0, 10e3, 50e3])
def test_structure_functions_of_many_fields(r):
    # 600 fields, one pair each in a random direction: v differences are Gaussian, so the mean square of n has a
    # relative sd of sqrt(2/n) = 5.8 %, of their sum at most that; 4 of them.
    rng = np.random.default_rng(5)
    along, across = [], []
    for seed in range(600):
        wind, azimuth = field(seed), rng.uniform(0, 2 * math.pi)
        x, y = rng.uniform(-1e5, 1e5, 2)
        c, s = math.cos(azimuth), math.sin(azimuth)
        a, b = wind.at(0.0, x, y, 0.0), wind.at(0.0, x + r * c, y + r * s, 0.0)
        north, east = b[0] - a[0], b[1] - a[1]
        along.append(c * north + s * east)
        across.append(-s * north + c * east)
    total, longitudinal = closed_form(r)
    bound = 4 * math.sqrt(2 / 600)
    assert np.mean(np.square(along)) == pytest.approx(longitudinal, rel=bound)
    assert np.mean(np.square(across)) == pytest.approx(total - longitudinal, rel=bound)


def test_the_law_holds_between_the_wavelengths():
    # What the two ends of the spectrum take away, where a survey's strips and lines are: of 3.6e-3 r^(2/3)
    for r, least in ((2e3, 0.80), (5e3, 0.88), (12e3, 0.88)):
        assert least < closed_form(r)[0] / (STRUCTURE * r ** (2 / 3)) < 1.0


def test_no_divergence_and_a_smooth_field():
    wind = field(3)
    for x, y in ((0.0, 0.0), (3e4, -2e4), (-1e5, 7e4)):
        north = (wind.at(0, x + 1, y, 0)[0] - wind.at(0, x - 1, y, 0)[0]) / 2
        east = (wind.at(0, x, y + 1, 0)[1] - wind.at(0, x, y - 1, 0)[1]) / 2
        turn = (wind.at(0, x + 1, y, 0)[1] - wind.at(0, x - 1, y, 0)[1]) / 2
        assert abs(north + east) < 1e-9
        assert abs(turn) > 1e-7
        assert wind.at(0, x, y, 0)[2] == 0.0


def test_near_the_last_point_it_is_the_same_field():
    # Up to 20 m the tangent plane stands for the field: off by (k d)^2/2, 0.8 % of the shortest waves' 0.3 m/s
    there = field(9)
    for x in np.arange(0.0, 3000.0, 7.0):
        assert there.at(0, x, 2 * x, 0) == pytest.approx(field(9).at(0, x, 2 * x, 0), abs=0.003)


def test_it_is_carried_along_and_the_same_each_time():
    still, carried = field(4), field(4, drift=(8.0, -3.0))
    assert carried.at(100.0, 5800.0, 3700.0, 0.0) == still.at(0.0, 5000.0, 4000.0, 0.0)
    assert still.at(0.0, 1.0, 2.0, 0.0) == field(4).at(50.0, 1.0, 2.0, 3000.0)
    assert still.at(0.0, 1.0, 2.0, 0.0) != field(5).at(0.0, 1.0, 2.0, 0.0)


def test_strength_only_scales():
    weak, strong = (field(6, Mesoscale(a, LONGEST, SHORTEST)).at(0, 1e3, 2e3, 0) for a in (1e-3, 4e-3))
    assert strong == pytest.approx([2 * each for each in weak])


def test_wavelengths_in_the_wrong_order_are_refused():
    with pytest.raises(InputError, match="no wavelength between"):
        field(1, Mesoscale(STRUCTURE, 1e3, 2e3))
