"""Made-up tables with the columns of runs.parquet, and sweep directories around them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from flights import scenario

from aerosim.scenario import with_overrides
from aerosim.sweep.spec import SweepSpec, make_spec
from aerosim.sweep.specfile import sweep_text
from aerosim.sweep.table import runs_table, write_table
from aerosim.sweep.work import Result

Metrics = Mapping[str, Callable[[Mapping[str, Any], int], float | None]]


def table(
    points: Sequence[Mapping[str, Any]],
    seeds: int,
    metrics: Metrics,
    failed: Mapping[tuple[int, int], str] | None = None,
) -> pa.Table:
    """One row per (point, seed).  metrics: value of a point and a seed.  failed: reasons by (point, seed)."""
    results = []
    for number, point in enumerate(points):
        for seed in range(1, seeds + 1):
            reason = (failed or {}).get((number, seed), "")
            summary = {} if reason else {name: find(point, seed) for name, find in metrics.items()}
            status = "failed" if reason else "done"
            results.append(
                Result(f"{number}-{seed}", number, seed, status, reason, point, summary, 1.5 + 0.1 * seed)
            )
    return runs_table(results, list(points[0]))


def directory(
    out: Path,
    vary: Mapping[str, Any],
    seeds: int,
    metrics: Metrics,
    failed: Mapping[tuple[int, int], str] | None = None,
    **settings: Any,
) -> SweepSpec:
    """A sweep directory as the driver leaves it, of a short flight that nobody flew."""
    spec = make_spec(
        with_overrides(scenario(), {"purpose": "Made up <here> & now."}), vary, seeds=seeds, **settings
    )
    out.mkdir(parents=True, exist_ok=True)
    (out / "sweep.yaml").write_text(sweep_text(spec), encoding="utf-8")
    write_table(out / "runs.parquet", table([point.values for point in spec.points], seeds, metrics, failed))
    return spec


def grid(vary: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    """All combinations, the last key quickest."""
    return [dict(zip(vary, values, strict=True)) for values in product(*vary.values())]


def noise(name: str, *numbers: int) -> float:
    """Standard normal deviate of its own for each name and numbers."""
    return float(np.random.default_rng([*name.encode(), *numbers]).standard_normal())
