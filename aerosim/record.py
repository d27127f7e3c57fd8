"""The run directory: what a run leaves, written whole, opened again and checked."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.recorder import Columns

if TYPE_CHECKING:
    import pyarrow as pa

    from aerosim.scenario import Scenario

UNITS = {
    "_deg2": "deg2", "_deg_s": "deg/s", "_deg": "deg", "_m_s": "m/s", "_per_s2": "1/s2", "_per_s": "1/s",
    "_grey": "grey levels", "_px": "px", "_pct": "%", "_m": "m", "_s": "s",
}  # fmt: skip


@dataclass
class Record:
    """A run in memory.  status: done, failed or interrupted; reason: why, if not done.

    telemetry, matches, photos, lines: columns of the tables of the same names, units in their names.
    rows, surfaces: what the viewer draws, empty if not kept.  inputs: files that the run was made from.
    """

    scenario: Scenario
    status: str
    reason: str
    telemetry: Columns
    matches: Columns
    photos: Columns
    lines: Columns
    summary: dict[str, Any]
    rows: Columns = field(default_factory=dict)
    surfaces: Columns = field(default_factory=dict)
    inputs: dict[str, Path] = field(default_factory=dict)


class Run:
    """A run directory that was opened."""

    def __init__(self, path: Path) -> None:
        """Raises InputError if there is no readable run."""
        self.path = Path(path)
        self.summary: dict[str, Any] = self._json("summary.json")
        self.status: str = self.summary["status"]

    def _json(self, name: str) -> dict[str, Any]:
        file = self.path / name
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
        except FileNotFoundError as error:
            raise InputError("is no run directory: it has no " + name, where=str(self.path)) from error
        except (OSError, ValueError) as error:
            raise InputError(f"cannot be read: {error}", where=str(file)) from error
        if not isinstance(found, dict) or (name == "summary.json" and "status" not in found):
            raise InputError("is not what a run writes", where=str(file))
        return found

    def table(self, name: str) -> pa.Table:
        """A table of the run by its name, for example ``telemetry``.  Raises InputError if it is not there."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        file = self.path / f"{name}.parquet"
        try:
            return pq.read_table(file)
        except (OSError, pa.ArrowInvalid) as error:
            raise InputError(f"cannot be read: {error}", where=str(file)) from error

    @property
    def telemetry(self) -> pa.Table:
        """One row per record period."""
        return self.table("telemetry")

    @property
    def matches(self) -> pa.Table:
        """One row per strip."""
        return self.table("matches")

    @property
    def photos(self) -> pa.Table:
        """One row per photo."""
        return self.table("photos")

    @property
    def lines(self) -> pa.Table:
        """One row per survey line, as planned."""
        return self.table("lines")

    @property
    def manifest(self) -> dict[str, Any]:
        """Versions, seeds, hashes of inputs and outputs."""
        return self._json("manifest.json")

    @property
    def scenario(self) -> Scenario:
        """The resolved scenario, which reproduces the run."""
        from aerosim.scenario import load

        return load(str(self.path / "scenario.yaml"))

    def verify(self) -> list[str]:
        """Names of outputs that are missing or differ from the manifest's hashes; empty if all is well."""
        found = self.manifest["outputs"]
        return [name for name, digest in found.items() if file_sha256(self.path / name) != digest]


def open_run(path: Path | str) -> Run:
    """Open a run directory.  Raises InputError if it is none."""
    return Run(Path(path))


def telemetry_sha256(telemetry: Columns) -> str:
    """Digest of the telemetry: little-endian columns one after the other, in their order."""
    digest = hashlib.sha256()
    for column in telemetry.values():
        digest.update(np.ascontiguousarray(column, column.dtype.newbyteorder("<")).tobytes())
    return digest.hexdigest()


def file_sha256(path: Path) -> str | None:
    """Digest of a file, None if it cannot be read."""
    try:
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return None


def plain(value: Any) -> Any:
    """A value as JSON has it: numbers that are not finite become null."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def unit_of(name: str) -> str:
    """Unit of a column by its name's suffix, "" for none."""
    return next((unit for suffix, unit in UNITS.items() if name.endswith(suffix)), "")


def arrow_table(columns: dict[str, Any]) -> pa.Table:
    """Columns as a table: NaN is null, each field's metadata carries its unit."""
    import pyarrow as pa

    fields, arrays = [], []
    for name, column in columns.items():
        array = _arrow_array(column)
        fields.append(pa.field(name, array.type, metadata={"unit": unit_of(name)}))
        arrays.append(array)
    return pa.Table.from_arrays(arrays, schema=pa.schema(fields))


def _arrow_array(column: NDArray[np.generic]) -> pa.Array:
    import pyarrow as pa

    if column.dtype.kind == "f":
        return pa.array(column, from_pandas=True)
    if column.dtype.kind == "O":
        items = column.tolist()
        return pa.array(items, pa.string() if all(isinstance(item, str | None) for item in items) else None)
    if column.ndim == 2:
        return pa.FixedSizeListArray.from_arrays(pa.array(column.ravel()), column.shape[1])
    return pa.array(column)
