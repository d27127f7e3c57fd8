"""A look for a strip on drawn ground: stripes, moving shadows, dead pixels, a camera that turns."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from aerosim.estimation.tracking.edges import beside, edges
from aerosim.estimation.tracking.look import CLEAN, Looked, View, Where, look
from aerosim.signals import Reason

PIXELS, MARGIN, STEPS_PER_PX, RING = 96, 7, 6.5, 128
ALL, WIDE = np.ones(PIXELS, np.float32), np.ones(PIXELS + 2 * MARGIN, np.float32)
BOW = np.zeros(PIXELS)
MIDDLE = 64
Ground = Callable[[np.ndarray, np.ndarray], np.ndarray]


def land(seed: int, contrast: float = 1.0) -> Ground:
    """Grey values of a ground of waves of 5 to 80 px; (across, along), px."""
    rng = np.random.default_rng(seed)
    length = np.exp(rng.uniform(np.log(5.0), np.log(80.0), 80))
    course, phase = rng.uniform(0, 2 * np.pi, 80), rng.uniform(0, 2 * np.pi, 80)
    kx, ky = 2 * np.pi / length * np.cos(course), 2 * np.pi / length * np.sin(course)
    size = contrast * 4.0 * np.sqrt(length) / np.sqrt(length).mean()

    def grey(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray(
            110.0 + (size * np.cos(np.multiply.outer(x, kx) + np.multiply.outer(y, ky) + phase)).sum(-1)
        )

    return grey


def stripes(seed: int, course_deg: float, period: float) -> Ground:
    """Stripes over a tenth of the land's contrast; course from along the flight."""
    rest, course = land(seed, 0.1), math.radians(course_deg)

    def grey(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        wave = 2.0 * np.pi / period * (x * math.cos(course) - y * math.sin(course))
        return rest(x, y) + 54.0 * np.sin(wave) * np.sinc(1.0 / period)

    return grey


def seen(ground: Ground, mu: float, step: float, shade: Ground | None = None, wind: float = 0.0, seed: int = 0):
    """Row I and the ring of row II over a ground; shade: factor of the light, moved on by `wind` px meanwhile."""
    rng = np.random.default_rng(seed)
    i, j = np.arange(-MARGIN, PIXELS + MARGIN, dtype=float), np.arange(PIXELS, dtype=float)
    along = np.broadcast_to((np.arange(RING)[:, None] - step) / STEPS_PER_PX, (RING, PIXELS))
    x2, y2 = np.broadcast_to(j + mu, along.shape), along
    row1, rows2 = ground(i, np.zeros_like(i)), ground(x2, y2)
    if shade is not None:
        row1, rows2 = row1 * shade(i, np.zeros_like(i)), rows2 * shade(x2, y2 - wind)
    return tuple((np.round(r + rng.normal(0.0, 1.5, r.shape))).astype(np.float32) for r in (row1, rows2))


def clouds(seed: int) -> Ground:
    """Shadows of 40 px that take 60 % of the light, with rims of 2 px."""
    field = land(seed)

    def light(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray(0.7 + 0.3 * np.tanh((field(0.25 * x, 0.25 * y) - 110.0) / 3.0))

    return light


def grey_view(row1: np.ndarray, rows2: np.ndarray) -> View:
    return View(row1, rows2, WIDE, ALL)


def edge_view(row1: np.ndarray, rows2: np.ndarray) -> View:
    sharp1, sharp2 = np.empty_like(row1), np.empty_like(rows2)
    edges(row1, WIDE, sharp1)
    for row, sharp in zip(rows2, sharp2, strict=True):
        edges(row, ALL, sharp)
    return View(sharp1, sharp2, beside(WIDE), beside(ALL), edges=True)


def looked(view: View, along: float = 3.0) -> Looked:
    half = round(along * STEPS_PER_PX)
    where = Where(MIDDLE - half, MIDDLE + half, 0, MARGIN, (0.0,), True)
    return look(view, where, lambda number: 0.0, lambda number, mu: 0.0, STEPS_PER_PX, BOW)


def off(found: Looked, mu: float, step: float, along: float = 3.0) -> float:
    """Error on the ground, px."""
    begin = MIDDLE - round(along * STEPS_PER_PX)
    return math.hypot(found.trough.mu - mu, (begin + found.trough.step - step) / STEPS_PER_PX)


def places(count: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(-3.0, 3.0, count), MIDDLE + rng.uniform(-8.0, 8.0, count)])


def test_sound_rows_over_land_are_clean() -> None:
    for k, (mu, step) in enumerate(places(12, 1)):
        found = looked(grey_view(*seen(land(k), mu, step)))
        assert found.clean
        assert off(found, mu, step) < 0.25


@pytest.mark.parametrize("course_deg", [30.0, 60.0, -45.0])
@pytest.mark.parametrize("period", [3.0, 17.7])
def test_along_stripes_nothing_is_measured(course_deg: float, period: float) -> None:
    """A valley and not a trough: what passes all the same must be right. In grey values and in edges."""
    for k, (mu, step) in enumerate(places(12, 2)):
        rows = seen(stripes(k, course_deg, period), mu, step, seed=k)
        for view in (grey_view(*rows), edge_view(*rows)):
            found = looked(view)
            assert not found.accepted or off(found, mu, step) < 0.35


def test_moving_shadows_leave_grey_values_in_doubt_and_edges_right() -> None:
    """The shadows have moved on by 4.6 px.  0.35 px are 0.5 deg, of which 0.2 px rms leave 8 % beyond."""
    doubtful, errors = 0, []
    for k, (mu, step) in enumerate(places(24, 3)):
        rows = seen(land(k), mu, step, clouds(100 + k), wind=4.6, seed=k)
        grey, sharp = looked(grey_view(*rows)), looked(edge_view(*rows))
        doubtful += not grey.clean
        if sharp.accepted:
            errors.append(sharp.trough.mu - mu)
    assert doubtful >= 20
    assert len(errors) >= 10
    assert np.sqrt(np.mean(np.square(errors))) < 0.2
    assert np.abs(errors).max() < 0.5


def test_clean_is_a_matter_of_what_is_left() -> None:
    found = looked(grey_view(*seen(land(2), 1.0, 60.0)))
    assert found.clean
    assert not found._replace(left=CLEAN * 1.01).clean
    assert not found._replace(trough=found.trough._replace(reason=Reason.WEAK)).clean


def test_pixels_of_row_1_that_do_not_count_do_no_harm() -> None:
    weights = WIDE.copy()
    weights[40:50] = 0.0
    row1, rows2 = seen(land(4), 1.5, 62.0)
    sound = row1.copy()
    row1[40:50] = np.linspace(row1[39], row1[50], 10)  # as they are mended for the differences
    view = View(row1, rows2, weights, ALL)
    found, whole = looked(view), looked(grey_view(sound, rows2))
    assert found.clean
    # a tenth of the pixels less: the two differ by about a third of one standard deviation of 0.05 px
    assert off(found, 1.5, 62.0) < 0.25
    assert found.trough.mu == pytest.approx(whole.trough.mu, abs=0.06)
    assert found.left < looked(View(row1, rows2, WIDE, ALL)).left
