"""Footprints against closed forms and against slow marching in ECEF."""

import numpy as np
import pytest
from photo_world import CAMERA, HALF_ANGLE, LAT, LON, UTM, Tight, Whole, flat, march, pose_at, view_at, window_of

from aerosim.frames import MapGrid, geodetic_from_ecef
from aerosim.metrics.footprint import Ground, Relief, View, footprint
from aerosim.projection import Camera


def hills(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 400.0 + 200.0 * np.sin(x / 600.0) * np.cos(y / 800.0) + 100.0 * np.sin((x + y) / 310.0)


def seen(view: View, ground: Ground):
    return footprint(view, Relief(ground, view.pose.lat, view.pose.lon).under(view))


def test_level_photo_over_level_ground_has_the_size_of_the_format_over_the_scale() -> None:
    # On a sphere of radius R a ray at the angle a from the vertical, from H above it, is (R + H) cos a -
    # sqrt(R^2 - (R + H)^2 sin^2 a) long; the ellipsoid's radii there differ by 0.3 % from the mean: 2 mm.
    corners = seen(view_at((0.0, 0.0, 0.0)), flat(300.0)).corners_n
    radius, slope = 6_371_000.0 + 300.0, np.arctan(np.sqrt(2.0) * np.tan(HALF_ANGLE))
    top = (radius + 3000.0) * np.cos(slope)
    length = top - np.sqrt(radius**2 - ((radius + 3000.0) * np.sin(slope)) ** 2)
    side = length * np.sin(slope) / np.sqrt(2.0)
    np.testing.assert_allclose(np.abs(corners[:, :2]), side, atol=0.01)
    np.testing.assert_array_equal(np.sign(corners[:, :2]), [[1, -1], [1, 1], [-1, 1], [-1, -1]])
    # The plane's figure, 3000 m x 230 / 153, is short by the drop of the corners, 0.8 m: 1.2 m.
    assert 2.0 * side == pytest.approx(3000.0 * 19167 * 0.012 / 153.0, abs=1.5)


def test_heading_turns_the_corners_clockwise() -> None:
    corners = seen(view_at((0.0, 0.0, 0.0), 90.0, 0.0, 0.0), flat()).corners_n
    # Flown east, the front left corner lies north-east.
    np.testing.assert_array_equal(np.sign(corners[:, :2]), [[1, 1], [-1, 1], [-1, -1], [1, -1]])


def test_a_degree_of_pitch_moves_the_footprint_by_1_16_per_cent() -> None:
    # tan(1 deg) x 153 / 230 of its length forward (the study's figure); positive roll moves it to the left.
    length = 3000.0 * CAMERA.rows / CAMERA.focal_px
    north, east, _ = seen(view_at((0.0, 0.0, 0.0), 0.0, 1.0, 0.0), flat()).centre_n / length
    assert north == pytest.approx(0.01161, abs=1e-5)
    assert east == pytest.approx(0.0, abs=1e-9)
    north, east, _ = seen(view_at((0.0, 0.0, 0.0), 0.0, 0.0, 1.0), flat()).centre_n / length
    assert east == pytest.approx(-0.01161, abs=1e-5)


@pytest.mark.parametrize("attitude", [(0.0, 0.0, 0.0), (77.0, 2.5, -3.0), (250.0, -4.0, 2.0)])
@pytest.mark.parametrize("camera", [CAMERA, Camera(9000.0, rows=9000, cols=5000, row0=4300.0, col0=2600.0)])
def test_corners_and_middle_on_relief_are_those_of_marching_in_ecef(attitude, camera) -> None:
    window = window_of(hills)
    view = View(camera, pose_at((200.0, -100.0, 0.0), attitude))
    found = seen(view, Ground(UTM, Whole(window)))
    los = camera.rays(np.vstack([camera.corners, camera.centre]))
    rays_e = los / np.linalg.norm(los, axis=1)[:, None] @ view.mat_ec.T
    points = view.to_ecef(np.vstack([found.corners_n, found.centre_n]))
    assert np.linalg.norm(points - march(window, view.pos_e, rays_e), axis=1).max() < 0.1


def test_mean_height_is_that_of_the_ground_inside() -> None:
    window = window_of(lambda x, y: 300.0 + 0.05 * x - 0.02 * y + 80.0 * np.cos(x / 150.0) * np.cos(y / 190.0))
    found = seen(view_at((0.0, 0.0, 0.0), 20.0, 2.0, 3.0), Ground(UTM, Whole(window)))
    # All cells whose centre lies within the quadrangle of the corners; waves of 1 km in 4.5 km leave some metres
    # of the relief of 80 m, so a mean over too small or too large a part, or over pixels, would show.
    lat, lon, _ = geodetic_from_ecef(view_at((0.0, 0.0, 0.0)).to_ecef(found.corners_n))
    corners = np.column_stack(UTM.from_geodetic(lat, lon))
    rows, cols = window.values.shape
    e, n = np.meshgrid(window.x0 + window.dx * np.arange(cols), window.y0 + window.dy * np.arange(rows))
    inside = np.ones(e.shape, bool)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        inside &= (b[0] - a[0]) * (n - a[1]) - (b[1] - a[1]) * (e - a[0]) < 0.0
    assert inside.sum() > 40_000
    assert found.mean_height == pytest.approx(float(window.values[inside].mean()), abs=2.0)
    assert found.complete


def test_asking_for_no_more_ground_than_needed_changes_nothing() -> None:
    window = window_of(lambda x, y: 600.0 - 500.0 * np.exp(-((x / 1500.0) ** 2)) + 0.0 * y)
    for attitude in [(0.0, 0.0, 0.0), (130.0, 3.0, -4.0)]:
        view = view_at((0.0, -2500.0, 0.0), *attitude)
        whole, tight = (seen(view, Ground(UTM, kind(window))) for kind in (Whole, Tight))
        np.testing.assert_allclose(tight.corners_n, whole.corners_n, atol=1e-3)
        assert tight.complete


def test_ground_that_ends_or_has_a_hole_is_not_complete() -> None:
    window = window_of(lambda x, y: np.where(y > 1000.0, np.nan, 300.0))
    found = seen(view_at((0.0, 0.0, 0.0)), Ground(UTM, Whole(window)))
    assert np.isnan(found.corners_n[:2]).all()
    assert np.isfinite(found.corners_n[2:]).all()
    assert np.isnan(found.mean_height)
    assert not found.complete
    window = window_of(lambda x, y: np.where(np.hypot(x - 700.0, y) < 400.0, np.nan, 300.0))
    found = seen(view_at((0.0, 0.0, 0.0)), Ground(UTM, Whole(window)))
    assert np.isfinite(found.corners_n).all()
    assert found.mean_height == pytest.approx(300.0)
    assert not found.complete


def test_a_photo_of_the_horizon_has_no_footprint() -> None:
    found = seen(view_at((0.0, 0.0, 0.0), 0.0, 50.0, 0.0), flat())
    assert np.isnan(found.corners_n).all()
    assert not found.complete


def test_north_is_true_north_and_not_that_of_the_grid() -> None:
    lat, lon, _ = geodetic_from_ecef(
        view_at((0.0, 0.0, 0.0)).to_ecef(seen(view_at((0.0, 0.0, 0.0)), flat()).corners_n)
    )
    # A level photo flown north at the reference: its two left corners lie symmetrical about the parallel, on
    # longitudes that differ only by the narrowing of the meridians; grid north is 1.6 deg (63 m a side) off.
    assert float((lon[0] - LON) / (lon[3] - LON)) == pytest.approx(np.cos(lat[3]) / np.cos(lat[0]), rel=1e-5)
    assert float(lat[:4].mean() - LAT) == pytest.approx(0.0, abs=2e-7)
    assert isinstance(UTM, MapGrid)
