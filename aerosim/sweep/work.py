"""One run of a sweep: what it is, flying it, and the small file that it leaves."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aerosim.errors import InputError, RunFailure

if TYPE_CHECKING:
    from aerosim.scenario import Scenario

# numerical libraries of a worker process: one thread each, since there is a process for each core
ONE_THREAD = dict.fromkeys(
    (
        "OMP_NUM_THREADS",
        "OPENBLAS_NUM_THREADS",
        "MKL_NUM_THREADS",
        "VECLIB_MAXIMUM_THREADS",
        "NUMBA_NUM_THREADS",
        "ARROW_NUM_THREADS",
        "GDAL_NUM_THREADS",
    ),
    "1",
)


@dataclass(frozen=True)
class Task:
    """One run to be flown, as it travels to a worker.

    id: of the run, from all that decides its outcome.  scenario: what all points have in common, as written, as
    JSON (one text for all tasks), with absolute paths.  parameters: the values that replace some of it, by dotted
    key.  out: the sweep directory.  keep: records or summaries.  cache: folder of flown trajectories, "" for none.
    """

    id: str
    point: int
    seed: int
    scenario: str
    parameters: Mapping[str, Any]
    out: str
    keep: str = "summaries"
    cache: str = ""


@dataclass(frozen=True)
class Result:
    """What became of one run.

    status: done or failed; reason: why, if failed.  summary: of the run, by dotted path; empty if failed, since
    figures of a part of a flight are no figures of the flight.  wall_s: the run's time, s.
    """

    id: str
    point: int
    seed: int
    status: str
    reason: str
    parameters: Mapping[str, Any]
    summary: Mapping[str, Any] = field(default_factory=dict)
    wall_s: float = 0.0


@cache
def version() -> str:
    """Version of aerosim."""
    return metadata.version("aerosim-survey")


def run_one(task: Task) -> Result:
    """Fly one run in this process; its result is in ``OUT/runs/<id>.json`` and returned.

    A result that cannot be written here (no room) is returned all the same: the driver writes it, or stops the
    sweep.  Raises KeyboardInterrupt, with nothing written.
    """
    result = fly(task)
    with suppress(OSError):
        write_result(Path(task.out), result)
    return result


def fly(task: Task) -> Result:
    """Fly one run in this process, without its file (another machine does not see the sweep directory).

    Whatever goes wrong in the run is a result with status failed and the reason.  Raises KeyboardInterrupt.
    """
    started = time.perf_counter()
    try:
        summary, status, reason = _flown(task)
    except (InputError, RunFailure) as error:
        summary, status, reason = {}, "failed", str(error)
    except Exception as error:  # a fault of the program must not lose the other runs
        summary, status, reason = {}, "failed", f"internal error: {type(error).__name__}: {error}"
    return Result(
        task.id,
        task.point,
        task.seed,
        status,
        " ".join(reason.split()),
        dict(task.parameters),
        flat(summary) if status == "done" else {},
        time.perf_counter() - started,
    )


def scenario_of(task: Task) -> Scenario:
    """The scenario that a task flies.  Raises InputError."""
    from aerosim.scenario import from_mapping, with_overrides

    changes: dict[str, Any] = {**task.parameters, "seed": task.seed}
    if task.keep != "records":  # nobody would see them
        changes |= {"record.rrd": False, "record.report": False}
    return with_overrides(from_mapping(json.loads(task.scenario)), changes)


def _flown(task: Task) -> tuple[dict[str, Any], str, str]:
    """Summary, status and reason of a flight."""
    from aerosim.flight.interface import fresh
    from aerosim.simulate import run, simulate
    from aerosim.sweep.flights import flights_in

    scenario = scenario_of(task)
    flights = flights_in(task.cache) if task.cache else fresh
    if task.keep == "records":
        kept = run(scenario, Path(task.out) / "records" / task.id, overwrite=True, flights=flights)
        return kept.summary, kept.status, ""
    record = simulate(scenario, flights=flights)
    if record.status == "interrupted":
        raise KeyboardInterrupt
    return record.summary, record.status, record.reason


def flat(summary: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Figures of a summary by dotted path; without what a row has anyway (status, seed) and the notes."""
    out: dict[str, Any] = {}
    for name, value in summary.items():
        if not prefix and name in ("status", "seed", "notes"):
            continue
        if isinstance(value, Mapping):
            out |= flat(value, f"{prefix}{name}.")
        elif value is None or isinstance(value, (bool, int, float, str)):
            out[f"{prefix}{name}"] = value
        else:
            out[f"{prefix}{name}"] = json.dumps(value)
    return out


def result_file(out: Path, name: str) -> Path:
    """File of a run's result."""
    return out / "runs" / f"{name}.json"


def write_result(out: Path, result: Result) -> None:
    """Write a run's file so that it is there whole or not at all, whatever is killed.  Raises OSError."""
    from aerosim.record import plain

    write_whole(result_file(out, result.id), json.dumps(plain(asdict(result)), allow_nan=False) + "\n")


def write_whole(file: Path, text: str) -> None:
    """Write a text file under another name, to the disk, then rename it into place.  Raises OSError."""
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(f".{file.name}.part-{os.getpid()}")
    try:
        with part.open("w", encoding="utf-8") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(stream.fileno())
        part.replace(file)
    except OSError:
        part.unlink(missing_ok=True)
        raise


def read_result(file: Path) -> Result | None:
    """Result of a run, None if there is none or its file is damaged: then it is flown anew."""
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        return Result(**found)
    except (OSError, ValueError, TypeError):
        return None
