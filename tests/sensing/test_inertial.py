"""The inertial unit: closed forms of what it reads without errors, statistics of its errors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerosim.frames import GRAVITY
from aerosim.sensing.inertial import InertialParameters, InertialUnit, specific_force
from aerosim.truth import AircraftState

PERIOD = 0.05
EXACT = InertialParameters(0.0, 0.0, 0.0, 60.0, 0.0, 0.0)
STILL = AircraftState(0.0, 0.6, -1.4, 3000.0, 70.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 70.0)


def unit(seed=1, **changes):
    return InertialUnit(EXACT._replace(**changes), PERIOD, np.random.default_rng(seed))


def readings(device, states):
    """One row a reading: the fields of InertialReading."""
    return np.array([device.read(state) for state in states])


def resting(count, **changes):
    return [STILL._replace(t=PERIOD * k, **changes) for k in range(count)]


@pytest.mark.parametrize("seed", range(4))
def test_specific_force_against_scipy(seed):
    rng = np.random.default_rng(seed)
    acceleration, (heading, pitch, roll) = rng.normal(0.0, 3.0, 3), rng.uniform(-1.2, 1.2, 3) * (2.0, 1.0, 1.0)
    mat_nb = Rotation.from_euler("ZYX", [heading, pitch, roll])
    expected = mat_nb.inv().apply(acceleration - np.array([0.0, 0.0, GRAVITY]))
    assert specific_force(*acceleration, roll, pitch, heading) == pytest.approx(expected, abs=1e-12)


def test_at_rest_the_accelerometers_bear_gravity():
    # Level: one g upwards, which is -z.  Nose up: the seat pushes forward.  Right wing down: to the left.
    assert unit().read(STILL)[-3:] == pytest.approx((0.0, 0.0, -GRAVITY))
    up, bank = math.radians(4.0), math.radians(10.0)
    assert unit().read(STILL._replace(pitch=up))[-3:] == pytest.approx(
        (GRAVITY * math.sin(up), 0.0, -GRAVITY * math.cos(up))
    )
    assert unit().read(STILL._replace(roll=bank))[-3:] == pytest.approx(
        (0.0, -GRAVITY * math.sin(bank), -GRAVITY * math.cos(bank))
    )


def turning(bank, rate, speed=70.0, count=200):
    """States of a level turn at a constant rate, heading along the track."""
    out = []
    for k in range(count):
        heading = math.remainder(rate * PERIOD * k + 3.0, 2.0 * math.pi)
        north, east = speed * math.cos(heading), speed * math.sin(heading)
        out.append(STILL._replace(t=PERIOD * k, v_north=north, v_east=east, roll=bank, heading=heading))
    return out


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_coordinated_turn_has_nothing_across(side):
    bank = side * math.radians(20.0)
    rate = GRAVITY * math.tan(bank) / 70.0
    accel = readings(unit(), turning(bank, rate))[1:, -3:]
    # A chord is shorter than its arc by (rate period)^2/24: 1.4e-7 of V rate.
    assert accel[:, 0] == pytest.approx(0.0, abs=1e-5)
    assert accel[:, 1] == pytest.approx(0.0, abs=1e-5)
    assert accel[:, 2] == pytest.approx(-GRAVITY / math.cos(bank), abs=1e-5)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_flat_turn_is_felt_across(side):
    rate = side * 0.02
    accel = readings(unit(), turning(0.0, rate))[1:, -3:]
    assert accel[:, 1] == pytest.approx(70.0 * rate, abs=1e-6)
    assert accel[:, 0] == pytest.approx(0.0, abs=1e-9)


def test_speeding_up_along_the_axis():
    states = [STILL._replace(t=PERIOD * k, v_north=70.0 + 0.8 * PERIOD * k) for k in range(5)]
    accel = readings(unit(), states)[:, -3:]
    assert accel[0] == pytest.approx((0.0, 0.0, -GRAVITY))  # nothing is known of what was before
    assert accel[1:, 0] == pytest.approx(0.8)


def test_force_is_the_mean_over_the_period():
    # v = sin: what the unit gives, summed, is the change of velocity, however it swings in between.
    times = PERIOD * np.arange(100)
    states = [STILL._replace(t=t, v_east=5.0 * math.sin(7.0 * t)) for t in times.tolist()]
    across = readings(unit(), states)[1:, -2]
    assert np.cumsum(across) * PERIOD == pytest.approx(5.0 * np.sin(7.0 * times[1:]), abs=1e-9)


def test_angles_without_errors_are_the_true_ones():
    states = turning(0.1, 0.05, count=3000)  # 7.5 rad: once around
    found = readings(unit(), states)
    assert found[:, 0].tolist() == [state.t for state in states]
    assert (found[:, 1] == 0.1).all()
    assert (found[:, 4] == 0.1).all()
    assert (found[:, [2, 5]] == 0.0).all()
    yaw = found[:, 3]
    assert yaw - yaw[0] == pytest.approx(0.05 * found[:, 0], abs=1e-9)  # not wrapped


def test_yaw_counts_from_any_direction():
    starts = np.array([unit(seed).read(STILL).yaw for seed in range(400)])
    assert np.abs(starts).max() <= math.pi
    # even over a turn: each quarter has 100 of 400, sd 8.7; 4 of them
    assert np.histogram(starts, 4, (-math.pi, math.pi))[0] == pytest.approx(100.0, abs=35.0)


def test_gyro_noise_is_white_and_as_large_as_told():
    count, sigma = 20_000, math.radians(0.014)
    found = readings(unit(gyro_noise=sigma), resting(count))
    for axis in (1, 2, 3):
        error = found[:, axis] - found[:, axis].mean()
        assert error.std() == pytest.approx(sigma, rel=4.0 / math.sqrt(2.0 * count))
        assert abs(np.corrcoef(error[1:], error[:-1])[0, 1]) < 4.0 / math.sqrt(count)
    between = np.corrcoef(found[:, 1:4].T)[np.triu_indices(3, 1)]
    assert np.abs(between).max() < 4.0 / math.sqrt(count)


def test_gyro_bias_grows_with_time():
    sigma = math.radians(10.0) / 3600.0
    rates = []
    for seed in range(300):
        device = unit(seed, gyro_bias=sigma)
        first, hour = device.read(STILL), device.read(STILL._replace(t=3600.0))
        half = unit(seed, gyro_bias=sigma)
        half.read(STILL)
        middle = half.read(STILL._replace(t=1800.0))
        rate = (np.array(hour[1:4]) - first[1:4]) / 3600.0
        assert (np.array(middle[1:4]) - first[1:4]) / 1800.0 == pytest.approx(rate, abs=1e-12)
        rates.append(rate)
    # 900 draws: the standard deviation within 4/sqrt(1800)
    assert np.std(rates) == pytest.approx(sigma, rel=0.095)
    assert abs(np.mean(rates)) < 4.0 * sigma / math.sqrt(900.0)


def test_levels_err_slowly():
    # Gauss-Markov: correlation exp(-lag/60 s).  150 units of 1000 s have 150 x 1000/(2 x 60) independent values.
    sigma, step = math.radians(0.1), 5.0
    roll, pitch = [], []
    for seed in range(150):
        device = InertialUnit(EXACT._replace(level_sigma=sigma), step, np.random.default_rng(seed))
        found = readings(device, [STILL._replace(t=step * k, roll=0.2, pitch=0.1) for k in range(200)])
        roll.append(found[:, 4] - 0.2)
        pitch.append(found[:, 5] - 0.1)
    for error in (np.array(roll), np.array(pitch)):
        independent = 150.0 * 1000.0 / 120.0
        assert error.std() == pytest.approx(sigma, rel=4.0 / math.sqrt(2.0 * independent))
        assert error[:, 0].std() == pytest.approx(sigma, rel=4.0 / math.sqrt(300.0))  # from the start
        for lag in (1, 12, 24):
            found = np.corrcoef(error[:, lag:].ravel(), error[:, :-lag].ravel())[0, 1]
            assert found == pytest.approx(math.exp(-lag * step / 60.0), abs=4.0 / math.sqrt(independent))
    assert abs(np.corrcoef(np.ravel(roll), np.ravel(pitch))[0, 1]) < 4.0 / math.sqrt(independent)


def test_accelerometer_errors():
    count, noise, bias, rest = 4000, 0.005, 0.001, np.array([0.0, 0.0, -GRAVITY])
    means = []
    for seed in range(100):
        device = unit(seed, accel_bias=bias)
        means.append(np.array(device.read(STILL)[-3:]) - rest)
        assert device.read(STILL._replace(t=9.0))[-3:] == pytest.approx((means[-1] + rest).tolist())
    assert np.std(means) == pytest.approx(bias, rel=4.0 / math.sqrt(600.0))
    accel = readings(unit(accel_noise=noise), resting(count))[:, -3:]
    assert accel.std(axis=0) == pytest.approx(noise, rel=4.0 / math.sqrt(2.0 * count))
    assert accel.mean(axis=0) == pytest.approx(rest, abs=4.0 * noise / math.sqrt(count))


NOISY = EXACT._replace(gyro_noise=1e-4, gyro_bias=1e-6, level_sigma=1e-3, accel_noise=5e-3, accel_bias=1e-3)


def test_what_is_left_away_is_nan_and_moves_nothing_else():
    made = {}
    for gives in ("gyro", "bank", "imu"):
        device = InertialUnit(NOISY._replace(gives=gives), PERIOD, np.random.default_rng(3))
        made[gives] = readings(device, turning(0.2, 0.03, count=600))  # noise is drawn in blocks of 512
    assert np.isfinite(made["imu"]).all()
    assert np.isnan(made["bank"][:, 6:]).all()
    assert np.array_equal(made["bank"][:, :6], made["imu"][:, :6])
    assert np.isnan(made["gyro"][:, 4:]).all()
    assert np.array_equal(made["gyro"][:, :4], made["imu"][:, :4])


def test_same_generator_same_readings():
    states = turning(0.2, 0.03, count=50)
    first, again, other = (
        readings(InertialUnit(NOISY, PERIOD, np.random.default_rng(seed)), states) for seed in (5, 5, 6)
    )
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
