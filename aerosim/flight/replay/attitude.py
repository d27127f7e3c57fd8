"""Attitude along a flown path: given angles interpolated, missing ones filled in by coordinated flight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from aerosim.flight.replay.penalised import DEGREE, Basis, solve
from aerosim.flight.replay.smooth_path import COARSEST, FINEST
from aerosim.flight.replay.trajectory import Trajectory
from aerosim.frames import GRAVITY, Array, radii

HALO = 2  # samples at each end that a derivative costs
ANGLE_SIGMA = 1e-5  # rad, where a column shows no quantisation
# Power density of the third derivative of an angle, (rad/s^3)^2 s: rolls of 2 deg/s at a third of a hertz.
ANGLE_DENSITY = 5e-3


class Attitude(NamedTuple):
    """Angles of b in n, (n,) each, rad; heading runs on over the full turn."""

    roll: Array
    pitch: Array
    heading: Array


@dataclass(frozen=True)
class GivenAttitude:
    """What the file says of the attitude, as functions of its time (s); None is filled in."""

    roll: BSpline | None = None
    pitch: BSpline | None = None
    heading: BSpline | None = None

    @classmethod
    def of(cls, points: Trajectory) -> GivenAttitude:
        """Smooth angles through the given ones, no rougher than their quantisation asks for.

        Angles run on over 360 deg, so that each is interpolated the short way; pitch stays far from the vertical
        in anything that surveys.
        """
        return cls(
            *(
                None if values is None else _smooth(points.t, values, points.steps.get(name, 0.0))
                for name, values in (("roll", points.roll), ("pitch", points.pitch), ("heading", points.heading))
            )
        )


def _smooth(t: Array, values: Array, step: float) -> BSpline | None:
    known = np.isfinite(values)
    if known.sum() < 4:
        return None
    basis = Basis(t[0], t[-1], min(max(float(np.median(np.diff(t[known]))), FINEST), COARSEST))
    sigma = np.full(int(known.sum()), max(step / np.sqrt(12.0), ANGLE_SIGMA))
    start = np.interp(basis.middles, t[known], values[known])
    penalty = basis.roughness(np.full(basis.size, ANGLE_DENSITY))
    return basis.spline(solve(basis.values(t[known]).tocsr(), values[known], sigma, penalty, start, DEGREE))


def slope(values: Array, dt: float) -> Array:
    """Derivative of evenly spaced values along the first axis, (n, ...) to (n - 4, ...), exact to dt^4."""
    return np.asarray((8.0 * (values[3:-1] - values[1:-3]) - (values[4:] - values[:-4])) / (12.0 * dt))


def coordinated(vel_air: Array, acc_air: Array, alpha: float) -> Attitude:
    """Attitude of an aircraft that flies through the air without sideslip and turns by banking.

    vel_air: velocity through the air in n, (n, 3), m/s; acc_air: its derivative, (n, 3), m/s^2; alpha: angle of
    attack, rad.  The bank is about the air's velocity: tan(bank) = V chi'/g, with chi its azimuth; then b is
    pitched up by alpha: mat_nb = Rz(chi) Ry(gamma) Rx(bank) Ry(alpha).  Level and straight this is heading = chi,
    pitch = gamma + alpha.
    """
    north, east, down = vel_air.T
    level = np.hypot(north, east)
    chi = np.unwrap(np.arctan2(east, north))
    gamma = np.arctan2(-down, level)
    bank = np.arctan((north * acc_air[:, 1] - east * acc_air[:, 0]) / np.maximum(level, 1.0) / GRAVITY)
    sb, cb, sa, ca = np.sin(bank), np.cos(bank), np.sin(alpha), np.cos(alpha)
    # First and last columns of Rx(bank) Ry(alpha), turned up by gamma; the azimuth is added to the heading.
    sg, cg = np.sin(gamma), np.cos(gamma)
    x, y, z = ca * cg - cb * sa * sg, sb * sa, -ca * sg - cb * sa * cg
    up_right, up_down = sb * cg, -sa * sg + cb * ca * cg
    return Attitude(np.arctan2(up_right, up_down), -np.arcsin(np.clip(z, -1.0, 1.0)), chi + np.arctan2(y, x))


def with_given(filled: Attitude, given: GivenAttitude, t: Array) -> Attitude:
    """The filled-in attitude, with whatever the file gives in its place.  t: of the file, (n,), s."""
    angles = []
    for own, told in zip(filled, (given.roll, given.pitch, given.heading), strict=True):
        angles.append(own if told is None else np.asarray(told(t)))
    return Attitude(*angles)


def body_rates(now: Attitude, rate: Attitude, lat: Array, height: Array, vel_n: Array) -> Array:
    """omega_eb_b, (n, 3), rad/s, of an attitude, its derivative (rad/s) and the motion over the ellipsoid.

    lat: rad; height: m; vel_n: (n, 3), m/s.
    """
    sr, cr = np.sin(now.roll), np.cos(now.roll)
    sp, cp = np.sin(now.pitch), np.cos(now.pitch)
    sh, ch = np.sin(now.heading), np.cos(now.heading)
    meridian, normal = radii(lat)
    # omega_en_n: n turns as the aircraft moves over the curved Earth.
    a, b = vel_n[:, 1] / (normal + height), -vel_n[:, 0] / (meridian + height)
    c = -a * np.tan(lat)
    en = (
        ch * cp * a + sh * cp * b - sp * c,
        (ch * sp * sr - sh * cr) * a + (sh * sp * sr + ch * cr) * b + cp * sr * c,
        (ch * sp * cr + sh * sr) * a + (sh * sp * cr - ch * sr) * b + cp * cr * c,
    )
    return np.stack([
        rate.roll - rate.heading * sp + en[0],
        rate.pitch * cr + rate.heading * cp * sr + en[1],
        -rate.pitch * sr + rate.heading * cp * cr + en[2],
    ], axis=-1)  # fmt: skip


def gust_n(now: Attitude, gust: Array) -> Array:
    """Gusts (n, 3) from b to n, m/s."""
    sr, cr = np.sin(now.roll), np.cos(now.roll)
    sp, cp = np.sin(now.pitch), np.cos(now.pitch)
    sh, ch = np.sin(now.heading), np.cos(now.heading)
    u, v, w = gust.T
    return np.stack([
        ch * cp * u + (ch * sp * sr - sh * cr) * v + (ch * sp * cr + sh * sr) * w,
        sh * cp * u + (sh * sp * sr + ch * cr) * v + (sh * sp * cr - ch * sr) * w,
        -sp * u + cp * sr * v + cp * cr * w,
    ], axis=-1)  # fmt: skip
