"""A smooth path through a trajectory's points: position at any time, velocity as its derivative.

Points received from an aircraft are good across the path (metres) and poor along it: their time stamps are old by
up to seconds.  So each point is weighted by what it is worth along and across the path, found from the file
itself, and ground speed and track, where there are any, are observations too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.interpolate import BSpline

from aerosim.flight.replay.penalised import DEGREE, Basis, solve
from aerosim.flight.replay.trajectory import SLOWEST, Trajectory
from aerosim.frames import WGS84_A, Array, radii

WINDOW = 7  # points to judge their scatter by
SPEED_SIGMA = 0.3  # m/s; what a receiver's Doppler speed is worth, at best
TRACK_SIGMA = np.radians(1.0)
CLIMB_SIGMA = 1.0  # m/s
FINEST, COARSEST = 0.02, 2.0  # s between knots
# Power density of jerk, (m/s^3)^2 s: held on a line, and rolling into a turn at 5 deg/s (9.8 x 0.09 for 4 s).
CALM, TURNING = 1e-3, 3.0
LEVEL = 3e-4  # the same for the height
TURN_ACCELERATION = 1.5  # m/s^2, bank of 9 deg: surely a turn
CLIMB_ACCELERATION = 0.5  # m/s^2
# Thrust and drag change the speed by this much, m/s^2, for about ten seconds: one look each second.
SPEEDING = 0.5 * np.sqrt(10.0)
SPREAD = 12.0  # s, how far around a turn it may begin


class Scatter(NamedTuple):
    """What a trajectory's points are worth: across the path and in height (m), and their time stamps (s)."""

    across: float
    height: float
    stamp: float


class Motion(NamedTuple):
    """Where and how fast: lat, lon (rad), height (m), velocity over ground in n (n, 3), m/s."""

    lat: Array
    lon: Array
    height: Array
    vel_n: Array


@dataclass(frozen=True)
class SmoothPath:
    """Path over first to last (s).  scatter: of the points about it, as it was assumed."""

    first: float
    last: float
    scatter: Scatter
    _origin: tuple[float, float]
    _scale: tuple[float, float]
    _place: BSpline
    _rate: BSpline

    def place(self, t: Array) -> tuple[Array, Array, Array]:
        """Latitude, longitude (rad) and height (m) at times t (s), (n,) each."""
        found = self._place(t)
        return (
            self._origin[0] + found[..., 0] / self._scale[0],
            self._origin[1] + found[..., 1] / self._scale[1],
            found[..., 2],
        )

    def motion(self, t: Array) -> Motion:
        """Place, and velocity as its exact derivative, at times t (n,), s."""
        lat, lon, height = self.place(t)
        rate = self._rate(t)
        meridian, normal = radii(lat)
        north = (meridian + height) * rate[..., 0] / self._scale[0]
        east = (normal + height) * np.cos(lat) * rate[..., 1] / self._scale[1]
        return Motion(lat, lon, height, np.stack([north, east, -rate[..., 2]], axis=-1))


def smooth_path(points: Trajectory, scatter: Scatter | None = None) -> SmoothPath:
    """The smooth path through one piece of a trajectory.

    scatter: of its points, better known from the whole flight; None finds it from this piece.
    """
    scale = _scale(points)
    plane = _plane(points, scale)
    scatter = scatter or scatter_of(points)
    basis = Basis(points.t[0], points.t[-1], min(max(float(np.median(np.diff(points.t))), FINEST), COARSEST))
    level = _fit_plane(basis, points, plane, scatter)
    height = _fit_height(basis, points, scatter)
    place = basis.spline(np.column_stack([level, height]))
    return SmoothPath(
        float(points.t[0]),
        float(points.t[-1]),
        scatter,
        (float(points.lat[0]), float(points.lon[0])),
        scale,
        place,
        place.derivative(),
    )


def _scale(points: Trajectory) -> tuple[float, float]:
    """Metres for a radian of latitude and of longitude, in the middle of the path."""
    lat = float(np.median(points.lat))
    meridian, normal = radii(lat)
    return float(meridian), float(normal) * float(np.cos(lat))


def _plane(points: Trajectory, scale: tuple[float, float]) -> Array:
    """Points on a plane, (n, 2) north, east, m."""
    return np.column_stack([(points.lat - points.lat[0]) * scale[0], (points.lon - points.lon[0]) * scale[1]])


def scatter_of(points: Trajectory) -> Scatter:
    """Scatter of the points about parabolas through seven of them, where it is straight; not below the steps."""
    steps = points.steps
    least = WGS84_A * max(steps.get("latitude", 0.0), steps.get("longitude", 0.0)) / np.sqrt(12.0)
    floor = max(least, 1e-3), max(steps.get("height", 0.0) / np.sqrt(12.0), 1e-3)
    # Of an even period nobody can tell whether it is rounded.
    stamp = 0.0 if np.ptp(np.diff(points.t)) < 1e-6 else steps.get("time", 0.0) / np.sqrt(12.0)
    if len(points) < 2 * WINDOW:
        return Scatter(*floor, stamp)
    along, across, rise, speed = _residuals(points, _plane(points, _scale(points)))
    found_across = _spread(across)
    found_stamp = np.sqrt(max(_spread(along) ** 2 - found_across**2, 0.0)) / max(speed, SLOWEST)
    return Scatter(
        max(floor[0], found_across), max(floor[1], _spread(rise)), max(float(found_stamp), float(stamp))
    )


def _spread(residuals: Array) -> float:
    """Standard deviation from the median size, of residuals of a parabola through seven points."""
    return (
        float(1.4826 * np.median(np.abs(residuals)) * np.sqrt(WINDOW / (WINDOW - 3.0))) if len(residuals) else 0.0
    )


def _residuals(points: Trajectory, plane: Array) -> tuple[Array, Array, Array, float]:
    """Residuals along, across and in height on the straightest windows, and the usual speed (m/s)."""
    windows = np.lib.stride_tricks.sliding_window_view
    t = windows(points.t, WINDOW)
    span = t[:, -1] - t[:, 0]
    u = (t - t.mean(axis=1, keepdims=True)) / span[:, None]
    basis, _ = np.linalg.qr(np.stack([np.ones_like(u), u, u**2], axis=-1))
    values = np.stack([*(windows(plane[:, k], WINDOW) for k in range(2)), windows(points.height, WINDOW)], axis=-1)
    values = values - values[:, :1]
    fitted = np.einsum("wik,wjk,wjd->wid", basis, basis, values)
    rest = values - fitted
    chord = values[:, -1, :2] - values[:, 0, :2]
    length = np.hypot(*chord.T)
    ahead = chord / np.maximum(length, 1e-9)[:, None]
    side = np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1)
    bow = np.abs(np.einsum("wd,wd->w", fitted[:, WINDOW // 2, :2] - 0.5 * chord, side)) / np.maximum(length, 1e-9)
    flying = (length > SLOWEST * span) & (span < 3.0 * np.median(span))
    if not flying.any():
        return np.zeros(0), np.zeros(0), np.zeros(0), SLOWEST
    straight = flying & (bow <= np.quantile(bow[flying], 0.4))
    along = np.einsum("wid,wd->wi", rest[straight, :, :2], ahead[straight])
    across = np.einsum("wid,wd->wi", rest[straight, :, :2], side[straight])
    # A height that stands still says nothing about its scatter.
    moving = np.ptp(values[..., 2], axis=1) > 0.0
    rise = rest[flying & moving, :, 2]
    return along.ravel(), across.ravel(), rise.ravel(), float(np.median(length[straight] / span[straight]))


def _fit_plane(basis: Basis, points: Trajectory, plane: Array, scatter: Scatter) -> Array:
    """Coefficients (size, 2): three rounds, each with the directions and turns of the round before."""
    t, n = points.t, basis.size
    pair = [sparse.kron(basis.values(t), row, format="csr") for row in ([[1.0, 0.0]], [[0.0, 1.0]])]
    rate = [sparse.kron(basis.slopes(t), row, format="csr") for row in ([[1.0, 0.0]], [[0.0, 1.0]])]
    found = np.column_stack([np.interp(basis.middles, t, plane[:, k]) for k in range(2)]).ravel()
    density = np.full(n, 0.1)
    for _ in range(3):
        curve = basis.spline(found.reshape(n, 2))
        vel, acc = curve.derivative()(t), curve.derivative(2)(t)
        design, target, sigma = _observations(points, plane, pair, rate, vel, acc, scatter)
        steady, loose = _even_speed(basis, curve)
        design = sparse.vstack([design, steady], format="csr")
        target, sigma = np.concatenate([target, np.zeros(len(loose))]), np.concatenate([sigma, loose])
        penalty = sparse.kron(basis.roughness(density), sparse.eye_array(2), format="csr")
        found = solve(design, target, sigma, penalty, found, 2 * DEGREE + 1)
        density = _densities(basis, basis.spline(found.reshape(n, 2)), TURN_ACCELERATION, CALM)
    return found.reshape(n, 2)


def _observations(
    points: Trajectory, plane: Array, pair: list[sparse.csr_array], rate: list[sparse.csr_array], vel: Array,
    acc: Array, scatter: Scatter,
) -> tuple[sparse.csr_array, Array, Array]:  # fmt: skip
    """Positions along and across the path, and velocities where there are any: design, target, sigma."""
    speed = np.maximum(np.hypot(*vel.T), 1.0)
    ahead = vel / speed[:, None]
    side = np.stack([-ahead[:, 1], ahead[:, 0]], axis=-1)
    turn = np.abs(vel[:, 0] * acc[:, 1] - vel[:, 1] * acc[:, 0]) / speed**2
    along = np.hypot(scatter.across, speed * scatter.stamp)
    across = np.full(len(points), scatter.across)
    rows = [(pair, ahead, (plane * ahead).sum(axis=1), along), (pair, side, (plane * side).sum(axis=1), across)]
    known = np.flatnonzero(np.isfinite(points.speed) & (points.speed > SLOWEST))
    if len(known):
        # In a turn a stale stamp makes the velocity's direction wrong, and its size hardly.
        late = turn[known] * scatter.stamp
        fine = max(SPEED_SIGMA, points.steps.get("groundspeed", 0.0) / np.sqrt(12.0))
        track = np.where(np.isfinite(points.track[known]), points.track[known], 0.0)
        way = np.column_stack([np.cos(track), np.sin(track)])
        given = np.isfinite(points.track[known])
        towards = np.where(given[:, None], way, ahead[known])
        rows.append((_take(rate, known), towards, points.speed[known], fine + points.speed[known] * late**2))
        beside = np.column_stack([-towards[:, 1], towards[:, 0]])
        loose = points.speed[known] * np.hypot(TRACK_SIGMA, 2.0 * late)
        which = np.flatnonzero(given)
        rows.append((_take(rate, known[which]), beside[which], np.zeros(len(which)), loose[which]))
    design = sparse.vstack([
        sparse.diags_array(direction[:, 0]) @ both[0] + sparse.diags_array(direction[:, 1]) @ both[1]
        for both, direction, _, _ in rows
    ], format="csr")  # fmt: skip
    return design, np.concatenate([row[2] for row in rows]), np.concatenate([row[3] for row in rows])


def _even_speed(basis: Basis, curve: BSpline) -> tuple[sparse.csr_array, Array]:
    """Each second the acceleration along the path is about zero: design, sigma."""
    first, last = basis.knots[DEGREE], basis.knots[-DEGREE - 1]
    at = np.linspace(first, last, max(2, int(last - first)))
    vel = curve.derivative()(at)
    ahead = vel / np.maximum(np.hypot(*vel.T), 1.0)[:, None]
    bends = basis.bends(at)
    design = sparse.kron(sparse.diags_array(ahead[:, 0]) @ bends, [[1.0, 0.0]]) + sparse.kron(
        sparse.diags_array(ahead[:, 1]) @ bends, [[0.0, 1.0]]
    )
    return design.tocsr(), np.full(len(at), SPEEDING)


def _take(rate: list[sparse.csr_array], known: NDArray[np.intp]) -> list[sparse.csr_array]:
    return [matrix[known] for matrix in rate]


def _densities(basis: Basis, curve: BSpline, much: float, calm: float) -> Array:
    """Power density of jerk that is granted at each third difference: more around turns."""
    at = basis.thirds
    at = np.clip(at, basis.knots[DEGREE], basis.knots[-DEGREE - 1])
    acc = curve.derivative(2)(at)
    size = np.hypot(*acc.T) if acc.ndim > 1 else np.abs(acc)
    share = np.clip(size / much, 0.0, 1.0) ** 2
    reach = max(1, round(SPREAD / basis.step))
    padded = np.pad(share, reach, mode="edge")
    most = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=-1)
    return np.asarray(calm * (TURNING / calm) ** most)


def _fit_height(basis: Basis, points: Trajectory, scatter: Scatter) -> Array:
    """Coefficients (size,) of the height."""
    t = points.t
    design, target = basis.values(t), points.height
    sigma = np.full(len(t), scatter.height)
    known: NDArray[np.bool_] = np.isfinite(points.climb)
    if known.any():
        fine = max(CLIMB_SIGMA, points.steps.get("vertical_rate", 0.0))
        design = sparse.vstack([design, basis.slopes(t[known])], format="csr")
        target = np.concatenate([target, points.climb[known]])
        sigma = np.concatenate([sigma, np.full(int(known.sum()), fine)])
    found = np.interp(basis.middles, t, points.height)
    density = np.full(basis.size, 0.01)
    for _ in range(2):
        found = solve(design.tocsr(), target, sigma, basis.roughness(density), found, DEGREE)
        density = _densities(basis, basis.spline(found), CLIMB_ACCELERATION, LEVEL)
    return np.asarray(found)
