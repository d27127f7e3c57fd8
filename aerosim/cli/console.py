"""What the commands print: results on stdout, messages and progress on stderr; the options that all share."""

from __future__ import annotations

import json
import logging
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import PurePath
from typing import Annotated, Any

import typer

Progress = Callable[[float, float], None]
_PLAIN_SHARE = 0.1  # a line for each tenth where there is no terminal
_BARE_WIDTH = 120
_COLUMN, _BESIDE_MAX = 10, 8  # width of a column, and how many stand beside each other


@dataclass
class Settings:
    """How much is said.  quiet: results only.  verbose: 1 or 2.  debug: tracebacks."""

    quiet: bool = False
    verbose: int = 0
    debug: bool = False

    def reset(self) -> None:
        """Back to the defaults, for another call in the same process."""
        self.quiet, self.verbose, self.debug = False, 0, False

    def start_log(self) -> None:
        """Messages of the package go to stderr, as many as asked for."""
        level = (
            logging.ERROR if self.quiet else (logging.WARNING, logging.INFO, logging.DEBUG)[min(self.verbose, 2)]
        )
        log = logging.getLogger("aerosim")
        for old in [each for each in log.handlers if each.get_name() == "stderr"]:
            log.removeHandler(old)
        handler = logging.StreamHandler(sys.stderr)
        handler.set_name("stderr")
        handler.setLevel(level)
        handler.setFormatter(logging.Formatter("%(levelname)s: %(message)s"))
        log.addHandler(handler)
        log.setLevel(min(level, logging.INFO))


settings = Settings()


def _set_quiet(value: bool) -> bool:
    settings.quiet = value
    settings.start_log()
    return value


def _set_verbose(value: int) -> int:
    settings.verbose = value
    settings.start_log()
    return value


def _set_debug(value: bool) -> bool:
    settings.debug = value
    return value


Quiet = Annotated[
    bool, typer.Option("--quiet", "-q", callback=_set_quiet, help="No messages and no progress, results only.")
]
Verbose = Annotated[
    int,
    typer.Option(
        "--verbose",
        "-v",
        count=True,
        show_default=False,
        callback=_set_verbose,
        help="More messages; -vv still more.",
    ),
]
Debug = Annotated[
    bool, typer.Option("--debug", callback=_set_debug, is_eager=True, help="Show where an error comes from.")
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document, for programs.")]


def say(line: str) -> None:
    """One line for the user on stderr, unless quiet."""
    if not settings.quiet:
        print(line, file=sys.stderr)


def _json_value(value: Any) -> Any:
    if isinstance(value, PurePath):
        return str(value)
    return value.tolist()  # numpy's numbers and arrays; anything else is a fault of the caller


def print_json(value: object) -> None:
    """One JSON document on stdout; what JSON lacks (NaN) is refused."""
    print(json.dumps(value, indent=2, allow_nan=False, default=_json_value))


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value + 0.0:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    return str(value)


def _side_by_side(name: str, parts: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    """Equal mappings, one beside the other: a row for each key."""
    for key in parts[0]:
        yield f"{name}.{key}", "".join(f"{_cell(part.get(key)):<{_COLUMN}}" for part in parts).rstrip()


def _rows(data: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    for key, value in data.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            yield from _rows(value, f"{name}.")
        elif isinstance(value, (list, tuple)) and value and all(isinstance(each, Mapping) for each in value):
            if len(value) <= _BESIDE_MAX:
                yield from _side_by_side(name, value)
            else:
                yield from (row for i, each in enumerate(value) for row in _rows(each, f"{name}.{i}."))
        elif isinstance(value, (list, tuple)):
            yield name, ", ".join(_cell(each) for each in value)
        else:
            yield name, _cell(value)


def print_table(data: Mapping[str, Any]) -> None:
    """Nested values on stdout, one a line, by dotted key (with its unit); those of a few lines side by side."""
    rows = list(_rows(data))
    width = max((len(name) for name, _ in rows), default=0)
    for name, value in rows:
        print(f"{name:<{width}}  {value}")


def print_columns(rows: list[tuple[str, ...]]) -> None:
    """Rows on stdout, columns aligned, the last one cut to the terminal."""
    import shutil

    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]) - 1)] if rows else []
    room = shutil.get_terminal_size((_BARE_WIDTH, 24)).columns if sys.stdout.isatty() else 10**6
    for row in rows:
        line = "  ".join([*(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=False)), row[-1]])
        print(line if len(line) <= room else f"{line[: room - 3]}...")


def _left(started: float, share: float) -> str:
    seconds = (time.monotonic() - started) * (1 - share) / share
    return f"{seconds:.0f} s left" if seconds < 100 else f"{seconds / 60:.0f} min left"


def _plain_progress(label: str, unit: str) -> Progress:
    started, told = time.monotonic(), [0.0]

    def progress(done: float, total: float) -> None:
        share = done / total if total > 0 else 1.0
        if share >= told[0] + _PLAIN_SHARE and share < 1:
            told[0] = share
            print(f"{label}: {100 * share:.0f} % of {total:.0f} {unit}, {_left(started, share)}", file=sys.stderr)

    return progress


@contextmanager
def progress_of(label: str, unit: str = "s flown") -> Iterator[Progress | None]:
    """Progress of a flight or other work on stderr: a bar with the time left on a terminal, else lines by tenths.

    Gives a function of what is done and what there is in all; None if quiet.
    """
    if settings.quiet:
        yield None
    elif not sys.stderr.isatty():
        yield _plain_progress(label, unit)
    else:
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[flown]}"))
        with Bar(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True) as bar:
            task = bar.add_task(label, total=1.0, flown="")

            def progress(done: float, total: float) -> None:
                bar.update(
                    task, completed=done, total=total, flown=f"{done:.0f} of {total:.0f} {unit.partition(' ')[0]}"
                )

            yield progress
