"""A metric of a sweep as a matrix: points by seeds."""

from __future__ import annotations

import json
from collections.abc import Hashable, Sequence
from difflib import get_close_matches
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.frames import Array

NO_METRIC = {"point", "seed", "status", "reason", "wall_s"}


class Matrix(NamedTuple):
    """A metric at all points and seeds.

    points: values of the varied keys, by point; seeds: their numbers, rising.  values: (points, seeds) in the
    metric's unit, NaN where there is none; failed: (points, seeds) True where the run failed.
    """

    points: list[dict[str, Any]]
    seeds: list[int]
    values: Array
    failed: NDArray[np.bool_]


def identity(value: Any) -> Hashable:
    """What tells values of a key apart: 10 and 10.0 are one, lists and mappings may be values too."""
    return json.dumps(value, sort_keys=True, default=str) if isinstance(value, (dict, list)) else value


def is_value(found: Any, value: Any) -> bool:
    """Whether a value found in the table is the one asked for; lists and mappings stand there as JSON text."""
    return bool(found == value or (isinstance(found, str) and found == json.dumps(value)))


def known(table: Any, name: str, what: str) -> None:
    """Raise InputError with the nearest name if the table has no such column.  what: metric or key."""
    if name not in table.column_names:
        near = get_close_matches(name, table.column_names, 1)
        allowed = f"did you mean {near[0]}" if near else "a column of runs.parquet"
        raise InputError(f"the sweep has no {what} {name}", key=name, allowed=allowed)


def numeric(table: Any) -> list[str]:
    """Columns that hold numbers, but for point, seed and wall time."""
    import pyarrow.types as kinds

    number = (kinds.is_floating, kinds.is_integer, kinds.is_null)
    return [f.name for f in table.schema if f.name not in NO_METRIC and any(is_it(f.type) for is_it in number)]


def matrix(table: Any, metric: str, keys: Sequence[str]) -> Matrix:
    """The metric of all points and seeds of a table with the columns of runs.parquet.

    Raises InputError for an unknown name, a metric that is no number, or a table without rows.
    """
    known(table, metric, "metric")
    for key in keys:
        known(table, key, "key")
    if metric not in numeric(table):
        raise InputError("is no metric: its values are no numbers", key=metric)
    if not table.num_rows:
        raise InputError("the sweep has no runs yet", key=metric)
    numbers = np.asarray(table["point"].to_pylist(), np.int64)
    points, first, row = np.unique(numbers, return_index=True, return_inverse=True)
    seeds, column = np.unique(np.asarray(table["seed"].to_pylist(), np.int64), return_inverse=True)
    values = np.full((len(points), len(seeds)), np.nan)
    failed = np.zeros(values.shape, bool)
    found = np.array([np.nan if v is None else float(v) for v in table[metric].to_pylist()])
    ended = np.array([status == "done" for status in table["status"].to_pylist()])
    # what a flight left before it failed is of a shorter flight: no value of this metric
    values[row, column] = np.where(ended & np.isfinite(found), found, np.nan)
    failed[row, column] = ~ended
    told = table.select(list(keys)).take(first).to_pylist() if keys else [{} for _ in points]
    return Matrix(told, seeds.tolist(), values, failed)
