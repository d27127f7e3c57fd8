"""Polygons in the plane: against matplotlib's paths, shoelace by hand, brute force over directions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from matplotlib.path import Path

from aerosim import polygon
from aerosim.errors import InputError

U = np.array([(0, 0), (30, 0), (30, 20), (20, 20), (20, 5), (10, 5), (10, 20), (0, 20)], float)


def star(radii: list[float]) -> np.ndarray:
    """A ring that cannot cross itself: one corner in each direction."""
    angle = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1) * np.array(radii)[:, None]


stars = st.lists(st.floats(1.0, 100.0), min_size=5, max_size=14).map(star)


@given(stars)
def test_inside_is_that_of_another_library(ring: np.ndarray) -> None:
    x, y = np.linspace(-101.3, 99.7, 23), np.linspace(-100.9, 100.1, 19)
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    mine = polygon.inside(ring, x, y).ravel()
    outer, inner = (Path(ring).contains_points(points, radius=r) for r in (1e-6, -1e-6))
    sure = outer == inner  # its rule on the edge itself is another
    assert (mine == outer)[sure].all()


@given(stars)
def test_points_held_are_those_inside(ring: np.ndarray) -> None:
    x, y = np.linspace(-101.3, 99.7, 23), np.linspace(-100.9, 100.1, 19)
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    held = [Path(ring).contains_points(points, radius=r) for r in (1e-6, -1e-6)]
    sure = held[0] == held[1]
    assert (polygon.holds(ring, points) == held[0])[sure].all()
    assert not polygon.holds(ring, np.array([[np.nan, 0.0], [0.0, np.nan]])).any()


@settings(deadline=None)  # a timed test says nothing on a busy machine
@given(stars, st.floats(-90.0, 80.0), st.floats(1.0, 60.0))
def test_a_strip_is_what_its_sections_cover(ring: np.ndarray, low: float, thick: float) -> None:
    found = polygon.strip(ring, low, low + thick)
    sections = [each for y in np.linspace(low, low + thick, 400) for each in polygon.section(ring, y)]
    assume(sections)
    for a, b in sections:
        assert any(c - 1e-6 <= a and b <= d + 1e-6 for c, d in found)
    # and no more than them, but for the step between two sections at the steepest corner
    covered = polygon.merged(sections, 5.0)
    assert sum(d - c for c, d in found) <= sum(b - a for a, b in covered) + 0.02 * 400 + 10.0 * len(ring)


def test_a_strip_of_a_u_by_hand() -> None:
    assert polygon.strip(U, 10.0, 15.0) == [(0.0, 10.0), (20.0, 30.0)]
    assert polygon.strip(U, 4.0, 15.0) == [(0.0, 30.0)]
    assert polygon.strip(U, -5.0, -1.0) == []
    assert polygon.merged([(0.0, 10.0), (20.0, 30.0)], 10.0) == [(0.0, 30.0)]
    assert polygon.merged([(0.0, 10.0), (20.0, 30.0)], 9.0) == [(0.0, 10.0), (20.0, 30.0)]


def test_area_has_the_sign_of_the_turn() -> None:
    assert polygon.area(U) == 30 * 20 - 10 * 15
    assert polygon.area(U[::-1]) == -450


@given(stars)
def test_a_star_does_not_cross_itself(ring: np.ndarray) -> None:
    assert polygon.crossing(ring) is None
    assert polygon.crossing(ring[::-1]) is None


@pytest.mark.parametrize(
    ("ring", "at"),
    [
        ([(0, 0), (10, 10), (10, 0), (0, 10)], (5, 5)),  # a bow
        ([(0, 0), (10, 0), (10, 10), (5, 0), (0, 10)], (5, 0)),  # touches its own side
        ([(0, 0), (10, 0), (10, 10), (10, 20), (10, 10), (0, 10)], (10, 20)),  # goes out and back
        ([(0, 0), (10, 0), (5, 5), (10, 10), (0, 10), (5, 5)], (5, 5)),  # touches at a corner
        ([(0, 0), (20, 0), (20, 10), (15, 10), (15, -5), (5, -5), (5, 10), (0, 10)], (15, 0)),
    ],
)
def test_where_a_ring_crosses_itself(ring: list[tuple[float, float]], at: tuple[float, float]) -> None:
    found = polygon.crossing(np.array(ring, float))
    assert found is not None
    assert found == pytest.approx(at)


@given(stars)
def test_the_narrowest_direction_by_trial(ring: np.ndarray) -> None:
    def width(azimuth: float) -> float:
        return float(np.ptp(ring @ np.array([math.cos(azimuth), -math.sin(azimuth)])))

    tried = min(width(a) for a in np.linspace(0.0, np.pi, 721))
    assert width(polygon.narrowest(ring)) <= tried + 1e-6


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ([], "0 distinct corners"),
        ([(0, 0), (1, 0), (0, 0)], "2 distinct corners"),
        ([(0, 0), (50, 50), (100, 100)], "area of zero"),
        ([(0, 0), (math.nan, 1), (1, 0)], "not a number"),
        (star([50.0] * 2001).tolist(), "polygon with 2001 corners"),
    ],
)
def test_points_that_are_no_ring(points: list[tuple[float, float]], words: str) -> None:
    with pytest.raises(InputError, match=words):
        polygon.ring_of(np.array(points, float).reshape(-1, 2))


def test_a_closed_ring_loses_its_last_corner() -> None:
    assert polygon.ring_of(np.vstack([U, U[:1]])).shape == (8, 2)
