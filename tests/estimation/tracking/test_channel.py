"""Noise that a filter learns from its own innovations."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.estimation.tracking.channel import Channel
from aerosim.estimation.tracking.lag_filter import WalkModel


@pytest.mark.parametrize("first", [0.01, 1.0])
def test_the_noise_is_learned_from_either_side(first: float) -> None:
    """Blocks of noise 0.1 (variance), begun ten times too low and too high: after 400 blocks about right.

    Each block moves it by a tenth of its surprise, so about 20 count: a share of sqrt(2/20) = 0.32, three times.
    """
    rng = np.random.default_rng(12)
    found = Channel(WalkModel(1e-4, 1e-6, 100.0), 0.5, 10.0, 1e-6, first)
    found.start(0.0, 0.0, 0.1)
    learned = []
    for k in range(1, 401):
        t = 0.5 * k
        found.add(t - 5.0, t, float(rng.normal(0.0, np.sqrt(0.1))))
        assert found.close(t)
        learned.append(found.noise)
    assert np.mean(learned[100:]) == pytest.approx(0.1, rel=0.32)
    assert 0.1 * (1 - 0.96) < learned[-1] < 0.1 * (1 + 0.96)


def test_a_block_without_strips_says_nothing() -> None:
    found = Channel(WalkModel(1e-4, 1e-6, 100.0), 0.5, 10.0, 1e-6, 0.1)
    found.start(0.0, 3.0, 0.1)
    assert not found.close(0.5)
    assert found.filter.now(0.5)[0] == pytest.approx(3.0)
    assert found.noise == 0.1
