"""What a fit gives back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.estimation.ari.diagnostics import Diagnostics
from aerosim.estimation.ari.posterior import Samples
from aerosim.estimation.ari.process import Process
from aerosim.estimation.ari.robust import Step
from aerosim.estimation.ari.vce import Iterate
from aerosim.frames import Array


@dataclass(frozen=True)
class Estimate:
    """A value and its 90 % interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class StripFit:
    """One smoothed strip on its grid of equal steps, unit of the series.

    x, sigma_x: smoothed values and their standard deviations (n,), what the parameters may be included;
    sigma_x_conditional: without.  cov_band: (n, width + 1), [t, h] is the covariance of the errors at t and t + h.
    rows: index on the grid of each row that was given.  start, dt: time of the first epoch, and step.
    weights: (n,), 0 where missing or rejected.  outliers: epochs rejected.  steps: jumps found.
    residuals: y - x (n,), NaN where missing.  redundancy_n: of each observation (n,).  redundancy_e: of each
    process equation (n - p - d,).
    """

    x: Array
    sigma_x: Array
    sigma_x_conditional: Array
    cov_band: Array
    rows: np.ndarray
    start: float
    dt: float
    weights: Array
    outliers: np.ndarray
    steps: tuple[Step, ...]
    residuals: Array
    redundancy_n: Array
    redundancy_e: Array

    def at(self, times: ArrayLike) -> tuple[Array, Array]:
        """Values and standard deviations at times within the strip, any shape.

        Between epochs the cubic through the four nearest, its covariance propagated; what the series does faster
        than its steps is not known.  Raises InputError outside.
        """
        t = (np.asarray(times, float) - self.start) / self.dt
        n = len(self.x)
        if np.any(~((t >= -1e-9) & (t <= n - 1 + 1e-9))):
            raise InputError(
                "outside of the strip", "times", f"{self.start:g} to {self.start + (n - 1) * self.dt:g}"
            )
        first = np.clip(np.floor(t).astype(int) - 1, 0, n - 4)
        s = t - first
        nodes = range(4)
        weights = [np.prod([(s - j) / (i - j) for j in nodes if j != i], axis=0) for i in nodes]
        value = sum(weights[i] * self.x[first + i] for i in nodes)
        variance = sum(
            weights[i] * weights[j] * self.cov_band[first + min(i, j), abs(i - j)] for i in nodes for j in nodes
        )
        return np.asarray(value), np.sqrt(np.maximum(variance, 0.0))


@dataclass(frozen=True)
class AriFit:
    """A fitted ARI(p, d) process and the strips smoothed with it.

    process: one draw that stands for all (or the mode): coefficients a and sigmas that belong together.
    sigma_n, sigma_e: standard deviations of observation noise and of the prediction errors, with 90 % intervals.
    r: correlations of the errors of x at lags 0, 1, ...  sigma_x: typical, root mean square of all strips.
    redundancy: of observations and of process equations, summed.  loglik: of `process`.  flags: what cannot be
    believed (docs/ari.md).  method: what was done.  iterates: of method vce.  samples: draws of theta in units of
    `scale`, None without.
    """

    p: int
    d: int
    process: Process
    sigma_n: Estimate
    sigma_e: Estimate
    sigma_x: float
    r: Array
    redundancy: tuple[float, float]
    loglik: float
    flags: tuple[str, ...]
    diagnostics: Diagnostics
    method: str
    strips: tuple[StripFit, ...]
    iterates: tuple[Iterate, ...] = ()
    samples: Samples | None = None
    scale: float = 1.0

    @property
    def a(self) -> Array:
        """Coefficients of the autoregressive part (p,), sign of the paper's equation (1)."""
        return self.process.a

    @property
    def roots(self) -> Array:
        """Moduli of its roots, largest first (p,)."""
        return self.process.roots

    @property
    def gain(self) -> float:
        """sigma_x over sigma_n: what the filter leaves of the noise."""
        return self.sigma_x / self.sigma_n.value

    @property
    def strip(self) -> StripFit:
        """The only strip.  Raises InputError when several were pooled."""
        if len(self.strips) != 1:
            raise InputError(f"{len(self.strips)} strips were pooled", "strip", "strips[k]")
        return self.strips[0]

    @property
    def x(self) -> Array:
        """Smoothed values of the only strip (n,)."""
        return self.strip.x
