"""ARI processes fitted to series of which nothing is known beforehand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.estimation.ari.assemble import Prepared, assembled, unscaled
from aerosim.estimation.ari.filter import filter_series
from aerosim.estimation.ari.likelihood import Strips
from aerosim.estimation.ari.modes import Mode, find_modes, objective, process_of, strewn_starts
from aerosim.estimation.ari.posterior import Averaged, Mixture, average, sample
from aerosim.estimation.ari.prior import Prior
from aerosim.estimation.ari.result import AriFit
from aerosim.estimation.ari.robust import clean, quick_starts
from aerosim.estimation.ari.series import Series, checked_order, checked_series, scaled
from aerosim.estimation.ari.vce import iterate, theta_of
from aerosim.frames import Array

Method = Literal["auto", "average", "ml", "vce"]
Robust = Literal["danish", "none"]
AVERAGED_UP_TO = 2000  # observations; beyond, the mode and the curvature around it say the same, faster
FLAT = Prior(flat=True)
DRAWS, DRAWS_LONG, LONG = 160, 24, 2_000
WIDTH = 3  # least lags of the covariance band: what interpolation needs
HEAD = 1000  # epochs on which starting values of longer series are tried
RUN_AWAY = 2.0  # of log likelihood, lost since the best iterate
VANISHING = 0.1  # of the largest sigma_e on the way
ITERATIONS = 60  # of method vce


def fit_ari(
    y: ArrayLike | Sequence[ArrayLike],
    p: int,
    d: int,
    *,
    times: ArrayLike | Sequence[ArrayLike] | None = None,
    dt: float = 1.0,
    weights: ArrayLike | Sequence[ArrayLike] | None = None,
    method: Method = "auto",
    robust: Robust = "danish",
    steps: bool = True,
    prior: Prior | None = None,
    period: float | None = None,
    lags: int = 4,
    seed: int = 0,
) -> AriFit:
    """Fit an ARI(p, d) process seen through white noise, and smooth the series with it.

    y: values (n,), NaN where missing; or a list of strips that share one process.  times, weights: of the same
    form; see `checked_series`.  dt: step where no times are given.
    method: `average` over the posterior density by draws; `ml`, the highest mode of the likelihood; `vce`, the
    iteration of the 1988 paper, which runs away; `auto`: average up to 2000 observations, ml beyond.
    robust: `danish` rejects blunders.  steps: jumps are looked for.  prior: of method average.  period: of an
    angle, to be unwrapped.  lags: least number of lags of the covariance band.  seed: of the draws.
    Raises InputError: see `checked_series`, `scaled`, `checked_order`, `danish`.
    """
    for key, value, allowed in (("method", method, get_args(Method)), ("robust", robust, get_args(Robust))):
        if value not in allowed:
            raise InputError(f"{value!r} is unknown", key, ", ".join(allowed))
    checked_order(p, d)
    data, known = _prepared(checked_strips(y, times, weights, dt, period), p, d, robust == "danish", steps)
    if method == "auto":
        method = "average" if data.observed <= AVERAGED_UP_TO else "ml"
    width = max(lags, WIDTH)
    if method == "vce":
        return _fit_vce(data, p, width, lags)
    levels, rng = data.levels, np.random.default_rng(seed)
    strips = Strips(levels, data.weights)
    chosen = FLAT if method == "ml" else (prior or Prior())
    # the posterior density has few hills, the likelihood many
    starts = np.vstack([*known, *_starts(strips, levels, data.weights, p, d, chosen, method)])
    modes = find_modes(objective(strips, d, chosen), starts)
    samples = None
    if method == "average":

        def value_of(thetas: Array) -> Array:
            value = strips.deviance(thetas, d, tol=1e-9)[0] + chosen.deviance(thetas)[0]
            return np.where(np.isfinite(value), value, np.inf)

        samples = sample(value_of, modes, rng)
        every = samples.thetas
        draws = every[np.linspace(0, len(every) - 1, DRAWS).astype(int)]
        theta = _typical(draws, d)
    else:
        every = draws = _laplace(modes[0], rng, DRAWS if data.observed <= LONG else DRAWS_LONG)
        theta = modes[0].theta
    averaged = [average(draws, ys, ws, d, width) for ys, ws in zip(levels, data.weights, strict=True)]
    return assembled(data, averaged, theta, every, modes, samples, method, lags)


def _starts(
    strips: Strips, y: list[Array], w: list[Array], p: int, d: int, prior: Prior, method: Method
) -> list[Array]:
    """Starting values (k, p + 2): iterates of the paper and strewn ones; of long series, the modes of a part."""
    iterates, strewn = (6, 12) if method == "ml" else (3, 4)
    head = strips.head(HEAD)
    if 2 * len(head.y) > len(strips.y):
        return [quick_starts(y, w, p, d, iterates), strewn_starts(strips, p, d, strewn)]
    parts = [slice(a, b) for a, b in pairwise(head.starts)]
    first = quick_starts([head.y[s] for s in parts], [head.w[s] for s in parts], p, d, iterates)
    of = objective(head, d, prior)
    modes = find_modes(of, np.vstack([first, strewn_starts(head, p, d, strewn)]))
    return [mode.theta[None] for mode in modes[:4]]


def checked_strips(
    y: ArrayLike | Sequence[ArrayLike],
    times: ArrayLike | Sequence[ArrayLike] | None,
    weights: ArrayLike | Sequence[ArrayLike] | None,
    dt: float,
    period: float | None,
) -> list[Series]:
    """The strips of a call, each checked; see `fit_ari` for the arguments."""
    several = isinstance(y, (list, tuple)) and len(y) > 0 and np.ndim(y[0]) > 0
    values = _parted(y, several)
    parts = []
    for key, given in (("times", times), ("weights", weights)):
        part = [None] * len(values) if given is None else _parted(given, several)
        if len(part) != len(values):
            raise InputError(f"{len(part)} of them for {len(values)} strips", key, "one for each strip")
        parts.append(part)
    out = [
        checked_series(value, t, w, dt, period, f"y[{k}]" if several else "y")
        for k, (value, t, w) in enumerate(zip(values, *parts, strict=True))
    ]
    if any(abs(s.dt / out[0].dt - 1.0) > 1e-3 for s in out):
        raise InputError("strips of different steps", "times", "one step for all that share a process")
    return out


def _parted(given: ArrayLike | Sequence[ArrayLike], several: bool) -> list[Array]:
    return [np.asarray(part, float) for part in given] if several else [np.asarray(given, float)]  # type: ignore[union-attr]


def _prepared(series: list[Series], p: int, d: int, blunders: bool, steps: bool) -> tuple[Prepared, list[Array]]:
    """Strips scaled and cleaned, and the parameters that were found on the way, if any."""
    ready = scaled(series, p, d)
    if not (blunders or steps):
        return Prepared(series, ready, ready.w, [[] for _ in series], d), []
    cleaned = clean(ready.y, ready.w, p, d, blunders=blunders, steps=steps)
    return Prepared(series, ready, cleaned.weights, cleaned.steps, d), [theta_of(cleaned.process)]


def _laplace(mode: Mode, rng: np.random.Generator, count: int) -> Array:
    """Draws from the normal density around a mode, in pairs that have it in their middle, (count, q)."""
    normal = rng.normal(size=(count // 2, len(mode.theta))) @ Mixture([mode]).roots[0].T
    return np.concatenate([mode.theta + normal, mode.theta - normal])


def _typical(draws: Array, d: int) -> Array:
    """The draw (q,) whose noise and filter are most like the mean of all."""
    said = []
    for theta in draws:
        sigma, r = process_of(theta, d).filtered(3, 256)
        said.append([0.5 * theta[-1], np.log(sigma), *r[1:]])
    values = np.array(said)
    spread = values.std(axis=0) + 1e-12
    return np.asarray(draws[np.argmin(np.sum(((values - values.mean(axis=0)) / spread) ** 2, axis=1))])


def _fit_vce(data: Prepared, p: int, width: int, lags: int) -> AriFit:
    """The paper's iteration to its end, and a flag when it left the likelihood behind on its way."""
    steps = iterate(data.levels, data.weights, p, data.d, most=ITERATIONS)
    last, scale = steps[-1], data.ready.scale
    averaged = []
    for ys, ws in zip(data.levels, data.weights, strict=True):
        out = filter_series(ys, ws, last.process, start="diffuse", width=width)
        averaged.append(Averaged(out.x, out.cov_band, out.cov_band))
    theta = theta_of(last.process, 0.9999)
    mode = Mode(theta, 0.0, np.eye(p + 2))
    fit = assembled(data, averaged, theta, theta[None], [mode], None, "vce", lags)
    ran_away = (
        max(step.loglik for step in steps) - last.loglik > RUN_AWAY
        or last.process.sigma_e < VANISHING * max(step.process.sigma_e for step in steps)
    )  # fmt: skip
    return replace(
        fit,
        process=unscaled(last.process, scale),
        iterates=tuple(replace(step, process=unscaled(step.process, scale)) for step in steps),
        sigma_n=replace(fit.sigma_n, low=np.nan, high=np.nan),
        sigma_e=replace(fit.sigma_e, low=np.nan, high=np.nan),
        redundancy=(last.redundancy_n, last.redundancy_e),
        flags=fit.flags + (("run_away",) if ran_away else ()),
    )
