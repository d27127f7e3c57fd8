"""Satellite track less inertial heading: what each error does to drift, crab and v/h."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerosim.sensing.fix import FixParameters, SatelliteCompass
from aerosim.truth import AircraftState

EXACT = FixParameters(0.6, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
PERIOD, GROUND = 0.05, 300.0


def state(t=0.0, heading_deg=30.0, track_deg=38.0, speed=70.0, height=3300.0):
    track = math.radians(track_deg)
    north, east = speed * math.cos(track), speed * math.sin(track)
    return AircraftState(
        t, 0.6, -1.4, height, north, east, 1.0, 0.02, 0.03, math.radians(heading_deg), 0, 0, 0, 69.0
    )


def device(seed=1, **changes):
    return SatelliteCompass(EXACT._replace(**changes), GROUND, np.random.default_rng(seed))


def told(made, states):
    """What it tells of each state, without the moments of nothing new."""
    found = [made.tell(each, 9999.0, 9.0) for each in states]  # neither land nor mount are known to it
    return [each for each in found if each is not None]


def steady(count, **what):
    return [state(PERIOD * k, **what) for k in range(count)]


@pytest.mark.parametrize(
    ("heading", "track", "drift"), [(80, 90, 10), (90, 80, -10), (179, -179, 2), (1, 359, -2), (360, 5, 5)]
)
def test_without_errors_it_tells_the_truth(heading, track, drift):
    (found,) = told(device(), steady(1, heading_deg=heading, track_deg=track))
    assert math.degrees(found.drift) == pytest.approx(drift, abs=1e-9)
    assert found.vh == pytest.approx(70.0 / 3000.0)
    assert found.valid
    assert (found.sigma_drift, found.sigma_vh) == (0.0, 0.0)


@pytest.mark.parametrize("yaw_deg", [0.5, -0.5])
def test_camera_turned_against_the_unit_leaves_crab(yaw_deg):
    # The unit points to the left of the camera that is turned right against it: the mount turns too far to the
    # right, by as much.  crab = drift - mount yaw = -boresight.
    (found,) = told(device(boresight_yaw=math.radians(yaw_deg)), steady(1))
    crab = 8.0 - math.degrees(found.drift)
    assert crab == pytest.approx(-yaw_deg, abs=1e-9)


def test_heading_that_drifts_grows_into_crab():
    sigma, ends = math.radians(6.0) / 3600.0, []
    for seed in range(400):
        made = device(seed, heading_drift=sigma)
        first, hour = told(made, [state(0.0), state(3600.0)])
        assert math.degrees(first.drift) == pytest.approx(8.0, abs=1e-9)
        ends.append(math.degrees(hour.drift) - 8.0)
    # 6 deg/h for an hour; standard deviation of 400 draws within 4/sqrt(800)
    assert np.std(ends) == pytest.approx(6.0, rel=4.0 / math.sqrt(800.0))
    assert abs(np.mean(ends)) < 4.0 * 6.0 / math.sqrt(400.0)


def test_noise_of_velocity_turns_the_track():
    # sigma across the track over the speed: 0.3/70 rad = 0.2455 deg; along it, v/h.  10 000 fixes.
    found = told(device(velocity_sigma=0.3, period=0.05, heading_period=0.05), steady(10_000))
    drift, vh = np.array([each.drift for each in found]), np.array([each.vh for each in found])
    bound = 4.0 / math.sqrt(20_000.0)
    assert drift.std() == pytest.approx(0.3 / 70.0, rel=bound)
    assert vh.std() == pytest.approx(0.3 / 3000.0, rel=bound)
    assert drift.mean() == pytest.approx(math.radians(8.0), abs=4.0 * 0.3 / 70.0 / 100.0)
    assert abs(np.corrcoef(drift[1:], drift[:-1])[0, 1]) < 4.0 / 100.0
    # what it states of itself is its white noise
    assert found[0].sigma_drift == pytest.approx(0.3 / 70.0, rel=0.02)
    assert found[0].sigma_vh == pytest.approx(0.3 / 3000.0, rel=0.02)


def test_noise_of_the_heading_and_of_the_height():
    found = told(device(heading_sigma=2e-3, height_sigma=9.0, heading_period=0.05, period=0.05), steady(10_000))
    bound = 4.0 / math.sqrt(20_000.0)
    assert np.std([each.drift for each in found]) == pytest.approx(2e-3, rel=bound)
    assert np.std([each.vh for each in found]) / (70.0 / 3000.0) == pytest.approx(9.0 / 3000.0, rel=bound)
    assert found[0].sigma_drift == 2e-3
    assert found[0].sigma_vh == pytest.approx(70.0 / 3000.0 * 9.0 / 3000.0, rel=0.02)


def test_relief_is_not_known():
    # Over land 300 m higher than planned v/h is told as planned, 10 % too small.
    (found,) = told(device(), steady(1))
    assert found.vh / (70.0 / 2700.0) == pytest.approx(0.9)


def test_periods():
    found = told(device(period=0.6, heading_period=0.1), steady(600))
    assert np.diff([each.t for each in found]) == pytest.approx(0.1)
    # a track that turns by 1 deg a period: it is taken over at each fix, the heading at each reading
    states = [state(PERIOD * k, track_deg=38.0 + k) for k in range(48)]
    found = told(device(), states)
    kept = [38.0 + 12 * (k // 6) for k in range(len(found))]
    assert [math.degrees(each.drift) + 30.0 for each in found] == pytest.approx(kept)


def test_heading_goes_on_between_the_fixes():
    states = [state(PERIOD * k, heading_deg=30.0 + 0.1 * k) for k in range(12)]
    found = told(device(), states)
    assert [math.degrees(each.drift) for each in found] == pytest.approx([8.0 - 0.2 * k for k in range(6)])


def test_delay_of_the_fix():
    # 0.25 s after the fix: nothing is told before, and the track is that of the fix, the heading that of now.
    states = [state(PERIOD * k, track_deg=38.0 + k, heading_deg=30.0 + k) for k in range(30)]
    found = told(device(period=0.2, delay=0.25), states)
    assert found[0].t == pytest.approx(0.3)  # headings come each 0.1 s
    for each in found:
        newest = math.floor((each.t - 0.25 + 1e-6) / 0.2) * 0.2
        assert math.degrees(each.drift) == pytest.approx(8.0 + (newest - each.t) / PERIOD)


def test_same_generator_same_errors():
    noisy = {"velocity_sigma": 0.1, "height_sigma": 3.0, "heading_sigma": 1e-3, "heading_drift": 1e-6}
    first, again, other = (told(device(seed, **noisy), steady(600)) for seed in (5, 5, 6))
    assert first == again != other
