"""Figures of the loop in docs/controller.md: closed forms, the loop stepped through, and the real estimator."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from aerosim.estimation.motion import MotionEstimator, MotionParameters
from aerosim.signals import Reason, StripMatch

SCRIPT = Path(__file__).parents[2] / "docs" / "control_figures.py"


@pytest.fixture(scope="module")
def loops() -> ModuleType:
    spec = importlib.util.spec_from_file_location("control_figures", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def grows(x: np.ndarray) -> bool:
    half = len(x) // 2
    return bool(np.abs(x[half:]).max() > np.abs(x[: half // 2]).max())


@pytest.mark.parametrize(("index", "negative"), [(0, -21.02), (1, -6.94), (2, -21.12)])
def test_errors_of_the_encoders_scale_that_the_loop_stands(loops: ModuleType, index: int, negative: float) -> None:
    """Between these errors it is stable; 3 % beyond it grows, 3 % within it dies away, stepped through.

    A scale wrong by +100 % is the limit for any delay: the mean of two delays is at most 1 and |1 - (1 - q)/z| at
    least q, so the loop's gain is never above the error.  One strip at a time, the other limit is -2/q.
    """
    loop = loops.LOOPS[index]
    most = loops.margin(loop, loops.through_encoder, -1.0).gain
    least = -loops.margin(loop, loops.through_encoder).gain
    assert most == pytest.approx(1.0, abs=1e-6)
    assert least == pytest.approx(negative, abs=0.01)
    if index < 2:
        assert least == pytest.approx(-2.0 / loop.q, rel=1e-6)
    steps = 6000
    for scale in (least, most):
        assert grows(loops.simulated(loop, 1.03 * scale, steps))
        assert not grows(loops.simulated(loop, 0.97 * scale, steps))
    assert np.isnan(loops.margin(loop, loops.through_encoder).phase)  # its gain is below 1 at all frequencies
    omegas = np.linspace(0.001, math.pi, 500)
    assert max(abs(loops.through_encoder(loop, w)) for w in omegas) <= 1.0


@pytest.mark.parametrize(
    ("index", "gain", "phase", "delay"), [(0, 21.02, 84.6, 15.5), (1, 6.94, 73.6, 4.49), (2, 22.1, 58.4, 12.9)]
)
def test_margins_of_plain_feedback(loops: ModuleType, index: int, gain: float, phase: float, delay: float) -> None:
    """A controller without an encoder: gain 3 % and delay one strip to either side, stepped through."""
    loop = loops.LOOPS[index]
    found = loops.margin(loop, loops.plain_feedback)
    assert found == (pytest.approx(gain, abs=0.05), pytest.approx(phase, abs=0.1), pytest.approx(delay, abs=0.05))
    assert grows(loops.simulated(loop, 1.03 * found.gain, 6000, plain=True))
    assert not grows(loops.simulated(loop, 0.97 * found.gain, 6000, plain=True))
    late = math.floor(found.delay)
    assert not grows(loops.simulated(loop, 1.0, 12000, plain=True, late=late))
    assert grows(loops.simulated(loop, 1.0, 12000, plain=True, late=late + 1))


def test_step_responses(loops: ModuleType) -> None:
    """One strip at a time, heading: half of the step comes with the strip in flight, the rest as (1 - q)^k."""
    for loop in loops.LOOPS[:2]:
        t, x = loops.step_response(loop, 1000.0)
        cycle, q = (259 + 14 + 1) * 0.05, loop.q
        for k in (1, 2, 5, 20):
            after = x[np.flatnonzero(t <= k * cycle + 1e-9)[-1]]
            assert after == pytest.approx(1.0 - (1.0 - q / 2.0) * (1.0 - q) ** (k - 1), rel=1e-6)
        # without the half strip: the limit's time constant in strips
        assert -1.0 / math.log(1.0 - q) == pytest.approx(10.0 if loop.gamma == 0.01 else 2.94, abs=0.01)
    times = [loops.time_to(0.632, *loops.step_response(loop, 1000.0)) for loop in loops.LOOPS]
    assert times == pytest.approx([150.7, 54.8, 19.7], abs=0.05)


def test_the_printed_time_constant() -> None:
    """1/q = 10.5 strips of 12.93 s are 136 s; the error falls to 1/e in 10.0 strips."""
    q = (-0.01 + math.sqrt(0.01**2 + 0.04)) / 2.0
    assert 1.0 / q == pytest.approx(10.5, abs=0.02)
    assert 12.93 / q == pytest.approx(136.0, abs=0.3)


PAR = MotionParameters(39.7, 132.6, 0.05, True, False, "riccati", 0.0, 0.087, 0.1164, 0.0, 0.05, 0.1164, None)
DEG = math.pi / 180.0


def settled(encoder: float, spacing: float, drift: float) -> float:
    """Drift believed by the real estimator after 80 strips, each at the yaw that the ones before asked for.

    encoder: what it reads of the yaw; spacing: true d, px, where the estimator believes 39.7.
    """
    estimator = MotionEstimator(PAR)
    yaws = [0.0, 0.0]
    for k in range(80):
        first, second = yaws[-2:]
        mu = spacing * math.tan(drift - (first + second) / 2.0)
        t = 13.7 * k
        seen = (first * encoder, second * encoder)
        nothing = np.zeros((1, 15), np.float32)
        times = (t, t + 12.95, t + 13.65)
        match = StripMatch(k, 274 * k, *times, 259.0, mu, 3.0, *seen, Reason.ACCEPTED, 155, nothing)
        estimator.add(match)
        yaws.append(estimator.now().drift)
    return estimator.now().drift


def test_what_scale_errors_leave() -> None:
    """Encoder 2 % long: the drift is believed 1/(1 - 0.02) too large; a wrong d leaves nothing."""
    drift = 8.0 * DEG
    assert settled(1.0, 39.7, drift) == pytest.approx(drift, rel=1e-6)
    assert settled(1.02, 39.7, drift) == pytest.approx(drift / 0.98, rel=1e-3)
    assert settled(1.0, 39.7 * 1.07, drift) == pytest.approx(drift, rel=1e-6)
    assert settled(0.0, 39.7, drift) == pytest.approx(drift / 2.0, rel=1e-3)  # a dead encoder: half of it


def test_gains_and_what_they_leave(loops: ModuleType) -> None:
    """(14) is the least variance that a gain can leave; (17) costs 8 % of it at most and ends at the same."""
    from aerosim.estimation.kalman import next_gain_halving, next_gain_riccati, next_variance, stationary_gain

    slow, fast, k = [1.0], [1.0], [1.0]
    for _ in range(60):
        slow.append(next_gain_riccati(slow[-1], 0.01))
        fast.append(next_gain_halving(fast[-1], stationary_gain(0.01)))
        k.append(next_variance(k[-1], 0.01, 1.0))
    best, other = loops.variance_of(np.array(slow)), loops.variance_of(np.array(fast))
    assert best == pytest.approx(k)
    assert (other >= best - 1e-12).all()
    assert other[60] == pytest.approx(best[60], rel=1e-3)
    assert (round(slow[10], 4), round(fast[10], 4)) == (0.1201, 0.0960)
    assert float((other / best).max()) == pytest.approx(1.080, abs=5e-4)
    assert int((other / best).argmax()) == 8
    # weight of the first strip after three and after ten
    for count, first, second in ((3, 0.244, 0.243), (10, 0.075, 0.106)):
        assert loops.weight_of_first(np.array(slow))[count] == pytest.approx(first, abs=5e-4)
        assert loops.weight_of_first(np.array(fast))[count] == pytest.approx(second, abs=5e-4)
