"""Edges of rows: what a shadow, a gain and dead pixels leave of them."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.estimation.tracking.edges import CLIP, SIZE, beside, common, edges

PIXELS = 96
ALL = np.ones(PIXELS, np.float32)


def land(seed: int = 1, size: int = PIXELS) -> np.ndarray:
    """Rough land, 110 grey levels in the mean."""
    rng = np.random.default_rng(seed)
    return (110.0 + np.convolve(rng.normal(0.0, 30.0, size + 2), [0.3, 0.4, 0.3], "valid")).astype(np.float32)


def edged(row: np.ndarray, weights: np.ndarray = ALL) -> np.ndarray:
    out = np.empty(len(row), np.float32)
    edges(row, weights, out)
    return out


@pytest.mark.parametrize("gain", [0.4, 1.0, 1.2])
def test_a_gain_changes_nothing(gain: float) -> None:
    assert edged(np.float32(gain) * land()) == pytest.approx(edged(land()), abs=1e-3)


def test_edges_are_of_one_size_and_none_is_great() -> None:
    found = edged(land())
    assert np.abs(found).mean() == pytest.approx(SIZE, rel=0.1)
    assert np.abs(found).max() <= CLIP * SIZE * 1.001
    assert not found[[0, -1]].any()


def test_a_shadow_changes_its_rim_only() -> None:
    """Half of the light from pixel 40 on: edges beside 39 and 40 jump, the others keep their shape."""
    shaded = land()
    shaded[40:] *= 0.5
    plain, other = edged(land()), edged(shaded)
    rim = [39, 40]
    away = np.setdiff1d(np.arange(PIXELS), rim)
    assert (np.abs(other[rim]) > 0.99 * CLIP * SIZE).all()
    # one rim of two pixels in 94 moves the mean size by 2 x 3 / 94 at most, and what is cut off with it
    ratio = other[away] @ plain[away] / (plain[away] @ plain[away])
    assert ratio == pytest.approx(1.0, abs=0.08)
    assert np.corrcoef(plain[away], other[away])[0, 1] > 0.995


def test_beside_a_pixel_that_does_not_count_there_is_no_edge() -> None:
    weights = ALL.copy()
    weights[30] = 0.0
    row = land()
    row[30] = 0.0
    found = edged(row, weights)
    assert not found[[29, 31]].any()
    assert found[30] != 0.0
    assert np.flatnonzero(beside(weights) == 0.0).tolist() == [0, 29, 31, 95]


def test_a_row_without_contrast_has_no_edges() -> None:
    assert not edged(np.full(PIXELS, 90.0, np.float32)).any()
    assert not edged(np.zeros(PIXELS, np.float32)).any()


def test_pixels_under_the_rim_of_a_shadow_are_found() -> None:
    """Row II, five pixels aside, with a shadow that row I did not see: these pixels and no other do not count."""
    margin, mu = 7, 5
    wide = land(3, PIXELS + 2 * margin)
    rows2 = np.zeros((8, PIXELS), np.float32)
    seen = wide[margin + mu : margin + mu + PIXELS].copy()
    seen += np.random.default_rng(5).normal(0.0, 1.5, PIXELS).astype(np.float32)
    seen[60:] *= 0.5
    rows2[3] = edged(seen)
    weights = beside(ALL)
    kept = common(edged(wide, np.ones(len(wide), np.float32)), rows2, weights, 3, mu, 0.0, np.zeros(PIXELS))
    assert not kept[[59, 60]].any()
    # of the normal noise 0.7 % lie beyond four median differences: 0.7 of 92, five are beyond 0.1 % chance
    assert kept.sum() >= 92 - 5
    assert not kept[weights == 0.0].any()
