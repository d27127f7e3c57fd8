"""Sigma and length by the rules of MIL-F-8785C, against the standard's figures and formulas in feet."""

import math

import pytest

from aerosim.errors import InputError
from aerosim.world.mil import high_sigma, mil_turbulence

FT = 0.3048


@pytest.mark.parametrize(
    ("feet", "exceedance", "sigma_fps"),
    [
        # figure 7 at 7500 and 15000 ft, as read in two places
        (7500, 1e-1, 1.6), (7500, 1e-2, 6.7), (7500, 1e-3, 10.1), (7500, 1e-4, 15.1),
        (7500, 1e-5, 23.6), (7500, 1e-6, 30.2),
        (15000, 1e-1, 0.0), (15000, 1e-2, 4.6), (15000, 1e-3, 8.0), (15000, 1e-4, 11.6),
        (15000, 1e-5, 22.1), (15000, 1e-6, 30.7),
        (25000, 1e-3, 6.6), (45000, 1e-5, 15.1), (80000, 1e-4, 2.1), (1750, 1e-2, 6.9),
        (500, 0.2, 3.2), (100, 0.2, 3.2),
        # half way between two columns, and between two curves on the logarithm
        (11250, 1e-3, 9.05), (7500, math.sqrt(1e-2 * 1e-3), 8.4),
    ],
)  # fmt: skip
def test_sigma_of_figure_7(feet, exceedance, sigma_fps):
    assert high_sigma(feet * FT, exceedance) == pytest.approx(sigma_fps * FT, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("severity", "sigma"), [("light", 1.84), ("moderate", 2.88), ("severe", 7.05)])
def test_severities_at_3000_m(severity, sigma):
    # as found independently from the same figure for the flight model's study
    found = mil_turbulence("dryden", height=3000.0, agl=2700.0, severity=severity)
    assert (found.sigma_u, found.sigma_w) == pytest.approx((sigma, sigma), abs=0.005)
    assert (found.length_u, found.length_w) == pytest.approx((533.4, 533.4))


def test_von_karman_has_its_own_length():
    found = mil_turbulence("von_karman", height=3000.0, agl=2700.0, severity="light")
    assert (found.length_u, found.length_w) == pytest.approx((762.0, 762.0))
    assert found.spectrum == "von_karman"


@pytest.mark.parametrize("feet", [10.0, 200.0, 640.0, 1000.0])
def test_low_altitude(feet):
    # Lw = h, Lu = Lv = h/(.177 + .000823 h)^1.2, sigma_w = .1 W20, sigma_u = sigma_v = sigma_w/(...)^.4, h in ft
    found = mil_turbulence("dryden", height=500.0, agl=feet * FT, wind_20ft=12.0)
    shape = 0.177 + 0.000823 * feet
    assert found.length_w == pytest.approx(feet * FT)
    assert found.length_u == pytest.approx(feet / shape**1.2 * FT)
    assert found.sigma_w == pytest.approx(1.2)
    assert found.sigma_u == pytest.approx(1.2 / shape**0.4)


def test_low_altitude_is_isotropic_at_1000_ft():
    found = mil_turbulence("dryden", height=500.0, agl=1000 * FT, wind_20ft=12.0)
    assert found.sigma_u == pytest.approx(found.sigma_w)
    assert found.length_u == pytest.approx(1000 * FT)


@pytest.mark.parametrize(("word", "knots"), [("light", 15.0), ("moderate", 30.0), ("severe", 45.0)])
def test_severity_near_the_ground_is_a_wind(word, knots):
    found = mil_turbulence("dryden", height=300.0, agl=150.0, severity=word)
    assert found.sigma_w == pytest.approx(0.1 * knots * 1852.0 / 3600.0, rel=1e-5)
    # a wind that is given goes before it
    assert mil_turbulence("dryden", height=300.0, agl=150.0, severity=word, wind_20ft=5.0).sigma_w == 0.5


def test_between_the_altitudes_it_is_linear_and_meets_both_ends():
    kind = {"height": 1500.0, "exceedance": 1e-3, "wind_20ft": 9.0}
    ends = [mil_turbulence("von_karman", agl=feet * FT, **kind) for feet in (1000, 2000)]
    for part in (0.25, 0.5):
        found = mil_turbulence("von_karman", agl=1000 * FT * (1.0 + part), **kind)
        for a, b, c in zip(ends[0][1:], ends[1][1:], found[1:], strict=True):
            assert c == pytest.approx(a + part * (b - a))
    assert ends[0][1:] == pytest.approx((0.9, 0.9, 304.8, 304.8))
    assert ends[1].sigma_u == pytest.approx(high_sigma(1500.0, 1e-3))


@pytest.mark.parametrize(
    ("agl", "more", "key"),
    [
        (2.0, {"severity": "light"}, "air.turbulence"),
        (200.0, {"exceedance": 1e-3}, "air.turbulence.wind_20ft_m_s"),
        (400.0, {"exceedance": 1e-3}, "air.turbulence.wind_20ft_m_s"),
        (400.0, {"wind_20ft": 5.0}, "air.turbulence.wind_20ft_m_s"),
        (2500.0, {"wind_20ft": 5.0}, "air.turbulence.wind_20ft_m_s"),
        (2500.0, {"exceedance": 0.5}, "air.turbulence.exceedance"),
    ],
)
def test_what_is_missing_is_named(agl, more, key):
    with pytest.raises(InputError) as caught:
        mil_turbulence("dryden", height=3000.0, agl=agl, **more)
    assert caught.value.key == key


def test_no_severity_above_the_figure():
    with pytest.raises(InputError, match="no severity is known at 25000 m"):
        mil_turbulence("dryden", height=25000.0, agl=24000.0, severity="light")
