"""Exact likelihood of strips that share one ARI process, and its gradient.

    theta = (atanh r_1 ... atanh r_p, log se^2, log sn^2),    r: partial autocorrelations, so always stationary

The first d values of each strip are unknown (flat), the p differences after them start in their stationary law.
The gradient is Fisher's identity: the derivative of the expected complete-data likelihood, from moments of the
smoothed differences and of their posterior covariances, which lie within the band.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numba import njit
from numpy.typing import NDArray

from aerosim.estimation.ari.band import factor, selected_inverse, smooth
from aerosim.estimation.ari.process import (
    ar_from_partial,
    differences,
    process_coefficients,
    start_corner,
    start_precision,
)
from aerosim.frames import Array

Indices = NDArray[np.int64]
LONG = 2000  # epochs from which on the smoother is refined


@njit(cache=True, error_model="numpy")
def unpack(theta: Array, a: Array, J: Array) -> Array:  # pragma: no cover - compiled
    """Coefficients a (p,) of theta (p + 2,), J = da/dr (p, p).  Returns the partial autocorrelations (p,)."""
    r = np.tanh(theta[: theta.shape[0] - 2])
    ar_from_partial(r, a, J)
    return r


@njit(cache=True, error_model="numpy")
def deviances(
    thetas: Array,
    y: Array,
    w: Array,
    starts: Indices,
    d: int,
    L: Array,
    Z: Array,
    x: Array,
    out: Array,
    grads: Array,
    tol: float,
) -> None:  # pragma: no cover - compiled
    """-2 log likelihood of all strips for each row of thetas (k, p + 2), into out (k,); NaN where it has none.

    y, w: values and weights of all strips in a row (N,), weight 0 where missing.  starts: bounds of the strips
    (strips + 1,).  L, Z: (longest strip, m + 1), x: (longest strip,): room to work in.
    grads: (k, p + 2) is written, or (0, 0): not wanted.  tol: as in `factor`.
    """  # fmt: skip
    for k in range(thetas.shape[0]):
        out[k] = _deviance(thetas[k], y, w, starts, d, L, Z, x, grads[k : k + 1], tol)


@njit(cache=True, error_model="numpy")
def _deviance(
    theta: Array,
    y: Array,
    w: Array,
    starts: Indices,
    d: int,
    L: Array,
    Z: Array,
    x: Array,
    grads: Array,
    tol: float,
) -> float:  # pragma: no cover - compiled
    p = theta.shape[0] - 2
    m = p + d
    a, J = np.zeros(p), np.zeros((p, p))
    r = unpack(theta, a, J)
    c, corner, G = np.zeros(m + 1), np.zeros((m, m)), np.zeros((p, p))
    process_coefficients(a, d, c)
    start_corner(a, d, corner)
    start_precision(a, G)
    inv_e, inv_n = math.exp(-theta[p]), math.exp(-theta[p + 1])
    log_start = 0.0
    for k in range(p):
        log_start += (k + 1) * math.log1p(-r[k] * r[k])
    wanted = grads.shape[0] > 0
    S0, M, u = np.zeros((p, p)), np.zeros((p + 1, p + 1)), np.zeros(0)
    total, noise, equations, observed = 0.0, 0.0, 0, 0
    for strip in range(starts.shape[0] - 1):
        ys, ws = y[starts[strip] : starts[strip + 1]], w[starts[strip] : starts[strip + 1]]
        n = ys.shape[0]
        Ls, xs, Zs = L[:n], x[:n], Z[:n]
        log_det = factor(Ls, ws, c, inv_n, inv_e, corner, u, tol)
        if math.isnan(log_det):
            return math.nan
        smooth(Ls, xs, ys, ws, c, inv_n, inv_e, corner, u, n > LONG)
        n_e = n - d
        square_n, square_e = 0.0, _start_square(xs, corner)
        for t in range(n):
            if ws[t] > 0.0:
                observed += 1
                square_n += ws[t] * (ys[t] - xs[t]) ** 2
                total -= math.log(ws[t])
        for t in range(m, n):
            e = 0.0
            for k in range(m + 1):
                e += c[k] * xs[t - k]
            square_e += e * e
        total += log_det - log_start + square_n * inv_n + square_e * inv_e + n_e * theta[p]
        equations += n_e
        if wanted:
            selected_inverse(Ls, Zs)
            noise += square_n
            for t in range(n):
                noise += ws[t] * Zs[t, 0]
            _moments(xs, Zs, p, d, M, S0)
    total += observed * theta[p + 1] + (observed - d * (starts.shape[0] - 1)) * math.log(2.0 * math.pi)
    if wanted:
        _gradient(grads[0], a, J, r, M, S0, G, inv_e, equations, observed, noise * inv_n, starts.shape[0] - 1)
    return float(total)


@njit(cache=True, error_model="numpy")
def _start_square(x: Array, corner: Array) -> float:  # pragma: no cover - compiled
    s = 0.0
    for i in range(corner.shape[0]):
        for j in range(corner.shape[0]):
            s += x[i] * corner[i, j] * x[j]
    return s


@njit(cache=True, error_model="numpy")
def _moments(x: Array, Z: Array, p: int, d: int, M: Array, S0: Array) -> None:  # pragma: no cover - compiled
    """Add E[u_{t-i} u_{t-j} | y], u = (1-B)^d x: over the equations to M (p + 1, p + 1), of the first p to S0."""
    n = x.shape[0]
    delta = differences(d)
    nu = n - d
    u = np.zeros(nu)
    for t in range(nu):
        for k in range(d + 1):
            u[t] += delta[k] * x[t + d - k]
    for h in range(p + 1):
        # all terms of one lag run along a diagonal of M: start and end of the sums differ only
        for t in range(nu - h):
            s = 0.0
            for i in range(d + 1):
                for j in range(d + 1):
                    lag = h + i - j
                    first = t + d - i if lag >= 0 else t + h + d - j
                    s += delta[i] * delta[j] * Z[first, abs(lag)]
            s += u[t] * u[t + h]
            if t + h < p:
                S0[t, t + h] += s
                if h:
                    S0[t + h, t] += s
            # u_{s-j} u_{s-i} with s - j = t, s - i = t + h, p <= s < nu
            for i in range(p - h + 1):
                e = t + h + i
                if p <= e < nu:
                    M[i, i + h] += s
                    if h:
                        M[i + h, i] += s


@njit(cache=True, error_model="numpy")
def _gradient(  # noqa: PLR0912
    grad: Array,
    a: Array,
    J: Array,
    r: Array,
    M: Array,
    S0: Array,
    G: Array,
    inv_e: float,
    equations: int,
    observed: int,
    noise: float,
    strips: int,
) -> None:  # pragma: no cover - compiled
    """-2 dlogL/dtheta of the moments.  noise: E[v'Wv | y]/sn^2."""  # fmt: skip
    p = a.shape[0]
    phi = np.ones(p + 1)
    phi[1:] = a
    by_a = np.zeros(p)
    square = 0.0
    for i in range(p + 1):
        row = 0.0
        for j in range(p + 1):
            row += M[i, j] * phi[j]
        square += phi[i] * row
        if i:
            by_a[i - 1] = 2.0 * row
    for i in range(p):
        for j in range(p):
            square += G[i, j] * S0[i, j]
    # trace of G(a) S0, G = L1 L1' - L2 L2'
    for h in range(1, p + 1):
        for k in range(p):
            if h + k < p:
                for j in range(k, p):
                    by_a[h - 1] += 2.0 * S0[h + k, j] * phi[j - k]
            i = p - h + k
            if i < p:
                for j in range(k, p):
                    by_a[h - 1] -= 2.0 * S0[i, j] * phi[p - j + k]
    for k in range(p):
        s = 0.0
        for i in range(p):
            s += by_a[i] * J[i, k]
        slope = 1.0 - r[k] * r[k]
        grad[k] = s * inv_e * slope + strips * 2.0 * (k + 1) * r[k]
    grad[p] = equations - square * inv_e
    grad[p + 1] = observed - noise


class Strips:
    """Series that share one process, ready for the compiled likelihood."""

    def __init__(self, series: list[Array], weights: list[Array]) -> None:
        """series: values of each strip (n_i,), finite where they count.  weights: (n_i,), 0 = missing."""
        self.starts: Indices = np.cumsum([0, *(len(s) for s in series)])
        self.y = np.where(np.concatenate(weights) > 0.0, np.concatenate(series), 0.0)
        self.w = np.concatenate(weights)
        self.longest = max(len(s) for s in series)
        self._room: dict[int, tuple[Array, Array, Array]] = {}

    @property
    def observed(self) -> int:
        """Number of observations of positive weight."""
        return int(np.count_nonzero(self.w > 0.0))

    def head(self, most: int) -> Strips:
        """The first strips, or what of the first one is not more than `most` epochs."""
        count = max(int(np.searchsorted(self.starts, most, side="right")) - 1, 1)
        bounds = np.minimum(self.starts[: count + 1], max(most, 1))
        parts = [slice(a, b) for a, b in pairwise(bounds)]
        return Strips([self.y[part] for part in parts], [self.w[part] for part in parts])

    def deviance(
        self, thetas: Array, d: int, *, gradient: bool = False, tol: float = 4e-15
    ) -> tuple[Array, Array]:
        """-2 log likelihood (k,) and gradient (k, p + 2), empty unless wanted, of parameters (k, p + 2)."""
        m = thetas.shape[1] - 2 + d
        if m not in self._room:
            shape = (self.longest, m + 1)
            self._room[m] = (np.zeros(shape), np.zeros(shape), np.zeros(self.longest))
        L, Z, x = self._room[m]
        out = np.zeros(len(thetas))
        grads = np.zeros(thetas.shape if gradient else (0, 0))
        deviances(np.ascontiguousarray(thetas), self.y, self.w, self.starts, d, L, Z, x, out, grads, tol)
        return out, grads
