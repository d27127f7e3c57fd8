"""Mean wind by height: signs, closed forms of shear and veer, profiles, and what is refused."""

import math

import pytest

from aerosim.errors import InputError
from aerosim.world.wind import Level, WindField, steady_wind, wind_n


def level(height, speed, from_deg):
    return Level(height, speed, math.radians(from_deg))


def speed_and_from(wind):
    north, east, down = wind
    assert down == 0.0
    return math.hypot(north, east), math.degrees(math.atan2(-east, -north)) % 360.0


@pytest.mark.parametrize(
    ("from_deg", "goes_to"), [(0, (-10, 0, 0)), (90, (0, -10, 0)), (180, (10, 0, 0)), (270, (0, 10, 0))]
)
def test_wind_is_named_by_where_it_comes_from(from_deg, goes_to):
    # A north wind blows to the south, a west wind to the east.
    assert wind_n(10.0, math.radians(from_deg)) == pytest.approx(goes_to, abs=1e-12)
    assert steady_wind(10.0, from_deg).at(1234.0) == pytest.approx(goes_to, abs=1e-12)


def test_steady_wind_and_equal_levels_are_uniform():
    assert steady_wind(7.0, 30.0).uniform
    assert WindField([level(0, 7, 30), level(1000, 7, 30)]).uniform
    assert not WindField([level(0, 7, 30), level(1000, 7, 31)]).uniform
    assert not WindField([level(0, 7, 30)], exponent=0.1).uniform
    assert not WindField([level(0, 7, 30)], veer=1e-6).uniform


@pytest.mark.parametrize(
    ("agl", "speed"), [(3000.0, 12.0), (1500.0, 12.0 / 2.0**0.5), (750.0, 6.0), (6000.0, 12.0 * 2.0**0.5)]
)
def test_power_law_over_the_ground_not_over_the_ellipsoid(agl, speed):
    field = WindField([level(0, 12, 250)], ground=400.0, exponent=0.5, reference_agl=3000.0)
    assert speed_and_from(field.at(400.0 + agl)) == pytest.approx((speed, 250.0))


def test_power_law_is_calm_at_and_below_the_ground():
    field = WindField([level(0, 12, 250)], ground=400.0, exponent=0.5)
    assert field.at(400.0)[:2] == field.at(300.0)[:2] == pytest.approx((0.0, 0.0))


@pytest.mark.parametrize(("agl", "from_deg"), [(3000.0, 350.0), (4000.0, 5.0), (1000.0, 320.0)])
def test_veer_turns_clockwise_upwards_from_the_reference(agl, from_deg):
    # 15 deg/km: the wind of 350 deg at 3000 m comes from 5 deg one km higher, from 320 deg two km lower.
    field = WindField([level(0, 9, 350)], ground=150.0, reference_agl=3000.0, veer=math.radians(15.0) / 1000.0)
    assert speed_and_from(field.at(150.0 + agl)) == pytest.approx((9.0, from_deg))


def test_profile_is_linear_in_north_and_east_and_constant_outside():
    field = WindField([level(500, 10, 0), level(1500, 10, 90), level(2500, 20, 90)])
    assert field.at(1000.0) == pytest.approx((-5.0, -5.0, 0.0))
    assert field.at(2000.0) == pytest.approx((0.0, -15.0, 0.0), abs=1e-12)
    assert field.at(1500.0) == pytest.approx((0.0, -10.0, 0.0), abs=1e-12)
    assert field.at(-100.0) == pytest.approx((-10.0, 0.0, 0.0), abs=1e-12)
    assert field.at(9000.0) == pytest.approx((0.0, -20.0, 0.0), abs=1e-12)


def test_profile_through_the_opposite_wind_has_no_jump():
    # From 0 to 180 deg an interpolated direction would have to choose a side; the components pass through calm.
    field = WindField([level(0, 8, 0), level(1000, 8, 180)])
    assert field.at(500.0) == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert field.at(501.0)[0] - field.at(499.0)[0] == pytest.approx(2 * 16.0 / 1000.0)


@pytest.mark.parametrize("heights", [(1000, 1000), (1000, 999)])
def test_levels_that_do_not_rise_are_refused(heights):
    with pytest.raises(InputError, match="heights that rise"):
        WindField([level(height, 5, 0) for height in heights])


def test_shear_on_a_profile_and_no_level_are_refused():
    with pytest.raises(InputError, match="put it into the levels"):
        WindField([level(0, 5, 0), level(1000, 5, 0)], exponent=0.1)
    with pytest.raises(InputError, match="no level"):
        WindField([])
