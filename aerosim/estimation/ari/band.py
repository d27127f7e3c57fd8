"""Banded normal equations of an ARI process and its observations: build, Cholesky, solve, selected inverse.

All compiled, O(N m^2) at most.  Where weights do not change, the rows of the factor converge within some
correlation lengths; from there on they are copied, and a point costs O(m).

    H = W/sn^2 + A'UA/se^2 + K/se^2,    (A x)_t = sum_k c_k x_{t-k},    m = p + d

Storage: row t of a lower band holds H[t, t - k] in column k; row t of a covariance band holds Z[t, t + k].
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from aerosim.frames import Array

SAME = 4e-15  # some units of the last place: rows that differ by less count as converged


@njit(cache=True, error_model="numpy")
def factor(  # noqa: PLR0912
    L: Array, w: Array, c: Array, inv_n: float, inv_e: float, corner: Array, u: Array, tol: float
) -> float:  # pragma: no cover - compiled
    """Cholesky factor of H, written into L (N, m + 1).  Returns log |H|, NaN if H is not positive definite.

    w: weights of the observations (N,).  c: coefficients (m + 1,).  inv_n, inv_e: 1/sn^2, 1/se^2.
    corner: K (m, m).  u: weights of the equations (N - m,), or empty for all one.  tol: rows that differ by less,
    relatively, count as converged.
    """
    n, m = L.shape[0], c.shape[0] - 1
    uniform = u.shape[0] == 0
    full = np.zeros(m + 1)
    for k in range(m + 1):
        for i in range(m + 1 - k):
            full[k] += c[i] * c[i + k]
        full[k] *= inv_e
    log_det, log_row, run = 0.0, 0.0, 0
    inv = np.zeros(n)
    for t in range(n):
        inner = uniform and m <= t < n - m
        if inner and run > m and w[t] == w[t - 1]:
            for k in range(m + 1):
                L[t, k] = L[t - 1, k]
            inv[t] = inv[t - 1]
            log_det += log_row
            continue
        for k in range(min(m, t), -1, -1):
            j = t - k
            if inner:
                s = full[k]
            else:
                s = 0.0
                for i in range(max(m - t, 0), min(m - k, n - 1 - t) + 1):
                    s += c[i] * c[i + k] * (1.0 if uniform else u[t + i - m])
                if t < m:
                    s += corner[t, j]
                s *= inv_e
            if k == 0:
                s += w[t] * inv_n
            for i in range(1, min(m - k, j) + 1):
                s -= L[t, k + i] * L[j, i]
            if k > 0:
                L[t, k] = s * inv[j]
            elif s > 0.0:
                L[t, 0] = math.sqrt(s)
                inv[t] = 1.0 / L[t, 0]
            else:
                return math.nan
        log_row = 2.0 * math.log(L[t, 0])
        log_det += log_row
        if t > m and w[t] == w[t - 1]:
            change = 0.0
            for k in range(m + 1):
                change = max(change, abs(L[t, k] - L[t - 1, k]))
            run = run + 1 if change <= tol * L[t, 0] else 0
        else:
            run = 0
    return log_det


@njit(cache=True, error_model="numpy")
def solve(L: Array, x: Array) -> None:  # pragma: no cover - compiled
    """Solve L L' x = b in place.  x: (N,), b on entry."""
    # the newest term last, no division on the way: what waits for the value before is short
    n, m = L.shape[0], L.shape[1] - 1
    for t in range(n):
        s = x[t]
        for k in range(min(m, t), 0, -1):
            s -= L[t, k] * x[t - k]
        x[t] = s * (1.0 / L[t, 0])
    for t in range(n - 1, -1, -1):
        s = x[t]
        for k in range(min(m, n - 1 - t), 0, -1):
            s -= L[t + k, k] * x[t + k]
        x[t] = s * (1.0 / L[t, 0])


@njit(cache=True, error_model="numpy")
def selected_inverse(L: Array, Z: Array) -> None:  # noqa: PLR0912  # pragma: no cover - compiled
    """Band of H^-1 out of the factor (Takahashi), written into Z (N, width + 1), width at least m.

    Z[t, k] = (H^-1)[t, t + k]; beyond the end zero.
    """
    n, m = L.shape[0], L.shape[1] - 1
    width = Z.shape[1] - 1
    run = 0
    for j in range(n - 1, -1, -1):
        reach = min(m, n - 1 - j)
        same = j + m + 1 < n
        if same:
            for k in range(m + 1):
                if L[j + k, k] != L[j + 1 + k, k]:
                    same = False
                    break
        if same and run > width:
            for k in range(width + 1):
                Z[j, k] = Z[j + 1, k]
            continue
        inv = 1.0 / L[j, 0]
        for h in range(width, 0, -1):
            i = j + h
            if i >= n:
                Z[j, h] = 0.0
                continue
            s = 0.0
            for k in range(1, reach + 1):
                s += (Z[j + k, h - k] if k <= h else Z[i, k - h]) * L[j + k, k]
            Z[j, h] = -s * inv
        s = inv
        for k in range(1, reach + 1):
            s -= Z[j, k] * L[j + k, k]
        Z[j, 0] = s * inv
        if same:
            change = 0.0
            for k in range(width + 1):
                change = max(change, abs(Z[j, k] - Z[j + 1, k]))
            run = run + 1 if change <= SAME * Z[j, 0] else 0
        else:
            run = 0


@njit(cache=True, error_model="numpy")
def smooth(
    L: Array,
    x: Array,
    y: Array,
    w: Array,
    c: Array,
    inv_n: float,
    inv_e: float,
    corner: Array,
    u: Array,
    refine: bool,
) -> None:  # pragma: no cover - compiled
    """Solve H x = W y/sn^2 with the factor L.  x: (N,), written.  The others as in `factor`.

    refine: one step of iterative refinement; long integrated series lose digits without.
    """  # fmt: skip
    n, m = L.shape[0], L.shape[1] - 1
    for t in range(n):
        x[t] = w[t] * y[t] * inv_n
    solve(L, x)
    if not refine:
        return
    r = np.zeros(n)
    for t in range(n):
        r[t] = w[t] * (y[t] - x[t]) * inv_n
    for t in range(m, n):
        e = 0.0
        for k in range(m + 1):
            e += c[k] * x[t - k]
        e *= inv_e * (u[t - m] if u.shape[0] else 1.0)
        for k in range(m + 1):
            r[t - k] -= c[k] * e
    for i in range(m):
        for j in range(m):
            r[i] -= corner[i, j] * x[j] * inv_e
    solve(L, r)
    for t in range(n):
        x[t] += r[t]


@njit(cache=True, error_model="numpy")
def equation_variances(Z: Array, c: Array, out: Array) -> None:  # pragma: no cover - compiled
    """Variances c' Z c of the values in each equation, written into out (N - m,), from the band Z."""
    m = c.shape[0] - 1
    for t in range(out.shape[0]):
        s = 0.0
        for i in range(m + 1):
            s += c[m - i] * c[m - i] * Z[t + i, 0]
            for k in range(1, m - i + 1):
                s += 2.0 * c[m - i] * c[m - i - k] * Z[t + i, k]
        out[t] = s
