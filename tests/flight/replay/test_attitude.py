"""Attitude filled in by coordinated flight, against closed forms and other rotations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from aerosim.flight.replay.attitude import (
    Attitude,
    GivenAttitude,
    body_rates,
    coordinated,
    gust_n,
    slope,
    with_given,
)
from aerosim.flight.replay.trajectory import Trajectory
from aerosim.frames import GRAVITY, WGS84_A, Array, mat_from_attitude, wrap_pi

RATE = 120.0


def circle(speed: float, rate: float, climb: float = 0.0) -> tuple[Array, Array]:
    """Velocity and acceleration of a steady turn, to the right for rate > 0, in n; and the time step's grid."""
    t = np.arange(0.0, 10.0, 1.0 / RATE)
    velocity = np.stack([speed * np.cos(rate * t), speed * np.sin(rate * t), np.full_like(t, -climb)], axis=-1)
    acceleration = np.stack([-speed * rate * np.sin(rate * t), speed * rate * np.cos(rate * t), 0.0 * t], axis=-1)
    return velocity, acceleration


def test_a_steady_turn_banks_into_it() -> None:
    velocity, acceleration = circle(70.0, 0.05)
    found = coordinated(velocity, acceleration, 0.0)
    assert found.roll == pytest.approx(math.atan(70.0 * 0.05 / GRAVITY))
    assert found.pitch == pytest.approx(0.0, abs=1e-12)
    assert np.diff(found.heading) == pytest.approx(0.05 / RATE)
    left = coordinated(*circle(70.0, -0.05), 0.0)
    assert left.roll == pytest.approx(-found.roll)


def test_a_climb_pitches_up_by_its_angle_and_the_angle_of_attack() -> None:
    found = coordinated(*circle(70.0, 0.0, climb=5.0), math.radians(2.0))
    assert found.pitch == pytest.approx(math.atan2(5.0, 70.0) + math.radians(2.0))
    assert found.heading == pytest.approx(0.0, abs=1e-12)
    assert found.roll == pytest.approx(0.0, abs=1e-12)


def test_there_is_no_sideslip_at_any_bank() -> None:
    """The air comes from straight ahead, an angle of attack below the nose, whatever the attitude."""
    alpha = math.radians(4.0)
    velocity, acceleration = circle(60.0, 0.07, climb=3.0)
    found = coordinated(velocity, acceleration, alpha)
    for k in (0, 300, 900):
        mat_nb = mat_from_attitude(found.heading[k], found.pitch[k], found.roll[k])
        u, v, w = mat_nb.T @ velocity[k]
        assert v == pytest.approx(0.0, abs=1e-9)
        assert math.atan2(w, u) == pytest.approx(alpha)
        # and the lift, across the velocity and in the aircraft's plane, points to the inside of the turn
        lift = mat_nb @ np.array([math.sin(alpha), 0.0, -math.cos(alpha)])
        assert lift @ acceleration[k] > 0.0


def angles(t: Array) -> Attitude:
    """A flight that rolls, pitches and turns through north, known as functions."""
    return Attitude(
        0.3 * np.sin(1.1 * t), 0.05 + 0.08 * np.sin(0.7 * t), np.radians(350.0) + 0.2 * t + 0.1 * np.sin(0.4 * t)
    )


def test_rates_are_the_derivative_of_the_rotation() -> None:
    """omega from two matrices a moment apart, by scipy."""
    t = np.arange(0.0, 20.0, 1.0 / RATE)
    wide = angles(t)
    rate = Attitude(*(slope(angle, 1.0 / RATE) for angle in wide))
    now = Attitude(*(angle[2:-2] for angle in wide))
    count = len(now.roll)
    # no motion over the ellipsoid: omega_nb_b
    found = body_rates(now, rate, np.full(count, 0.8), np.zeros(count), np.zeros((count, 3)))
    for k in (0, 500, 1700):
        mats = [
            Rotation.from_matrix(mat_from_attitude(*(angle[0] for angle in reversed(angles(np.array([moment]))))))
            for moment in (t[k + 2] - 1e-4, t[k + 2] + 1e-4)
        ]
        omega = (mats[0].inv() * mats[1]).as_rotvec() / 2e-4
        # five-point differences at 120 Hz of 1.1 rad/s: (1.1/120)^4/30 of 0.3 rad/s, 1e-10
        assert found[k] == pytest.approx(omega, abs=1e-7)


def test_a_level_flight_over_the_curved_earth_pitches_down() -> None:
    """omega_eb_b of an aircraft that keeps level going north: -v/R about its right wing."""
    one = np.ones(3)
    still = Attitude(0.0 * one, 0.0 * one, 0.0 * one)
    found = body_rates(still, still, 0.0 * one, 0.0 * one, np.array([[100.0, 0.0, 0.0]] * 3))
    # at the equator the meridian's radius is a (1 - e^2)
    assert found[0] == pytest.approx([0.0, -100.0 / (WGS84_A * (1.0 - 0.00669438)), 0.0], rel=1e-6)


def test_gusts_turn_like_any_vector_of_b() -> None:
    now = Attitude(np.array([0.3]), np.array([-0.1]), np.array([2.0]))
    assert gust_n(now, np.array([[1.0, -2.0, 3.0]]))[0] == pytest.approx(
        mat_from_attitude(2.0, -0.1, 0.3) @ [1.0, -2.0, 3.0]
    )


def given(t: Array, roll: Array | None, pitch: Array | None, heading: Array | None) -> GivenAttitude:
    zero = np.zeros_like(t)
    return GivenAttitude.of(
        Trajectory(
            "x", t, zero, zero, zero, zero, zero, zero, roll, pitch, heading, np.arange(len(t)), {}
        )
    )  # fmt: skip


def test_given_angles_are_interpolated_as_rotations() -> None:
    """Between points 0.1 s apart, against scipy's slerp of the true rotations, through north."""
    t = np.arange(0.0, 30.0, 0.1)
    told = angles(t)
    found = given(t, told.roll, told.pitch, np.unwrap(wrap_pi(told.heading)))
    fine = np.arange(1.0, 29.0, 0.013)
    nothing = Attitude(0.0 * fine, 0.0 * fine, 0.0 * fine)
    smooth = with_given(nothing, found, fine)
    between = Slerp(t, Rotation.from_euler("ZYX", np.stack([told.heading, told.pitch, told.roll], axis=-1)))
    error = (between(fine).inv() * Rotation.from_euler("ZYX", np.stack(smooth[::-1], axis=-1))).magnitude()
    # slerp itself cuts corners: 0.1^2/8 of 0.36 rad/s^2 is 4.5e-4 rad; the truth is met ten times better
    assert error.max() < 6e-4
    for name in Attitude._fields:
        assert getattr(smooth, name) == pytest.approx(
            getattr(angles(fine), name) - (2.0 * np.pi if name == "heading" else 0.0), abs=5e-5
        )


def test_what_is_missing_is_filled_in() -> None:
    t = np.arange(0.0, 30.0, 0.1)
    told = given(t, None, None, np.full_like(t, 0.7))
    filled = Attitude(np.full(5, 0.1), np.full(5, 0.2), np.full(5, 0.3))
    found = with_given(filled, told, np.linspace(5.0, 10.0, 5))
    assert found.roll == pytest.approx(0.1)
    assert found.pitch == pytest.approx(0.2)
    assert found.heading == pytest.approx(0.7)
    empty = given(t, np.full_like(t, np.nan), None, None)
    assert empty.roll is None
