"""`sweep`: fly a scenario many times, some of its values varied."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aerosim.cli.console import (
    Debug,
    Json,
    Quiet,
    Verbose,
    print_columns,
    print_json,
    print_table,
    progress_of,
    say,
)
from aerosim.cli.flights import Settings
from aerosim.errors import InputError

if TYPE_CHECKING:
    from aerosim.sweep.results import Sweep

FAILED = 3


def sweep(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SCENARIO|SWEEP",
            help="A scenario, a sweep file, the name of a shipped one, or a sweep's directory.",
        ),
    ],
    *,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="KEY=A,B,C|LOW:HIGH:STEP|LOW..HIGH",
            help="Values of a key; may be repeated.  LOW..HIGH: for a Latin hypercube.",
        ),
    ] = None,
    seeds: Annotated[
        int | None, typer.Option("--seeds", metavar="N", help="Seeds 1 to N are flown at every point.  [1]")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Sweep directory.  [sweeps/<name>]")
    ] = None,
    setting: Settings = None,
    sampling: Annotated[
        str | None, typer.Option("--sampling", help="grid, list or latin_hypercube.  [grid]")
    ] = None,
    samples: Annotated[
        int | None, typer.Option("--samples", metavar="N", help="Points of a Latin hypercube.")
    ] = None,
    sampling_seed: Annotated[
        int | None, typer.Option("--sampling-seed", metavar="N", help="Draws the hypercube.  [1]")
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option("--workers", metavar="K", help="Processes; 0: in this one.  [one for each core]"),
    ] = None,
    dask: Annotated[
        str | None, typer.Option("--dask", metavar="ADDRESS", help="Scheduler of a Dask cluster instead.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the directory.")] = False,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Fly its failed runs again; implies --resume.")
    ] = False,
    stop_when: Annotated[
        str | None,
        typer.Option(
            "--stop-when",
            metavar="METRIC:HALFWIDTH|METRIC:PERCENT%",
            help="Stop when 95 % confidence limits are this narrow at every point; %: of the mean.",
        ),
    ] = None,
    keep: Annotated[
        str | None,
        typer.Option("--keep", metavar="records|summaries", help="What is kept of each run.  [summaries]"),
    ] = None,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Fly a scenario many times, some values varied, the same seeds for all; the last line is the directory."""
    settings = {
        "seeds": seeds, "sampling": sampling, "samples": samples, "sampling_seed": sampling_seed, "keep": keep,
        "stop_when": stop_when,
    }  # fmt: skip
    from aerosim.scenario import parse_setting
    from aerosim.sweep.start import start
    from aerosim.sweep.vary import parse_vary

    overrides = [parse_setting(text) for text in setting or []]
    values: dict[str, Any] = {}
    for text in vary or []:
        key, each = parse_vary(text)
        if key in values:
            raise InputError("is varied twice", key=f"--vary {key}", allowed=f"one --vary {key} with all values")
        values[key] = each
    given = {key: value for key, value in settings.items() if value is not None}
    where = {"out": out, "workers": workers, "dask": dask, "resume": resume, "retry_failed": retry_failed}
    try:
        with progress_of("sweep", "runs") as progress:
            done = start(source, values, given, overrides, **where, progress=progress, option="--vary")  # type: ignore[arg-type]
    except KeyboardInterrupt as stop:
        if path := getattr(stop, "path", None):
            say(f"it goes on with: aerosim sweep {path} --resume")
            print(path)
        raise
    return _shown(done, as_json, quiet)


def _shown(done: Sweep, as_json: bool, quiet: bool) -> int:
    """Figures and reasons; returns the exit code: failed if no run was done."""
    summary = done.summary
    if as_json:
        print_json({"sweep": str(done.path), **summary})
    else:
        if not quiet:
            print_table({key: value for key, value in summary.items() if key != "reasons"})
        if summary["reasons"]:
            reasons = [(str(each["runs"]), each["reason"]) for each in summary["reasons"]]
            print_columns([("runs", "failed because"), *reasons])
        print(done.path)
    if summary["failed"] and not summary["done"]:
        say("run failed: no run of the sweep was done")
        return FAILED
    if summary["failed"]:
        say(f"{summary['failed']} runs failed; --retry-failed flies them again")
    return 0
