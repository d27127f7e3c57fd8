"""Writing a run directory: under a temporary name, with room kept for its record, then renamed."""

from __future__ import annotations

import json
import logging
import os
import platform
import shutil
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aerosim.errors import InputError, Interrupted, RunFailure
from aerosim.record import Record, Run, arrow_table, file_sha256, plain

if TYPE_CHECKING:
    from aerosim.scenario import Scenario

PACKAGES = ("jsbsim", "numpy", "numba", "scipy", "pyarrow", "rasterio", "pyproj", "pydantic", "rerun-sdk")
LAST_WORDS = 1 << 18  # bytes kept for summary and manifest of a run whose disk is full
log = logging.getLogger("aerosim")

Draw = Callable[["Scenario", Path], None]


class Staging:
    """A run directory in the making, beside its final place."""

    def __init__(self, out: Path, overwrite: bool, room: int) -> None:
        """room: bytes kept free for the record from the start, so that a disk that fills up costs no data.

        Raises InputError if `out` exists and must not be replaced, or cannot be written.
        """
        self.out = out
        if os.path.lexists(out) and not overwrite:
            raise InputError(f"{out} exists", key="--out", allowed="another directory, or --overwrite")
        if os.path.lexists(out) and not (out / "summary.json").is_file():
            raise InputError(f"{out} is not a run, it is not replaced", key="--out", allowed="another directory")
        self.path = out.parent / f".{out.name}.part-{os.getpid()}"
        self._made = [p for p in (out.parent, *out.parent.parents) if not p.exists()]
        try:
            out.parent.mkdir(parents=True, exist_ok=True)
            self.path.mkdir()
            self._keep("room", room)
            self._keep("last", LAST_WORDS)
        except OSError as error:
            self.discard()
            raise InputError(f"{out} cannot be written: {error.strerror or error}", key="--out") from error
        self._handler = logging.FileHandler(self.path / "run.log", encoding="utf-8")
        self._handler.setFormatter(logging.Formatter("%(levelname)s %(message)s"))
        log.addHandler(self._handler)
        log.setLevel(min(log.level or logging.INFO, logging.INFO))

    def _keep(self, name: str, size: int) -> None:
        with (self.path / f".{name}").open("wb") as file:
            if hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
            else:
                file.write(b"\0" * size)

    def release(self, name: str) -> None:
        """Give kept room back to the disk: it is about to be used."""
        (self.path / f".{name}").unlink(missing_ok=True)

    def commit(self, intact: bool) -> Path:
        """Rename into place.  intact: False for a run that did not end well; it never replaces an earlier one.

        Returns the final path: `out`, or ``<out>.failed`` beside an earlier run.
        """
        self._close()
        target = self.out
        if os.path.lexists(target) and not intact:
            target = target.with_name(target.name + ".failed")
        old = target.parent / f".{target.name}.old-{os.getpid()}"
        if os.path.lexists(target):
            target.rename(old)
        self.path.rename(target)
        shutil.rmtree(old, ignore_errors=True)
        return target

    def discard(self) -> None:
        """Leave nothing behind, not even the folders made on the way."""
        self._close()
        shutil.rmtree(self.path, ignore_errors=True)
        for made in self._made:
            if made.is_dir() and not any(made.iterdir()):
                made.rmdir()

    def _close(self) -> None:
        handler = getattr(self, "_handler", None)
        if handler is not None:
            log.removeHandler(handler)
            handler.close()


def write_run(record: Record, staging: Staging, draw: Draw) -> Run:
    """Write all files of a run and move it into place.

    draw: adds report and viewer file to a directory that holds the tables.  A disk that fills up ends in a
    directory with as much as there was room for, marked failed; Ctrl-C likewise, marked interrupted.
    Raises RunFailure or Interrupted (their `path` is the directory) unless the record's status is done; whatever
    else goes wrong leaves nothing behind.
    """
    try:
        _write(record, staging, draw)
        path = staging.commit(record.status == "done")
    except BaseException:
        staging.discard()
        raise
    if record.status == "done":
        return Run(path)
    end = Interrupted(record.reason) if record.status == "interrupted" else RunFailure(record.reason)
    end.path = path
    raise end


def _write(record: Record, staging: Staging, draw: Draw) -> None:
    staging.release("room")
    try:
        _write_tables(record, staging.path)
        record.rows, record.surfaces = {}, {}  # they are on disk now, and large
        draw(record.scenario, staging.path)
        staging.release("last")
        _write_words(record, staging.path)
        return
    except (OSError, RunFailure) as error:
        record.status, record.reason = "failed", f"the record could not be written: {error}"
    except KeyboardInterrupt:
        record.status, record.reason = "interrupted", "interrupted by the user while the record was written"
    staging.release("last")
    log.error(record.reason)
    _drop_unfinished(staging.path)
    _write_words(record, staging.path)


def _write_tables(record: Record, path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    from aerosim.scenario import to_yaml

    (path / "scenario.yaml").write_text(to_yaml(record.scenario), encoding="utf-8")
    tables = {name: getattr(record, name) for name in ("telemetry", "matches", "photos", "lines")}
    if record.rows:
        tables |= {"rows": record.rows, "mad": record.surfaces}
    for name, columns in tables.items():
        part = path / f"{name}.parquet.part"
        pq.write_table(arrow_table(columns), part, compression="zstd")
        part.rename(path / f"{name}.parquet")
        pa.default_memory_pool().release_unused()
    _write_summary(record, path)


def _write_summary(record: Record, path: Path) -> None:
    """The summary with its status, and the reason of one that is not done."""
    record.summary = record.summary | {"status": record.status}
    if record.reason:
        record.summary["notes"] = {**record.summary.get("notes", {}), "status": record.reason}
    _write_json(path / "summary.json", record.summary)


def _write_words(record: Record, path: Path) -> None:
    _write_summary(record, path)
    _write_json(path / "manifest.json", _manifest(record, path))


def _drop_unfinished(path: Path) -> None:
    """Remove what was being written: parts, and pictures, which are of a run that was still well."""
    for file in list(path.iterdir()):
        if file.name in ("run.rrd", "report.html") or file.name.startswith(".") or file.suffix == ".part":
            file.unlink()


def _write_json(file: Path, content: dict[str, Any]) -> None:
    part = file.with_name(file.name + ".part")
    part.write_text(json.dumps(plain(content), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    part.replace(file)


def _manifest(record: Record, path: Path) -> dict[str, Any]:
    inputs = {name: {"file": str(file), "sha256": file_sha256(file)} for name, file in record.inputs.items()}
    skip = {"manifest.json", "run.log", ".room", ".last"}
    outputs = {f.name: file_sha256(f) for f in sorted(path.iterdir()) if f.is_file() and f.name not in skip}
    return {
        "aerosim": metadata.version("aerosim-survey"),
        "versions": {"python": platform.python_version(), **{p: metadata.version(p) for p in PACKAGES}},
        "machine": f"{platform.system()} {platform.machine()}",
        "seed": record.scenario.seed,
        "status": record.status,
        "terrain": {name: inputs[name]["file"] for name in ("orthophoto", "elevation") if name in inputs},
        "inputs": inputs,
        "outputs": outputs,
    }
