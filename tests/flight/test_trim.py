from __future__ import annotations

import math
import re

import numpy as np
import pytest

from aerosim.errors import InputError
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.limits import density
from aerosim.flight.trim import Trim, solve

from .made import TABLES, aircraft, linear


def test_trim_is_that_of_the_coefficients(twin: Aircraft) -> None:
    # Solved by hand from the set: 4600 kg, 3000 m, 250 km/h, g 9.80665.  JSBSim's gravity there is 0.1 % weaker
    # and the Earth's curvature and rotation take another 0.1 % off the lift, worth 0.012 deg of alpha.
    trim = twin.start(math.radians(51.0), 0.2, 3000.0, math.radians(90.0), 250.0 / 3.6)
    assert math.degrees(trim.alpha) == pytest.approx(1.69, abs=0.02)
    assert math.degrees(trim.elevator) == pytest.approx(0.04, abs=0.02)
    assert abs(trim.sideslip) < 1e-5
    assert trim.lift == pytest.approx(0.528, rel=0.007)
    assert trim.thrust == pytest.approx(4815.0, rel=0.003)
    assert trim.power == pytest.approx(334e3 / 0.84, rel=0.005)
    assert trim.power_available == pytest.approx(924e3 * (0.9091 / 1.225) ** 0.7, rel=0.002)


def test_bank_holds_the_course_on_a_turning_earth(twin: Aircraft) -> None:
    # Coriolis 2 Omega V sin(lat) to the right, and the track's curvature against the meridians to the left on an
    # easterly course: both are balanced by bank.
    lat, speed = math.radians(51.0), 69.44
    trim = twin.start(lat, 0.2, 3000.0, 0.0, speed)
    push = 2.0 * 7.292115e-5 * speed * math.sin(lat)
    assert trim.roll == pytest.approx(-push / 9.80, rel=0.02)


def fastest(plane: Aircraft, height: float) -> float:
    """The fastest airspeed (m/s) that limits and power leave, to 1 m/s, less 5 % for the wind."""
    low, high = plane.limits.speed_range(height, plane.limits.mass_empty_kg + plane.fuel)
    for speed in np.arange(high, low, -1.0):
        try:
            plane.start(0.89, 0.2, height, 0.0, float(speed))
        except InputError:
            continue
        return 0.95 * float(speed)
    raise AssertionError("nothing can be flown at this height")


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("share", [0.02, 0.2, 0.4, 0.6, 0.8, 0.96])
def test_flies_hands_off_in_crosswind(name: str, share: float) -> None:
    # Six heights, five speeds each: autopilot off for half a minute in 12 m/s across the course.
    plane = aircraft(name)
    height = plane.limits.height_min_m + share * (plane.limits.height_max_m - plane.limits.height_min_m)
    low, _ = plane.limits.speed_range(height, TABLES[name].mass.total_kg)
    wind = (-12.0, 0.0, 0.0)
    for speed in np.linspace(low, fastest(plane, height), 5):
        plane = aircraft(name)
        plane.start(0.89, 0.2, height, math.radians(90.0), float(speed), wind)
        plane._set("ap/on", 0.0)
        begin = plane.state()
        assert begin.v_down == pytest.approx(0.0, abs=1e-9)
        plane.advance(30 * 120)
        now = plane.state()
        assert now.height == pytest.approx(height, abs=5.0)
        assert now.airspeed == pytest.approx(speed, abs=1.0)
        assert (now.lat - begin.lat) * 6.37e6 == pytest.approx(0.0, abs=5.0)
        assert abs(now.v_north) < 1.0


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_newton_finds_every_trim_of_the_envelope(name: str, share: float) -> None:
    # Light and heavy, up and down, corner to corner: refused only for want of power, and that with its figures.
    limits = aircraft(name).limits
    fuel = 5.0 + share * (limits.fuel_max_kg - 5.0)
    found, refused = 0, []
    for height in np.linspace(limits.height_min_m, limits.height_max_m, 6):
        low, high = limits.speed_range(height, limits.mass_empty_kg + fuel)
        for speed in np.linspace(low + 1e-6, high - 1e-6, 6):
            plane = aircraft(name, fuel)
            try:
                trim = plane.start(0.5, 0.2, float(height), 2.0, float(speed), (9.0, -8.0, -1.0))
            except InputError as refusal:
                refused.append(str(refusal))
            else:
                found += 1
                assert trim.iterations < 15
    assert found > 15
    assert all(re.search(r"too little power .*needs \d+ kW, has \d+ kW", text) for text in refused)


def test_quoted_trim_of_the_beaver() -> None:
    # AlviPat9's launcher example of LR-556: 35 m/s, 1800 rpm, 20 inHg, at sea level: alpha, theta, elevator,
    # aileron, rudder, sideslip.  First what the set itself gives, solved outside this project; then as quoted;
    # the set misses its aileron and sideslip by 0.0015 and 0.0029 rad.
    by_hand = (0.2113, 0.1919, -0.0931, 0.0081, -0.0492, -0.0177)
    quoted = (0.2110, 0.1919, -0.0931, 0.0096, -0.0495, -0.0206)
    power = 1e3 * 0.7355 * (-326.5 + 0.00412 * (20.0 + 7.4) * (1800.0 + 2010.0))
    found = linear.powered_trim(linear.Body(TABLES["beaver"], 1.225, 9.80665), 35.0, power)
    values = (found.alpha, found.pitch, found.controls.elevator, found.controls.aileron, found.controls.rudder)
    assert (*values, found.beta) == pytest.approx(by_hand, abs=6e-5)
    assert (*values, found.beta) == pytest.approx(quoted, abs=0.003)


def test_quoted_trim_of_the_beaver_in_the_running_model() -> None:
    # At that power it sinks at 0.67 m/s: in air that rises as fast the same flight is level, as every start is.
    power = 1e3 * 0.7355 * (-326.5 + 0.00412 * (20.0 + 7.4) * (1800.0 + 2010.0))

    def trim_in(rising: float) -> Trim:
        return aircraft("beaver").start(0.9, 0.2, 0.0, 0.0, 35.0, (0.0, 0.0, -rising))

    slow, fast = 0.0, 1.0
    for _ in range(6):  # secant
        change = trim_in(fast).power - trim_in(slow).power
        slow, fast = fast, fast + (fast - slow) * (power - trim_in(fast).power) / change
        if abs(fast - slow) < 1e-5:
            break
    trim = trim_in(fast)
    assert trim.power == pytest.approx(power, rel=1e-4)
    assert fast / 35.0 == pytest.approx(math.sin(0.2113 - 0.1919), abs=2e-4)
    found = (trim.alpha, trim.pitch, trim.elevator, trim.aileron, trim.rudder, trim.sideslip)
    assert found == pytest.approx((0.2113, 0.1919, -0.0931, 0.0081, -0.0492, -0.0177), abs=5e-4)


def test_ball_is_centred_and_wings_level() -> None:
    # The propeller's swirl asks for rudder and sideslip, not for bank: that is left to the Earth's rotation.
    # Eastward: Coriolis, and the track's curvature against the meridian.
    lat, speed = math.radians(51.0), 60.0
    trim = aircraft("beaver").start(lat, 0.2, 3000.0, math.radians(90.0), speed)
    push = 2.0 * 7.292115e-5 * speed * math.sin(lat) + speed**2 * math.tan(lat) / 6.394e6
    assert trim.roll == pytest.approx(-push / 9.80, rel=0.02)
    assert trim.sideslip < -0.008
    assert trim.rudder < -0.03


@pytest.mark.parametrize(("name", "height", "speed"), [("survey_twin", 7500.0, 120.0), ("beech_99", 7500.0, 170.0),
                                                      ("beaver", 4900.0, 70.0)])  # fmt: skip
def test_too_little_power_is_refused(name: str, height: float, speed: float) -> None:
    with pytest.raises(InputError, match=r"too little power.*needs \d+ kW, has \d+ kW"):
        aircraft(name).start(0.9, 0.2, height, 0.0, speed)


def test_standard_atmosphere() -> None:
    # US Standard Atmosphere 1976, table 1.
    assert density(0.0) == pytest.approx(1.2250, abs=1e-4)
    assert density(3000.0) == pytest.approx(0.90925, abs=3e-4)
    assert density(6000.0) == pytest.approx(0.66011, abs=6e-4)


def test_newton_finds_a_root_and_says_when_there_is_none() -> None:
    root, iterations = solve(lambda x: np.array([x[0] ** 2 - 2.0]), np.array([1.0]), np.array([1.0]))
    assert root[0] == pytest.approx(math.sqrt(2.0), abs=1e-9)
    assert 1 < iterations < 10
    with pytest.raises(InputError, match="no steady level flight"):
        solve(lambda x: np.array([x[0] ** 2 + 1.0]), np.array([1.0]), np.array([1.0]))
