"""Where the water of an elevation model runs: filled basins, flow accumulation, channels as smooth lines."""

from __future__ import annotations

import heapq

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

Array = NDArray[np.float64]
STEPS = np.array([(-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1)])


def flow_order(height: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Priority flood from the rim.  height: (rows, cols).

    Returns cells in the order in which water reaches them from outside (flat indices), and for each cell the one
    it drains to (-1 on the rim).
    """
    rows, cols = height.shape
    z = height.ravel().tolist()
    target = np.full(rows * cols, -1, np.int64)
    seen = np.zeros(rows * cols, bool)
    rim = np.ones((rows, cols), bool)
    rim[1:-1, 1:-1] = False
    heap = [(z[i], int(i)) for i in np.flatnonzero(rim)]
    seen[rim.ravel()] = True
    heapq.heapify(heap)
    order = []
    while heap:
        level, cell = heapq.heappop(heap)
        order.append(cell)
        row, col = divmod(cell, cols)
        for down, right in STEPS:
            r, c = row + int(down), col + int(right)
            other = r * cols + c
            if 0 <= r < rows and 0 <= c < cols and not seen[other]:
                seen[other] = True
                target[other] = cell
                heapq.heappush(heap, (max(level, z[other]), other))
    return np.array(order), target


@njit(cache=True)
def accumulate(order: NDArray[np.int64], target: NDArray[np.int64]) -> Array:  # pragma: no cover - compiled
    """Number of cells that drain through each one."""
    area = np.ones(len(target))
    for k in range(len(order) - 1, -1, -1):
        if target[order[k]] >= 0:
            area[target[order[k]]] += area[order[k]]
    return area


def channels(
    order: NDArray[np.int64], target: NDArray[np.int64], area: Array, cols: int, least: float
) -> list[tuple[Array, Array]]:
    """Channels from their source, or the junction with a larger one, down.

    least: cells that make a channel.  Returns (points (n, 2) as row and column, area (n,)) of each, smoothed.
    """
    found, taken = [], np.zeros(len(target), bool)
    is_channel = area >= least
    fed = np.zeros(len(target), bool)
    fed[target[is_channel & (target >= 0)]] = True
    heads = np.flatnonzero(is_channel & ~fed)
    reach = np.zeros(len(target))
    for cell in order:
        reach[cell] = reach[target[cell]] + 1.0 if target[cell] >= 0 else 0.0
    for head in heads[np.argsort(-reach[heads], kind="stable")]:
        cell, path = int(head), []
        while cell >= 0:
            path.append(cell)
            if taken[cell]:
                break
            taken[cell] = True
            cell = int(target[cell])
        points = np.column_stack(np.divmod(np.array(path), cols)).astype(float)
        if len(points) > 4:
            ends = points[[0, -1]].copy()
            points = ndimage.gaussian_filter1d(points, 1.6, axis=0, mode="nearest")
            points[[0, -1]] = ends
        found.append((points, area[path]))
    return found
