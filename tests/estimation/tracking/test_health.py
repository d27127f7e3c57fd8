"""Pixels that see nothing are left out; water and dark rows accuse no pixel."""

from __future__ import annotations

import numpy as np

from aerosim.estimation.tracking.health import SURE, Health


def rows(count: int, contrast: float = 20.0) -> np.ndarray:
    return np.random.default_rng(3).normal(110.0, contrast, (count, 96)).astype(np.float32)


def test_a_pixel_that_stands_still_is_left_out_whatever_it_shows() -> None:
    seen = rows(3 * SURE)
    seen[:, 5], seen[:, 50] = 0.0, 117.0
    health = Health(96)
    for row in seen:
        weights = health(row)
    assert np.flatnonzero(weights == 0.0).tolist() == [5, 50]


def test_not_before_some_rows_were_seen() -> None:
    seen = rows(SURE)
    seen[:, 5] = 0.0
    health = Health(96)
    assert all(health(row).all() for row in seen[: SURE - 1])
    assert not health(seen[-1]).all()


def test_rows_without_a_pattern_accuse_no_pixel() -> None:
    health = Health(96)
    assert all(health(np.round(row)).all() for row in rows(200, contrast=0.3))


def test_a_pixel_that_comes_back_counts_again() -> None:
    seen = rows(500)
    seen[:60, 7] = 0.0
    health = Health(96)
    weights = [health(row) for row in seen]
    assert weights[59][7] == 0.0
    assert weights[-1].all()
