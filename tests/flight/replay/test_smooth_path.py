"""Smooth paths against paths known in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from flown_paths import Track, columns_of, on_plane, race_track, write_csv

from aerosim.flight.replay.smooth_path import SmoothPath, smooth_path
from aerosim.flight.replay.trajectory import read_trajectory
from aerosim.flight.replay.trajectory_pieces import flown_pieces
from aerosim.frames import WGS84_A, Array


def fitted(path: Path, columns: dict[str, Array], formats: dict[str, str] | None = None) -> SmoothPath:
    return smooth_path(read_trajectory(write_csv(path / "flight.csv", columns, formats)))


def off(path: SmoothPath, track: Track) -> tuple[Array, Array, Array]:
    """Errors along and across the true path (m), and of the velocity (n, 3)."""
    found = path.motion(track.t)
    north = (found.lat - track.lat) * WGS84_A
    east = (found.lon - track.lon) * WGS84_A * np.cos(track.lat)
    speed = np.hypot(*track.vel_n[:, :2].T)
    ahead = track.vel_n[:, :2] / speed[:, None]
    along, across = north * ahead[:, 0] + east * ahead[:, 1], east * ahead[:, 0] - north * ahead[:, 1]
    return along, across, found.vel_n - track.vel_n


def weave(rate: float) -> Track:
    """A course that swings by 2.4 deg in 30 s and a climb that swings by 0.9 m/s in 40 s."""
    t = np.arange(0.0, 300.0, 1.0 / rate)
    return on_plane(
        t, 65.0 * t, 13.0 * np.sin(2.0 * np.pi * t / 30.0), 3000.0 + 6.0 * np.sin(2.0 * np.pi * t / 40.0)
    )


def test_exact_points_are_kept_to_their_decimals(tmp_path: Path) -> None:
    fine = weave(100.0)
    path = fitted(
        tmp_path, columns_of(fine, 10), {"latitude_deg": ".9f", "longitude_deg": ".9f", "height_m": ".3f"}
    )
    along, across, velocity = off(path, fine)
    # 1e-9 deg is 0.1 mm, 1 mm of height; ten points a second leave room for no more
    assert np.abs(along).max() < 2e-3
    assert np.abs(across).max() < 2e-3
    inside = slice(200, -200)
    assert np.abs(velocity[inside]).max() < 0.01


def test_a_point_a_second_of_a_weaving_flight(tmp_path: Path) -> None:
    fine = weave(20.0)
    along, across, velocity = off(fitted(tmp_path, columns_of(fine, 20)), fine)
    inside = slice(100, -100)
    # the parabolas that judge the scatter see the swings too: a few centimetres of 13 m
    assert np.abs(along[inside]).max() < 0.1
    assert np.abs(across[inside]).max() < 0.1
    assert np.abs(velocity[inside]).max() < 0.1


def test_velocity_is_the_derivative_of_the_place(tmp_path: Path) -> None:
    path = fitted(tmp_path, columns_of(race_track(rate=1.0)))
    t = np.linspace(path.first + 1.0, path.last - 1.0, 500)
    step = 1e-3
    before, after = path.place(t - step), path.place(t + step)
    found = path.motion(t)
    from aerosim.frames import ecef_from_geodetic, mat_ne

    moved = (ecef_from_geodetic(*after) - ecef_from_geodetic(*before)) / (2.0 * step)
    turned = np.stack([mat_ne(a, b) @ v for a, b, v in zip(found.lat, found.lon, moved, strict=True)])
    # ECEF is good to 1e-9 m, over 2 ms that is 1e-6 m/s
    assert found.vel_n == pytest.approx(turned, abs=1e-5)


def received(track: Track, every: int, stale: float, seed: int) -> dict[str, Array]:
    """As a receiver logs it: positions old by up to `stale` s, whole seconds, knots, degrees and 25 ft."""
    rng = np.random.default_rng(seed)
    index = np.arange(0, len(track.t), every)
    dt = track.t[1] - track.t[0]
    old = np.maximum(index - (rng.uniform(0.0, stale, len(index)) / dt).astype(int), 0)
    speed = np.hypot(*track.vel_n[index, :2].T)
    return {
        "t_s": track.t[index],
        "latitude_deg": np.round(np.degrees(track.lat[old]), 5),
        "longitude_deg": np.round(np.degrees(track.lon[old]), 5),
        "barometric_altitude_ft": 25.0 * np.round(track.height[index] / 0.3048 / 25.0),
        "groundspeed_kt": np.round(speed * 3600.0 / 1852.0),
        "track_deg": np.round(np.degrees(np.arctan2(track.vel_n[index, 1], track.vel_n[index, 0])) % 360.0),
    }


def test_stale_stamps_move_the_points_along_the_path_only(tmp_path: Path) -> None:
    fine = race_track(rate=20.0, leg=18000.0)
    path = fitted(tmp_path, received(fine, 200, stale=5.0, seed=3))
    # uniform over 5 s: 1.44 s; from 50 points of straight flight, known to 10 % (one sigma 1.44/sqrt(2*50))
    assert path.scatter.stamp == pytest.approx(5.0 / np.sqrt(12.0), rel=0.35)
    along, across, velocity = off(path, fine)
    straight = (fine.t > 30.0) & (fine.t < 270.0) | (fine.t > 400.0) & (fine.t < fine.t[-1] - 30.0)
    # five decimals of a degree are 1.1 m; the mean staleness of 2.5 s x 60 m/s nobody can know
    assert np.abs(across[straight]).max() < 1.5
    assert (along[straight].mean() / 60.0) == pytest.approx(-2.5, abs=0.5)
    assert along[straight].std() < 0.4 * 60.0 * 5.0 / np.sqrt(12.0)
    # a knot is 0.51 m/s, the raw points say 20 m/s
    assert np.abs(velocity[straight, :2]).max() < 1.0
    assert np.sqrt((velocity[straight, 2] ** 2).mean()) < 0.2


def test_steps_of_height_leave_no_steps_in_the_climb(tmp_path: Path) -> None:
    t = np.arange(0.0, 600.0, 0.05)
    fine = on_plane(t, 60.0 * t, 0.0 * t, 1000.0 + 0.8 * t)
    path = fitted(tmp_path, received(fine, 200, stale=0.0, seed=4))
    found = path.motion(np.arange(30.0, 570.0, 1.0))
    # the path curves over the Earth with the plane's distance: take the true rate there
    true = np.interp(np.arange(30.0, 570.0, 1.0), t, fine.vel_n[:, 2])
    # 25 ft in 10 s are 0.76 m/s, rounding alone (25 ft/sqrt(6)/10 s) is 0.31 m/s rms
    assert np.sqrt(((found.vel_n[:, 2] - true) ** 2).mean()) < 0.15


def test_a_gap_is_crossed_straight(tmp_path: Path) -> None:
    fine = weave(20.0)
    columns = columns_of(fine, 20)
    keep = (columns["t_s"] < 100.0) | (columns["t_s"] > 160.0)
    path = fitted(tmp_path, {name: values[keep] for name, values in columns.items()})
    found = path.motion(np.arange(100.0, 160.0, 1.0))
    course = np.arctan2(found.vel_n[:, 1], found.vel_n[:, 0])
    # it left and came back on swings of 2.4 deg
    assert np.abs(course).max() < np.radians(6.0)
    assert np.abs(found.vel_n[:, 0] - 65.0).max() < 2.0


def test_one_wild_point_is_not_followed(tmp_path: Path) -> None:
    fine = race_track(rate=20.0, leg=18000.0)
    columns = received(fine, 200, stale=2.0, seed=5)
    columns["longitude_deg"][12] += 0.02  # 1.5 km aside, at 150 m/s: no jump by the limit
    points, notes = flown_pieces(read_trajectory(write_csv(tmp_path / "flight.csv", columns)), 120.0)
    assert "1 points far aside" in notes[0]
    assert "flight.csv:14" in notes[0]
    _, across, _ = off(smooth_path(points[0]), fine)
    assert np.abs(across[(fine.t > 30.0) & (fine.t < 270.0)]).max() < 15.0
