"""runs.parquet: one row per (point, seed), made from the runs' own files."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aerosim.errors import InputError
from aerosim.record import unit_of
from aerosim.sweep.work import Result

if TYPE_CHECKING:
    import pyarrow as pa

# of every run, before the varied keys and the figures of the summary
RUN_COLUMNS = ("point", "seed", "id", "status", "reason", "wall_s")
ROLE = b"role"  # of a column, in its metadata: run, parameter or metric


def runs_table(results: Iterable[Result], parameters: Sequence[str]) -> pa.Table:
    """Table of runs, sorted by point and seed, whatever order they come in.

    parameters: the varied keys, in their order.  Columns: point, seed, id, status, reason, wall_s, a column for
    each parameter, one for each path of the summary; null where a run has no such figure.  A path that is also a
    varied key has ``summary.`` before it.  Metadata of a column: its unit, and its role.
    """
    import pyarrow as pa

    rows = sorted(results, key=lambda each: (each.point, each.seed))
    paths: dict[str, None] = {}
    for row in rows:
        paths.update(dict.fromkeys(row.summary))
    fields, arrays = [], []

    def add(name: str, role: str, values: list[Any]) -> None:
        array = _column(values)
        fields.append(pa.field(name, array.type, metadata={"unit": unit_of(name), ROLE: role}))
        arrays.append(array)

    for name in RUN_COLUMNS:
        add(name, "run", [getattr(row, name) for row in rows])
    for name in parameters:
        add(name, "parameter", [row.parameters.get(name) for row in rows])
    for name in paths:
        add(f"summary.{name}" if name in parameters else name, "metric", [row.summary.get(name) for row in rows])
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


def _column(values: list[Any]) -> pa.Array:
    """Array of the narrowest kind that holds all values; lists, mappings and mixtures become JSON text."""
    import pyarrow as pa

    kinds = {type(value) for value in values if value is not None}
    if kinds <= {float, int} and (float in kinds or not kinds):
        return pa.array([None if value is None else float(value) for value in values], pa.float64())
    for kind, column in ((int, pa.int64()), (bool, pa.bool_()), (str, pa.string())):
        if kinds == {kind}:
            return pa.array(values, column)
    texts = (value if value is None or isinstance(value, str) else json.dumps(value) for value in values)
    return pa.array(list(texts), pa.string())


def parameters_of(table: pa.Table) -> list[str]:
    """Names of the varied keys of a table, in their order."""
    return _named(table, b"parameter")


def metrics_of(table: pa.Table) -> list[str]:
    """Names of the columns that hold numbers of the runs' summaries, in their order."""
    from pyarrow import types

    return [
        name
        for name in _named(table, b"metric")
        if types.is_floating(table.field(name).type) or types.is_integer(table.field(name).type)
    ]


def _named(table: pa.Table, role: bytes) -> list[str]:
    return [field.name for field in table.schema if (field.metadata or {}).get(ROLE) == role]


def write_table(file: Path, table: pa.Table) -> None:
    """Write a table so that readers see the old one or the new one.  Raises OSError."""
    import pyarrow.parquet as pq

    part = file.with_name(f".{file.name}.part-{os.getpid()}")
    try:
        pq.write_table(table, part, compression="zstd")
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def read_table(file: Path) -> pa.Table:
    """Table of a sweep.  Raises InputError if it is not there or cannot be read."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        return pq.read_table(file)
    except (OSError, pa.ArrowInvalid) as error:
        raise InputError(f"cannot be read: {error}", where=str(file)) from error
