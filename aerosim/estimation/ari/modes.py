"""Modes of the likelihood or of the posterior density: many starts, all descents in step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aerosim.errors import InputError
from aerosim.estimation.ari.likelihood import Strips, unpack
from aerosim.estimation.ari.prior import Prior
from aerosim.estimation.ari.process import Process
from aerosim.frames import Array

Objective = Callable[[Array], tuple[Array, Array]]
STEP_MAX = 1.5  # of one iteration, in any parameter: atanh of r or logarithms of variances
ARMIJO = 1e-4
SHORTEST = 1e-10
STREWN = (-9.0, 0.0)  # logarithms of variances, those of the differenced observations being 1
SHOWN = 2000
EARLY, KEPT = 12, 8  # iterations after which the best descents go on


@dataclass(frozen=True)
class Mode:
    """theta (p + 2,), what was minimised there, and half its second derivatives (q, q): the inverse covariance."""

    theta: Array
    value: float
    precision: Array


def objective(strips: Strips, d: int, prior: Prior) -> Objective:
    """-2 log of likelihood times prior, and its gradient."""

    def of(thetas: Array) -> tuple[Array, Array]:
        value, grad = strips.deviance(thetas, d, gradient=True)
        more, more_grad = prior.deviance(thetas)
        total, grad = value + more, grad + more_grad
        bad = ~np.isfinite(total) | ~np.isfinite(grad).all(axis=1)
        total[bad], grad[bad] = np.inf, 0.0
        return total, grad

    return of


def descend(of: Objective, starts: Array, *, most: int = 120, enough: float = 1e-6) -> tuple[Array, Array]:
    """BFGS from each start (k, q), all at once.  Returns parameters (k, q) and values (k,), unsorted.

    enough: a descent ends when its next step promises less than this.
    """
    theta = starts.copy()
    f, g = of(theta)
    k, q = theta.shape
    inverse = np.repeat(0.05 * np.eye(q)[None], k, axis=0)
    fresh = np.ones(k, bool)
    live = np.isfinite(f)
    step = -np.einsum("kij,kj->ki", inverse, g)
    length = np.ones(k)
    for _ in range(most):
        on = np.flatnonzero(live)
        if not len(on):
            break
        size = np.abs(step[on]).max(axis=1)
        cut = length[on] * np.minimum(1.0, STEP_MAX / np.maximum(size, 1e-300))
        move = cut[:, None] * step[on]
        new = theta[on] + move
        f_new, g_new = of(new)
        slope = np.einsum("ki,ki->k", g[on], move)
        good = f_new <= f[on] + ARMIJO * slope
        length[on[~good]] *= 0.25
        for i in np.flatnonzero(good):
            j = on[i]
            change = g_new[i] - g[j]
            curvature = float(change @ move[i])
            if curvature > 1e-12 * np.linalg.norm(change) * np.linalg.norm(move[i]):
                if fresh[j]:
                    inverse[j] = np.eye(q) * curvature / (change @ change)
                    fresh[j] = False
                Hy = inverse[j] @ change
                inverse[j] += (1.0 + change @ Hy / curvature) / curvature * np.outer(move[i], move[i])
                inverse[j] -= (np.outer(move[i], Hy) + np.outer(Hy, move[i])) / curvature
            theta[j], f[j], g[j], length[j] = new[i], f_new[i], g_new[i], 1.0
            step[j] = -inverse[j] @ g[j]
            if g[j] @ step[j] >= 0.0:
                inverse[j], fresh[j] = 0.05 * np.eye(q), True
                step[j] = -inverse[j] @ g[j]
            live[j] = -(g[j] @ step[j]) > enough
        live[on] &= length[on] > SHORTEST
    return theta, f


def strewn_starts(strips: Strips, p: int, d: int, count: int, tries: int = 200) -> Array:
    """The most likely of parameters strewn widely, (count, p + 2): hills that no iterate of the paper lies on.

    Judged by the first `SHOWN` observations.
    """
    rng = np.random.default_rng(p + 10 * d)
    low, high = STREWN
    thetas = np.c_[rng.normal(0.0, 0.7, (tries, p)), rng.uniform(low, high, (tries, 2))]
    value, _ = strips.head(SHOWN).deviance(thetas, d, tol=1e-8)
    best: Array = thetas[np.argsort(np.where(np.isfinite(value), value, np.inf))[:count]]
    return best


def precision_at(of: Objective, theta: Array, h: float = 1e-3) -> Array:
    """Half the second derivatives by central differences of the gradient, (q, q), made symmetric."""
    steps = h * np.eye(len(theta))
    _, grads = of(np.concatenate([theta + steps, theta - steps]))
    q = len(theta)
    second = (grads[:q] - grads[q:]) / (2.0 * h)
    return np.asarray(0.25 * (second + second.T))


def find_modes(of: Objective, starts: Array, *, within: float = 12.0, apart: float = 0.05) -> list[Mode]:
    """Distinct modes whose value is within so much of the best, best first.  Raises InputError if there is none.

    apart: modes nearer than this in value, and in every parameter by 0.1, are the same.
    """
    if len(starts) > KEPT:
        # what lies far behind after some steps will not catch up
        early, behind = descend(of, starts, most=EARLY)
        starts = early[np.argsort(behind)[:KEPT]]
    theta, value = descend(of, starts)
    order = np.argsort(value)
    found: list[tuple[Array, float]] = []
    for i in order:
        if not np.isfinite(value[i]) or (found and value[i] > found[0][1] + within):
            break
        same = any(abs(value[i] - v) < apart and np.abs(theta[i] - t).max() < 0.1 for t, v in found)
        # a descent that had not arrived yet is no mode of its own
        if not same and not any(np.abs(theta[i] - t).max() < 0.3 for t, _ in found):
            found.append((theta[i], float(value[i])))
    if not found:
        raise InputError("no process of this order explains it", "y", "another order; robust='none'")
    return [Mode(t, v, precision_at(of, t)) for t, v in found]


def process_of(theta: Array, d: int) -> Process:
    """The process of parameters theta (p + 2,)."""
    p = len(theta) - 2
    a = np.zeros(p)
    unpack(theta, a, np.zeros((p, p)))
    sigma_e, sigma_n = np.exp(0.5 * theta[p:])
    return Process(a, d, float(sigma_n), float(sigma_e))
