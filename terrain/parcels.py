"""Parcels: land split into fields or forest stands of random size, each district with its own direction."""

from __future__ import annotations

import numpy as np
from noise import Field, band
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Labels = NDArray[np.int32]


def split(shape: tuple[int, int], pixel: float, district: float, sizes: tuple[float, float], seed: int) -> Labels:
    """Number of the parcel at each pixel.

    district: mean distance of districts, m.  sizes: shortest and longest side of a parcel, m.
    """
    rng = np.random.default_rng(seed)
    rows, cols = shape
    bend = [band(shape, pixel, 250.0, 1500.0, seed + 1 + k) * 9.0 for k in range(2)]
    north = np.arange(rows, dtype=np.float32)[:, None] * pixel + bend[0]
    east = np.arange(cols, dtype=np.float32)[None, :] * pixel + bend[1]
    count = int(rows * cols * pixel**2 / district**2) + 1
    seeds = rng.uniform(
        (-0.1 * rows * pixel, -0.1 * cols * pixel), (1.1 * rows * pixel, 1.1 * cols * pixel), (count, 2)
    )
    nearest = cKDTree(seeds).query(np.stack([north.ravel(), east.ravel()], axis=-1), workers=2)[1].reshape(shape)
    labels = np.zeros(shape, np.int32)
    first = 1
    order = np.argsort(nearest.ravel(), kind="stable")
    ends = np.searchsorted(nearest.ravel()[order], np.arange(count + 1))
    for k in range(count):
        inside = order[ends[k] : ends[k + 1]]
        if len(inside):
            angle = rng.uniform(0.0, np.pi)
            n, e = north.ravel()[inside] - seeds[k, 0], east.ravel()[inside] - seeds[k, 1]
            u, v = np.cos(angle) * e + np.sin(angle) * n, np.cos(angle) * n - np.sin(angle) * e
            leaf, used = _leaves(u, v, sizes, rng)
            labels.ravel()[inside] = first + leaf
            first += used
    return labels


def _leaves(u: Field, v: Field, sizes: tuple[float, float], rng: np.random.Generator) -> tuple[Labels, int]:
    """Splits a district at random until its rectangles are small enough."""
    u0, v0 = float(u.min()), float(v.min())
    cell = 2.5
    grid = np.zeros((int((u.max() - u0) / cell) + 2, int((v.max() - v0) / cell) + 2), np.int32)
    stack, used = [(0, grid.shape[0], 0, grid.shape[1])], 0
    while stack:
        a, b, c, d = stack.pop()
        longest = max(b - a, d - c) * cell
        if longest > rng.uniform(*sizes) and longest > 2.0 * sizes[0]:
            part = rng.uniform(0.33, 0.67)
            if b - a > d - c:
                m = int(a + part * (b - a))
                stack += [(a, m, c, d), (m, b, c, d)]
            else:
                m = int(c + part * (d - c))
                stack += [(a, b, c, m), (a, b, m, d)]
        else:
            grid[a:b, c:d] = used
            used += 1
    return grid[((u - u0) / cell).astype(int), ((v - v0) / cell).astype(int)], used


def edges(labels: Labels) -> NDArray[np.bool_]:
    """Pixels whose right or lower neighbour belongs to another parcel."""
    found = np.zeros(labels.shape, bool)
    found[:, :-1] |= labels[:, 1:] != labels[:, :-1]
    found[:-1] |= labels[1:] != labels[:-1]
    return found


def values(labels: Labels, seed: int) -> NDArray[np.float32]:
    """One uniform random number of each parcel, at its pixels."""
    rng = np.random.default_rng(seed)
    return rng.random(int(labels.max()) + 1, dtype=np.float32)[labels]
