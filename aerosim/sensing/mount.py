"""The camera mount: yaw servo with delay, lag, rate limit, stop and encoder."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.signals import MountReading
from aerosim.truth import AircraftState, CameraPose

ENCODER_BLOCK = 1024


class MountParameters(NamedTuple):
    """How a mount moves and reads.  rad, rad/s, s.

    level_pitch: constant pitch of the mount against the airframe; a static mount takes out the trim pitch.
    """

    yaw_limit: float
    rate_limit: float
    time_constant: float
    delay: float
    encoder_sigma: float
    level_pitch: float = 0.0


class Mount:
    """Yaw of the camera against the airframe, positive clockwise seen from above."""

    def __init__(self, parameters: MountParameters, dt: float, rng: np.random.Generator) -> None:
        """dt: step, s.  The camera starts along the aircraft's axis."""
        self._par = parameters
        self._dt = dt
        self._follow = 1.0 - math.exp(-dt / parameters.time_constant) if parameters.time_constant > 0.0 else 1.0
        self._most = parameters.rate_limit * dt
        self._queue = np.zeros(round(parameters.delay / dt) + 1)  # ring of commands, the newest at _at
        self._at = 0
        self._rng = rng
        self._noise: list[float] = []
        self.yaw = 0.0
        self.rate = 0.0

    def step(self, command: float) -> None:
        """One step towards the commanded yaw (rad), as it was `delay` ago."""
        self.advance(command, 1)

    def advance(self, command: float, steps: int) -> None:
        """Several steps towards the same command."""
        self._turn(command, steps, self._most)

    def _turn(self, command: float, steps: int, most: float) -> None:
        """Several steps of at most so much (rad) each."""
        self.yaw, move, self._at = _turned(
            self._queue, self._at, self.yaw, command, steps, self._par.yaw_limit, most, self._follow
        )
        self.rate = move / self._dt

    def read(self, t: float) -> MountReading:
        """The encoder's reading at time t (s)."""
        if not self._noise:
            noise = self._rng.standard_normal(ENCODER_BLOCK) * self._par.encoder_sigma
            self._noise = noise.tolist()
        return MountReading(t, self.yaw + self._noise.pop())

    def pose(self, aircraft: AircraftState, ahead: float = 0.0, turned: bool = True) -> CameraPose:
        """Pose of the camera now, or carried on by its present motion for `ahead` s (less than a step).

        The projection centre is the aircraft's centre of gravity; mat_bm = Ry(level pitch) Rz(yaw), and c is m.
        turned: False for a device on the mount's fixed part, which is levelled but does not follow the yaw.
        """
        a = aircraft
        yaw, rate = (self.yaw, self.rate) if turned else (0.0, 0.0)
        out = np.empty((5, 3))  # one array is faster made than three
        _camera(
            out, a.v_north, a.v_east, a.v_down, a.roll, a.pitch, a.heading, a.p, a.q, a.r,
            self._par.level_pitch, yaw, rate, ahead,
        )  # fmt: skip
        vel_n, mat_nc, omega = out[0], out[1:4], out[4]
        if ahead == 0.0:
            return CameraPose(a.t, a.lat, a.lon, a.height, vel_n, mat_nc, omega)
        lat, lon, height = moved(a.lat, a.lon, a.height, a.v_north * ahead, a.v_east * ahead, a.v_down * ahead)
        return CameraPose(a.t + ahead, lat, lon, height, vel_n, mat_nc, omega)


def moved(
    lat: float, lon: float, height: float, north: float, east: float, down: float
) -> tuple[float, float, float]:
    """Geodetic position moved by a few metres in n: right to a micrometre over a step's path."""
    from aerosim.frames import radii

    meridian, normal = radii(lat)
    return (
        lat + north / (float(meridian) + height),
        lon + east / ((float(normal) + height) * math.cos(lat)),
        height - down,
    )


@njit(cache=True)
def _turned(
    queue: Array, at: int, yaw: float, command: float, steps: int, limit: float, most: float, follow: float
) -> tuple[float, float, int]:  # pragma: no cover - compiled
    """Yaw after some steps, the last step, and where the newest command stands in the queue."""
    move = 0.0
    for _ in range(steps):
        queue[at] = command
        at = at + 1 if at + 1 < queue.shape[0] else 0
        move = (min(max(queue[at], -limit), limit) - yaw) * follow
        move = min(max(move, -most), most)
        yaw += move
    return yaw, move, at


@njit(cache=True)
def _camera(
    out: Array,
    v_north: float,
    v_east: float,
    v_down: float,
    roll: float,
    pitch: float,
    heading: float,
    p: float,
    q: float,
    r: float,
    level: float,
    yaw: float,
    yaw_rate: float,
    ahead: float,
) -> None:  # pragma: no cover - compiled
    """Fills out (5, 3): vel_n, mat_nc (Rz Ry Rx of the aircraft, Ry Rz of the mount), omega_nc_c.

    Turned on by `ahead` seconds.
    """
    sr, cr = np.sin(roll), np.cos(roll)
    sp, cp = np.sin(pitch), np.cos(pitch)
    sh, ch = np.sin(heading), np.cos(heading)
    sl, cl = np.sin(level), np.cos(level)
    sy, cy = np.sin(yaw), np.cos(yaw)
    b = (
        (ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr),
        (sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr),
        (-sp, cp * sr, cp * cr),
    )
    m = ((cl * cy, -cl * sy, sl), (sy, cy, 0.0), (-sl * cy, sl * sy, cl))
    mat, omega = out[1:4], out[4]
    out[0, 0], out[0, 1], out[0, 2] = v_north, v_east, v_down
    for j in range(3):
        omega[j] = m[0][j] * p + m[1][j] * q + m[2][j] * r
    omega[2] += yaw_rate
    turn_x, turn_y, turn_z = omega[0] * ahead, omega[1] * ahead, omega[2] * ahead
    for i in range(3):
        x = b[i][0] * m[0][0] + b[i][1] * m[1][0] + b[i][2] * m[2][0]
        y = b[i][0] * m[0][1] + b[i][1] * m[1][1] + b[i][2] * m[2][1]
        z = b[i][0] * m[0][2] + b[i][1] * m[1][2] + b[i][2] * m[2][2]
        # mat (1 + [turn]x), first order: ahead is less than a step
        mat[i, 0] = x + y * turn_z - z * turn_y
        mat[i, 1] = y + z * turn_x - x * turn_z
        mat[i, 2] = z + x * turn_y - y * turn_x
