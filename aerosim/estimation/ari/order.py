"""Choice of the order (p, d) by an information criterion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.estimation.ari.fit import Robust, checked_strips
from aerosim.estimation.ari.likelihood import Strips
from aerosim.estimation.ari.modes import descend, objective
from aerosim.estimation.ari.robust import PRIOR, clean, lowered, quick_starts
from aerosim.estimation.ari.series import checked_order, points_needed, scaled
from aerosim.frames import Array

Criterion = Literal["aicc", "bic"]


@dataclass(frozen=True)
class OrderChoice:
    """The order chosen, and the criterion of all that were tried: {(p, d): value}, least is best."""

    p: int
    d: int
    criterion: dict[tuple[int, int], float]


def select_order(
    y: ArrayLike | Sequence[ArrayLike],
    *,
    p: Sequence[int] = range(1, 7),
    d: Sequence[int] = (1, 2),
    criterion: Criterion = "aicc",
    times: ArrayLike | Sequence[ArrayLike] | None = None,
    dt: float = 1.0,
    weights: ArrayLike | Sequence[ArrayLike] | None = None,
    robust: Robust = "danish",
    period: float | None = None,
) -> OrderChoice:
    """Order with the least AICc or BIC among those given.

    Likelihoods of different d are comparable as densities of the later values given the first max(p) + max(d).
    Short strips seldom show their true order (docs/ari.md): what is chosen filters well, it is no finding.
    y, times, dt, weights, robust, period: as in `fit_ari`.  Raises InputError as that does.
    """
    if criterion not in get_args(Criterion):
        raise InputError(f"{criterion!r} is unknown", "criterion", ", ".join(get_args(Criterion)))
    if not len(p) or not len(d):
        raise InputError("no order to choose from", "p" if not len(p) else "d", "at least one")
    for each in p:
        for other in d:
            checked_order(each, other)
    series = checked_strips(y, times, weights, dt, period)
    first = max(p) + max(d)
    if sum(s.observed for s in series) < points_needed(max(p), max(d)) + first * len(series):
        needed = points_needed(max(p), max(d)) + first * len(series)
        raise InputError(f"too few points for orders up to ({max(p)},{max(d)})", "y", f"at least {needed}")
    middle = sorted(p)[len(p) // 2], sorted(d)[-1]
    ready = scaled(series, *middle)
    w, level = ready.w, ready.y
    if robust == "danish":
        cleaned = clean(ready.y, ready.w, *middle, blunders=True, steps=True)
        w = cleaned.weights
        level = [lowered(ys, s) for ys, s in zip(ready.y, cleaned.steps, strict=True)]
    values = {}
    for each_d in d:
        for each_p in p:
            values[int(each_p), int(each_d)] = _value(level, w, each_p, each_d, first, criterion)
    best = min(values, key=lambda order: values[order])
    return OrderChoice(*best, values)


def _value(y: list[Array], w: list[Array], p: int, d: int, first: int, criterion: Criterion) -> float:
    strips = Strips(y, w)
    theta, value = descend(objective(strips, d, PRIOR), quick_starts(y, w, p, d), enough=1e-3)
    best = theta[np.argmin(value)][None]
    heads = Strips([ys[:first] for ys in y], [ws[:first] for ws in w])
    two_l = float((strips.deviance(best, d)[0] - heads.deviance(best, d)[0])[0])
    n, k = strips.observed - heads.observed, p + 2
    if criterion == "bic":
        return two_l + k * float(np.log(n))
    return two_l + 2.0 * k * n / max(n - k - 1, 1)
