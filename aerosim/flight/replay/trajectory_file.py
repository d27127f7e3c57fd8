"""A table of a flown path: CSV or Parquet, columns with their unit in the name, read and checked cell by cell."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.frames import Array

MOST_ROWS = 2_000_000
LONG_AGO = 1e7  # s; times beyond it are counted from the first row
FOOT, KNOT = 0.3048, 1852.0 / 3600.0


class Kind(NamedTuple):
    """What a column holds.  factor: of its unit in SI; low, high: possible values, in its unit."""

    quantity: str
    factor: float
    low: float
    high: float


_DEG = math.radians(1.0)
KINDS: dict[str, Kind] = {
    "t_s": Kind("time", 1.0, -1e12, 1e12),
    "time_utc": Kind("time", 1.0, -1e12, 1e12),
    "latitude_deg": Kind("latitude", _DEG, -90.0, 90.0),
    "longitude_deg": Kind("longitude", _DEG, -360.0, 360.0),
    "height_m": Kind("height", 1.0, -500.0, 30_000.0),
    "orthometric_height_m": Kind("orthometric_height", 1.0, -500.0, 30_000.0),
    "barometric_altitude_m": Kind("barometric_altitude", 1.0, -700.0, 30_000.0),
    "barometric_altitude_ft": Kind("barometric_altitude", FOOT, -2300.0, 98_000.0),
    "groundspeed_m_s": Kind("groundspeed", 1.0, 0.0, 400.0),
    "groundspeed_kt": Kind("groundspeed", KNOT, 0.0, 777.0),
    "track_deg": Kind("track", _DEG, -360.0, 360.0),
    "vertical_rate_m_s": Kind("vertical_rate", 1.0, -150.0, 150.0),
    "vertical_rate_ftpmin": Kind("vertical_rate", FOOT / 60.0, -30_000.0, 30_000.0),
    "roll_deg": Kind("roll", _DEG, -180.0, 180.0),
    "pitch_deg": Kind("pitch", _DEG, -90.0, 90.0),
    "heading_deg": Kind("heading", _DEG, -360.0, 360.0),
}
HEIGHTS = ("height", "orthometric_height", "barometric_altitude")
NEEDED = ("time", "latitude", "longitude")
# Names that other programs give a column, and what they may mean here.
_ALIASES = {
    "time": "t_s or time_utc", "timestamp": "t_s or time_utc", "t": "t_s",
    "lat": "latitude_deg", "lon": "longitude_deg", "lng": "longitude_deg", "long": "longitude_deg",
    "alt": "height_m or barometric_altitude_ft", "altitude": "height_m or barometric_altitude_ft",
    "geoaltitude": "height_m", "baroaltitude": "barometric_altitude_m", "elevation": "orthometric_height_m",
    "speed": "groundspeed_m_s", "velocity": "groundspeed_m_s", "course": "track_deg",
    "vertrate": "vertical_rate_m_s", "yaw": "heading_deg",
}  # fmt: skip


@dataclass
class Table:
    """Columns of a trajectory file in SI and radians.

    columns: quantity -> (n,), NaN where an optional cell is empty.  names: quantity -> name in the file.
    lines: of the file (CSV), or number of the row (Parquet), (n,).  rows: what these are called.
    """

    source: str
    rows: str
    lines: NDArray[np.int64]
    columns: dict[str, Array] = field(default_factory=dict)
    names: dict[str, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    def place(self, index: int) -> str:
        """Where a row stands: ``file:line`` or ``file, row n``."""
        number = int(self.lines[index])
        return f"{self.source}:{number}" if self.rows == "line" else f"{self.source}, row {number}"


def read_table(path: Path) -> Table:
    """Read a trajectory file, CSV or (suffix .parquet) Parquet.

    Raises InputError with file and line: no such file, not text, empty, other separators, columns missing, twice
    or of an unknown unit, cells that are no number, impossible values.
    """
    if not path.is_file():
        raise InputError(f"no trajectory file {path}")
    return _read_parquet(path) if path.suffix.lower() in (".parquet", ".pq") else _read_csv(path)


def _read_csv(path: Path) -> Table:
    rows = _csv_rows(path)
    header = next(rows, (1, []))[1]
    names = [name.strip() for name in header]
    if not any(names):
        raise InputError("the trajectory file is empty", where=str(path))
    _check_separator(path, header)
    lines: list[int] = []
    cells: list[list[str]] = []
    for number, row in rows:
        if not row or not any(cell.strip() for cell in row):
            continue
        if len(row) != len(names):
            raise InputError(
                f"{len(row)} cells under {len(names)} columns",
                where=f"{path}:{number}",
                allowed="cells parted by commas, decimal points",
            )
        lines.append(number)
        cells.append(row)
        if len(lines) > MOST_ROWS:
            raise InputError(f"more than {MOST_ROWS} rows", where=str(path))
    table = Table(str(path), "line", np.array(lines, np.int64))
    columns = dict(zip(names, zip(*cells, strict=True), strict=True)) if cells else dict.fromkeys(names, ())
    for name in _known(names, str(path), table.notes):
        values = [_number(text, name, table, i) for i, text in enumerate(columns[name])]
        _keep(table, name, np.array(values, float))
    return _complete(table)


def _csv_rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(stream)
            for row in reader:
                if any("\0" in cell for cell in row):
                    raise InputError("is no text file", where=str(path), allowed="CSV, or Parquet named .parquet")
                yield reader.line_num, row
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError("is no text file", where=str(path), allowed="CSV, or Parquet named .parquet") from error
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=str(path)) from error


def _check_separator(path: Path, header: Sequence[str]) -> None:
    line = ",".join(header)
    for other, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(header) == 1 and other in line:
            raise InputError(
                f"{word} between the columns",
                where=f"{path}:1",
                allowed="commas, and decimal points in the numbers",
            )


def _number(text: str, name: str, table: Table, index: int) -> float:
    """Value of a cell, NaN if it is empty."""
    text = text.strip()
    if not text:
        return math.nan
    if name == "time_utc":
        return _instant(text, table, index)
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{name} is {text!r}, no number", where=table.place(index)) from None


def _instant(text: str, table: Table, index: int) -> float:
    try:
        at = datetime.fromisoformat(text)
    except ValueError:
        raise InputError(
            f"time_utc is {text!r}, no ISO 8601 time", where=table.place(index), allowed="2024-05-01T10:20:30.5Z"
        ) from None
    return (at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp()


def _read_parquet(path: Path) -> Table:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        data = pq.read_table(path)
    except (pa.ArrowException, OSError) as error:
        raise InputError(f"cannot be read as Parquet ({error})", where=str(path)) from error
    if data.num_rows > MOST_ROWS:
        raise InputError(f"more than {MOST_ROWS} rows", where=str(path))
    table = Table(str(path), "row", np.arange(1, data.num_rows + 1))
    for name in _known(list(data.column_names), str(path), table.notes):
        _keep(table, name, _parquet_column(data[name], name, table))
    return _complete(table)


def _parquet_column(column: Any, name: str, table: Table) -> Array:
    import pyarrow as pa

    kind = column.type
    if pa.types.is_timestamp(kind) and name == "time_utc":
        ns = column.cast(pa.timestamp("ns"), safe=False).to_numpy(zero_copy_only=False)
        seconds = (ns - np.datetime64(0, "ns")) / np.timedelta64(1, "s")
        return np.asarray(seconds, float)
    if pa.types.is_string(kind) or pa.types.is_large_string(kind):
        return np.array([_number(text or "", name, table, i) for i, text in enumerate(column.to_pylist())], float)
    if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind)):
        raise InputError(f"column {name} holds {kind}, no numbers", where=table.source)
    return np.asarray(column.cast(pa.float64()).to_numpy(zero_copy_only=False), float)


def _known(names: Sequence[str], source: str, notes: list[str]) -> list[str]:
    """Names of columns that are used; the others go into the notes, or are refused."""
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise InputError(f"column {twice[0]!r} stands twice", where=f"{source}:1")
    quantities = {kind.quantity for kind in KINDS.values()}
    for name in names:
        head, _, unit = name.rpartition("_")
        if name not in KINDS and (head in quantities or name in quantities):
            units = [known for known, kind in KINDS.items() if kind.quantity in (head, name)]
            problem = f"column {name!r} has the unknown unit {unit!r}" if head in quantities else (
                f"column {name!r} does not say its unit"
            )  # fmt: skip
            raise InputError(problem, where=f"{source}:1", allowed=" or ".join(units))
    extra = [name for name in names if name not in KINDS and name]
    _missing(names, extra, source)
    if extra:
        notes.append(f"columns not used: {', '.join(extra)}")
    return [name for name in names if name in KINDS]


def _missing(names: Sequence[str], extra: Sequence[str], source: str) -> None:
    there = {KINDS[name].quantity: name for name in names if name in KINDS}
    wanted = [(quantity,) for quantity in NEEDED] + [HEIGHTS]
    for one_of in wanted:
        found = [name for name in names if name in KINDS and KINDS[name].quantity in one_of]
        if len(found) > 1:
            raise InputError(
                f"columns {' and '.join(found)} say the same", where=f"{source}:1", allowed="one of them"
            )
        if not found:
            names_of = [name for name, kind in KINDS.items() if kind.quantity in one_of]
            raise InputError(
                f"no column {' or '.join(names_of)}",
                where=f"{source}:1",
                allowed=f"there are {', '.join(n for n in names if n) or 'none'}{_hint(names_of, extra)}",
            )
    for quantity in there:
        found = [name for name in names if name in KINDS and KINDS[name].quantity == quantity]
        if len(found) > 1:
            raise InputError(
                f"columns {' and '.join(found)} say the same", where=f"{source}:1", allowed="one of them"
            )


def _hint(wanted: Sequence[str], extra: Sequence[str]) -> str:
    for name in extra:
        head = name.lower().partition("_")[0]
        alias = _ALIASES.get(name.lower(), _ALIASES.get(head, ""))
        if any(each in alias for each in wanted):
            return f"; is {name} a {alias}?"
        if near := get_close_matches(name.lower(), wanted, 1, 0.7):
            return f"; is {name} a {near[0]}?"
    return ""


def _keep(table: Table, name: str, values: Array) -> None:
    """Check a column and put it in, in SI."""
    kind = KINDS[name]
    needed = kind.quantity in (*NEEDED, *HEIGHTS)
    bad = ~np.isfinite(values) if needed else np.isinf(values)
    if bad.any():
        index = int(np.argmax(bad))
        said = "infinite" if np.isinf(values[index]) else "empty or not a number (NaN)"
        raise InputError(f"{name} is {said}", where=table.place(index))
    out = (values < kind.low) | (values > kind.high)
    if out.any():
        index = int(np.argmax(out))
        swapped = "; are latitude and longitude swapped?" if name == "latitude_deg" else ""
        raise InputError(
            f"{name} is {values[index]:g}, which cannot be",
            where=table.place(index),
            allowed=f"{kind.low:g} to {kind.high:g}{swapped}",
        )
    if len(values) and kind.quantity == "time" and (name == "time_utc" or abs(values[0]) > LONG_AGO):
        # Seconds since 1970 have no digits left for the motion between two steps.
        table.notes.append(f"{name}: counted from the first row, {values[0]:.3f} s")
        values = values - values[0]
    table.columns[kind.quantity] = values * kind.factor
    table.names[kind.quantity] = name


def _complete(table: Table) -> Table:
    count = len(table.lines)
    if count < 4:
        said = ("no points", "one point", "2 points", "3 points")[count]
        raise InputError(f"a trajectory of {said}", where=table.source, allowed="4 and more")
    return table
