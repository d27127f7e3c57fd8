"""Linear Gauss processes, sampled exactly."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy.linalg import expm, solve_continuous_lyapunov

from aerosim.frames import Array


class GaussProcess:
    """x' = A x + B white, y = C x, sampled at dt without any error of discretisation (Van Loan 1978).

    A: (n, n), 1/s.  B: (n, m), per root second.  C: (k, n).  It starts in its stationary distribution.
    """

    def __init__(self, a: ArrayLike, b: ArrayLike, c: ArrayLike, dt: float, rng: np.random.Generator) -> None:
        """Raises ValueError for a system that is not stable."""
        a, b = np.asarray(a, float), np.asarray(b, float)
        if np.linalg.eigvals(a).real.max() >= 0.0:
            raise ValueError("the process is not stable")
        n = len(a)
        power = b @ b.T
        self._phi, noise = _transition(a, power, dt)
        self._root = _root(noise)
        self._c = np.ascontiguousarray(c, float)
        self._rng = rng
        self.covariance: Array = solve_continuous_lyapunov(a, -power)
        self._x = _root(self.covariance) @ rng.standard_normal(n)

    @property
    def output_covariance(self) -> Array:
        """Covariance of y, (k, k), in its stationary state."""
        found: Array = self._c @ self.covariance @ self._c.T
        return found

    def draw(self, steps: int) -> Array:
        """The next values of y, (steps, k); the first call starts at time 0."""
        noise = self._rng.standard_normal((steps, len(self._x)))
        return _run(self._phi, self._root, self._c, self._x, noise)


def _transition(a: Array, power: Array, dt: float) -> tuple[Array, Array]:
    """Transition matrix over dt and covariance of the noise that comes in meanwhile."""
    n = len(a)
    # Van Loan's matrix holds exp(-A t), which overflows for a fast state and a long step: take a short step there,
    # then double it
    doublings = max(0, int(np.ceil(np.log2(np.abs(a).max() * dt))))
    joint = expm(np.block([[-a, power], [np.zeros((n, n)), a.T]]) * (dt / 2**doublings))
    phi = np.ascontiguousarray(joint[n:, n:].T)
    noise = phi @ joint[:n, n:]
    for _ in range(doublings):
        noise = noise + phi @ noise @ phi.T
        phi = phi @ phi
    return phi, noise


def _root(covariance: Array) -> Array:
    """A square root of a covariance that may be singular to rounding."""
    values, vectors = np.linalg.eigh((covariance + covariance.T) / 2.0)
    return np.ascontiguousarray(vectors * np.sqrt(np.maximum(values, 0.0)))


@njit(cache=True)
def _run(phi: Array, root: Array, c: Array, x: Array, noise: Array) -> Array:  # pragma: no cover - compiled
    steps, n = noise.shape
    y = np.zeros((steps, c.shape[0]))
    old = np.empty(n)
    for k in range(steps):
        for i in range(c.shape[0]):
            for j in range(n):
                y[k, i] += c[i, j] * x[j]
        old[:] = x
        for i in range(n):
            x[i] = 0.0
            for j in range(n):
                x[i] += phi[i, j] * old[j] + root[i, j] * noise[k, j]
    return y
