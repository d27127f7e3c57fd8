"""What is assumed of the parameters before the data: as little as keeps short strips from degenerating."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from aerosim.errors import InputError
from aerosim.frames import Array

# walls, quadratic outside: logs of variances relative to that of the differenced observations, atanh of r
LOWEST_E, LOWEST_N, HIGHEST, STEEPEST, WALL = -42.0, -30.0, 8.0, 6.0, 1.0


@dataclass(frozen=True)
class Prior:
    """Density of theta: sn^kn se^ke in the logarithms (1: flat in the sigma), r_1 ~ N(0, first), the others
    r_k ~ N(0, s2/k), all within (-1, 1).

    over: the parameters of which it is a density, which matters to its mode only.  flat: nothing but the
    likelihood; only walls far outside hold it.
    """

    kn: float = 2.0
    ke: float = 0.5
    s2: float = 0.25
    first: float = 1.0
    over: Literal["atanh r", "r"] = "atanh r"
    flat: bool = False

    def __post_init__(self) -> None:
        """Raises InputError unless the numbers make a density."""
        sizes = [self.s2, self.first]
        if not np.isfinite([self.kn, self.ke, *sizes]).all() or min(sizes) <= 0.0 or min(self.kn, self.ke) < 0.0:
            raise InputError("no density", "prior", "kn, ke at least 0, s2, first above 0")

    def deviance(self, thetas: Array, strips: int = 1) -> tuple[Array, Array]:
        """-2 log density of theta (k, p + 2), up to a constant, and its gradient: (k,), (k, p + 2)."""
        p = thetas.shape[1] - 2
        z = thetas[:, :p]
        out = np.clip(thetas, self._low(p), self._high(p))
        out -= thetas
        value, grad = WALL * np.einsum("ij,ij->i", out, out), -2.0 * WALL * out
        if self.flat:
            return value, grad
        r = np.tanh(z)
        k = np.r_[1.0 / self.first, np.arange(2, p + 1) / self.s2][:p]
        value += (r * r) @ k
        grad[:, :p] += 2.0 * r * (1.0 - r * r) * k
        # log cosh z = -log(1 - r^2)/2, the change of variables, without cancellation for large z
        size = np.abs(z)
        if self.over != "r":
            value += 4.0 * (size + np.log1p(np.exp(-2.0 * size)) - np.log(2.0)).sum(axis=1)
            grad[:, :p] += 4.0 * r
        value -= self.ke * thetas[:, p] + self.kn * thetas[:, p + 1]
        grad[:, p] -= self.ke
        grad[:, p + 1] -= self.kn
        return value, grad

    @staticmethod
    def _low(p: int) -> Array:
        return np.array([-STEEPEST] * p + [LOWEST_E, LOWEST_N])

    @staticmethod
    def _high(p: int) -> Array:
        return np.array([STEEPEST] * p + [HIGHEST, HIGHEST])
