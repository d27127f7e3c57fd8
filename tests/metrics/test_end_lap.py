"""End laps against closed forms and dense ray casting."""

import math

import numpy as np
import pytest
from photo_world import CAMERA, HALF_ANGLE, flat, ground_of, march, view_at, window_of

from aerosim.frames import radii, rot_z
from aerosim.metrics.end_lap import end_lap, end_lap_terrain
from aerosim.metrics.footprint import Ground, Relief, View
from aerosim.truth import CameraPose

DEPTH = 3000.0
LENGTH = DEPTH * CAMERA.rows / CAMERA.focal_px
TAN = np.tan(HALF_ANGLE)


def terrain_lap(view: View, previous: View, ground: Ground) -> float:
    patch = Relief(ground, view.pose.lat, view.pose.lon).under(view)
    assert patch is not None
    return end_lap_terrain(view, previous, patch)


@pytest.mark.parametrize("heading", [0.0, 90.0, 233.0])
@pytest.mark.parametrize("base", [1000.0, 1800.0, 5000.0])
def test_level_parallel_photos_over_a_plane(heading: float, base: float) -> None:
    ahead = np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0.0])
    view, previous = view_at((0.0, 0.0, 0.0), heading, 0.0, 0.0), view_at(-base * ahead, heading, 0.0, 0.0)
    assert end_lap(view, previous, 300.0) == pytest.approx(1.0 - base / LENGTH, abs=1e-9)


def test_level_photos_over_the_curved_earth() -> None:
    # Flown north by an angle g of the meridian's circle (radius R + H): in the plane of this photo the previous
    # one stands (R + H) sin g behind, (R + H)(1 - cos g) deeper, and looks forward by g.
    height, radius, base = 3300.0, float(radii(view_at((0.0, 0.0, 0.0)).pose.lat)[0]), 1800.0
    here = view_at((0.0, 0.0, 0.0)).pose
    g = base / (radius + height)
    back = CameraPose(0.0, here.lat - g, here.lon, height, here.vel_n, np.eye(3), np.zeros(3))
    front = -(radius + height) * np.sin(g) + (DEPTH - (radius + height) * (1.0 - np.cos(g))) * np.tan(
        HALF_ANGLE + g
    )
    expected = (front + DEPTH * TAN) / (2.0 * DEPTH * TAN)
    found = end_lap(View(CAMERA, here), View(CAMERA, back), 300.0)
    assert found == pytest.approx(expected, abs=1e-6)
    # The curve itself is worth 2 H/R of the base and less.
    assert found == pytest.approx(1.0 - base / LENGTH, abs=4e-4)


def test_pitch_of_either_photo() -> None:
    # Pitched forward by p: front H tan(a + p), rear -H tan(a - p).
    base, pitch = 1800.0, np.radians(1.0)
    front, rear = DEPTH * np.tan(HALF_ANGLE + pitch), -DEPTH * np.tan(HALF_ANGLE - pitch)
    back = (-base, 0.0, 0.0)
    pitched, level = view_at((0.0, 0.0, 0.0), 0.0, 1.0, 0.0), view_at(back)
    assert end_lap(pitched, level, 300.0) == pytest.approx((-base + DEPTH * TAN - rear) / (front - rear), abs=1e-9)
    pitched, level = view_at(back, 0.0, 1.0, 0.0), view_at((0.0, 0.0, 0.0))
    assert end_lap(level, pitched, 300.0) == pytest.approx((front - base + DEPTH * TAN) / LENGTH, abs=1e-9)


def test_a_shift_aside_counts_only_by_its_direction_and_crab_by_its_cosine() -> None:
    crab = np.radians(5.0)
    view, previous = view_at((0.0, 0.0, 0.0), 5.0, 0.0, 0.0), view_at((-1800.0, 0.0, 0.0), 5.0, 0.0, 0.0)
    expected = 1.0 - 1800.0 / (LENGTH * np.cos(crab))
    assert end_lap(view, previous, 300.0) == pytest.approx(expected, abs=1e-9)


def test_photos_from_one_place_have_no_direction() -> None:
    assert math.isnan(end_lap(view_at((0.0, 0.0, 0.0)), view_at((0.0, 0.0, 0.0)), 300.0))


def test_on_level_ground_both_laps_are_the_same() -> None:
    view, previous = view_at((0.0, 0.0, 0.0), 40.0, 0.7, 0.0), view_at((-1379.0, -1157.0, 0.0), 40.0, -0.4, 0.0)
    assert terrain_lap(view, previous, flat()) == pytest.approx(end_lap(view, previous, 300.0), abs=3e-4)


def test_roll_takes_the_least_of_the_three_columns() -> None:
    # Yawed by y against the previous photo, about its own middle: on level ground the previous front edge, seen
    # along column c (tangent t), lies at the s where it is crossed: closed form by intersecting the two lines.
    base, yaw = 1800.0, np.radians(2.0)
    view, previous = view_at((0.0, 0.0, 0.0), 2.0, 0.0, 0.0), view_at((-base, 0.0, 0.0))
    laps = []
    for t in (-TAN, 0.0, TAN):
        rear, front = -TAN * np.cos(yaw) - t * np.sin(yaw), TAN * np.cos(yaw) - t * np.sin(yaw)
        laps.append((-base / DEPTH + TAN - rear) / (front - rear))
    assert max(laps) - min(laps) > 0.02
    assert terrain_lap(view, previous, flat()) == pytest.approx(min(laps), abs=3e-4)


def test_uncovered_and_fully_covered_photos() -> None:
    view = view_at((0.0, 0.0, 0.0))
    assert terrain_lap(view, view_at((-5000.0, 0.0, 0.0)), flat()) == 0.0
    assert terrain_lap(view, view_at((50.0, 0.0, 0.0)), flat()) == 1.0


def by_dense_rays(view: View, previous: View, window, rows: int = 1200) -> float:
    """The contract's words once more: every column, first ground point in front of the previous front edge."""
    laps = []
    for col in (-0.5, (CAMERA.cols - 1) / 2.0, CAMERA.cols - 0.5):
        row = np.linspace(CAMERA.rows - 0.5, -0.5, rows)
        los = np.column_stack([(CAMERA.rows - 1) / 2.0 - row, np.full(rows, col - (CAMERA.cols - 1) / 2.0)])
        los = np.column_stack([los, np.full(rows, CAMERA.focal_px)])
        rays_e = los / np.linalg.norm(los, axis=1)[:, None] @ view.mat_ec.T
        points = march(window, view.pos_e, rays_e)
        up = view.pos_e / np.linalg.norm(view.pos_e)
        flown = view.pos_e - previous.pos_e
        level = flown - (flown @ up) * up
        s = points @ (level / np.linalg.norm(level))
        in_previous = (points - previous.pos_e) @ previous.mat_ec
        first = int(np.argmax(in_previous[:, 0] / in_previous[:, 2] > TAN))
        laps.append((s[first] - s[0]) / (s[-1] - s[0]))
    return min(laps)


@pytest.mark.parametrize("course", [0.0, 233.0])
@pytest.mark.parametrize(
    ("name", "height"),
    [
        ("ridge across", lambda x, y: 300.0 + 300.0 * np.exp(-(((y - 400.0) / 300.0) ** 2)) + 0.0 * x),
        ("valley along", lambda x, y: 600.0 - 300.0 * np.exp(-((x / 900.0) ** 2)) + 0.0 * y),
        ("hills", lambda x, y: 400.0 + 200.0 * np.sin(x / 400.0) * np.cos(y / 350.0)),
        ("steps", lambda x, y: 300.0 + 250.0 * (np.sin(y / 170.0) > 0.0) + 0.0 * x),
    ],
)
def test_end_lap_on_relief_is_that_of_dense_rays(name: str, height, course: float) -> None:
    window = window_of(height)
    back = rot_z(np.radians(course)) @ [-1750.0, 60.0, 20.0]
    view, previous = view_at((0.0, 0.0, 0.0), course + 3.0, 1.5, -2.0), view_at(back, course - 2.0, -1.0, 1.0)
    expected = by_dense_rays(view, previous, window)
    assert terrain_lap(view, previous, ground_of(window)) == pytest.approx(expected, abs=0.005), name


def test_relief_makes_the_two_laps_differ() -> None:
    # All but the rear end lies 300 m higher: front edges on 600 m, the rear edge on 300 m, in closed form.  A wall
    # of one cell is hidden by nothing.  The plane's figure, at the mean height, is another.
    window = window_of(lambda x, y: np.where(y > -1500.0, 600.0, 300.0) + 0.0 * x)
    view, previous = view_at((0.0, 0.0, 0.0)), view_at((-1800.0, 0.0, 0.0))
    found = terrain_lap(view, previous, ground_of(window))
    assert found == pytest.approx(1.0 - 1800.0 / (TAN * (2700.0 + 3000.0)), abs=4e-4)
    assert found - end_lap(view, previous, 550.0) > 0.01


def test_unknown_ground_gives_no_lap() -> None:
    window = window_of(lambda x, y: np.where(y > 1000.0, np.nan, 300.0))
    view, previous = view_at((0.0, 0.0, 0.0)), view_at((-1800.0, 0.0, 0.0))
    assert math.isnan(terrain_lap(view, previous, ground_of(window)))
