"""Noise that a filter learns from its own innovations."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.estimation.tracking.channel import COARSE, Channel
from aerosim.estimation.tracking.lag_filter import LagFilter, WalkModel
from aerosim.estimation.tracking.sway_filter import SwayFilter


@pytest.mark.parametrize("first", [0.01, 1.0])
def test_the_noise_is_learned_from_either_side(first: float) -> None:
    """Blocks of noise 0.1 (variance), begun ten times too low and too high: after 400 blocks about right.

    Each block moves it by a tenth of its surprise, so about 20 count: a share of sqrt(2/20) = 0.32, three times.
    """
    rng = np.random.default_rng(12)
    found = Channel(LagFilter(WalkModel(1e-4, 1e-6, 100.0), 0.5, 10.0), 1e-6, first)
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
    found = Channel(LagFilter(WalkModel(1e-4, 1e-6, 100.0), 0.5, 10.0), 1e-6, 0.1)
    found.start(0.0, 3.0, 0.1)
    assert not found.close(0.5)
    assert found.filter.now(0.5)[0] == pytest.approx(3.0)
    assert found.noise == 0.1


@pytest.mark.parametrize("first", [0.05, 5.0])
def test_the_sway_is_learned_from_either_side(first: float) -> None:
    """Sway of variance 0.5, begun ten times too low and too high: the difference of two looks, and white noise.

    Each block moves it by a tenth of its surprise, so about 20 count: sqrt(2/20) = 0.32; the sway of neighbouring
    blocks is correlated over some three, so sqrt(3) of it, three times, about a mean over 500 blocks: a factor of
    two is allowed to the mean.
    """
    rng = np.random.default_rng(3)
    step, span, time, variance = 0.5, 10, 1.5, 0.5
    w, fade = step / time, np.exp(-step / time)
    move = fade * np.array([[1.0 + w, step], [-step / time**2, 1.0 - w]])
    rest = variance * np.diag([1.0, time**-2])
    kick = np.linalg.cholesky(rest - move @ rest @ move.T)
    sway = [np.linalg.cholesky(rest) @ rng.normal(size=2)]
    for _ in range(900):
        sway.append(move @ sway[-1] + kick @ rng.normal(size=2))
    found = Channel(SwayFilter(1e-4, step, 8.0, first, time, ends=True), 1e-4, first)
    found.start(span * step, 0.0, 0.1)
    learned = []
    for k in range(span + 1, 900):
        t = step * k
        rest_of_it = rng.normal(0.0, np.sqrt(COARSE * variance))
        found.add(t - span * step, t, float(sway[k - span][0] - sway[k][0] + rest_of_it))
        assert found.close(t)
        assert isinstance(found.filter, SwayFilter)
        learned.append(found.filter.sway)
    assert variance / 2 < np.mean(learned[300:]) < variance * 2
