"""How fast the nose turns, and what a mount leaves that is told ahead."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aerosim.control.law import ControlParameters, camera_command
from aerosim.estimation.tracking.yaw_rate import SMOOTH_S, YawRate
from aerosim.sensing.mount import Mount, MountParameters
from aerosim.signals import MotionEstimate

PERIOD, DT = 0.05, 1.0 / 120.0
LAG, DELAY = 0.1, 0.05
DEG = math.radians(1.0)


def test_a_steady_turn_is_told_after_a_while() -> None:
    rate = YawRate()
    for k in range(40):
        rate(PERIOD * k, 2.0 + 0.03 * PERIOD * k)
        expected = 0.03 * (1.0 - math.exp(-PERIOD * k / SMOOTH_S))
        assert rate.rate == pytest.approx(expected, abs=1e-12)


def test_noise_of_the_readings() -> None:
    """White noise s of a reading: a difference has s sqrt(2)/dt, and what is smoothed by 1 - a of an exponential
    a^k has s/dt sqrt(2 (1 - a)^2/(1 + a)) (differences of neighbours are anticorrelated).

    20,000 values of a correlation of some 3: their standard deviation is known to 1/sqrt(2 x 6000), 1 %.
    """
    rng = np.random.default_rng(5)
    rate, told = YawRate(), []
    for k in range(20000):
        rate(PERIOD * k, 0.014 * rng.standard_normal())
        told.append(rate.rate)
    a = math.exp(-PERIOD / SMOOTH_S)
    assert np.std(told[100:]) == pytest.approx(
        0.014 / PERIOD * math.sqrt(2.0 * (1.0 - a) ** 2 / (1.0 + a)), rel=0.04
    )


def residual(lead: float, period: float) -> float:
    """Crab, rms in deg, of a nose that swings by 1 deg with a period (s), the track known and straight."""
    par = ControlParameters(1.0, 0.7, 0.02, 2.0, True, True, True, yaw_lead=lead)
    mount = Mount(MountParameters(1.0, 10.0, LAG, DELAY, 0.0), DT, np.random.default_rng(1))
    rate, off = YawRate(), []
    command = 0.0
    for step in range(round(20.0 / DT)):
        heading = DEG * math.sin(2.0 * math.pi * step * DT / period)
        if step % 6 == 0:
            rate(step * DT, heading)
            estimate = MotionEstimate(step * DT, -heading, 0.02, 0.0, 0.0, True, yaw_rate=rate.rate)
            command = camera_command(par, estimate).mount_yaw
        off.append(-heading - mount.yaw)
        mount.step(command)
    return float(np.degrees(np.std(off[600:])))


@pytest.mark.parametrize("period", [4.0, 6.0])
def test_mount_part_is_yaw_rate_times_lag_and_delay(period: float) -> None:
    """Study, 6.3: yaw-rate rms x (lag + delay); a command that stands for 0.05 s is half of that older.

    The first-order formula is 1/2 (w T)^2 too large or small: 6 % at 4 s, T = 0.175 s.
    """
    rate = 2.0 * math.pi / period / math.sqrt(2.0)  # deg/s, of 1 deg
    assert residual(0.0, period) == pytest.approx(rate * (LAG + DELAY + PERIOD / 2.0), rel=0.06)


@pytest.mark.parametrize("period", [2.0, 4.0])
def test_a_lead_takes_out_most_of_it(period: float) -> None:
    """What is left, by the transfer functions: smoothed differences, a command that stands, delay and lag.

    The mount moves in steps of 1/120 s: 1 % of the phase of 0.15 s is 0.0015 s, a quarter of one.
    """
    plain, ahead = residual(0.0, period), residual(LAG + DELAY, period)
    w = 2.0 * math.pi / period
    z, a = np.exp(-1j * w * PERIOD), 1.0 - math.exp(-PERIOD / SMOOTH_S)
    lead = 1.0 + (LAG + DELAY) * a * (1.0 - z) / PERIOD / (1.0 - (1.0 - a) * z)
    stands = (1.0 - z) / (1j * w * PERIOD)
    mount = np.exp(-1j * w * DELAY) / (1.0 + 1j * w * LAG)
    assert ahead == pytest.approx(abs(1.0 - lead * stands * mount) / math.sqrt(2.0), rel=0.05)
    assert plain == pytest.approx(abs(1.0 - stands * mount) / math.sqrt(2.0), rel=0.05)
    assert ahead < 0.6 * plain
