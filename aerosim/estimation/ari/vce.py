"""Variance components and the iteration of the 1988 paper, as far as its text tells it.

Filter, estimate the two variances from the residuals and their redundancies (Helmert, Foerstner), fit the
coefficients to the filtered series by least squares, repeat (2.2).  The last step takes the filtered series for
the true one, which is rougher: the iteration has its fixed point where the prediction errors vanish.  It passes
near the truth on its way there, which makes it a good source of starting values.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from aerosim.errors import InputError
from aerosim.estimation.ari.filter import Filtered, filter_series
from aerosim.estimation.ari.process import Process, partial_from_ar
from aerosim.estimation.ari.series import DIGITS
from aerosim.frames import Array

SETTLED = 1e-4  # relative change of both sigmas
GONE = 1e-4
FLOOR = 1e-5  # of the first sigma: below, a component has vanished


@dataclass(frozen=True)
class Iterate:
    """A step of the iteration: the process, and the likelihood of it (first values free, as in the paper)."""

    process: Process
    loglik: float
    redundancy_n: float
    redundancy_e: float


def components(y: list[Array], w: list[Array], process: Process) -> tuple[Process, Iterate, list[Filtered]]:
    """One step of variance component estimation, time domain, coefficients kept.

    y, w: values and weights of each strip (n_i,).  Returns the process with new sigmas, the step itself and what
    was filtered on the way.
    """
    outs = [filter_series(ys, ws, process, start="diffuse") for ys, ws in zip(y, w, strict=True)]
    redundancy_n = sum(float(np.sum(o.redundancy_n)) for o in outs)
    redundancy_e = sum(float(np.sum(o.redundancy_e)) for o in outs)
    square_n = sum(float(np.nansum(o.weights * o.residuals**2)) for o in outs)
    square_e = sum(float(np.sum(o.errors_e**2)) for o in outs)
    step = Iterate(process, sum(o.loglik for o in outs), redundancy_n, redundancy_e)
    new = replace(
        process,
        sigma_n=float(np.sqrt(square_n / max(redundancy_n, 1e-12))),
        sigma_e=float(np.sqrt(square_e / max(redundancy_e, 1e-12))),
    )
    return new, step, outs


def estimate_components(y: list[Array], w: list[Array], process: Process, *, most: int = 200) -> Process:
    """Sigmas of known coefficients: variance components to their fixed point, the maximum of the likelihood.

    A component that vanishes is given back as `GONE` of the other.
    """
    for _ in range(most):
        new, _, _ = components(y, w, process)
        change = abs(np.log(new.sigma_n / process.sigma_n)) + abs(np.log(new.sigma_e / process.sigma_e))
        least = GONE * max(new.sigma_n, new.sigma_e)
        process = replace(new, sigma_n=max(new.sigma_n, least), sigma_e=max(new.sigma_e, least))
        if change < SETTLED or least in (process.sigma_n, process.sigma_e):
            break
    return process


def spectral_components(y: Array, a: Array, d: int, *, most: int = 500) -> Process:
    """Sigmas of known coefficients in the frequency domain (Foerstner 1984), from a series without gaps (n,).

    The periodogram of the differences, tapered by Hann, is shared out between the two spectra; the redundancies
    are the sums of the shares.  Fixed point: the maximum of Whittle's likelihood.
    """
    z, a = np.diff(y, n=d), np.asarray(a, float)
    n = len(z)
    taper = np.hanning(n + 2)[1:-1]
    power: Array = np.abs(np.fft.rfft(taper * (z - (np.mean(z) if d == 0 else 0.0))))[1 : (n + 1) // 2] ** 2
    power /= np.sum(taper**2)
    omega = 2.0 * np.pi * np.arange(1, (n + 1) // 2) / n
    of_e = 1.0 / Process(a, 0, 1.0, 1.0).transfer(omega)
    of_n = np.abs(1.0 - np.exp(-1j * omega)) ** (2 * d)
    n2, e2 = float(np.median(power / of_n)), float(np.median(power / of_e))
    for _ in range(most):
        total = n2 * of_n + e2 * of_e
        share_n, share_e = n2 * of_n / total, e2 * of_e / total
        old = n2, e2
        n2 *= float(np.sum(share_n * power / total) / np.sum(share_n))
        e2 *= float(np.sum(share_e * power / total) / np.sum(share_e))
        if abs(np.log(n2 / old[0])) + abs(np.log(e2 / old[1])) < SETTLED:
            break
    return Process(a, d, float(np.sqrt(n2)), float(np.sqrt(e2)))


def autoregression(series: list[Array], p: int) -> Array:
    """Coefficients a (p,) by least squares on differences taken for true."""
    if p == 0:
        return np.zeros(0)
    rows = np.concatenate([np.lib.stride_tricks.sliding_window_view(u, p + 1) for u in series if len(u) > p])
    # rows are in time order: the last column is predicted by the others, newest first
    solution = np.linalg.lstsq(rows[:, -2::-1], -rows[:, -1], rcond=None)[0]
    return np.asarray(solution)


def iterate(y: list[Array], w: list[Array], p: int, d: int, *, most: int) -> list[Iterate]:
    """The paper's iteration from a start that knows nothing.  Ends when settled, vanished, or after `most`."""
    known = [np.diff(np.where(ws > 0.0, ys, np.nan), n=d) for ys, ws in zip(y, w, strict=True)]
    if not np.any(np.abs(np.nan_to_num(np.concatenate(known))) > DIGITS):
        raise InputError(
            "does not vary but for its outliers and steps", "y", "a noisy series; robust='none' keeps all"
        )
    spread = float(np.sqrt(np.nanmean(np.concatenate(known) ** 2)))
    process = Process(np.zeros(p), d, 0.5 * spread, 0.5 * spread)
    steps: list[Iterate] = []
    for k in range(most):
        try:
            new, step, outs = components(y, w, process)
        except InputError:  # coefficients so explosive that the equations are singular: the run-away's end
            break
        steps.append(step)
        a = autoregression([np.diff(o.x, n=d) for o in outs], p)
        new = replace(new, a=a)
        if not np.all(np.isfinite(a)) or min(new.sigma_n, new.sigma_e) < FLOOR * spread:
            break
        change = abs(np.log(new.sigma_n / process.sigma_n)) + abs(np.log(new.sigma_e / process.sigma_e))
        process = new
        if k > 1 and change < SETTLED:
            break
    # the first one is the start, which knows no coefficients
    return steps[1:] or steps or [Iterate(process, -np.inf, np.nan, np.nan)]


def theta_of(process: Process, limit: float = 0.98) -> Array:
    """Parameters (p + 2,) of a process, its partial autocorrelations cut to +-limit."""
    r = partial_from_ar(process.a, limit)
    theta: Array = np.r_[np.arctanh(r), 2.0 * np.log(process.sigma_e), 2.0 * np.log(process.sigma_n)]
    return theta
