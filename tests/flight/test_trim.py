from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from aerosim.errors import InputError
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.limits import density
from aerosim.flight.trim import solve


def test_trim_is_that_of_the_coefficients(twin: Aircraft) -> None:
    # Solved by hand from the set: 4600 kg, 3000 m, 250 km/h, g 9.80665.  JSBSim's gravity there is 0.1 % weaker
    # and the Earth's curvature and rotation take another 0.1 % off the lift, worth 0.012 deg of alpha.
    trim = twin.start(math.radians(51.0), 0.2, 3000.0, math.radians(90.0), 250.0 / 3.6)
    assert math.degrees(trim.alpha) == pytest.approx(1.69, abs=0.02)
    assert math.degrees(trim.elevator) == pytest.approx(0.04, abs=0.02)
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


@pytest.mark.parametrize("height", [300.0, 3000.0, 6000.0])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.85])
def test_flies_hands_off_in_crosswind(folder: Path, height: float, share: float) -> None:
    aircraft = Aircraft(folder, 120.0)
    low, high = aircraft.limits.speed_range(height, 4600.0)
    fastest = min(high, 95.0)
    speed = low + share * (fastest - low)
    wind = (-12.0, 0.0, 0.0)
    aircraft.start(0.89, 0.2, height, math.radians(90.0), speed, wind)
    aircraft._set("ap/on", 0.0)
    begin = aircraft.state()
    assert begin.v_down == pytest.approx(0.0, abs=1e-9)
    for _ in range(30 * 120):
        aircraft.step(*wind, 0.0, 0.0, 0.0)
    now = aircraft.state()
    assert now.height == pytest.approx(height, abs=5.0)
    assert now.airspeed == pytest.approx(speed, abs=1.0)
    assert (now.lat - begin.lat) * 6.37e6 == pytest.approx(0.0, abs=5.0)
    assert abs(now.v_north) < 1.0


def test_too_little_power_is_refused(twin: Aircraft) -> None:
    with pytest.raises(InputError, match=r"too little power.*needs \d+ kW, has \d+ kW"):
        twin.start(0.9, 0.2, 7500.0, 0.0, 120.0)


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
