"""Penalised splines: the smoothest curve that observations of differing quality allow, solved as a banded system.

Quintic B-splines on even knots, third differences of the coefficients penalised (Eilers & Marx 1996), so that
the curve, its velocity and acceleration are smooth, and a gap is crossed at even acceleration.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.interpolate import BSpline
from scipy.linalg import solveh_banded

from aerosim.frames import Array

DEGREE = 5
ORDER = 3
ROBUST = 3.0  # residuals beyond so many sigma pull the less the larger they are


class Basis:
    """Even knots over a span of time.  first, last: s; step: between knots, s."""

    def __init__(self, first: float, last: float, step: float) -> None:
        parts = max(2 * DEGREE, int(np.ceil((last - first) / step)))
        self.step = (last - first) / parts
        self.knots = first + self.step * np.arange(-DEGREE, parts + DEGREE + 1)
        self.size = parts + DEGREE
        # B-spline coefficients of degree 5 belong to the middles of their supports.
        self.middles = first + self.step * (np.arange(self.size) - (DEGREE - 1) / 2.0)
        self._slope = (
            sparse.diags_array([-1.0, 1.0], offsets=[0, 1], shape=(self.size - 1, self.size)).tocsr() / self.step
        )
        third = np.diff(np.eye(ORDER + 1), n=ORDER, axis=0)[0]
        self._third = sparse.diags_array(
            list(third), offsets=list(range(ORDER + 1)), shape=(self.size - ORDER, self.size)
        )

    def values(self, t: Array) -> Any:
        """Sparse matrix (n, size) that gives the curve at times t."""
        return BSpline.design_matrix(np.clip(t, self.knots[DEGREE], self.knots[-DEGREE - 1]), self.knots, DEGREE)

    def slopes(self, t: Array) -> Any:
        """Sparse matrix (n, size) that gives the curve's derivative at times t."""
        t = np.clip(t, self.knots[DEGREE], self.knots[-DEGREE - 1])
        return BSpline.design_matrix(t, self.knots[1:-1], DEGREE - 1) @ self._slope

    def bends(self, t: Array) -> Any:
        """Sparse matrix (n, size) that gives the curve's second derivative at times t."""
        t = np.clip(t, self.knots[DEGREE], self.knots[-DEGREE - 1])
        second = self._slope[:-1, :-1] @ self._slope
        return BSpline.design_matrix(t, self.knots[2:-2], DEGREE - 2) @ second

    def roughness(self, density: Array) -> Any:
        """Penalty (size, size): the square of the third derivative, over its power density at the middles."""
        weight = 1.0 / (density[: self.size - ORDER] * self.step**5)
        return self._third.T @ sparse.diags_array(weight) @ self._third

    def spline(self, coefficients: Array) -> BSpline:
        """The curve.  coefficients: (size,) or (size, k)."""
        return BSpline(self.knots, coefficients, DEGREE)

    @property
    def thirds(self) -> Array:
        """Times to which the third differences belong, (size - 3,), s."""
        return np.asarray(self.middles[:-ORDER] + 1.5 * self.step)


def solve(
    design: Any, target: Array, sigma: Array, penalty: Any, start: Array, band: int, rounds: int = 3
) -> Array:
    """Coefficients that fit the observations, outliers held back.

    design: sparse (n, m); target, sigma: (n,); penalty: sparse (m, m); start: (m,), first guess; band: half width
    of the normal equations.
    """
    found, weight = start, 1.0 / sigma**2
    for _ in range(rounds):
        normal = (design.T @ sparse.diags_array(weight) @ design + penalty).todia()
        upper = np.zeros((band + 1, len(start)))
        for k in range(band + 1):
            upper[band - k, k:] = normal.diagonal(k)
        # From the last guess on, so that rounding hurts the correction only.
        for _ in range(2):
            rest = design.T @ (weight * (target - design @ found)) - penalty @ found
            found = found + solveh_banded(upper, rest, overwrite_ab=False, check_finite=False)
        off = np.abs(target - design @ found) / sigma
        weight = np.minimum(1.0, (ROBUST / np.maximum(off, 1e-12)) ** 2) / sigma**2
    return found
