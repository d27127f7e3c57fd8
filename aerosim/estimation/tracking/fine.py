"""The minimum of a strip between pixels and exposures: least squares on grey values, with a rotation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.signals import Grey

ITERATIONS = 4
DONE_PX = 0.002
REACH_PX = 0.5  # ground motion to either side from which the change with time is taken
SLOW = 4.0  # exposures a pixel from which on row II is smoothed in time too
UNKNOWNS = 5  # step, shift, rotation, gain, offset


class Fine(NamedTuple):
    """Where the strip lies.  step: exposures (fraction), mu: px, slope: exposures a pixel.

    sd_step, sd_mu: standard deviations that the residuals speak for, exposures and px.  gain: row II over row I.
    rms: of the residuals, grey levels.  ok: it converged near its start.  sd_most, sd_least: standard deviations
    in the directions in which the place on the ground is known worst and best, px.
    """

    step: float
    mu: float
    slope: float
    sd_step: float
    sd_mu: float
    gain: float
    rms: float
    ok: bool
    sd_most: float = np.inf
    sd_least: float = np.inf


@njit(inline="always")
def _spline(s: float) -> tuple[float, float, float, float]:  # pragma: no cover - compiled
    """Weights of the uniform cubic B-spline at a part s of a step."""
    r = 1.0 - s
    return (
        r * r * r / 6.0,
        2.0 / 3.0 - s * s + 0.5 * s * s * s,
        2.0 / 3.0 - r * r + 0.5 * r * r * r,
        s * s * s / 6.0,
    )


@njit(inline="always")
def _through(s: float) -> tuple[float, float, float, float]:  # pragma: no cover - compiled
    """Weights of the cubic through the values (Catmull-Rom) at a part s of a step."""
    r = 1.0 - s
    return -0.5 * s * r * r, 1.0 + s * s * (1.5 * s - 2.5), 1.0 + r * r * (1.5 * r - 2.5), -0.5 * s * s * r


@njit(inline="always")
def _around(place: int, ring: int) -> int:  # pragma: no cover - compiled
    """Place in a ring that may lie up to a turn beyond either end; a division would take as long as a pixel."""
    return place + ring if place < 0 else place - ring if place >= ring else place


@njit(inline="always")
def _smooth(rows: Grey, row: int, i: int) -> float:  # pragma: no cover - compiled
    """A pixel with its neighbours in the row, as the spline weighs them at a whole place."""
    left, right = max(i - 1, 0), min(i + 1, rows.shape[1] - 1)
    return float(rows[row, left] + 4.0 * rows[row, i] + rows[row, right]) / 6.0


@njit(inline="always")
def _spreads(
    normal: Array, rms: float, steps_per_px: float
) -> tuple[float, float, float, float]:  # pragma: no cover - compiled
    """Standard deviations of step (exposures) and mu (px), and along the axes of their ellipse, px of ground."""
    inverse = np.linalg.inv(normal)
    along, across = inverse[0, 0] / steps_per_px**2, inverse[1, 1]
    mean, off = 0.5 * (along + across), np.hypot(0.5 * (along - across), inverse[0, 1] / steps_per_px)
    sd_step, sd_mu = rms * np.sqrt(abs(inverse[0, 0])), rms * np.sqrt(abs(inverse[1, 1]))
    return sd_step, sd_mu, rms * np.sqrt(abs(mean + off)), rms * np.sqrt(abs(mean - off))


@njit(cache=True)
def fine(
    row1: Grey,
    rows2: Grey,
    weights: Grey,
    step: float,
    mu: float,
    slope: float,
    bow: Array,
    steps_per_px: float,
    stretch: float = 0.0,
) -> tuple[float, float, float, float, float, float, float, bool, float, float]:  # pragma: no cover - compiled
    """Least squares of row II against row I around a minimum; the fields of `Fine`.

    B(i, step + slope (i - c) + bow(i)) = gain A(i + mu + stretch (i - c)) + offset for all pixels i of row II, c
    its middle.  row1: (u + 2 j,), element j + i faces element i of row II at mu = 0; NaN does not count.  rows2:
    ring of exposures of row II, (ring, u), a step being its index, taken modulo the ring.  weights: (u,), 0 leaves
    a pixel of row II out.  step, mu, slope: where to start.  bow: (u,) exposures, see `surface`.  steps_per_px:
    exposures in which the ground moves by a pixel.  stretch: by which the shift grows along a turned row.
    """
    u, extended, ring = rows2.shape[1], row1.shape[0], rows2.shape[0]
    margin, middle = (extended - u) // 2, (u - 1) / 2.0
    reach, slow = int(REACH_PX * steps_per_px), steps_per_px >= SLOW
    normal, right = np.empty((5, 5)), np.empty(5)
    jac = np.empty(5)
    unknown = np.array([step, mu, slope, 1.0, 0.0])
    rms, ok = np.nan, False
    for iteration in range(ITERATIONS):
        normal[:] = 0.0
        right[:] = 0.0
        square, count = 0.0, 0
        for i in range(u):
            place = i + margin + unknown[1] + stretch * (i - middle)
            k = int(np.floor(place))
            if weights[i] == 0.0 or k < 1 or k > extended - 3:
                continue
            # row I by a cubic B-spline, row II with the same weights: a curve through the values would be noisiest
            # at whole pixels and draw the minimum away from them
            s = place - k
            a0, a1, a2, a3 = row1[k - 1], row1[k], row1[k + 1], row1[k + 2]
            b0, b1, b2, b3 = _spline(s)
            value = b0 * a0 + b1 * a1 + b2 * a2 + b3 * a3
            if np.isnan(value):
                continue
            r = 1.0 - s
            along_row = (
                0.5 * (s * s * a3 - r * r * a0) + (1.5 * s * s - 2.0 * s) * a1 - (1.5 * r * r - 2.0 * r) * a2
            )
            when = unknown[0] + unknown[2] * (i - middle) + bow[i]
            j = int(np.floor(when))
            t0, t1, t2, t3 = _spline(when - j) if slow else _through(when - j)
            j %= ring
            seen = t0 * _smooth(rows2, _around(j - 1, ring), i) + t1 * _smooth(rows2, j, i)
            seen += t2 * _smooth(rows2, _around(j + 1, ring), i) + t3 * _smooth(rows2, _around(j + 2, ring), i)
            later, before = _around(j + 1 + reach, ring), _around(j - reach, ring)
            in_time = (rows2[later, i] - rows2[before, i]) / (2.0 * reach + 1.0)
            jac[0], jac[1], jac[2] = in_time, -unknown[3] * along_row, in_time * (i - middle)
            jac[3], jac[4] = -value, -1.0
            left = seen - unknown[3] * value - unknown[4]
            square += left * left
            count += 1
            for p in range(5):
                right[p] -= jac[p] * left
                for q in range(p, 5):
                    normal[p, q] += jac[p] * jac[q]
        if count < 4 * UNKNOWNS:
            return unknown[0], unknown[1], unknown[2], np.inf, np.inf, unknown[3], rms, False, np.inf, np.inf
        for p in range(5):
            for q in range(p):
                normal[p, q] = normal[q, p]
            normal[p, p] += 1e-9 * (normal[p, p] + 1.0)
        rms = np.sqrt(square / (count - UNKNOWNS))
        if ok:  # the sums at the solution: what the covariance is taken from
            break
        change = np.linalg.solve(normal, right)
        for p in range(5):
            unknown[p] += change[p]
        if abs(unknown[1] - mu) > 1.5 or abs(unknown[0] - step) > 1.5 * steps_per_px + 2.0:
            return unknown[0], unknown[1], unknown[2], np.inf, np.inf, unknown[3], rms, False, np.inf, np.inf
        small = abs(change[1]) < DONE_PX and abs(change[0]) < DONE_PX * steps_per_px
        ok = small or iteration == ITERATIONS - 2
    sd_step, sd_mu, sd_most, sd_least = _spreads(normal, rms, steps_per_px)
    return unknown[0], unknown[1], unknown[2], sd_step, sd_mu, unknown[3], rms, True, sd_most, sd_least
