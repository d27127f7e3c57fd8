"""The directory of a sweep: made, locked, known again, and the files in it."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from aerosim.errors import InputError
from aerosim.scenario.reader import parse, read
from aerosim.sweep.spec import SweepSpec
from aerosim.sweep.specfile import sweep_text
from aerosim.sweep.work import Result, read_result, write_whole

SPEC, TABLE, SUMMARY, REPORT, LOG, RUNS, FLIGHTS = (
    "sweep.yaml", "runs.parquet", "summary.json", "report.html", "sweep.log", "runs", "flights",
)  # fmt: skip
LOCK = ".lock"
MAY_CHANGE = ("seeds", "stop_when")  # when a sweep is resumed


@contextmanager
def opened(out: Path, spec: SweepSpec, resume: bool) -> Iterator[bool]:
    """The directory of a sweep, made or found again, and nobody else's while it is open.

    Gives True if it was there.  resume: it may be there; then it must be of the same sweep, except that seeds and
    the rule for stopping may have changed.  Raises InputError, with nothing left behind.
    """
    there = os.path.lexists(out)
    if there and not resume:
        raise InputError(f"{out} exists", key="--out", allowed="another directory, or --resume")
    found = there and (out / SPEC).is_file()
    if there and not found and not _blank(out):
        raise InputError(f"{out} is no sweep", key="--out", allowed="the directory of a sweep, or a new one")
    if found:
        _compare(out, spec)
    try:
        (out / RUNS).mkdir(parents=True, exist_ok=True)
        lock = (out / LOCK).open("a")
    except OSError as error:
        raise InputError(f"{out} cannot be written: {error.strerror or error}", key="--out") from error
    with lock:
        _lock(lock, out)
        _write_spec(out, spec)
        yield found


def _blank(out: Path) -> bool:
    """Whether it is what a sweep leaves that was killed before it began."""
    return out.is_dir() and all(
        each.name == LOCK or each.name.startswith(f".{SPEC}") or (each.name == RUNS and not any(each.iterdir()))
        for each in out.iterdir()
    )


def _lock(file: IO[str], out: Path) -> None:
    """Lock the directory until the process ends, however it ends.  Raises InputError if another one has it."""
    try:
        try:
            import fcntl
        except ImportError:  # Windows
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
        else:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        problem = f"{out} is in use: another sweep writes there"
        raise InputError(problem, key="--out", allowed="wait for it, or another directory") from error


def _write_spec(out: Path, spec: SweepSpec) -> None:
    text = sweep_text(spec)
    with suppress(OSError):
        if (out / SPEC).read_text(encoding="utf-8") == text:
            return
    try:
        write_whole(out / SPEC, text)
    except OSError as error:
        raise InputError(f"{out} cannot be written: {error.strerror or error}", key="--out") from error


def _compare(out: Path, spec: SweepSpec) -> None:
    """Raise InputError unless the directory is of this sweep, made by this version."""
    theirs, _ = read(out / SPEC, str(out / SPEC))
    ours, _ = parse(sweep_text(spec), "sweep")
    if theirs.get("aerosim") != ours["aerosim"]:
        problem = f"{out} was made by aerosim {theirs.get('aerosim')}, this is {ours['aerosim']}"
        raise InputError(problem, key="--resume", allowed="the same version, or another --out")
    _compare_inputs(out, theirs.pop("inputs", {}), ours.pop("inputs", {}))
    for key in MAY_CHANGE:
        theirs.pop(key, None), ours.pop(key, None)
    if different := _difference(theirs, ours):
        problem = f"{out} holds another sweep: {different} differs"
        raise InputError(problem, key="--resume", allowed="the same scenario and values, or another --out")


def _compare_inputs(out: Path, theirs: Mapping[str, Any], ours: Mapping[str, Any]) -> None:
    """Raise InputError if a file that runs have read is another one now.  One that was not there may have come."""
    for file, now in ours.items():
        if theirs.get(file) not in (None, now):
            what = "cannot be read any more" if now is None else f"has changed since {out} was begun"
            raise InputError(f"{file} {what}", key="--resume", allowed="the file as it was, or another --out")


def _difference(one: Any, other: Any, key: str = "") -> str:
    """Dotted key of the first difference, "" if there is none."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        for name in {**one, **other}:
            if name not in one or name not in other:
                return f"{key}.{name}".lstrip(".")
            if found := _difference(one[name], other[name], f"{key}.{name}".lstrip(".")):
                return found
        return ""
    return "" if one == other else key


def results(out: Path, wanted: set[str]) -> Iterator[Result]:
    """Results in the directory whose names are wanted; damaged files are left out, they will be flown anew."""
    with os.scandir(out / RUNS) as files:
        for file in files:
            name = file.name.removesuffix(".json")
            if name in wanted and name != file.name and (result := read_result(Path(file.path))) is not None:
                yield result
