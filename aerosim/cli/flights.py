"""`run`: fly a scenario."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aerosim.cli.console import Debug, Json, Quiet, Verbose, print_json, print_table, progress_of, say
from aerosim.errors import InputError, RunFailure

if TYPE_CHECKING:
    from aerosim.scenario import Scenario

Source = Annotated[str, typer.Argument(metavar="SCENARIO", help="A scenario file, or a shipped name.")]
Seed = Annotated[int | None, typer.Option("--seed", metavar="N", help="Seed of all random numbers.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY.PATH=VALUE", help="Replace a value of the scenario; may be repeated."),
]

# what a person wants to see first; the rest is in summary.json and the report
HEADLINES = (
    "flight.drift_mean_deg",
    "crab.residual_rms_deg",
    "crab.residual_max_deg",
    "crab.estimate_error_rms_deg",
    "crab.accepted_pct",
    "vh.error_rms_pct",
    "photos.count",
    "photos.end_lap_mean_pct",
    "photos.end_lap_error_rms_pct",
    "photos.end_lap_min_pct",
    "photos.blur_rms_px",
    "speed.real_time_factor",
)


def scenario_of(source: str, seed: int | None, settings: list[str] | None) -> Scenario:
    """Scenario with the options of the command line put in."""
    from aerosim.scenario import Override, load, parse_setting

    overrides = [parse_setting(text) for text in settings or []]
    if seed is not None:
        overrides.append(Override("seed", seed, "--seed"))
    return load(source, overrides)


def placed(scenario: Scenario, error: InputError) -> InputError:
    """An error found behind the scenario (terrain, aircraft), with file and line of its key."""
    return scenario.place(error) if error.key and not error.key.startswith("-") else error


def _headlines(summary: dict[str, Any]) -> dict[str, Any]:
    found = {}
    for path in HEADLINES:
        part, name = path.split(".")
        found[path] = (summary.get(part) or {}).get(name)
    return found


def run(
    source: Source,
    *,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="DIR", help="Run directory.  [runs/<name>/<seed>]")
    ] = None,
    seed: Seed = None,
    setting: Settings = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace an earlier run in that directory.")
    ] = False,
    live: Annotated[bool, typer.Option("--live", help="Show the flight in the viewer while it runs.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Fly a scenario; the last line printed is the run directory."""
    if live:
        raise InputError("is not available in this version", key="--live", allowed="aerosim view RUN, afterwards")
    scenario = scenario_of(source, seed, setting)
    import aerosim
    from aerosim.metrics.consistency import overconfident
    from aerosim.metrics.expect import check_expect
    from aerosim.metrics.summary import lines_not_seen

    try:
        with progress_of(scenario.name) as progress:
            done = aerosim.run(scenario, out, overwrite=overwrite, progress=progress)
    except InputError as error:
        raise placed(scenario, error) from error
    except (KeyboardInterrupt, RunFailure) as end:
        path = getattr(end, "path", None)
        if as_json and path is not None:
            kept = aerosim.open_run(path)
            print_json({"run": str(path), "status": kept.status, "reason": str(end), "summary": kept.summary})
            end.path = None  # type: ignore[union-attr]
        elif path is not None and isinstance(end, KeyboardInterrupt):
            print(path)  # the record up to there
        raise
    for line in (*lines_not_seen(done.summary), *overconfident(done.summary).values()):
        say(f"warning: {line}")
    unmet = check_expect(done.summary, scenario.expect)
    if as_json:
        print_json({"run": str(done.path), "status": done.status, "unmet": unmet, "summary": done.summary})
        return 1 if unmet else 0
    if not quiet:
        print_table(_headlines(done.summary))
        if scenario.expect:
            print("expect: met" if not unmet else "\n".join(f"expect not met: {line}" for line in unmet))
    print(done.path)
    return 1 if unmet else 0
