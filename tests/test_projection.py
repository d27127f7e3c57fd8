"""Pinhole camera against OpenCV, closed forms and its own inverse."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerosim.errors import InputError
from aerosim.projection import Camera


def test_front_edge_looks_forward_and_last_column_to_starboard() -> None:
    camera = Camera(100.0, rows=11, cols=21)
    np.testing.assert_allclose(camera.rays([0.0, 20.0]), [5.0, 10.0, 100.0])
    np.testing.assert_allclose(camera.rays([[10.0, 0.0]]), [[-5.0, -10.0, 100.0]])
    np.testing.assert_allclose(camera.rays(camera.centre), [0.0, 0.0, 100.0])


def test_outer_corners_span_the_whole_format() -> None:
    # 230 x 60 mm before 152 mm: tangents of the half angles 115/152 and 30/152.
    camera = Camera.of_frame(0.152, (0.230, 0.060), 10e-6)
    assert (camera.rows, camera.cols) == (23000, 6000)
    along, across = 115.0 / 152.0, 30.0 / 152.0
    rays = camera.rays(camera.corners)
    expected = [[along, -across], [along, across], [-along, across], [-along, -across]]
    np.testing.assert_allclose(rays[:, :2] / rays[:, 2:], expected, rtol=1e-12)


def test_same_pixels_as_opencv() -> None:
    # OpenCV: x right, y down, z forward = y_c, -x_c, z_c; pixels (column, row), first centre at (0, 0).
    camera = Camera(1234.5, rows=800, cols=600, row0=390.25, col0=310.75)
    points_c = np.random.default_rng(1).normal(size=(50, 3)) * [300.0, 200.0, 100.0] + [0.0, 0.0, 1500.0]
    matrix = np.array([[1234.5, 0.0, 310.75], [0.0, 1234.5, 390.25], [0.0, 0.0, 1.0]])
    opencv = points_c[:, [1, 0, 2]] * [1.0, -1.0, 1.0]
    col_row, _ = cv2.projectPoints(opencv, np.zeros(3), np.zeros(3), matrix, None)
    np.testing.assert_allclose(camera.pixels(points_c), col_row[:, 0, ::-1], atol=1e-9)


@given(row=st.floats(-5e3, 3e4), col=st.floats(-5e3, 3e4), length=st.floats(1e-3, 1e6), row0=st.floats(-100, 2e4))
def test_there_and_back(row: float, col: float, length: float, row0: float) -> None:
    camera = Camera(12666.0, rows=19167, cols=9000, row0=row0, col0=4400.0)
    np.testing.assert_allclose(camera.pixels(length * camera.rays([row, col])), [row, col], atol=1e-7)


def test_nothing_is_seen_behind_the_camera() -> None:
    camera = Camera(100.0, rows=11, cols=21)
    assert np.isnan(camera.pixels([[1.0, 1.0, -5.0], [1.0, 1.0, 0.0]])).all()


@pytest.mark.parametrize(("focal", "rows"), [(0.0, 5), (np.nan, 5), (-1.0, 5), (100.0, 0)])
def test_a_camera_without_focal_length_or_picture_is_refused(focal: float, rows: int) -> None:
    with pytest.raises(InputError, match="camera with"):
        Camera(focal, rows=rows, cols=5)
