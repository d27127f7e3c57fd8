"""An ARI(p, d) process: its coefficients, its start, its spectrum; series drawn from it.

    c(B) = phi(B) (1 - B)^d,    phi(B) = 1 + a_1 B + ... + a_p B^p,    c(B) x_t = e_t,    V(e_t) = sigma_e^2

Lindenberger 1988, equation (1), and 2.1 for the d differences.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.frames import Array


@njit(cache=True, error_model="numpy")
def ar_from_partial(r: Array, a: Array, J: Array) -> None:  # pragma: no cover - compiled
    """Coefficients a (p,) of partial autocorrelations r (p,) by Levinson's recursion, and J = da/dr (p, p)."""
    p = r.shape[0]
    old, old_J = np.zeros(p), np.zeros((p, p))
    J[:] = 0.0
    for k in range(p):
        for i in range(k):
            old[i] = a[i]
            for j in range(k):
                old_J[i, j] = J[i, j]
        for i in range(k):
            a[i] = old[i] + r[k] * old[k - 1 - i]
            for j in range(k):
                J[i, j] = old_J[i, j] + r[k] * old_J[k - 1 - i, j]
            J[i, k] = old[k - 1 - i]
        a[k] = r[k]
        J[k, k] = 1.0


@njit(cache=True, error_model="numpy")
def partial_from_ar(a: Array, limit: float) -> Array:  # pragma: no cover - compiled
    """Partial autocorrelations (p,) of coefficients a (p,), each cut to +-limit: a process that is stationary."""
    p = a.shape[0]
    r, b = np.zeros(p), a.copy()
    for k in range(p - 1, -1, -1):
        r[k] = min(max(b[k], -limit), limit)
        scale = 1.0 - r[k] * r[k]
        new = b.copy()
        for i in range(k):
            new[i] = (b[i] - r[k] * b[k - 1 - i]) / scale
        b = new
    return r


@njit(cache=True, error_model="numpy")
def start_precision(a: Array, G: Array) -> None:  # pragma: no cover - compiled
    """Inverse covariance, times sigma_e^2, of p values in a row of the stationary AR(p): Gohberg and Semencul."""
    p = a.shape[0]
    for i in range(p):
        for j in range(i + 1):
            s = 0.0
            for k in range(j + 1):
                first = (a[i - k - 1] if i > k else 1.0) * (a[j - k - 1] if j > k else 1.0)
                s += first - a[p - i + k - 1] * a[p - j + k - 1]
            G[i, j] = G[j, i] = s


@njit(cache=True, error_model="numpy")
def differences(d: int) -> Array:  # pragma: no cover - compiled
    """Coefficients of (1 - B)^d, (d + 1,)."""
    c = np.zeros(d + 1)
    c[0] = 1.0
    for k in range(1, d + 1):
        for i in range(k, 0, -1):
            c[i] -= c[i - 1]
    return c


@njit(cache=True, error_model="numpy")
def process_coefficients(a: Array, d: int, c: Array) -> None:  # pragma: no cover - compiled
    """Coefficients c (p + d + 1,) of phi(B) (1 - B)^d."""
    p = a.shape[0]
    delta = differences(d)
    c[:] = 0.0
    for i in range(p + 1):
        factor = a[i - 1] if i else 1.0
        for k in range(d + 1):
            c[i + k] += factor * delta[k]


@njit(cache=True, error_model="numpy")
def start_corner(a: Array, d: int, K: Array) -> None:  # pragma: no cover - compiled
    """K (p + d, p + d): differences of the first values start in the stationary law of the AR(p)."""
    p = a.shape[0]
    G = np.zeros((p, p))
    start_precision(a, G)
    delta = differences(d)
    K[:] = 0.0
    for i in range(p):
        for j in range(p):
            for k in range(d + 1):
                for h in range(d + 1):
                    K[i + d - k, j + d - h] += G[i, j] * delta[k] * delta[h]


@dataclass(frozen=True)
class Process:
    """An ARI(p, d) process seen through white noise.

    a: coefficients (p,) of phi, the sign of the paper's equation (1).  d: differences.
    sigma_n, sigma_e: standard deviations of observation noise and prediction error, unit of the series.
    """

    a: Array
    d: int
    sigma_n: float
    sigma_e: float

    @property
    def p(self) -> int:
        """Order of the autoregressive part."""
        return len(self.a)

    @property
    def c(self) -> Array:
        """Coefficients of phi(B) (1 - B)^d, (p + d + 1,)."""
        c = np.zeros(self.p + self.d + 1)
        process_coefficients(self.a, self.d, c)
        return c

    @property
    def corner(self) -> Array:
        """K of the normal equations, (p + d, p + d)."""
        K = np.zeros((self.p + self.d, self.p + self.d))
        start_corner(self.a, self.d, K)
        return K

    @property
    def roots(self) -> Array:
        """Moduli of the roots of the autoregressive part, largest first, (p,); below one: stationary."""
        return np.sort(np.abs(np.roots(np.r_[1.0, self.a])))[::-1]

    def transfer(self, omega: ArrayLike) -> Array:
        """|c(exp(-i omega))|^2.  omega: rad per epoch, any shape."""
        z = np.exp(-1j * np.asarray(omega, float))
        return np.asarray(np.abs(np.polynomial.polynomial.polyval(z, self.c)) ** 2)

    def filtered(self, lags: int, points: int = 1 << 14) -> tuple[float, Array]:
        """Standard deviation and correlations r(0 ... lags) of the error far from the ends.

        Closed form: the error's spectrum is sn^2/(1 + (sn/se)^2 |c|^2).  points: frequencies of the mean over it.
        """
        omega = (np.arange(points) + 0.5) * np.pi / points
        spectrum = self.sigma_n**2 / (1.0 + (self.sigma_n / self.sigma_e) ** 2 * self.transfer(omega))
        cov = np.array([np.mean(spectrum * np.cos(h * omega)) for h in range(lags + 1)])
        return float(np.sqrt(cov[0])), cov / cov[0]


def checked_process(a: ArrayLike, d: int, sigma_n: float, sigma_e: float) -> Process:
    """The process, its arguments checked.  Raises InputError: not finite, sigmas not positive, not stationary."""
    coefficients = np.atleast_1d(np.asarray(a, float)).ravel()
    if not np.all(np.isfinite(coefficients)):
        raise InputError("coefficients are not finite", "a")
    if d not in (0, 1, 2, 3):
        raise InputError(f"{d} differences", "d", "0, 1, 2 or 3")
    for key, value in (("sigma_n", sigma_n), ("sigma_e", sigma_e)):
        if not (np.isfinite(value) and value > 0.0):
            raise InputError(f"{value} is no standard deviation", key, "a positive number")
    process = Process(coefficients, d, float(sigma_n), float(sigma_e))
    if process.p and process.roots[0] >= 1.0:
        raise InputError(f"not stationary: a root of modulus {process.roots[0]:.4g}", "a", "all moduli below 1")
    return process


def simulate_ari(
    n: int, a: ArrayLike, d: int, sigma_n: float, sigma_e: float, *, rng: np.random.Generator
) -> tuple[Array, Array]:
    """A series of n epochs: truth x and observations y = x + noise, both (n,), unit of the sigmas.

    The differences start in the stationary law of the AR(p), the values themselves at zero.  rng: the generator.
    Raises InputError as `checked_process` does.
    """
    process = checked_process(a, d, sigma_n, sigma_e)
    p = process.p
    values = rng.normal(0.0, process.sigma_e, n)
    if p:
        from scipy.signal import lfilter, lfiltic

        G = np.zeros((p, p))
        start_precision(process.a, G)
        first = np.linalg.solve(np.linalg.cholesky(G).T, rng.normal(0.0, process.sigma_e, p))
        phi = np.r_[1.0, process.a]
        values, _ = lfilter([1.0], phi, values, zi=lfiltic([1.0], phi, first[::-1]))
    for _ in range(d):
        values = np.r_[0.0, np.cumsum(values)[:-1]]
    return values, values + rng.normal(0.0, process.sigma_n, n)
