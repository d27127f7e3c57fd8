"""Forming filters of turbulence: white noise through a series of first-order sections."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aerosim.world.process import GaussProcess


def filtered_noise(
    gain: float,
    sections: Sequence[tuple[float, float]],
    dt: float,
    rng: np.random.Generator,
    rate: tuple[float, float] | None = None,
) -> GaussProcess:
    """Noise through gain * prod (1 + n s)/(1 + d s), the sections being (n, d) in s; n of the first is 0.

    The white noise has the one-sided density 1/pi per rad/s, so the output's is gain^2 prod |...|^2 / pi.
    rate: (factor, tau) adds a second output, factor s/(1 + tau s) of the first.  The gain stands outside of the
    states: another gain gives the same series, only stronger.  Raises ValueError for a first section that passes
    white noise.
    """
    if sections[0][0] != 0.0:
        raise ValueError("the first section passes white noise")
    n = len(sections) + (rate is not None)
    a, b = np.zeros((n, n)), np.zeros((n, 1))
    y = np.zeros(n)  # output of the sections so far, as a row over the states
    for k, (up, down) in enumerate(sections):
        # x' = (input - x)/d, output = (1 - n/d) x + n/d input
        a[k] = y / down
        a[k, k] -= 1.0 / down
        if k == 0:
            b[0, 0] = 1.0 / down
        y = y * (up / down)
        y[k] += 1.0 - up / down
    outputs = [y]
    if rate is not None:
        factor, tau = rate
        a[-1] = y / tau
        a[-1, -1] -= 1.0 / tau
        slope = y / tau
        slope[-1] -= 1.0 / tau
        outputs.append(factor * slope)
    return GaussProcess(a, b, gain * np.array(outputs), dt, rng)
