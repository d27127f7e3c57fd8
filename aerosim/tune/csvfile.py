"""CSV files of numbers, columns with their unit in the name."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError

Array = NDArray[np.float64]


def columns(path: Path, needed: Sequence[str]) -> dict[str, Array]:
    """Columns of a CSV file of numbers by their names.  Raises InputError with file and line."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("is not a text file", where=str(path), allowed="CSV, UTF-8") from error
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=str(path)) from error
    rows = [
        (k, row) for k, row in enumerate(csv.reader(text.splitlines()), start=1) if any(c.strip() for c in row)
    ]
    if not rows:
        raise InputError("is empty", where=str(path), allowed=f"columns {', '.join(needed)}")
    names = [name.strip() for name in rows[0][1]]
    if lacking := [name for name in needed if name not in names]:
        raise InputError(f"has no column {lacking[0]}", where=f"{path}:{rows[0][0]}", allowed=", ".join(needed))
    if len(rows) == 1:
        raise InputError("has no rows below its header", where=str(path))
    values = np.array([_numbers(row, names, f"{path}:{line}") for line, row in rows[1:]])
    return {name: values[:, k] for k, name in enumerate(names)}


def _numbers(row: list[str], names: list[str], where: str) -> list[float]:
    if len(row) != len(names):
        raise InputError(f"{len(row)} cells under {len(names)} columns", where=where)
    out = []
    for name, cell in zip(names, row, strict=True):
        try:
            value = float(cell)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(f"{name}: {cell.strip()!r} is not a finite number", where=where)
        out.append(value)
    return out
