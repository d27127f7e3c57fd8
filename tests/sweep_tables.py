"""Made-up tables with the columns of runs.parquet."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import pyarrow as pa


def table(
    points: Sequence[Mapping[str, Any]],
    seeds: int,
    metrics: Mapping[str, Callable[[Mapping[str, Any], int], float | None]],
    failed: Mapping[tuple[int, int], str] | None = None,
) -> pa.Table:
    """One row per (point, seed).  metrics: value of a point and a seed.  failed: reasons by (point, seed)."""
    failed = failed or {}
    rows = []
    for number, point in enumerate(points):
        for seed in range(1, seeds + 1):
            reason = failed.get((number, seed), "")
            values = {name: None if reason else find(point, seed) for name, find in metrics.items()}
            status = "failed" if reason else "done"
            row = {"point": number, "seed": seed, "status": status, "reason": reason, "wall_s": 1.5 + 0.1 * seed}
            rows.append({**row, **point, **values})
    return pa.Table.from_pylist(rows)


def grid(vary: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """All combinations, the last key quickest."""
    return [dict(zip(vary, values, strict=True)) for values in product(*vary.values())]


def noise(name: str, *numbers: int) -> float:
    """Standard normal deviate of its own for each name and numbers."""
    return float(np.random.default_rng([*name.encode(), *numbers]).standard_normal())
