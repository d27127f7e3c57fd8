"""The driver of a sweep: what is flown, what is kept, when it ends, and how it goes on after it was ended."""

from __future__ import annotations

import json
import logging
import os
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

from aerosim.errors import InputError, Interrupted, RunFailure
from aerosim.sweep import folder
from aerosim.sweep.book import Book
from aerosim.sweep.executor import Executor
from aerosim.sweep.order import flight_order
from aerosim.sweep.reporting import write_report
from aerosim.sweep.results import Sweep
from aerosim.sweep.spec import SweepSpec
from aerosim.sweep.table import write_table
from aerosim.sweep.work import Result, Task, result_file, scenario_of, write_result, write_whole

journal = logging.getLogger("aerosim")

Progress = Callable[[float, float], None]
End = InputError | RunFailure | Interrupted  # what ends a sweep before all is flown
TABLE_EVERY_S = 30.0  # at most so often the table is written while the sweep goes on,
TABLE_SHARE = 0.01  # and at most this share of the time goes into it


def drive(
    spec: SweepSpec,
    out: Path,
    executor: Executor,
    *,
    resume: bool = False,
    retry_failed: bool = False,
    cache: Path | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """Fly what is missing of a sweep and write its tables and its report.

    out: the sweep directory.  retry_failed: failed runs are flown again.  cache: folder of flown trajectories,
    None for none.  progress: told (runs ended, runs to fly) of this call.
    Raises InputError before anything is flown (with no directory left, or one that tells the reason: if workers
    of a cluster cannot take part); Interrupted and RunFailure (their `path` is the directory) with a directory
    that resumes.  Runs that fail do not raise: they are rows of the table.
    """
    out = Path(out).absolute()
    _check_rule(spec)
    _check_first(spec)
    with folder.opened(out, spec, resume) as found, _log_in(out / folder.LOG):
        journal.info("%d points with %d seeds, %d runs", len(spec.points), spec.seeds, spec.size)
        course = _Course(spec, out, progress)
        if found:
            course.recall(retry_failed)
        (out / folder.SUMMARY).unlink(missing_ok=True)  # whoever is killed from here on leaves no old one
        status, end = course.fly(executor, cache)
        course.finish(status, executor.workers, end)
        if status == "done" and cache is not None and cache.parent == out:
            shutil.rmtree(cache, ignore_errors=True)  # of these seeds nothing is left to fly
    if end is not None:
        raise _with_path(end, out)
    return Sweep(out)


def _with_path(end: End, out: Path) -> End:
    """What ends a sweep, with the directory that it leaves; wrong input needs none."""
    if not isinstance(end, InputError):
        end.path = out
    return end


def _check_rule(spec: SweepSpec) -> None:
    """Raise InputError for a rule for stopping that cannot hold."""
    rule = spec.stop_when
    if rule is None:
        return
    import numpy as np

    from aerosim.scenario.expect import SUMMARY_PATHS
    from aerosim.sweep.stoprule import LEAST

    if rule.metric not in SUMMARY_PATHS:
        from difflib import get_close_matches

        near = get_close_matches(rule.metric, SUMMARY_PATHS, 1, 0.4)
        hint = f"did you mean {near[0]}?" if near else "a number of summary.json, as crab.residual_rms_deg"
        raise InputError(f"{rule.metric} is no number of summary.json", key="--stop-when", allowed=hint)
    if spec.seeds < LEAST:
        problem = f"{spec.seeds} seeds are too few for a rule for stopping"
        raise spec.placed(InputError(problem, key="seeds", allowed=f"at least {LEAST}"))
    rule.series(np.zeros((len(spec.points), 1)), [point.values for point in spec.points])


def _check_first(spec: SweepSpec) -> None:
    """Raise InputError if the first point cannot be built: its terrain, aircraft or lines are wrong."""
    from aerosim.scenario.build import build

    scenario = scenario_of(next(spec.tasks(Path())))
    try:
        build(scenario)
    except InputError as error:
        raise spec.placed(spec.scenario.place(error) if error.key not in spec.places else error) from error


class _Log(logging.FileHandler):
    """A log that is no reason to end, nor to print anything, if there is no room for it."""

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802
        """What is not written is left out."""

    def close(self) -> None:
        """Close the file; what is still to be written may be lost."""
        with suppress(OSError):
            super().close()


@contextmanager
def _log_in(file: Path) -> Iterator[None]:
    """Messages of the package go into a file too."""
    handler = _Log(file, encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s"))
    journal.addHandler(handler)
    journal.setLevel(min(journal.level or logging.INFO, logging.INFO))
    try:
        yield
    finally:
        journal.removeHandler(handler)
        handler.close()


class _Course:
    """A sweep under way."""

    def __init__(self, spec: SweepSpec, out: Path, progress: Progress | None) -> None:
        self.spec, self.out, self.progress = spec, out, progress
        self.book = Book(spec)
        self.started = time.monotonic()
        self.flown, self.to_fly, self._found = 0, spec.size, 0
        self._again: set[str] = set()  # failed runs that are flown anew: their old files are there
        self._table_at, self._table_cost = self.started, 0.0

    def recall(self, retry_failed: bool) -> None:
        """Take in what an earlier process left."""
        wanted = {self.spec.run_id(point, seed) for seed, point in self.spec.runs()}
        for result in folder.results(self.out, wanted):
            if result.status == "done" or not retry_failed:
                self.book.add(result)
            else:
                self._again.add(result.id)
        self._found = sum(1 for _ in self.book.counted())
        self.to_fly = self.book.wanted - self._found
        journal.info("resumed: %d runs are there", len(self.book.results))

    def missing(self, cache: Path | None, workers: int) -> Iterator[Task]:
        """Tasks that are to be flown, until the rule for stopping holds.  Flights that serve once are not kept."""
        order, shared = flight_order(self.spec, workers) if cache is not None else (None, False)
        for task in self.spec.tasks(self.out, str(cache) if shared else "", order):
            if self.book.stopped is not None:
                return
            if task.id not in self.book.results and task.seed <= self.book.last(task.point):
                yield task

    def fly(self, executor: Executor, cache: Path | None) -> tuple[str, End | None]:
        """Fly what is missing.  Returns the status and the exception that ends the call."""
        try:
            self._tell()
            with closing(executor.run(self.missing(cache, executor.workers))) as ending:
                for result in ending:
                    self._keep(result)
                    if self.book.stopped is not None:
                        journal.info("stopped after %d seeds: %s", self.book.stopped, self.spec.stop_when)
                        break
        except KeyboardInterrupt:
            return "interrupted", Interrupted("interrupted by the user")
        except OSError as error:
            return "failed", self._unwritten(error)
        except (InputError, RunFailure) as error:
            return "failed", error
        return "done", None

    def _unwritten(self, error: OSError) -> RunFailure:
        why = os.strerror(error.errno) if error.errno else str(error)  # pyarrow's own words are long ones
        return RunFailure(f"{self.out} cannot be written: {why}; --resume goes on")

    def _keep(self, result: Result) -> None:
        """A result that ended: its file is there or is written now."""
        if result.id in self._again or not result_file(self.out, result.id).is_file():
            write_result(self.out, result)
        if result.status != "done":
            journal.info("point %d, seed %d failed: %s", result.point, result.seed, result.reason)
        self.book.add(result)
        self.flown += 1
        self.to_fly = self.book.wanted - self._found
        self._tell()
        now = time.monotonic()
        if now - self._table_at > max(TABLE_EVERY_S, self._table_cost / TABLE_SHARE):
            write_table(self.out / folder.TABLE, self.book.table())
            self._table_at, self._table_cost = time.monotonic(), time.monotonic() - now

    def _tell(self) -> None:
        if self.progress is not None:
            self.progress(self.flown, max(self.to_fly, self.flown))

    def _sentence(self) -> str:
        """How the sweep ended, for the report."""
        rule, early = self.spec.stop_when, self.book.wanted < self.spec.size
        if rule is not None and rule.each and early:
            stops = sorted(self.book.last(point.number) for point in self.spec.points)
            return f"Points stopped after {stops[0]} to {stops[-1]} of {self.spec.seeds} seeds: {rule}."
        if self.book.stopped is None or not early:
            return ""
        return f"Stopped after {self.book.stopped} of {self.spec.seeds} seeds: {self.spec.stop_when} holds."

    def finish(self, status: str, workers: int, end: End | None) -> None:
        """Write the table, the summary and the report.

        end: what ends the call, if not all was flown; its words are the summary's `reason`.  Raises RunFailure if
        something cannot be written.
        """
        if end is not None:
            journal.info("%s", end)
        figures: dict[str, Any] = {
            "status": status,
            **({"reason": str(end)} if end is not None else {}),
            **self.book.figures(),
            "flown_now": self.flown,
            "workers": workers,
            "wall_s": time.monotonic() - self.started,
        }
        try:
            write_table(self.out / folder.TABLE, self.book.table())
            write_whole(self.out / folder.SUMMARY, json.dumps(figures, indent=1) + "\n")
            if status == "done":
                write_report(self.out, self.spec, self._sentence())
        except OSError as error:
            raise _with_path(self._unwritten(error), self.out) from error
        journal.info(
            "%s: %d of %d runs done, %d failed", status, figures["done"], figures["runs"], figures["failed"]
        )
