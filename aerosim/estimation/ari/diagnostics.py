"""What a fit cannot know, said: noise and process not told apart, roots near one, two hills."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky_banded, solve_banded
from scipy.stats import chi2

from aerosim.estimation.ari.filter import Filtered
from aerosim.estimation.ari.modes import Mode, process_of
from aerosim.estimation.ari.process import Process
from aerosim.frames import Array

ROOT = 0.98  # modulus from which on a root counts as near one
SPREAD_N, SPREAD_E = 0.38, 0.7  # from which on a sigma counts as unknown: 90 % intervals of a factor 3.5 and 10
LIMIT_E = 1.0  # the same, of what the data allow for sigma_e: its interval is mostly the prior's
RATIO_N = 0.12  # sigma_n/sigma_e that must be excluded (5 %): noise below it is not told from the process
PILED_UP = 0.1, 0.05  # share of the estimate, probability of less
REPEATED = 0.3  # share of equal neighbours: steps of the reading are no white noise then
SECOND_HILL = 6.0  # in -2 log density
HILLS_DIFFER = 0.15  # relative difference of sigma_n, or of the filter's gain
NOT_WHITE = 1e-5  # the probability is an approximation: the parameters were fitted to the same values


@dataclass(frozen=True)
class Diagnostics:
    """Numbers behind the flags.

    ratio: sigma_n/sigma_e; ratio_low: its 5 % quantile over the draws.  limit_n, limit_e: least relative standard
    deviation of each sigma that the data allow (Cramer and Rao, Whittle's likelihood).  spread_n, spread_e: what
    was found, a standard deviation of the logarithm that has the same 90 % interval.
    root: largest modulus.  hills: number of modes within reach.  whiteness: probability of innovations as
    correlated as these (Ljung and Box).  piled_up: probability that sigma_n is below a tenth of its estimate.
    acceptance, effective: of the chains; NaN without.  repeated: share of observations equal to the one before.
    """

    ratio: float
    ratio_low: float
    limit_n: float
    limit_e: float
    spread_n: float
    spread_e: float
    root: float
    hills: int
    whiteness: float
    piled_up: float
    acceptance: float
    effective: float
    repeated: float


def limits(process: Process, n: int) -> tuple[float, float]:
    """Least relative standard deviations of sigma_n and sigma_e from n epochs, coefficients unknown too.

    Fisher information of Whittle's likelihood of the d-th differences.
    """
    omega = (np.arange(2048) + 0.5) * np.pi / 2048
    z = np.exp(-1j * omega)
    phi = np.polynomial.polynomial.polyval(z, np.r_[1.0, process.a])
    of_e = process.sigma_e**2 / np.abs(phi) ** 2
    of_n = process.sigma_n**2 * np.abs(1.0 - z) ** (2 * process.d)
    share = of_e / (of_e + of_n)
    rows = [-2.0 * np.real(z**i / phi) * share for i in range(1, process.p + 1)]
    rows += [share, 1.0 - share]
    slopes = np.array(rows)
    information = slopes @ slopes.T / len(omega) * 0.5 * max(n - process.d, 1)
    # not more than 1e6, however alike the two spectra are
    covariance = np.linalg.inv(information + 1e-12 * np.trace(information) * np.eye(len(rows)))
    return 0.5 * math.sqrt(abs(covariance[-1, -1])), 0.5 * math.sqrt(abs(covariance[-2, -2]))


def innovations(out: Filtered) -> Array:
    """Prediction errors of A y in units of their own standard deviation (n - m,); NaN where a value is missing.

    A y = e + A n has a band of covariances; its Cholesky factor whitens it from past to future.
    """
    process, n = out.process, len(out.x)
    c = process.c
    m = len(c) - 1
    there = out.weights > 0.0
    y = np.where(there, out.y, out.x)
    noise = process.sigma_n**2 / np.where(there, out.weights, 1e-8)
    w = np.convolve(y, c, "valid")
    lower = np.zeros((m + 1, n - m))
    for k in range(m + 1):
        for i in range(k, m + 1):
            lower[k, : n - m - k] += c[i] * c[i - k] * noise[m + k - i : n - i]
    lower[0] += process.sigma_e**2
    try:
        L = cholesky_banded(lower, lower=True)
    except np.linalg.LinAlgError:  # both sigmas next to nothing beside the coefficients: other flags say so
        return np.full(n - m, np.nan)
    z = solve_banded((m, 0), L, w)
    known = np.convolve((~there).astype(float), np.ones(m + 1), "valid") == 0.0
    return np.where(known, z, np.nan)


def whiteness(z: list[Array], fitted: int, lags: int = 20) -> float:
    """Probability of autocorrelations like those of innovations z, were they white (Ljung and Box).

    fitted: parameters that were fitted to them, taken off the degrees of freedom.  Strips are taken together.
    """
    count = sum(int(np.count_nonzero(np.isfinite(v))) for v in z)
    lags = max(min(lags, count // 5), fitted + 2)
    square = sum(float(np.nansum(v**2)) for v in z) / max(count, 1)
    total = 0.0
    for h in range(1, lags + 1):
        products = np.concatenate([v[h:] * v[:-h] for v in z if len(v) > h] or [np.zeros(0)])
        pairs = np.count_nonzero(np.isfinite(products))
        if pairs:
            total += (float(np.nansum(products)) / (square * pairs)) ** 2 * pairs
    return float(chi2.sf(total, max(lags - fitted, 1)))


def two_hills(modes: list[Mode], d: int) -> bool:
    """Whether a second mode lies within reach that says something else of the noise or of the filter."""
    said = [(m.value, *_said(m.theta, d)) for m in modes]
    return any(
        v - said[0][0] < SECOND_HILL
        and max(abs(sn / said[0][1] - 1.0), abs(gain / said[0][2] - 1.0)) > HILLS_DIFFER
        for v, sn, gain in said[1:]
    )


def _said(theta: Array, d: int) -> tuple[float, float]:
    process = process_of(theta, d)
    return process.sigma_n, process.filtered(0, 1024)[0]


def flags(found: Diagnostics, hills: bool) -> tuple[str, ...]:
    """Names of what is wrong, in a fixed order; empty: nothing found."""
    raised = {
        "sigma_n_unidentified": found.spread_n > SPREAD_N or found.ratio_low < RATIO_N,
        "sigma_e_unidentified": found.spread_e > SPREAD_E or found.limit_e > LIMIT_E,
        "pile_up": found.piled_up > PILED_UP[1],
        "root_near_one": found.root > ROOT,
        "multimodal": hills,
        "not_white": found.whiteness < NOT_WHITE,
        "quantised": found.repeated > REPEATED,
    }
    return tuple(name for name, is_so in raised.items() if is_so)
