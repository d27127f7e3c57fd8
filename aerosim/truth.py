"""What only the world knows: the aircraft's state, the air's, the camera's pose.  Never given to an estimator."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from aerosim.frames import Array

# tells latitude, longitude (rad) and ellipsoidal height (m) of the aircraft
Where = Callable[[], tuple[float, float, float]]


class AircraftState(NamedTuple):
    """State of the aircraft's centre of gravity at time t (s).  SI, rad.

    lat, lon: geodetic, height: ellipsoidal.  v_*: velocity over ground in n.  roll, pitch, heading: of b in n.
    p, q, r: omega_eb_b.  airspeed: true, gusts included.
    """

    t: float
    lat: float
    lon: float
    height: float
    v_north: float
    v_east: float
    v_down: float
    roll: float
    pitch: float
    heading: float
    p: float
    q: float
    r: float
    airspeed: float


class AirState(NamedTuple):
    """State of the air at the aircraft: mean and slow wind in n (where it goes to), gusts in b.  m/s, rad/s.

    u, v, w: gust velocity of the air along x, y, z of b.  p, q, r: rotation of the air as the aircraft feels it.
    """

    wind_north: float
    wind_east: float
    wind_down: float
    u: float
    v: float
    w: float
    p: float
    q: float
    r: float


class Below(NamedTuple):
    """Ellipsoidal heights below the aircraft, m: at the nadir, mean of the rows' footprint, mean of a strip."""

    nadir: float
    footprint: float
    strip: float


class CameraPose(NamedTuple):
    """Pose and motion of the camera's projection centre at time t (s).

    lat, lon (rad), height (ellipsoidal, m); velocity over ground in n (m/s), shape (3,);
    mat_nc: c to n, (3, 3); omega_nc_c: rotation of c against n, in c, (3,), rad/s.
    """

    t: float
    lat: float
    lon: float
    height: float
    vel_n: Array
    mat_nc: Array
    omega_nc_c: Array


class Shot(NamedTuple):
    """One photo as it happened: pose and motion in the middle of the exposure.

    line: survey line from 0.  interval: wanted time between photos then, s.  fmc_rate: forward-motion
    compensation applied, rad/s (v/h).
    """

    pose: CameraPose
    line: int
    interval: float
    fmc_rate: float
