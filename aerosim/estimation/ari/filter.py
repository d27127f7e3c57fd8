"""The filter of Lindenberger 1988, 2.2, for a process that is known: equations (2) and (3) as least squares.

    y = x + n, V(n_t) = sn^2/w_t        0 = A x + e, V(e_t) = se^2/u_t

Missing observations have weight zero; nothing else is needed for gaps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.estimation.ari.band import SAME, equation_variances, factor, selected_inverse, smooth, solve
from aerosim.estimation.ari.process import Process, checked_process, start_precision
from aerosim.estimation.ari.series import checked_series, trend_of
from aerosim.frames import Array

Start = Literal["stationary", "diffuse"]
NOTHING = np.zeros(0)


@dataclass(frozen=True)
class Filtered:
    """A smoothed series with its covariances, all conditional on the process.

    x: (n,), unit of the series.  cov_band: (n, width + 1), [t, h] is the covariance of the errors at t and t + h,
    width at least p + d.  loglik: logarithm of the likelihood.  residuals: y - x (n,), NaN where missing.
    redundancy_n: of each observation (n,); redundancy_e: of each process equation (n - m,), between 0 and 1.
    errors_e: A x (n - m,).  factor: of the normal equations (n, m + 1).  y, weights: what was smoothed, (n,) each.
    """

    process: Process
    x: Array
    cov_band: Array
    loglik: float
    residuals: Array
    redundancy_n: Array
    redundancy_e: Array
    errors_e: Array
    factor: Array
    y: Array
    weights: Array

    @property
    def sigma_x(self) -> Array:
        """Standard deviation of the error of x (n,)."""
        return np.sqrt(self.cov_band[:, 0])

    def correlation(self, lags: int, at: int | None = None) -> Array:
        """Correlations r(0 ... lags) of the error at epoch `at` (the middle) with those after it.

        The correlation coefficients of tables 3 to 5 of the paper.
        """
        n = len(self.x)
        middle = n // 2 if at is None else at
        lags = min(lags, n - 1 - middle)
        column = np.zeros(n)
        column[middle] = 1.0
        solve(self.factor, column)
        variances = self.cov_band[middle : middle + lags + 1, 0]
        return np.asarray(column[middle : middle + lags + 1] / np.sqrt(variances * variances[0]))


def filter_series(
    y: Array, w: Array, process: Process, *, start: Start = "stationary", width: int = 0, u: Array = NOTHING
) -> Filtered:
    """Smooth values y (n,) of weights w (n,), 0 = missing; u: weights of the equations (n - m,), empty for one."""
    n, m = len(y), process.p + process.d
    c, inv_n, inv_e = process.c, process.sigma_n**-2.0, process.sigma_e**-2.0
    corner = process.corner if start == "stationary" else np.zeros((m, m))
    L, x, Z = np.zeros((n, m + 1)), np.zeros(n), np.zeros((n, max(width, m) + 1))
    log_det = factor(L, w, c, inv_n, inv_e, corner, u, SAME)
    if math.isnan(log_det):
        raise InputError("the observations do not determine the series", "weights", f"at least {m} values")
    smooth(L, x, y, w, c, inv_n, inv_e, corner, u, True)
    selected_inverse(L, Z)
    there = w > 0.0
    v = np.where(there, y - x, np.nan)
    e = np.convolve(x, c, "valid")
    uu = u if len(u) else np.ones(n - m)
    equation = np.zeros(n - m)
    equation_variances(Z, c, equation)
    used = uu > 0.0
    squares = np.nansum(w * v**2) * inv_n + np.sum(uu * e**2) * inv_e + float(x[:m] @ corner @ x[:m]) * inv_e
    equations, free = (n - process.d, process.d) if start == "stationary" else (int(np.sum(used)), m)
    log_start = np.linalg.slogdet(_start(process))[1] if start == "stationary" else 0.0
    two_l = (
        np.count_nonzero(there) * 2.0 * math.log(process.sigma_n)
        - np.sum(np.log(w[there]))
        + equations * 2.0 * math.log(process.sigma_e)
        - np.sum(np.log(uu[used]))
        - log_start
        + log_det
        + squares
        + (np.count_nonzero(there) - free) * math.log(2.0 * math.pi)
    )
    return Filtered(
        process, x, Z, -0.5 * float(two_l), v, np.where(there, 1.0 - w * Z[:, 0] * inv_n, 0.0),
        1.0 - uu * equation * inv_e, e, L, y, w,
    )  # fmt: skip


def _start(process: Process) -> Array:
    G = np.zeros((process.p, process.p))
    start_precision(process.a, G)
    return G if process.p else np.eye(1)


def filter_ari(
    y: ArrayLike,
    a: ArrayLike,
    d: int,
    sigma_n: float,
    sigma_e: float,
    *,
    weights: ArrayLike | None = None,
    process_weights: ArrayLike | None = None,
    start: Start = "stationary",
    width: int = 0,
    period: float | None = None,
) -> Filtered:
    """Smooth a series whose process is known.

    y: (n,), NaN where missing.  a, d, sigma_n, sigma_e: as in `Process`, unit of the series.  weights: of the
    observations (n,).  process_weights: of the equations (3) of the paper (n - p - d,).  start: the first
    differences come from the stationary law, or are free as in the paper.  width: least number of lags of the
    covariance band.  period: of an angle.  Raises InputError: see `checked_series`, `checked_process`.
    """
    process = checked_process(a, d, sigma_n, sigma_e)
    strip = checked_series(y, None, weights, 1.0, period)
    m = process.p + d
    if strip.observed <= m:
        raise InputError(f"{strip.observed} points for order ({process.p},{d})", "y", f"at least {m + 1}")
    u = NOTHING if process_weights is None else np.asarray(process_weights, float)
    if len(u) not in (0, len(strip.y) - m) or np.any(~(u >= 0.0)):
        raise InputError(
            "process weights do not fit", "process_weights", f"{len(strip.y) - m} numbers, none negative"
        )
    # digits: a polynomial that the differences take away passes the filter unchanged
    trend = trend_of(strip, d)
    rest = np.where(strip.w > 0.0, strip.y - trend, 0.0)
    out = filter_series(rest, strip.w, process, start=start, width=width, u=u)
    return replace(out, x=out.x + trend, y=out.y + trend)
