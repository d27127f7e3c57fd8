"""Least squares of the calibration: rows of two, errors shared by lines and by control points, a prior."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.frames import Array

# Variance factors tried: of what rows of a line do not share, and of what they share.
OWN_FACTORS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.45, 0.65, 1.0, 1.5)
SHARED_FACTORS = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.15, 1.3, 1.6, 2.0, 3.0)
# Their sum is believed to be 1 as if so many lines had said so.
BELIEF = 4.0


class Equations(NamedTuple):
    """Linear equations of n rows, 2 numbers each, px.

    misfit: (n, 2) measured less predicted.  design: (n, 2, k) by the parameters, rad.  shared: (n, 2, 6) by errors
    of the navigation of 1 sigma; own: (n, 2, m) by errors of the gimbal; of_point: (n, 2, 3) by errors of the
    control point; pixel: sigma of the measured pixel.
    """

    misfit: Array
    design: Array
    shared: Array
    own: Array
    of_point: Array
    pixel: float


class Fit(NamedTuple):
    """values, covariance: of the parameters, prior included; information: of the rows alone, prior excluded,
    errors of lines and points taken out.  distance: (n,) squared, whitened, of each row after the fit.
    evidence: -2 log of the rows' probability, but for a constant."""

    values: Array
    covariance: Array
    information: Array
    distance: Array
    evidence: float


class _White(NamedTuple):
    """Rows whitened: misfit (n, 2), columns (n, 2, q) of parameters and shared points, line errors (n, 2, 6),
    roots of the weights (n,), and log of the determinants of what was whitened."""

    misfit: Array
    columns: Array
    lines: Array
    root: Array
    log_det: float


class _Sums(NamedTuple):
    """Normal matrix and right side of the columns, square of the misfit; of each line (l, 6, ...) its errors with
    themselves, with the columns and with the misfit."""

    normal: Array
    right: Array
    square: float
    own: Array
    cross: Array
    toward: Array


def adjust(
    eq: Equations,
    at: Array,
    prior: Array,
    point: NDArray[np.int64],
    lines: NDArray[np.int64] | None,
    factors: tuple[float, float],
    weight: Array,
) -> Fit:
    """One step of Gauss-Newton.  at: (k,) where the equations were made; prior: (k,) sigmas about zero.

    point, lines: (n,) number of each row's control point and line; factors: variance of the navigation that
    rows of a line share, and that they do not, over sigma squared; weight: (n,) of rows, 0 to 1.
    """
    white = _whiten(eq, at, factors[1], point, weight)
    fit, errors = _fit(_sums(white, lines), white.log_det, prior, factors[0])
    left = white.misfit - (white.columns @ errors[0])
    if lines is not None:
        left -= (white.lines @ errors[1][lines][..., None])[..., 0]
    return fit._replace(distance=(left**2).sum(axis=1))


def variance_factors(
    eq: Equations, at: Array, prior: Array, point: NDArray[np.int64], lines: NDArray[np.int64], weight: Array
) -> tuple[float, float]:
    """The two factors of `adjust` under which the rows are most probable, with a weak belief that they add to
    1."""
    best = (np.inf, 1.0, 0.0)
    for own in OWN_FACTORS:
        white = _whiten(eq, at, own, point, weight)
        sums = _sums(white, lines)
        for shared in SHARED_FACTORS:
            if shared + own > 0.0:
                fit, _ = _fit(sums, white.log_det, prior, shared)
                belief = BELIEF * (np.log(shared + own) + 1.0 / (shared + own))
                best = min(best, (fit.evidence + belief, shared, own))
    return best[1], best[2]


def _whiten(eq: Equations, at: Array, own_factor: float, point: NDArray[np.int64], weight: Array) -> _White:
    cov = eq.own @ np.swapaxes(eq.own, 1, 2) + own_factor * eq.shared @ np.swapaxes(eq.shared, 1, 2)
    cov[:, [0, 1], [0, 1]] += eq.pixel**2
    number, times = np.unique(point, return_counts=True)
    alone = np.isin(point, number[times == 1])
    cov[alone] += eq.of_point[alone] @ np.swapaxes(eq.of_point[alone], 1, 2)
    # Cholesky's lower factor of 2 x 2
    a = np.sqrt(cov[:, 0, 0])
    b = cov[:, 1, 0] / a
    d = np.sqrt(cov[:, 1, 1] - b * b)

    def white(values: Array) -> Array:
        first = values[:, 0] / a[:, None]
        return np.stack([first, (values[:, 1] - b[:, None] * first) / d[:, None]], axis=1)

    several = number[times > 1]
    columns = np.zeros((len(point), 2, len(at) + 3 * len(several)))
    columns[:, :, : len(at)] = white(eq.design)
    of_point = white(eq.of_point)
    place = np.searchsorted(several, point)
    rows = np.flatnonzero(~alone)
    for k in range(3):
        columns[rows, :, len(at) + 3 * place[rows] + k] = of_point[rows, :, k]
    misfit = np.where(weight[:, None] > 0.0, np.nan_to_num(eq.misfit), eq.misfit) + eq.design @ at
    log_det = 2.0 * float(np.log((a * d)[weight > 0.0]).sum())
    return _White(white(misfit[..., None])[..., 0], columns, white(eq.shared), np.sqrt(weight), log_det)


def _sums(white: _White, lines: NDArray[np.int64] | None) -> _Sums:
    unknowns = white.columns.shape[2]
    used = white.root > 0.0
    root = white.root[used, None]
    rows = (white.columns[used] * root[..., None]).reshape(-1, unknowns)
    seen = (white.misfit[used] * root).ravel()
    count = 0 if lines is None else int(lines.max()) + 1
    own, cross, toward = np.zeros((count, 6, 6)), np.zeros((count, 6, unknowns)), np.zeros((count, 6))
    if lines is not None:
        errors = (white.lines[used] * root[..., None]).reshape(-1, 6)
        twice = np.repeat(lines[used], 2)
        order = np.argsort(twice, kind="stable")
        ends = np.searchsorted(twice[order], np.arange(count + 1))
        for k in range(count):
            these = order[ends[k] : ends[k + 1]]
            mine = errors[these].T
            own[k], cross[k], toward[k] = mine @ mine.T, mine @ rows[these], mine @ seen[these]
    return _Sums(rows.T @ rows, rows.T @ seen, float(seen @ seen), own, cross, toward)


def _fit(sums: _Sums, log_det: float, prior: Array, factor: float) -> tuple[Fit, tuple[Array, Array]]:
    """Solve with the lines' errors eliminated.  Returns the fit without distances; unknowns and lines' errors."""
    count, unknowns = len(prior), len(sums.right)
    normal, right, square = sums.normal.copy(), sums.right.copy(), sums.square
    own = factor * sums.own + np.eye(6)
    solved = np.linalg.solve(own, np.concatenate([sums.cross, sums.toward[..., None]], axis=-1)) * factor
    normal -= np.einsum("lij,lik->jk", sums.cross, solved[..., :-1])
    right -= np.einsum("lij,li->j", sums.cross, solved[..., -1])
    square -= float((sums.toward * solved[..., -1]).sum())
    log_det += float(np.linalg.slogdet(own)[1].sum())
    points = np.arange(count, unknowns)
    normal[points, points] += 1.0
    information = normal[:count, :count].copy()
    if unknowns > count:
        of_points = np.linalg.solve(normal[count:, count:], normal[count:, :count])
        information -= normal[:count, count:] @ of_points
    normal[np.arange(count), np.arange(count)] += prior**-2
    found = np.linalg.solve(normal, right)
    covariance = np.linalg.inv(normal)[:count, :count]
    errors = solved[..., -1] - solved[..., :-1] @ found
    evidence = log_det + float(np.linalg.slogdet(normal)[1]) + square - float(right @ found)
    information = 0.5 * (information + information.T)
    covariance = 0.5 * (covariance + covariance.T)
    fit = Fit(np.asarray(found[:count], float), covariance, information, np.zeros(0), evidence)
    return fit, (np.asarray(found, float), errors)
