"""The mount: sign of its yaw, delay, lag, limits, encoder, and the camera's pose against other libraries."""

import math

import numpy as np
import pytest
from pyproj import Transformer
from scipy.spatial.transform import Rotation

from aerosim.sensing.mount import Mount, MountParameters
from aerosim.truth import AircraftState

DT = 1.0 / 120.0
INF = math.inf


def mount(yaw_limit=INF, rate_limit=INF, time_constant=0.0, delay=0.0, encoder_sigma=0.0, level_pitch=0.0, seed=1):
    parameters = MountParameters(yaw_limit, rate_limit, time_constant, delay, encoder_sigma, level_pitch)
    return Mount(parameters, DT, np.random.default_rng(seed))


def aircraft(**changes):
    level = AircraftState(5.0, 0.64, -1.47, 3200.0, 40.0, 55.0, -1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 70.0)
    return level._replace(**changes)


def yaws(device, command, steps):
    """Yaw at the end of each step."""
    found = []
    for _ in range(steps):
        device.step(command)
        found.append(device.yaw)
    return np.array(found)


def attitude(state, level, yaw):
    """mat_nc, by another library: heading, pitch, roll about axes that turn along, then the mount's two."""
    nb = Rotation.from_euler("ZYX", [state.heading, state.pitch, state.roll])
    return nb * Rotation.from_euler("YZ", [level, yaw])


def test_positive_yaw_is_clockwise_seen_from_above():
    device = mount()
    device.step(math.radians(90.0))
    ahead, right, axis = device.pose(aircraft()).mat_nc.T
    # The aircraft flies north: the camera's front edge is to the east, its right edge to the south.
    assert ahead == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    assert right == pytest.approx([-1.0, 0.0, 0.0], abs=1e-12)
    assert axis == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)


@pytest.mark.parametrize("steps", [0, 1, 6])
def test_nothing_moves_before_the_delay_and_all_after_it(steps):
    device = mount(delay=steps * DT)
    found = yaws(device, 0.2, steps + 2)
    # A command given at t = 0 acts from the delay on: it is seen at the end of the step that begins then.
    assert found == pytest.approx([0.0] * steps + [0.2, 0.2])


def test_lag_is_exponential():
    lag, delay = 0.1, 0.05
    device = mount(time_constant=lag, delay=delay)
    found = yaws(device, 0.3, 120)
    t = DT * np.arange(1, 121)
    expected = np.where(t > delay, 0.3 * (1.0 - np.exp(-(t - delay) / lag)), 0.0)
    assert found == pytest.approx(expected, abs=1e-12)


def test_rate_limit():
    rate = math.radians(10.0)
    device = mount(rate_limit=rate, time_constant=0.05)
    found = yaws(device, -math.radians(20.0), 360)
    moves = np.diff([0.0, *found])
    assert np.abs(moves).max() == pytest.approx(rate * DT)
    # At full rate until the lag asks for less, T times the rate (and half a step) before the end.
    ramp = int((math.radians(20.0) / rate - 0.05) / DT) - 2
    assert found[:ramp] == pytest.approx(-rate * DT * np.arange(1, ramp + 1))
    assert found[-1] == pytest.approx(-math.radians(20.0), abs=1e-6)


def test_several_steps_at_once():
    one, many = (mount(rate_limit=0.2, time_constant=0.1, delay=0.05) for _ in range(2))
    for command, steps in ((0.1, 6), (-0.05, 1), (0.3, 15), (0.0, 6)):
        yaws(one, command, steps)
        many.advance(command, steps)
        assert (many.yaw, many.rate) == (one.yaw, one.rate)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_stop(side):
    device = mount(yaw_limit=math.radians(30.0), time_constant=0.02)
    found = side * yaws(device, side * math.radians(60.0), 240)
    assert found.max() <= math.radians(30.0)
    assert found[-1] == pytest.approx(math.radians(30.0), abs=1e-9)
    # off the stop again at once: what was asked beyond it is not stored
    device.step(0.0)
    assert side * device.yaw < math.radians(30.0) * 0.7


def test_rate_is_the_yaws():
    device = mount(rate_limit=math.radians(10.0), time_constant=0.1)
    before = 0.0
    for command in (0.2, 0.2, -0.1, 0.05, 0.0):
        device.step(command)
        assert device.rate == pytest.approx((device.yaw - before) / DT)
        before = device.yaw


def test_encoder():
    sigma = math.radians(0.02)
    device = mount(encoder_sigma=sigma)
    device.step(0.4)
    read = [device.read(0.05 * k) for k in range(20_000)]
    assert read[7].t == pytest.approx(0.35)
    error = np.array([reading.yaw for reading in read]) - 0.4
    # sd of a mean sigma/sqrt(N), of a standard deviation sigma/sqrt(2 N); 4 of them
    assert abs(error.mean()) < 4.0 * sigma / math.sqrt(20_000)
    assert error.std() == pytest.approx(sigma, rel=4.0 / math.sqrt(40_000))
    # successive readings share nothing: the correlation has an sd of 1/sqrt(N)
    assert abs(np.corrcoef(error[1:], error[:-1])[0, 1]) < 4.0 / math.sqrt(20_000)


def test_encoder_errs_in_reading_only():
    still, read = mount(encoder_sigma=0.1, time_constant=0.1), mount(encoder_sigma=0.1, time_constant=0.1)
    for _ in range(50):
        still.step(0.2)
        read.step(0.2)
        read.read(0.0)
    assert still.yaw == read.yaw
    exact = mount()
    exact.step(0.2)
    assert exact.read(1.0) == (1.0, 0.2)


@pytest.mark.parametrize("yaw", [-25.0, 0.0, 10.0])
def test_static_level_takes_the_trim_pitch_out(yaw):
    trim = math.radians(1.69)
    device = mount(level_pitch=-trim)
    device.step(math.radians(yaw))
    mat = device.pose(aircraft(pitch=trim, heading=2.0)).mat_nc
    assert mat[:, 2] == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
    heading = math.atan2(mat[1, 0], mat[0, 0])
    assert heading == pytest.approx(2.0 + math.radians(yaw), abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_attitude_is_heading_pitch_roll_level_yaw(seed):
    heading, pitch, roll, level, yaw = np.random.default_rng(seed).uniform(-0.5, 0.5, 5) * (12, 1, 2, 1, 2)
    state = aircraft(heading=heading, pitch=pitch, roll=roll)
    device = mount(level_pitch=level)
    device.step(yaw)
    pose = device.pose(state)
    assert pose.mat_nc == pytest.approx(attitude(state, level, yaw).as_matrix(), abs=1e-12)
    assert (pose.t, pose.lat, pose.lon, pose.height) == (state.t, state.lat, state.lon, state.height)
    assert pose.vel_n.tolist() == [40.0, 55.0, -1.5]


MOVING = aircraft(heading=4.0, pitch=0.06, roll=-0.2, p=0.30, q=-0.08, r=0.11)


def turned_on(state, level, yaw, rate, ahead):
    """Exact attitude `ahead` seconds on, body rates and mount rate held."""
    body = Rotation.from_rotvec(np.array([state.p, state.q, state.r]) * ahead)
    nb = Rotation.from_euler("ZYX", [state.heading, state.pitch, state.roll]) * body
    return nb * Rotation.from_euler("YZ", [level, yaw + rate * ahead])


def test_camera_rate_is_that_of_its_attitude():
    device = mount(level_pitch=-0.03, rate_limit=0.2)
    for _ in range(30):
        device.step(1.0)
    h = 1e-5
    before, after = (turned_on(MOVING, -0.03, device.yaw, device.rate, s) for s in (-h, h))
    expected = (before.inv() * after).as_rotvec() / (2.0 * h)
    assert device.rate == pytest.approx(0.2)
    assert device.pose(MOVING).omega_nc_c == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("ahead", [0.001, 0.004, DT, -0.004])
def test_pose_carried_on(ahead):
    device = mount(level_pitch=-0.03, rate_limit=0.2)
    for _ in range(30):
        device.step(1.0)
    pose = device.pose(MOVING, ahead)
    exact = turned_on(MOVING, -0.03, device.yaw, device.rate, ahead).as_matrix()
    # First order: (omega ahead)^2 / 2 is left out, and mount and body rates do not commute: as much again.
    rate = float(np.linalg.norm(pose.omega_nc_c)) + 0.2
    assert pose.mat_nc == pytest.approx(exact, abs=(rate * ahead) ** 2)
    assert pose.t == pytest.approx(5.0 + ahead)
    to_e = Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)

    def place(p):
        return np.array(to_e.transform(math.degrees(p.lon), math.degrees(p.lat), p.height))

    sp, cp, sl, cl = (f(x) for x in (0.64, -1.47) for f in (math.sin, math.cos))
    mat_ne = np.array([[-sp * cl, -sp * sl, cp], [-sl, cl, 0.0], [-cp * cl, -cp * sl, -sp]])
    moved = mat_ne @ (place(pose) - place(MOVING))
    assert moved == pytest.approx(ahead * np.array([40.0, 55.0, -1.5]), abs=1e-6)


def test_device_on_the_fixed_part():
    device = mount(level_pitch=-0.03, rate_limit=0.2)
    for _ in range(30):
        device.step(1.0)
    pose = device.pose(MOVING, turned=False)
    assert pose.mat_nc == pytest.approx(attitude(MOVING, -0.03, 0.0).as_matrix(), abs=1e-12)
    expected = Rotation.from_euler("Y", -0.03).inv().apply([MOVING.p, MOVING.q, MOVING.r])
    assert pose.omega_nc_c == pytest.approx(expected, abs=1e-12)
