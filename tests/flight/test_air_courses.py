"""The same turbulence rolls the aircraft the same on every course, whatever the wind's direction.

JSBSim's own turbulence fails this: the roll it makes depends on the angles between course, wind and north.
"""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import butter, sosfiltfilt

from aerosim.flight.aircraft import Aircraft
from aerosim.flight.jsbsim_flight import JsbsimFlight
from aerosim.flight.plan import FlightPlan
from aerosim.rng import generator
from aerosim.world.air import AIR_RATE_HZ
from aerosim.world.atmosphere import make_air
from aerosim.world.turbulence import Turbulence
from aerosim.world.wind import steady_wind

from .conftest import AIRSPEED, HEIGHT, line_of

COURSES = (0.0, 90.0, 180.0, 270.0)
RATE, HOLD, EVERY = 120.0, 3, 12
SETTLED = 60.0


def rolls(folder: Path, course: float, seed: int, duration: float, wind: float) -> NDArray[np.float64]:
    """Roll every 0.1 s, deg, after the first minute, in sigma 1.4 m/s and a north wind."""
    aircraft = Aircraft(folder, RATE)
    assert round(RATE / AIR_RATE_HZ) == HOLD
    air = make_air(
        wind=steady_wind(wind, 0.0),
        origin=(0.89, 0.23),
        height=HEIGHT,
        airspeed=AIRSPEED,
        span=aircraft.span,
        dt=HOLD / RATE,
        rng_of=partial(generator, seed),
        turbulence=Turbulence.equal("dryden", 1.4, 533.4),
    )
    line = line_of(course, (duration + 60.0) * (AIRSPEED + wind))
    flight = JsbsimFlight(aircraft, FlightPlan([line], HEIGHT, AIRSPEED, run_in_s=0.0), air, HOLD)
    found = []
    for _ in range(round(duration * RATE / EVERY)):
        flight.advance(EVERY)
        found.append(flight.aircraft.attitude()[0])
    return np.degrees(found[round(SETTLED * RATE / EVERY) :])


def test_same_gusts_roll_the_same_on_every_course(folder: Path) -> None:
    # Gusts come in body axes, so with one seed all courses meet the same.  In still air only the Earth's rotation
    # tells them apart.
    histories = [rolls(folder, course, 5, 180.0, 0.0) for course in COURSES]
    rms = float(np.sqrt(np.mean(histories[0] ** 2)))
    assert rms > 0.3
    for each in histories[1:]:
        assert np.std(each - histories[0]) < 0.002 * rms


def test_the_winds_direction_does_not_change_what_gusts_do(folder: Path) -> None:
    # A wind of 10 m/s from the north is met from ahead, from both sides and from behind.  It changes how the line
    # is held, slowly; above 0.15 Hz the gusts alone roll the aircraft.
    fast = butter(4, 0.15, "high", output="sos", fs=RATE / EVERY)
    histories = [sosfiltfilt(fast, rolls(folder, course, 5, 180.0, 10.0)) for course in COURSES]
    for each in histories[1:]:
        assert np.std(each - histories[0]) < 0.02 * np.std(histories[0])


def test_other_gusts_roll_as_much_on_every_course(folder: Path) -> None:
    # Other seeds: rms of 540 s each.  Bartlett: the relative variance of a mean square over D seconds is
    # 2/D int rho^2 dtau over both sides, so that D/int rho^2 independent samples count; rho of the roll itself,
    # from all four courses, up to 30 s (it gives 280).  The rms has half the sd of the mean square, 4.2 %.
    histories = [rolls(folder, course, 20 + index, 600.0, 10.0) for index, course in enumerate(COURSES)]
    rms = np.array([np.sqrt(np.mean(each**2)) for each in histories])
    size = len(histories[0])
    lags = [
        np.fft.irfft(np.abs(np.fft.rfft(each, 2 * size)) ** 2)[:300] / np.arange(size, size - 300, -1)
        for each in histories
    ]
    rho = np.mean(lags, axis=0) / np.mean(lags, axis=0)[0]
    samples = 540.0 / (0.1 * (2.0 * (rho**2).sum() - 1.0))
    assert samples > 100.0
    sd = 0.5 * math.sqrt(2.0 / samples)
    assert rms / rms.mean() == pytest.approx(np.ones(4), abs=4.0 * sd)
    assert 4.0 * sd < 0.25
