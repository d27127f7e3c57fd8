"""From parameters and smoothed strips to a result in the unit of the series."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aerosim.estimation.ari import diagnostics as told
from aerosim.estimation.ari.diagnostics import Diagnostics
from aerosim.estimation.ari.filter import Filtered, filter_series
from aerosim.estimation.ari.modes import Mode, process_of
from aerosim.estimation.ari.posterior import Averaged, Samples
from aerosim.estimation.ari.process import Process
from aerosim.estimation.ari.result import AriFit, Estimate, StripFit
from aerosim.estimation.ari.robust import Step, lowered
from aerosim.estimation.ari.series import Scaled, Series
from aerosim.frames import Array

INTERVAL = 0.05, 0.95


@dataclass(frozen=True)
class Prepared:
    """Strips on their way: as given, scaled, without blunders (weights) and steps (levels)."""

    series: list[Series]
    ready: Scaled
    weights: list[Array]
    steps: list[list[Step]]
    d: int

    @property
    def levels(self) -> list[Array]:
        """Scaled values without the jumps (n_i,)."""
        return [lowered(y, s) for y, s in zip(self.ready.y, self.steps, strict=True)]

    @property
    def observed(self) -> int:
        """Observations that count."""
        return sum(int(np.count_nonzero(w)) for w in self.weights)


def assembled(
    data: Prepared,
    averaged: list[Averaged],
    theta: Array,
    every: Array,
    modes: list[Mode],
    samples: Samples | None,
    method: str,
    lags: int,
) -> AriFit:
    """The result.  theta: the parameters (q,) that stand for all; every: draws of them (k, q)."""
    d, p, scale = data.d, len(theta) - 2, data.ready.scale
    process = process_of(theta, d)
    outs = [filter_series(ys, ws, process) for ys, ws in zip(data.levels, data.weights, strict=True)]
    strips = tuple(_strip(data, k, averaged[k], outs[k]) for k in range(len(outs)))
    sigma_n, sigma_e = np.exp(0.5 * every[:, p + 1]) * scale, np.exp(0.5 * every[:, p]) * scale
    if samples is None:
        value_n, value_e = process.sigma_n * scale, process.sigma_e * scale
    else:
        value_n, value_e = float(np.mean(sigma_n)), float(np.median(sigma_e))
    numbers = _numbers(data, process, outs, sigma_n, sigma_e, (value_n, value_e), modes, samples)
    return AriFit(
        p=p,
        d=d,
        process=unscaled(process, scale),
        sigma_n=Estimate(value_n, *map(float, np.quantile(sigma_n, INTERVAL))),
        sigma_e=Estimate(value_e, *map(float, np.quantile(sigma_e, INTERVAL))),
        sigma_x=float(np.sqrt(np.mean(np.concatenate([s.sigma_x for s in strips]) ** 2))),
        r=_correlations([s.cov_band for s in strips], lags),
        redundancy=(
            sum(float(o.redundancy_n.sum()) for o in outs),
            sum(float(o.redundancy_e.sum()) for o in outs),
        ),
        loglik=sum(o.loglik for o in outs) - (data.observed - d * len(outs)) * float(np.log(scale)),
        flags=told.flags(numbers, told.two_hills(modes, d)),
        diagnostics=numbers,
        method=method,
        strips=strips,
        samples=samples,
        scale=scale,
    )


def unscaled(process: Process, scale: float) -> Process:
    """The process in the unit of the series."""
    return Process(process.a, process.d, process.sigma_n * scale, process.sigma_e * scale)


def _numbers(
    data: Prepared,
    process: Process,
    outs: list[Filtered],
    sigma_n: Array,
    sigma_e: Array,
    values: tuple[float, float],
    modes: list[Mode],
    samples: Samples | None,
) -> Diagnostics:
    limit_n, limit_e = told.limits(process, data.observed)
    return Diagnostics(
        ratio=values[0] / values[1],
        ratio_low=float(np.quantile(sigma_n / sigma_e, INTERVAL[0])),
        limit_n=limit_n,
        limit_e=limit_e,
        # a single value has no spread: what the data allow at best stands for it
        spread_n=_spread(sigma_n) if len(sigma_n) > 1 else limit_n,
        spread_e=_spread(sigma_e) if len(sigma_e) > 1 else limit_e,
        root=float(process.roots[0]) if process.p else 0.0,
        hills=len(modes),
        whiteness=told.whiteness([told.innovations(o) for o in outs], process.p + 1),
        piled_up=float(np.mean(sigma_n < told.PILED_UP[0] * values[0])),
        acceptance=samples.acceptance if samples else np.nan,
        effective=samples.size if samples else np.nan,
        repeated=_repeated(data.series),
    )


def _repeated(series: list[Series]) -> float:
    """Share of observations that equal the one before them."""
    equal = pairs = 0
    for strip in series:
        both = (strip.w[1:] > 0.0) & (strip.w[:-1] > 0.0)
        pairs += int(np.count_nonzero(both))
        equal += int(np.count_nonzero(both & (strip.y[1:] == strip.y[:-1])))
    return equal / max(pairs, 1)


def _spread(sigma: Array) -> float:
    """Standard deviation of the logarithm of a normal variable with the same 90 % interval."""
    low, high = np.quantile(sigma, INTERVAL)
    return float(np.log(high / low) / (2.0 * 1.6449))


def _correlations(bands: list[Array], lags: int) -> Array:
    """Correlations of the errors at lags 0 ... lags, from the covariances of all strips."""
    lags = min(lags, bands[0].shape[1] - 1)
    means = []
    for h in range(lags + 1):
        total = sum(float(b[: len(b) - h, h].sum()) for b in bands)
        means.append(total / sum(len(b) - h for b in bands))
    return np.array(means) / means[0]


def _strip(data: Prepared, k: int, averaged: Averaged, out: Filtered) -> StripFit:
    """One strip in its own unit again, jumps put back, their uncertainty added."""
    strip, used, scale = data.series[k], data.weights[k], data.ready.scale
    x, band = averaged.x.copy(), averaged.cov_band.copy()
    n = len(x)
    for step in data.steps[k]:
        jump = np.zeros(n)
        jump[step.index :] = 1.0
        x += step.size * jump
        left = jump - filter_series(jump, used, out.process).x
        for h in range(min(band.shape[1], n)):
            band[: n - h, h] += step.sigma**2 * left[: n - h] * left[h:]
    x = x * scale + data.ready.trend[k]
    there = strip.w > 0.0
    ordered = sorted(data.steps[k], key=lambda step: step.index)
    return StripFit(
        x=x,
        sigma_x=np.sqrt(band[:, 0]) * scale,
        sigma_x_conditional=out.sigma_x * scale,
        cov_band=band * scale**2,
        rows=strip.rows,
        start=strip.start,
        dt=strip.dt,
        weights=used,
        outliers=np.flatnonzero(there & (used == 0.0)),
        steps=tuple(Step(s.index, s.size * scale, s.sigma * scale) for s in ordered),
        residuals=np.where(there, strip.y - x, np.nan),
        redundancy_n=out.redundancy_n,
        redundancy_e=out.redundancy_e,
    )
