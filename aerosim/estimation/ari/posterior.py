"""Averaging over what the parameters may be: an ensemble of chains, begun in the modes.

Moves: differences of other walkers (ter Braak 2006), in two halves so that each is reversible; every few steps a
draw from Student mixtures around the modes, which lets walkers change hills with the right frequency.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln, logsumexp

from aerosim.errors import InputError
from aerosim.estimation.ari.band import SAME, factor, selected_inverse, smooth
from aerosim.estimation.ari.filter import NOTHING
from aerosim.estimation.ari.modes import Mode
from aerosim.estimation.ari.process import ar_from_partial, process_coefficients, start_corner
from aerosim.frames import Array

FREEDOM = 5.0  # of the Student densities: heavier tails than the hills they cover
FLATTEST = 0.15  # least curvature that is believed of a mode
JUMP_EVERY = 4


@dataclass(frozen=True)
class Samples:
    """Draws of theta (n, q) from the posterior density, in no order.

    values: -2 log density (n,).  acceptance: share of moves taken.  size: effective number of independent draws,
    of the worst parameter.
    """

    thetas: Array
    values: Array
    acceptance: float
    size: float


class Mixture:
    """Student densities around modes, weighed by the mass that each hill should have."""

    def __init__(self, modes: list[Mode]) -> None:
        self.centres = np.array([m.theta for m in modes])
        self.roots, log_det = [], []
        for mode in modes:
            values, vectors = np.linalg.eigh(mode.precision)
            values = np.maximum(values, FLATTEST)
            self.roots.append(vectors / np.sqrt(values))
            log_det.append(-0.5 * np.sum(np.log(values)))
        self.inverse = [np.linalg.inv(root) for root in self.roots]
        self.log_det = np.array(log_det)
        mass = -0.5 * np.array([m.value for m in modes]) + self.log_det
        # no hill is left out altogether: its Laplace mass is a guess
        share = 0.9 * np.exp(mass - logsumexp(mass)) + 0.1 / len(modes)
        self.share = share / share.sum()

    def draw(self, n: int, rng: np.random.Generator) -> Array:
        """n draws, (n, q)."""
        q = self.centres.shape[1]
        which = rng.choice(len(self.share), n, p=self.share)
        normal = rng.normal(size=(n, q)) / np.sqrt(rng.chisquare(FREEDOM, n) / FREEDOM)[:, None]
        return np.asarray(self.centres[which] + np.einsum("nij,nj->ni", np.array(self.roots)[which], normal))

    def log_density(self, thetas: Array) -> Array:
        """Logarithm of the density of thetas (n, q), up to a constant, (n,)."""
        q = self.centres.shape[1]
        parts = []
        for centre, inverse, log_det, share in zip(
            self.centres, self.inverse, self.log_det, self.share, strict=True
        ):
            square = np.sum(((thetas - centre) @ inverse.T) ** 2, axis=1)
            parts.append(np.log(share) - log_det - 0.5 * (FREEDOM + q) * np.log1p(square / FREEDOM))
        constant = gammaln(0.5 * (FREEDOM + q)) - gammaln(0.5 * FREEDOM)
        return np.asarray(logsumexp(np.array(parts), axis=0) + constant)


def sample(
    value_of: Callable[[Array], Array],
    modes: list[Mode],
    rng: np.random.Generator,
    *,
    walkers: int = 36,
    steps: int = 100,
    burn: int = 28,
    tries: int = 240,
) -> Samples:
    """Draws from exp(-value/2).  value_of: -2 log density (k,) of thetas (k, q), infinite where there is none.

    Raises InputError if no draw around the modes has a density.
    """
    mixture = Mixture(modes)
    first = mixture.draw(tries, rng)
    values = value_of(first)
    log_weight = -0.5 * values - mixture.log_density(first)
    log_weight[~np.isfinite(log_weight)] = -np.inf
    if not np.isfinite(log_weight.max()):
        raise InputError("no process of this order explains it", "y", "another order; robust='none'")
    weight = np.exp(log_weight - log_weight.max())
    # with replacement, but no draw may found the whole ensemble
    weight = np.minimum(weight, max(np.sort(weight)[-walkers // 4], 1e-12))
    chosen = rng.choice(tries, walkers, p=weight / weight.sum())
    theta, value = first[chosen], values[chosen]
    q, half = theta.shape[1], walkers // 2
    kept, kept_values, accepted = [], [], 0
    for k in range(steps):
        for side in (slice(0, half), slice(half, walkers)):
            other = theta[half:] if side.start == 0 else theta[:half]
            n = side.stop - side.start
            log_ratio = np.zeros(n)
            if k % JUMP_EVERY == JUMP_EVERY - 1:
                proposed = mixture.draw(n, rng)
                log_ratio = mixture.log_density(theta[side]) - mixture.log_density(proposed)
            else:
                one = rng.integers(0, len(other), n)
                two = (one + rng.integers(1, len(other), n)) % len(other)
                scale = 2.38 / np.sqrt(2.0 * q) * rng.choice([1.0, 0.5, 0.2], n, p=[0.6, 0.3, 0.1])
                proposed = theta[side] + scale[:, None] * (other[one] - other[two])
                proposed += 1e-4 * rng.normal(size=(n, q))
            new = value_of(proposed)
            take = np.log(rng.uniform(size=n)) < 0.5 * (value[side] - new) + log_ratio
            theta[side][take], value[side][take] = proposed[take], new[take]
            accepted += int(take.sum())
        if k >= burn:
            kept.append(theta.copy())
            kept_values.append(value.copy())
    chains = np.array(kept)
    return Samples(
        chains.reshape(-1, q), np.concatenate(kept_values), accepted / (steps * walkers), effective_size(chains)
    )


def effective_size(chains: Array) -> float:
    """Number of independent draws that chains (steps, walkers, q) are worth, of the worst parameter.

    Autocorrelations averaged over the walkers, summed up to the first below 0.05 (Geyer's truncation, simplified).
    """
    n = len(chains)
    centred = chains - chains.mean(axis=(0, 1))
    variance = np.mean(centred**2, axis=(0, 1)) + 1e-300
    time = np.ones(chains.shape[2])
    going = np.ones(chains.shape[2], bool)
    for lag in range(1, n // 2):
        rho = np.mean(centred[lag:] * centred[:-lag], axis=(0, 1)) / variance
        going &= rho > 0.05
        if not going.any():
            break
        time[going] += 2.0 * rho[going]
    return float(chains.shape[0] * chains.shape[1] / time.max())


@dataclass(frozen=True)
class Averaged:
    """Mean of x (n,) over draws, covariance band (n, width + 1) with the spread of x over the draws in it.

    within: the mean of the covariances alone.
    """

    x: Array
    cov_band: Array
    within: Array


def average(thetas: Array, y: Array, w: Array, d: int, width: int) -> Averaged:
    """Smooth one strip with each of thetas (k, p + 2); mean and law of total covariance.  y, w: (n,)."""
    p, n = thetas.shape[1] - 2, len(y)
    m = p + d
    width = max(width, m)
    L, Z, x = np.zeros((n, m + 1)), np.zeros((n, width + 1)), np.zeros(n)
    a, J, c, corner = np.zeros(p), np.zeros((p, p)), np.zeros(m + 1), np.zeros((m, m))
    xs, within = np.zeros((len(thetas), n)), np.zeros((n, width + 1))
    for k, theta in enumerate(thetas):
        ar_from_partial(np.tanh(theta[:p]), a, J)
        process_coefficients(a, d, c)
        start_corner(a, d, corner)
        inv_e, inv_n = np.exp(-theta[p]), np.exp(-theta[p + 1])
        factor(L, w, c, inv_n, inv_e, corner, NOTHING, SAME)
        smooth(L, x, y, w, c, inv_n, inv_e, corner, NOTHING, True)
        selected_inverse(L, Z)
        xs[k] = x
        within += Z
    within /= len(thetas)
    mean = xs.mean(axis=0)
    off = xs - mean
    band = within.copy()
    for h in range(min(width, n - 1) + 1):
        band[: n - h, h] += np.mean(off[:, : n - h] * off[:, h:], axis=0)
    return Averaged(mean, band, within)
