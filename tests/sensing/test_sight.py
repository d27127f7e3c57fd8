"""The navigator at the drift sight: how often, by how much and to which side he turns the camera."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from scipy.signal import lfilter

from aerosim.crew import DEGREE
from aerosim.sensing.sight import DriftSight, SightParameters
from aerosim.truth import AircraftState

PERIOD = 0.05
SPEED = 250.0 / 3.6
RUN_IN_S, LINE_S = 60.0, 12_000.0 / SPEED
GROUND, HEIGHT = 300.0, 3300.0
PERFECT = SightParameters(look=6.0, look_scatter=0.0, settle=0.0, track_sigma=0.0, reaction=0.0, vh_sigma=0.0)


def state(t=0.0, drift=0.0, heading=0.5, roll=0.0, speed=SPEED):
    track = heading + drift
    north, east = speed * math.cos(track), speed * math.sin(track)
    return AircraftState(t, 0.6, -1.4, HEIGHT, north, east, 0.0, roll, 0.0, heading, 0.0, 0.0, 0.0, SPEED)


class Seat:
    """A sight and a camera that goes at once where it is told; time runs on."""

    def __init__(self, parameters=PERFECT, seed=1):
        self.sight = DriftSight(parameters, PERIOD, np.random.default_rng(seed))
        self.yaw, self.t, self.told, self.tellings = 0.0, 0.0, None, 0

    def wait(self, seconds, **what):
        for _ in range(round(seconds / PERIOD)):
            told = self.sight.tell(state(self.t, **what), GROUND, self.yaw)
            if told is not None:
                self.told, self.yaw, self.tellings = told, told.drift, self.tellings + 1
            self.t += PERIOD


class Flown(NamedTuple):
    spoken: list[int]
    crab: np.ndarray  # deg


def fly_line(seed, wind, parameters):
    """A run-in and a line on the track, the nose turned into a crosswind (m/s each period)."""
    seat, crab = Seat(parameters, seed), []
    for across in wind.tolist():
        drift = math.asin(across / SPEED)
        seat.wait(PERIOD, drift=drift, heading=0.5 - drift)
        if seat.t > RUN_IN_S:
            crab.append(math.degrees(drift - seat.yaw))
    return Flown([order.degrees for order in seat.sight.orders if order.t > RUN_IN_S], np.array(crab))


@pytest.fixture(scope="module")
def lines():
    """48 lines in 8 m/s from the left and a wind that wanders by 1.5 m/s in 120 s."""
    rng, steps = np.random.default_rng(11), round((RUN_IN_S + LINE_S) / PERIOD)
    keep = math.exp(-PERIOD / 120.0)
    kicks = 1.5 * math.sqrt(1.0 - keep**2) * rng.standard_normal((48, steps))
    kicks[:, 0] = 1.5 * rng.standard_normal(48)
    winds = 8.0 + lfilter([1.0], [1.0, -keep], kicks, axis=1)
    return [fly_line(seed, wind, SightParameters()) for seed, wind in enumerate(winds)]


def test_corrections_are_as_many_and_as_large_as_the_paper_says(lines):
    # Schmelovsky (1988): on 12 km at 250 km/h three to four corrections of 2 to 3 deg.  The number scatters by 1.3
    # from line to line, the size by 0.6 deg: over 48 lines the means are known to 0.19 and to 0.05 deg, and have
    # to lie inside the paper's ranges.
    counts = np.array([len(line.spoken) for line in lines])
    sizes = np.abs([degrees for line in lines for degrees in line.spoken])
    assert 3.0 < counts.mean() < 4.0
    assert 2.0 < sizes.mean() < 3.0
    assert np.mean((sizes == 2) | (sizes == 3)) > 0.85
    signed = np.array([degrees for line in lines for degrees in line.spoken])
    assert abs(signed.mean()) < 3.0 * signed.std() / math.sqrt(len(signed))


def test_what_is_left_of_the_crab(lines):
    # Below 1.5 deg nothing is said, and a look errs by 1 deg: a residual of one to two degrees, to both sides.
    crab = np.concatenate([line.crab for line in lines])
    assert 0.8 < math.sqrt(np.mean(crab**2)) < 1.8
    # means of lines scatter by no more than the residual itself: 3 x 1.2/sqrt(48)
    assert abs(crab.mean()) < 0.55


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_turns_the_camera_after_the_track_in_whole_degrees(side):
    # Track to the right of the camera's axis: the camera is turned to the right, clockwise seen from above.
    seat = Seat()
    seat.wait(20.0, drift=side * 6.3 * DEGREE)
    assert [order.degrees for order in seat.sight.orders] == [side * 6]
    assert seat.yaw == pytest.approx(side * 6.0 * DEGREE)
    assert seat.told.drift == seat.yaw
    # the 0.3 deg that are left are not worth a word
    seat.wait(100.0, drift=side * 6.3 * DEGREE)
    assert len(seat.sight.orders) == 1


@pytest.mark.parametrize(
    ("crab_deg", "spoken"), [(1.4, []), (1.6, [2]), (-1.4, []), (-1.6, [-2]), (14.0, [10, 4])]
)
def test_smallest_and_largest_correction(crab_deg, spoken):
    seat = Seat()
    seat.wait(40.0, drift=crab_deg * DEGREE)
    assert [order.degrees for order in seat.sight.orders] == spoken


def test_camera_turns_after_the_word_and_the_next_look_waits():
    seat = Seat(replace(PERFECT, reaction=3.0, settle=50.0))
    while not seat.sight.orders:
        seat.wait(PERIOD, drift=5.0 * DEGREE)
    while seat.yaw == 0.0:
        seat.wait(PERIOD, drift=5.0 * DEGREE)
    assert seat.t - seat.sight.orders[0].t == pytest.approx(3.0, abs=2.1 * PERIOD)
    while len(seat.sight.orders) < 2:
        seat.wait(PERIOD, drift=9.0 * DEGREE)
    assert seat.sight.orders[1].t - seat.sight.orders[0].t == pytest.approx(56.0, abs=2.1 * PERIOD)


def test_sees_the_mean_of_the_last_seconds():
    # Yawing by +-4 deg in 1 s: the mean over 5 s lets 1/sqrt(1 + (2 pi 5)^2) of it through, 0.13 deg.
    seat = Seat(replace(PERFECT, look=9.7))
    for k in range(round(200.0 / PERIOD)):
        seat.wait(PERIOD, drift=(1.3 + 4.0 * math.sin(2.0 * math.pi * k * PERIOD)) * DEGREE)
    assert not seat.sight.orders


def test_does_not_look_in_a_bank_and_begins_anew_on_another_heading():
    seat = Seat()
    seat.wait(30.0, drift=5.0 * DEGREE)
    assert seat.yaw == pytest.approx(5.0 * DEGREE)
    said = len(seat.sight.orders)
    seat.wait(60.0, drift=-9.0 * DEGREE, roll=math.radians(20.0))
    assert len(seat.sight.orders) == said
    seat.wait(1.0, drift=-5.0 * DEGREE, heading=0.5 + math.pi)
    assert seat.yaw == 0.0  # he does not know the drift of this line
    seat.wait(30.0, drift=-5.0 * DEGREE, heading=0.5 + math.pi)
    assert seat.yaw == pytest.approx(-5.0 * DEGREE)


def test_a_gust_that_banks_is_no_turn():
    seat = Seat()
    seat.wait(30.0, drift=5.0 * DEGREE)
    seat.wait(1.0, drift=5.0 * DEGREE, roll=math.radians(7.0))
    seat.wait(30.0, drift=5.0 * DEGREE)
    assert seat.yaw == pytest.approx(5.0 * DEGREE)
    assert len(seat.sight.orders) == 1


def test_a_camera_that_does_not_follow_is_not_turned_further():
    sight = DriftSight(PERFECT, PERIOD, np.random.default_rng(1))
    for k in range(round(120.0 / PERIOD)):
        sight.tell(state(PERIOD * k, drift=5.0 * DEGREE), GROUND, 0.0)
    assert [order.degrees for order in sight.orders] == [5]


def test_v_over_h_is_read_at_the_looks_and_smoothed():
    seat = Seat(replace(PERFECT, vh_weight=0.5))
    seat.wait(7.9)
    assert not seat.told.valid
    seat.wait(0.3)
    assert seat.told.valid
    assert seat.told.vh == pytest.approx(SPEED / (HEIGHT - GROUND))
    assert math.isnan(seat.told.sigma_vh)
    assert math.isnan(seat.told.sigma_drift)
    # A reading of 10 % more, half of it taken each 6 s; the mean of 5 s lags.
    seat.wait(62.0, speed=1.1 * SPEED)
    assert seat.told.vh == pytest.approx(1.1 * SPEED / (HEIGHT - GROUND), rel=1e-3)
    assert seat.tellings == 1 + 1 + 10  # the line's beginning, and each look


def test_errors_of_a_reading_of_v_over_h():
    # Readings err by s, each taken by half: s sqrt(0.5/1.5) in the end.  2000 looks, correlated over two: the
    # standard deviation within 4/sqrt(2000).
    seat, found = Seat(replace(PERFECT, look=4.0, vh_sigma=0.03)), []
    for _ in range(2000):
        seat.wait(4.0)
        found.append(seat.told.vh)
    assert np.std(found[10:]) / (SPEED / (HEIGHT - GROUND)) == pytest.approx(0.03 / math.sqrt(3.0), rel=0.09)


def test_same_generator_same_navigator():
    def orders(seed):
        seat = Seat(SightParameters(), seed)
        for k in range(round(200.0 / PERIOD)):
            seat.wait(PERIOD, drift=(4.0 + 0.03 * k * PERIOD) * DEGREE)
        return list(seat.sight.orders)

    assert orders(1) == orders(1) != orders(2)


def test_section_has_the_same_defaults():
    from aerosim.scenario.navigator import SightNavigator

    section, parameters = SightNavigator(), SightParameters()
    assert math.radians(section.track_sigma_deg) == pytest.approx(parameters.track_sigma)
    assert section.look_scatter_pct / 100.0 == pytest.approx(parameters.look_scatter)
    assert section.vh_sigma_pct / 100.0 == pytest.approx(parameters.vh_sigma)
    assert section.vh_weight_pct / 100.0 == pytest.approx(parameters.vh_weight)
    assert (section.look_s, section.settle_s, section.average_s, section.least_deg, section.reaction_s) == (
        parameters.look, parameters.settle, parameters.average, parameters.least, parameters.reaction,
    )  # fmt: skip


def test_a_look_over_no_land_turns_the_camera_and_reads_no_v_over_h():
    """A run-in that starts outside of the terrain: the angle is seen all the same, v/h once there is land."""
    seat = Seat()
    for _ in range(round(20.0 / PERIOD)):
        told = seat.sight.tell(state(seat.t, drift=math.radians(8.0)), math.nan, seat.yaw)
        if told is not None:
            seat.told, seat.yaw = told, told.drift
        seat.t += PERIOD
    assert seat.told.valid
    assert math.degrees(seat.yaw) == pytest.approx(8.0)
    assert math.isnan(seat.told.vh)
    seat.wait(10.0, drift=math.radians(8.0))
    assert seat.told.vh == pytest.approx(SPEED / (HEIGHT - GROUND))
