"""Gross errors and jumps: Danish weights for observations, a test for steps of the trajectory.

Danish method: Krarup, Juhl and Kubik 1980 (constants as commonly quoted).  A weight that falls with the residual
does nothing against a step, which is spread over p + d of the equations (3); it is found by a test and carried as
a regressor instead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from aerosim.errors import InputError
from aerosim.estimation.ari.filter import Filtered, filter_series
from aerosim.estimation.ari.likelihood import Strips
from aerosim.estimation.ari.modes import descend, objective, process_of
from aerosim.estimation.ari.prior import Prior
from aerosim.estimation.ari.process import Process
from aerosim.estimation.ari.vce import iterate, theta_of
from aerosim.frames import Array

FULL = 2.5  # standard deviations up to which a Danish weight is one
REJECT = 3.3  # least deletion residual of the final test: 0.1 % of good observations
FALSE_SHARE = 0.05  # of the rejected, at most, in the mean
SCALE_MIN = 0.2  # of residuals that claim to be 1: more than half of them near zero are repeated readings
FIRST, EXPONENTS = 3, (4.4, 3.0)  # iterations with the sharper exponent and a robust scale
STEP_ERROR = 0.01  # chance of a step found in a strip that has none
STEPS_MAX = 10
CANCELLED = 1e-9
CANDIDATES, WORTH_A_TRIAL = 3, 2.5
REJECTED_MAX = 1.0 / 3.0  # more are not outliers of anything
PRIOR = Prior(
    kn=2.0, ke=1.0, s2=0.1, first=0.1, over="r"
)  # of the quick fits within: the mode close to the average


@dataclass(frozen=True)
class Step:
    """A jump of the trajectory: values from epoch `index` on are higher by `size`, known to `sigma`."""

    index: int
    size: float
    sigma: float


@dataclass(frozen=True)
class Cleaned:
    """Strips after the search: weights (0 = rejected or missing), steps of each, the process fitted on the way."""

    weights: list[Array]
    steps: list[list[Step]]
    process: Process


def quick_starts(y: list[Array], w: list[Array], p: int, d: int, count: int = 3) -> Array:
    """Starting values (count, p + 2): early, middle and late iterates of the paper."""
    steps = iterate(y, w, p, d, most=14 if count <= 3 else 21)
    at = (2, 6, 12) if count <= 3 else (1, 3, 6, 9, 13, 19)
    return np.array([theta_of(steps[min(k, len(steps) - 1)].process) for k in at])


def deletion_residuals(out: Filtered, w: Array) -> Array:
    """Observation less what all others say of it, over its standard deviation (n,); NaN where there is none.

    out: smoothed with any weights; w: the weights that the observations have by themselves.
    """
    used, there = out.weights, w > 0.0
    redundancy = 1.0 - used * out.cov_band[:, 0] / out.process.sigma_n**2
    redundancy = np.maximum(redundancy, 1e-12)
    variance = out.process.sigma_n**2 / np.where(there, w, 1.0) + out.cov_band[:, 0] / redundancy
    return np.where(there, (out.y - out.x) / redundancy / np.sqrt(variance), np.nan)


def danish(y: list[Array], w: list[Array], d: int, theta: Array, *, most: int = 12) -> tuple[list[Array], Array]:
    """Weights of the observations and parameters (p + 2,), in turn.  y, w: values, own weights of each strip."""
    weights = [ws.copy() for ws in w]
    for k in range(most):
        t = _residuals(y, weights, w, theta, d)
        every = np.concatenate(t)
        scale = max(1.4826 * float(np.nanmedian(np.abs(every))), SCALE_MIN) if k < FIRST else 1.0
        if k == 0 and scale > 0.5 and not np.any(np.abs(every) > REJECT * min(scale, 1.0)):
            return weights, theta
        exponent = EXPONENTS[0] if k < FIRST else EXPONENTS[1]
        new = [_danish_weight(ts / scale, exponent) * ws for ts, ws in zip(t, w, strict=True)]
        change = max(float(np.max(np.abs(a - b))) for a, b in zip(new, weights, strict=True))
        weights = new
        theta = refit(y, weights, d, theta)
        if k >= FIRST and change < 0.02:
            break
    for _ in range(4):
        t = _residuals(y, weights, w, theta, d)
        limit = rejection_limit(np.concatenate(t))
        new = [np.where(np.abs(ts) > limit, 0.0, ws) for ts, ws in zip(t, w, strict=True)]
        same = all(np.array_equal(a, b) for a, b in zip(new, weights, strict=True))
        weights = new
        if same:
            break
        theta = refit(y, weights, d, theta)
    rejected = sum(np.count_nonzero((a > 0.0) & (b == 0.0)) for a, b in zip(w, weights, strict=True))
    total = sum(np.count_nonzero(ws) for ws in w)
    if rejected > REJECTED_MAX * total:
        raise InputError(
            f"{rejected} of {total} observations are outliers of the rest",
            "y",
            "at most a third; robust='none' keeps all",
        )
    for ys, ws in zip(y, weights, strict=True):
        if np.ptp(ys[ws > 0.0]) == 0.0:
            raise InputError("does not vary but for its outliers", "y", "a noisy series; robust='none' keeps all")
    return weights, theta


def refit(y: list[Array], w: list[Array], d: int, theta: Array) -> Array:
    """Parameters (p + 2,) at the mode next to theta."""
    best, _ = descend(objective(Strips(y, w), d, PRIOR), theta[None], most=60, enough=1e-3)
    return np.asarray(best[0])


def _residuals(y: list[Array], used: list[Array], w: list[Array], theta: Array, d: int) -> list[Array]:
    process = process_of(theta, d)
    return [deletion_residuals(filter_series(ys, us, process), ws) for ys, us, ws in zip(y, used, w, strict=True)]


def rejection_limit(t: Array) -> float:
    """Size from which on standardised residuals t are rejected, so that few of the rejected were good.

    Benjamini and Hochberg 1995: a clean strip loses next to nothing, one with many blunders is tested at `REJECT`.
    """
    size = np.sort(np.abs(t[np.isfinite(t)]))[::-1]
    chance = 2.0 * norm.sf(size)
    fits = np.flatnonzero(chance <= FALSE_SHARE * np.arange(1, len(size) + 1) / len(size))
    return max(REJECT, float(size[fits[-1]]) * (1.0 - 1e-12)) if len(fits) else np.inf


def _danish_weight(t: Array, exponent: float) -> Array:
    size = np.minimum(np.abs(np.nan_to_num(t)), 1e3)
    return np.where(size <= FULL, 1.0, np.exp(-0.05 * size**exponent))


def step_statistics(out: Filtered) -> tuple[Array, Array]:
    """For a step at each epoch: its size by least squares over its standard deviation, and that one, (n,) each.

    T = g'S^-1 w/sqrt(g'S^-1 g), w = A y of covariance S, g the running sum of c: a step as the equations see it.
    out: smoothed with a covariance band of at least 2 (p + d) lags.  NaN within p + d of the ends.
    """
    process, n = out.process, len(out.x)
    m = process.p + process.d
    inv = process.sigma_e**-2.0
    g = np.cumsum(process.c)[:m] if process.d else np.cumsum(process.c)
    first, last = m, n - m
    size, sigma = np.full(n, np.nan), np.full(n, np.nan)
    if last <= first or process.d == 0:
        return size, sigma
    count = last - first
    along = sum(g[i] * out.errors_e[first - m + i : first - m + i + count] for i in range(m)) * inv
    # A'g: what the equations that a step touches make of the values around it, from m before to m - 1 after
    k = np.convolve(g, process.c[::-1])
    spread = np.zeros(count)
    for i in range(2 * m):
        for j in range(2 * m):
            spread += k[i] * k[j] * out.cov_band[first - m + min(i, j) : first - m + min(i, j) + count, abs(i - j)]
    information = (float(g @ g) - spread * inv) * inv
    # what is left of two numbers that cancel says nothing
    information = np.where(information > CANCELLED * float(g @ g) * inv, information, np.nan)
    sigma[first:last] = 1.0 / np.sqrt(information)
    size[first:last] = along / information
    return size / sigma, sigma


def clean(y: list[Array], w: list[Array], p: int, d: int, *, blunders: bool, steps: bool) -> Cleaned:
    """Look for blunders and steps until nothing more is found.  y, w: values and weights of each strip (n_i,)."""
    starts = quick_starts(y, w, p, d)
    thetas, values = descend(objective(Strips(y, w), d, PRIOR), starts, enough=1e-3)
    theta = thetas[np.argmin(values)]
    found: list[list[Step]] = [[] for _ in y]
    while True:
        level = [lowered(ys, s) for ys, s in zip(y, found, strict=True)]
        weights, theta = danish(level, w, d, theta) if blunders else (w, refit(level, w, d, theta))
        if steps and d and sum(map(len, found)) < STEPS_MAX:
            search = _StepSearch(level, weights, w, d, theta)
            if search.found is not None:
                found[search.found[0]].append(search.found[1])
                theta = search.theta
                found = _resized(y, w, found, process_of(theta, d))
                continue
        return Cleaned(weights, found, process_of(theta, d))


def lowered(y: Array, steps: list[Step]) -> Array:
    """Values (n,) without the jumps."""
    out = y.copy()
    for step in steps:
        out[step.index :] -= step.size
    return out


class _StepSearch:
    """The step that makes the data most likely, the process fitted anew to each candidate.

    A step within the data makes the process look rougher than it is, and so hides itself: it is judged by what
    becomes of the likelihood once it is taken out.  Rejected observations around it are given back, and their
    rejection is charged as a parameter each, as the step is.
    """

    def __init__(self, y: list[Array], used: list[Array], w: list[Array], d: int, theta: Array) -> None:
        self._y, self._used, self._w, self._d = y, used, w, d
        self.theta = theta
        self.found: tuple[int, Step] | None = None
        self._m = len(theta) - 2 + d
        count = sum(max(len(ys) - 2 * self._m, 1) for ys in y)
        self._charge = float(norm.isf(0.5 * STEP_ERROR / count)) ** 2
        best = 0.0
        self._before = self._value(y, used, theta)
        for strip, at in self._candidates(theta):
            gain, step, new = self._tried(strip, at, theta)
            if gain > best:
                best, self.found, self.theta = gain, (strip, step), new

    def _candidates(self, theta: Array) -> list[tuple[int, int]]:
        """Epochs at which a step would be most significant as things stand, strongest first."""
        peaks = []
        process = process_of(theta, self._d)
        for strip, (ys, us) in enumerate(zip(self._y, self._used, strict=True)):
            t = np.nan_to_num(np.abs(step_statistics(filter_series(ys, us, process, width=2 * self._m))[0]))
            for _ in range(CANDIDATES):
                k = int(np.argmax(t))
                if t[k] < WORTH_A_TRIAL:
                    break
                peaks.append((t[k], strip, k))
                t[max(k - self._m, 0) : k + self._m + 1] = 0.0
        found = [(strip, k) for _, strip, k in sorted(peaks, reverse=True)[:CANDIDATES]]
        return found + [place for place in self._crowds() if place not in found]

    def _crowds(self) -> list[tuple[int, int]]:
        """Middles of the densest groups of rejected observations: a step may hide behind them."""
        crowds: list[tuple[int, int, int]] = []
        for strip, (us, ws) in enumerate(zip(self._used, self._w, strict=True)):
            rejected = np.flatnonzero((us == 0.0) & (ws > 0.0))
            groups = np.split(rejected, np.flatnonzero(np.diff(rejected) > self._m) + 1)
            crowds += [(len(group), strip, int(group[len(group) // 2])) for group in groups if len(group) > 1]
        return [(strip, k) for _, strip, k in sorted(crowds, reverse=True)[:CANDIDATES]]

    def _tried(self, strip: int, at: int, theta: Array) -> tuple[float, Step, Array]:
        """What a step near an epoch gains in -2 log likelihood, all charges counted; the step; the process."""
        m, w = self._m, self._w[strip]
        near = slice(max(at - m - 2, 0), at + m + 3)
        used = list(self._used)
        used[strip] = used[strip].copy()
        given_back = np.flatnonzero((used[strip][near] == 0.0) & (w[near] > 0.0)) + near.start
        used[strip][near] = w[near]
        y = list(self._y)
        step = Step(at, 0.0, 0.0)
        for _ in range(3):
            process = process_of(theta, self._d)
            t, sigma = step_statistics(filter_series(self._y[strip], used[strip], process, width=2 * m))
            k = near.start + int(np.argmax(np.nan_to_num(np.abs(t[near]))))
            step = Step(k, float(np.nan_to_num(t[k] * sigma[k])), float(np.nan_to_num(sigma[k])))
            y[strip] = lowered(self._y[strip], [step])
            theta = refit(y, used, self._d, theta)
        rejected = self._rejection(strip, given_back)
        if step.size**2 <= self._charge * step.sigma**2:
            return 0.0, step, theta
        gain = self._before + rejected - self._value(y, used, theta) - self._charge
        return gain, step, theta

    def _rejection(self, strip: int, rejected: np.ndarray) -> float:
        """-2 log likelihood of observations that may be anything: the peak of their density, and the charge."""
        if not len(rejected):
            return 0.0
        out = filter_series(self._y[strip], self._used[strip], process_of(self.theta, self._d))
        variance = out.process.sigma_n**2 / self._w[strip][rejected] + out.cov_band[rejected, 0]
        return float(np.sum(np.log(2.0 * np.pi * variance) + self._charge))

    def _value(self, y: list[Array], used: list[Array], theta: Array) -> float:
        value = Strips(y, used).deviance(theta[None], self._d)[0] + PRIOR.deviance(theta[None])[0]
        return float(value[0])


def _resized(y: list[Array], w: list[Array], found: list[list[Step]], process: Process) -> list[list[Step]]:
    """All steps of each strip estimated together, by turns."""
    m = process.p + process.d
    for ys, ws, steps in zip(y, w, found, strict=True):
        for _ in range(6 if len(steps) > 1 else 0):
            for k, step in enumerate(steps):
                t, sigma = step_statistics(filter_series(lowered(ys, steps), ws, process, width=2 * m))
                at = step.index
                if np.isfinite(t[at]):
                    steps[k] = replace(step, size=step.size + float(t[at] * sigma[at]), sigma=float(sigma[at]))
    return found
