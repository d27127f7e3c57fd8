"""A strapped-down inertial unit: gyroscopes, levels and accelerometers, and how they err."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
from numba import njit

from aerosim.frames import GRAVITY
from aerosim.signals import InertialReading
from aerosim.truth import AircraftState

Gives = Literal["gyro", "bank", "imu"]

NOISE_BLOCK = 512
HALF, TURN = math.pi, 2.0 * math.pi
NAN = math.nan


class InertialParameters(NamedTuple):
    """Errors of a unit.  rad, rad/s, s, m/s^2.

    gyro_noise: white noise of each integrated angle; gyro_bias: standard deviation of an axis' constant rate
    error; level_sigma, level_time: Gauss-Markov error of the levels; accel_noise: white noise of each mean;
    accel_bias: standard deviation of an axis' constant error.  gives: what is handed out: gyro: integrated
    angles; bank: the levels too; imu: all.
    """

    gyro_noise: float
    gyro_bias: float
    level_sigma: float
    level_time: float
    accel_noise: float
    accel_bias: float
    gives: Gives = "imu"


class InertialUnit:
    """Reads attitude and specific force of the aircraft at equal times.

    Earth's rotation, the transport rate and Coriolis' acceleration are taken out as the computer of such a unit
    does it, without error: the accelerations are those of the velocity over ground, in n.  The same generator
    makes the same errors of what is handed out, whatever else `gives` leaves away.
    """

    def __init__(self, parameters: InertialParameters, period: float, rng: np.random.Generator) -> None:
        """period: between readings, s."""
        par = self._par = parameters
        self._gives = par.gives
        self._rng = rng
        self._keep = math.exp(-period / par.level_time)
        kick = par.level_sigma * math.sqrt(1.0 - self._keep**2)
        self._scale = np.array([par.gyro_noise] * 3 + [kick] * 2 + [par.accel_noise] * 3)
        self._bias = tuple((rng.standard_normal(6) * ([par.gyro_bias] * 3 + [par.accel_bias] * 3)).tolist())
        self._level_roll, self._level_pitch = (par.level_sigma * rng.standard_normal(2)).tolist()
        self._yaw = rng.uniform(-math.pi, math.pi)
        self._noise: list[list[float]] = []
        self._before: tuple[float, ...] | None = None

    def read(self, aircraft: AircraftState) -> InertialReading:
        """The reading at the aircraft's time.

        The specific force is the mean since the last reading, from the change of velocity, in the mean attitude;
        at the first reading it is that of an aircraft that does not accelerate.
        """
        if not self._noise:
            self._noise = (self._rng.standard_normal((NOISE_BLOCK, 8)) * self._scale).tolist()
        n_roll, n_pitch, n_yaw, kick_roll, kick_pitch, n_x, n_y, n_z = self._noise.pop()
        t, _, _, _, north, east, down, roll, pitch, heading, _, _, _, _ = aircraft
        if self._before is None:
            self._before = t, north, east, down, roll, pitch, heading
        t0, north0, east0, down0, roll0, pitch0, heading0 = self._before
        self._before = t, north, east, down, roll, pitch, heading
        turned = heading - heading0
        if not -HALF <= turned <= HALF:
            turned = math.remainder(turned, TURN)
        self._yaw += turned
        b_roll, b_pitch, b_yaw, b_x, b_y, b_z = self._bias
        smooth_roll, smooth_pitch = roll + b_roll * t + n_roll, pitch + b_pitch * t + n_pitch
        yaw = self._yaw + b_yaw * t + n_yaw
        gives = self._gives
        if gives == "gyro":
            return InertialReading(t, smooth_roll, smooth_pitch, yaw, NAN, NAN, NAN, NAN, NAN)
        error_roll = self._level_roll = self._keep * self._level_roll + kick_roll
        error_pitch = self._level_pitch = self._keep * self._level_pitch + kick_pitch
        level_roll, level_pitch = roll + error_roll, pitch + error_pitch
        if gives == "bank":
            return InertialReading(t, smooth_roll, smooth_pitch, yaw, level_roll, level_pitch, NAN, NAN, NAN)
        rate = 1.0 / (t - t0) if t > t0 else 0.0
        x, y, z = specific_force(
            (north - north0) * rate, (east - east0) * rate, (down - down0) * rate,
            0.5 * (roll + roll0), 0.5 * (pitch + pitch0), heading - 0.5 * turned,
        )  # fmt: skip
        return InertialReading(
            t, smooth_roll, smooth_pitch, yaw, level_roll, level_pitch, x + b_x + n_x, y + b_y + n_y, z + b_z + n_z
        )


@njit(cache=True)
def specific_force(
    north: float, east: float, down: float, roll: float, pitch: float, heading: float
) -> tuple[float, float, float]:  # pragma: no cover - compiled
    """Specific force along x, y, z of b, m/s^2: acceleration over ground in n (m/s^2) less gravity, turned into b.

    Gravity is 9.80665 m/s^2 down.  roll, pitch, heading: rad.
    """
    down -= GRAVITY
    sine, cosine = math.sin(heading), math.cos(heading)
    ahead, right = cosine * north + sine * east, cosine * east - sine * north
    sine, cosine = math.sin(pitch), math.cos(pitch)
    x, below = cosine * ahead - sine * down, sine * ahead + cosine * down
    sine, cosine = math.sin(roll), math.cos(roll)
    return x, cosine * right + sine * below, cosine * below - sine * right
