"""Bad strips and silence by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from aerosim.metrics.lock import bad_share, silence


def strips(decided: list[float], accepted: list[bool], off: list[float] | None = None) -> dict[str, Any]:
    angles = np.zeros(len(decided)) if off is None else np.array(off)
    return {
        "t_decided_s": np.array(decided), "accepted": np.array(accepted, bool),
        "angle_deg": 3.0 + angles, "crab_true_deg": np.full(len(decided), 3.0),
    }  # fmt: skip


def test_bad_are_accepted_strips_that_are_off() -> None:
    found = strips([1, 2, 3, 4, 5, 6], [True, True, True, True, False, True], [0.1, -0.7, 0.6, 0.49, 9.0, np.nan])
    assert bad_share(found, np.ones(6, bool)) == pytest.approx(50.0)
    assert bad_share(found, np.array([True, False, False, True, True, True])) == 0.0
    assert bad_share(found, np.array([False, False, False, False, True, True])) is None


def test_silence_on_two_lines() -> None:
    lines = {0: (10.0, 100.0), 1: (200.0, 300.0)}
    at = [5.0, 20.0, 60.0, 95.0, 150.0, 210.0, 290.0]
    assert silence(strips(at, [True] * 7), lines) == (80.0, 10.0)
    # a refused strip breaks no silence; what is lost for good reaches the end
    assert silence(strips(at, [True, True, True, False, True, True, False]), lines) == (90.0, 90.0)
    assert silence(strips(at, [False] * 7), lines) == (100.0, 100.0)
    assert silence(strips([99.0, 20.0], [True, True]), {0: (10.0, 100.0)}) == (79.0, 1.0)  # in any order


def test_nothing_is_told_where_nothing_was_looked_for() -> None:
    assert silence(strips([], []), {0: (10.0, 100.0)}) == (None, None)
    assert silence(strips([1.0], [True]), {}) == (None, None)
    assert bad_share(strips([], []), np.zeros(0, bool)) is None
