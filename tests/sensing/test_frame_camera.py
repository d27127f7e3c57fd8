"""The shutter: first photo, spacing, delay, and the pose in the middle of the exposure."""

import math

import numpy as np
import pytest

from aerosim.sensing.frame_camera import FrameCamera, ShutterParameters
from aerosim.sensing.mount import Mount, MountParameters
from aerosim.signals import CameraCommand
from aerosim.truth import AircraftState

DT = 1.0 / 120.0
SPEED, TURN = 70.0, 0.02
LAG = 0.05 + 0.003 / 2.0


def state(t):
    """Flying north at 70 m/s from latitude 0.6, nose turning at 0.02 rad/s; and the meridian's radius up there."""
    sin2 = math.sin(0.6) ** 2
    e2 = 0.00669437999014
    radius = 6378137.0 * (1.0 - e2) / (1.0 - e2 * sin2) ** 1.5 + 3000.0
    lat = 0.6 + SPEED * t / radius
    return AircraftState(t, lat, 0.1, 3000.0, SPEED, 0.0, 0.0, 0.0, 0.0, TURN * t, 0.0, 0.0, TURN, SPEED), radius


def fly(duration, interval, line=lambda t: 0, delay=0.05, exposure=0.003):
    """Shots of a flight.  interval, line: functions of time."""
    camera = FrameCamera(ShutterParameters(exposure, delay), DT)
    mount = Mount(MountParameters(0.5, 1.0, 0.1, 0.0, 0.0), DT, np.random.default_rng(1))
    shots = []
    for step in range(round(duration / DT)):
        t = step * DT
        command = CameraCommand(0.0, interval(t), 0.02 + 0.001 * t)
        if camera.step(t, line(t), command):
            shots.append(camera.expose(state(t)[0], mount))
            assert t - 1e-9 <= shots[-1].pose.t < t + DT
    return shots


def times(shots):
    return np.array([shot.pose.t for shot in shots])


def on(*lines):
    """Line number by time: (number, start, end), start and end on the grid of steps."""
    return lambda t: next((n for n, a, b in lines if a - 1e-9 <= t < b - 1e-9), -1)


def test_compensation_is_no_faster_than_the_camera_can():
    camera = FrameCamera(ShutterParameters(0.003, 0.05, fmc_limit=0.021), DT)
    mount = Mount(MountParameters(0.5, 1.0, 0.1, 0.0, 0.0), DT, np.random.default_rng(1))
    # 0.02 rad/s before 5 s, 0.03 after; 2 s from photo to photo
    rates = [
        camera.expose(state(step * DT)[0], mount).fmc_rate
        for step in range(round(10.0 / DT))
        if camera.step(step * DT, 0, CameraCommand(0.0, 2.0, 0.02 if step * DT < 5.0 else 0.03))
    ]
    assert rates == [0.02, 0.02, 0.02, 0.021, 0.021]


@pytest.mark.parametrize("start", [0.0, 2.0, 125 * DT])
def test_first_photo_is_at_the_start_of_the_line(start):
    shots = fly(10.0, lambda t: 4.0, on((3, start, 99.0)))
    assert shots[0].pose.t == pytest.approx(start + LAG, abs=1e-9)
    assert shots[0].line == 3


@pytest.mark.parametrize("interval", [2.0, 4.123, 13.33333])
def test_spacing_is_the_interval_though_it_is_no_multiple_of_the_step(interval):
    found = times(fly(60.0, lambda t: interval))
    assert len(found) == math.floor((60.0 - LAG) / interval) + 1
    assert found == pytest.approx(LAG + interval * np.arange(len(found)), abs=1e-6)


def test_an_interval_that_changes_counts_by_its_share():
    # Half of 5 s, then half of 3 s: 4 s; from then on 3 s.
    found = times(fly(20.0, lambda t: 5.0 if t < 2.5 - 1e-9 else 3.0))
    assert found - LAG == pytest.approx([0.0, 4.0, 7.0, 10.0, 13.0, 16.0, 19.0], abs=1e-6)


def test_an_interval_that_wanders_is_integrated():
    # The photos lie where the integral of dt/interval is whole; the command is held over a step, which leaves
    # half a step of slope, (dI/dt) dt/2 < 1 ms.
    def interval(t):
        return 4.0 + 1.0 * math.sin(0.3 * t)

    found = times(fly(120.0, interval)) - LAG
    t = np.linspace(0.0, 120.0, 1_200_001)
    count = np.concatenate([[0.0], np.cumsum(1.0 / (4.0 + np.sin(0.3 * (t[1:] + t[:-1]) / 2.0))) * 1e-4])
    assert found == pytest.approx(np.interp(np.arange(len(found)), count, t), abs=2e-3)


def test_none_off_the_lines_and_each_line_begins_anew():
    shots = fly(60.0, lambda t: 4.0, on((0, 3.0, 16.0), (1, 30.0, 39.0), (2, 39.0, 45.0)))
    expected = {0: [3, 7, 11, 15], 1: [30, 34, 38], 2: [39, 43]}
    for line, starts in expected.items():
        found = times([shot for shot in shots if shot.line == line])
        assert found - LAG == pytest.approx(starts, abs=1e-6)
    assert len(shots) == 9


def test_a_photo_triggered_in_the_line_is_taken_though_the_shutter_opens_behind_it():
    shots = fly(10.0, lambda t: 4.0, on((5, 1.0, 1.0 + DT)), delay=0.5)
    assert [(shot.line, round(shot.pose.t, 9)) for shot in shots] == [(5, 1.5015)]


def test_delays_longer_than_the_interval_do_not_lose_photos():
    found = times(fly(10.0, lambda t: 0.4, delay=1.0))
    assert found == pytest.approx(1.0015 + 0.4 * np.arange(len(found)), abs=1e-6)
    assert len(found) == 23


def test_pose_is_that_of_the_middle_of_the_exposure():
    shots = fly(30.0, lambda t: 4.123, exposure=0.02)
    assert len(shots) == 8
    for k, shot in enumerate(shots):
        middle = 4.123 * k + 0.05 + 0.01
        assert shot.pose.t == pytest.approx(middle, abs=1e-6)
        wanted, radius = state(middle)
        # a step of flight is 0.58 m, a step of turn 1.7e-4 rad
        assert (shot.pose.lat - wanted.lat) * radius == pytest.approx(0.0, abs=1e-4)
        heading = math.atan2(shot.pose.mat_nc[1, 0], shot.pose.mat_nc[0, 0])
        assert heading == pytest.approx(wanted.heading, abs=1e-7)


def test_what_was_commanded_at_the_trigger_goes_with_the_photo():
    shots = fly(20.0, lambda t: 4.0 if t < 8.5 else 6.0, delay=1.0)
    assert [shot.interval for shot in shots] == [4.0, 4.0, 4.0, 6.0]
    triggers = times(shots) - 1.0015
    assert [shot.fmc_rate for shot in shots] == pytest.approx(0.02 + 0.001 * triggers, abs=1e-5)


@pytest.mark.parametrize("delay", [0.0, 0.05, 1.0])
def test_control_ticks_of_several_steps_give_the_same_photos(delay):
    # As the loop runs it: a command each sixth step, stops in between only where a photo is due.
    camera = FrameCamera(ShutterParameters(0.003, delay), DT)
    mount = Mount(MountParameters(0.5, 1.0, 0.1, 0.0, 0.0), DT, np.random.default_rng(1))

    def interval(t):
        return 2.5 + 0.5 * math.sin(0.3 * (round(t / DT) // 6) * 6 * DT)

    line = on((0, 1.0, 30.0), (1, 35.0, 50.0))
    found, step = [], 0
    while step < 60 * 120:
        t = step * DT
        if step % 6 == 0:
            camera.step(t, line(t), CameraCommand(0.0, interval(t), 0.0), 6 * DT)
        if camera.due(t):
            found.append(camera.expose(state(t)[0], mount))
            assert t - 1e-9 <= found[-1].pose.t < t + DT
        step += max(1, min(6 - step % 6, camera.steps_to_next(t)))
    expected = fly(60.0, interval, line, delay)
    assert len(found) > 15
    assert [shot.line for shot in found] == [shot.line for shot in expected]
    assert times(found) == pytest.approx(times(expected), abs=1e-6)
