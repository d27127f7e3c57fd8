"""Mode schmelovsky_1988 is what the paper says, with its slow filter, and is not tuned up."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from flights import scenario

from aerosim.estimation.motion import MotionEstimator, strip_motion
from aerosim.scenario.build import motion_of, planned_n
from aerosim.scenario.build.devices import strips_of
from aerosim.scenario.scenario import Scenario
from aerosim.signals import Reason, StripMatch

T = 12.93  # s, of a strip at 3000 m and 250 km/h
PAPER_VH = 250.0 / 3.6 / 3000.0


def of_1988(**estimation: Any) -> Scenario:
    return scenario(control={"mode": "schmelovsky_1988"}, estimation=estimation)


def strip(k: int, mu: float, n: float = 259.0) -> StripMatch:
    t = 13.7 * k
    return StripMatch(
        k,
        274 * k,
        t,
        t + T,
        t + T + 0.7,
        n,
        mu,
        3.0,
        0.0,
        0.0,
        Reason.ACCEPTED,
        155,
        np.zeros((1, 15), np.float32),
    )


def step_response(wanted: Scenario, settled: int, after: int) -> tuple[list[float], list[float]]:
    """Drift and n, each as a share of a step of 5 px and 20 exposures, strip by strip behind it."""
    par = motion_of(wanted)
    estimator = MotionEstimator(par)
    for k in range(settled):
        estimator.add(strip(k, 0.0, 259.0))
    drift, n = [], []
    for k in range(after):
        estimator.add(strip(settled + k, 5.0, 279.0))
        now = estimator.now()
        drift.append(now.drift / math.atan(5.0 / par.spacing_px))
        n.append((par.spacing_px / (par.focal_px * par.period * now.vh) - 259.0) / 20.0)
    return drift, n


@pytest.mark.parametrize(
    ("gamma", "effective", "strips"),
    [
        (0.01, 0.01, 10.0),  # as printed
        (None, 0.225 * T / 25.0, 2.94),  # the consistent reading keeps its T: 0.116
    ],
)
def test_step_response_in_closed_form(gamma: float | None, effective: float, strips: float) -> None:
    """1 - (1 - q)^k at the limit, q = (-gamma + sqrt(gamma^2 + 4 gamma))/2; 1/e is left after 10 and 3 strips."""
    wanted = of_1988(crab={"gamma": gamma}) if gamma is None else of_1988()
    assert motion_of(wanted).gamma_drift == gamma
    q = (-effective + math.sqrt(effective**2 + 4.0 * effective)) / 2.0
    drift, n = step_response(wanted, 400, 30)
    assert drift == pytest.approx([1.0 - (1.0 - q) ** k for k in range(1, 31)], rel=1e-6)
    left = np.log(1.0 - np.array(drift))
    assert np.interp(1.0, -left, np.arange(1, 31)) == pytest.approx(strips, abs=0.01)
    # n has the printed gamma in either case here
    slow = (-0.01 + math.sqrt(0.01**2 + 0.04)) / 2.0
    assert n == pytest.approx([1.0 - (1.0 - slow) ** k for k in range(1, 31)], rel=1e-5)


def test_the_printed_filter_takes_136_seconds() -> None:
    q = (-0.01 + math.sqrt(0.01**2 + 0.04)) / 2.0
    assert round(q, 4) == 0.0951
    assert T / q == pytest.approx(136.0, abs=0.3)  # 10.5 strips


def test_the_instrument() -> None:
    """Rows on the airframe, padded, one strip at a time, whole pixels, no cosine put right, (15)."""
    wanted = of_1988()
    par, strips = motion_of(wanted), strips_of(wanted, PAPER_VH)
    assert (par.on_camera, par.right_cosine, par.series, par.strip_period) == (False, False, "riccati", None)
    assert (par.gamma_drift, par.gamma_vh) == (0.01, 0.01)
    assert (strips.period, strips.subpixel, strips.padded, strips.mean_subtracted) == (None, False, True, True)
    assert (strips.max_shift, strips.pixels) == (7, 96)
    other = of_1988(gain="halving")
    assert motion_of(other).series == "halving"


def test_the_papers_numbers_from_the_defaults() -> None:
    """7 px are 10 deg; a roll of 1.5 deg reads 5 deg; 3000 m, 250 km/h and 50 ms make n 257 to 261."""
    wanted = of_1988()
    par = motion_of(wanted)
    assert wanted.ccd_rows.period_s == 0.05
    assert 257.0 < planned_n(wanted, PAPER_VH) < 261.0
    assert planned_n(wanted, PAPER_VH) == pytest.approx(258.6, abs=0.1)
    assert planned_n(wanted, PAPER_VH) * 0.05 == pytest.approx(T, abs=0.01)
    assert math.degrees(strip_motion(strip(0, 7.0), par).drift) == pytest.approx(10.0, abs=0.01)
    roll = par.focal_px * math.tan(math.radians(1.5))
    assert math.degrees(strip_motion(strip(0, roll), par).drift) == pytest.approx(5.0, abs=0.01)
    assert strip_motion(strip(0, 0.0, 258.6), par).vh == pytest.approx(PAPER_VH, rel=1e-3)
