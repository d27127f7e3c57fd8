"""Strips of a flight in steady wind against the way that the aircraft flew between their two exposures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aerosim.scenario import load_scenario
from aerosim.simulate import simulate


@pytest.fixture(scope="module")
def strips() -> dict[str, NDArray[Any]]:
    """Without gusts the attitude stays, so a strip has no error but the matcher's and the relief's."""
    calm = {"air.turbulence.sigma_m_s": 0, "air.slow_wind.sigma_m_s": 0, "record.rrd": False}
    return simulate(load_scenario("crosswind", calm)).matches


def test_most_strips_are_accepted(strips: dict[str, NDArray[Any]]) -> None:
    judged = strips["reason"] != "timeout"
    assert strips["accepted"][judged].mean() > 0.8


def test_accepted_strips_are_right(strips: dict[str, NDArray[Any]]) -> None:
    """Study, real textures: drift sd 0.13 to 0.20 deg; on hills of 300 m v/h sd 0.8 %, its core, and no bias."""
    taken = strips["accepted"]
    angle = (strips["angle_deg"] - strips["crab_true_deg"])[taken]
    vh = 100.0 * (strips["vh_per_s"] / strips["vh_true_per_s"] - 1.0)[taken]
    assert abs(np.mean(angle)) < 0.05
    assert np.sqrt(np.mean(angle**2)) < 0.25
    assert abs(np.median(vh)) < 0.4
    assert np.percentile(np.abs(vh), 68.0) < 1.2
    assert np.mean((np.abs(angle) > 1.5) | (np.abs(vh) > 3.0)) < 0.08


def test_refused_strips_are_worse_than_accepted_ones(strips: dict[str, NDArray[Any]]) -> None:
    refused = np.isin(strips["reason"], ["ambiguous", "degenerate"])
    wrong = np.abs(strips["vh_per_s"] / strips["vh_true_per_s"] - 1.0) > 0.03
    assert wrong[refused].mean() > 5.0 * wrong[strips["accepted"]].mean()
