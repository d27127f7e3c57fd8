"""Roads that avoid slopes: least-cost paths between places, as smooth lines."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra

Array = NDArray[np.float64]


def cost_graph(height: Array, cell: float, penalty: Array) -> csr_matrix:
    """Cost of going between neighbours: length, times how steep it is.  cell: m; penalty: (rows, cols) factor."""
    rows, cols = height.shape
    index = np.arange(rows * cols).reshape(rows, cols)
    parts = []
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (2, 1), (1, -2), (2, -1)):
        a = np.s_[: rows - down, max(0, -right) : cols - max(0, right)]
        b = np.s_[down:, max(0, right) : cols + min(0, right)]
        length = cell * np.hypot(down, right)
        slope = np.abs(height[b] - height[a]) / length
        cost = length * (1.0 + (slope / 0.05) ** 2) * (penalty[a] + penalty[b])
        parts.append((index[a].ravel(), index[b].ravel(), cost.ravel()))
    i, j, v = (np.concatenate(p) for p in zip(*parts, strict=True))
    return coo_matrix((v, (i, j)), shape=(rows * cols, rows * cols)).tocsr()


def network(graph: csr_matrix, cols: int, places: NDArray[np.int64], smooth: float) -> list[Array]:
    """Joins places one after the other to what is there.  places: flat indices.

    Returns lines (n, 2), row and column, smoothed over so many cells.
    """
    reached, lines = {int(places[0])}, []
    for place in places[1:]:
        cost, before = dijkstra(graph, directed=False, indices=int(place), return_predecessors=True, limit=np.inf)
        known = np.array(sorted(reached))
        cell, path = int(known[np.argmin(cost[known])]), []
        while cell >= 0:
            path.append(cell)
            cell = int(before[cell])
        reached.update(path)
        points = np.column_stack(np.divmod(np.array(path), cols)).astype(float)
        if len(points) > 3:
            ends = points[[0, -1]].copy()
            points = ndimage.gaussian_filter1d(points, smooth, axis=0, mode="nearest")
            points[[0, -1]] = ends
        lines.append(points)
    return lines
