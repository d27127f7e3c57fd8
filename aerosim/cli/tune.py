"""`tune`: what a filter ought to assume, out of recorded flights and a navigator's notes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from aerosim.cli.console import Debug, Json, Quiet, Verbose, print_json
from aerosim.errors import InputError

EPILOG = """\
Examples:

aerosim tune --count 3.5 --size_deg 2.5 --duration_s 172.8

aerosim tune --count 1 --size_deg 3 --duration_s 40

(three to four corrections of 2.5 deg on 12 km at 250 km/h, and the paper's b2)

aerosim tune rates.csv --height_agl_m 3000 --ground_speed_m_s 70

aerosim tune runs/low runs/high --corrections notes.csv --out table.yaml

then, in a scenario:  estimation: {table: table.yaml}
"""


def _number(option: str, metavar: str, text: str) -> Any:
    return typer.Option(option, metavar=metavar, help=text, show_default=False)


def tune(
    sources: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="RUN|RATES.csv",
            help="Run directories (v/h from the photos of control.mode: fixed), or CSV files: t_s, roll_deg or "
            "p_deg_s, and pitch_deg or q_deg_s, drift_deg, height_agl_m, ground_speed_m_s.",
        ),
    ] = None,
    *,
    corrections: Annotated[
        Path | None,
        _number("--corrections", "FILE", "A navigator's corrections of drift: CSV with t_s, correction_deg."),
    ] = None,
    count: Annotated[float | None, _number("--count", "N", "Or their number ...")] = None,
    size_deg: Annotated[float | None, _number("--size_deg", "DEG", "... and size ...")] = None,
    duration_s: Annotated[float | None, _number("--duration_s", "S", "... within this time, or ...")] = None,
    route_km: Annotated[
        float | None, _number("--route_km", "KM", "... on a route of this length, at --ground_speed_m_s.")
    ] = None,
    ground_speed_m_s: Annotated[
        float | None, _number("--ground_speed_m_s", "M/S", "Of the route, and of CSV files without that column.")
    ] = None,
    height_agl_m: Annotated[
        float | None, _number("--height_agl_m", "M", "Height above ground of CSV files without that column.")
    ] = None,
    corrections_agl_m: Annotated[
        float | None,
        _number("--corrections_agl_m", "M", "Height of the corrections: b2 T is then the same at all heights."),
    ] = None,
    crab_walk_deg2_per_s: Annotated[
        float | None, _number("--crab_walk_deg2_per_s", "B2", "b2 of the drift, instead of a measured one.")
    ] = None,
    vh_walk_pct2_per_s: Annotated[
        float | None, _number("--vh_walk_pct2_per_s", "B2", "b2 of v/h, instead of a measured one.")
    ] = None,
    spacing_px: Annotated[float, typer.Option("--spacing_px", help="Of the rows, for CSV files.")] = 39.7,
    focal_px: Annotated[float, typer.Option("--focal_px", help="Of the rows, for CSV files.")] = 132.6,
    out: Annotated[
        Path | None, _number("--out", "FILE", "Write the table over height (YAML), for estimation.table.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace that file.")] = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Estimate what the filters ought to assume of drift and v/h: b2 and N0, by height.

    b2 of the drift from a navigator's corrections, or from the recorded drift; N0 from roll and pitch over the
    time of a strip; b2 of v/h from the end laps of photos taken without v/h control (control.mode: fixed).
    """
    for option, value in {
        "--count": count, "--size_deg": size_deg, "--duration_s": duration_s, "--route_km": route_km,
        "--ground_speed_m_s": ground_speed_m_s, "--height_agl_m": height_agl_m,
        "--corrections_agl_m": corrections_agl_m, "--crab_walk_deg2_per_s": crab_walk_deg2_per_s,
        "--vh_walk_pct2_per_s": vh_walk_pct2_per_s, "--spacing_px": spacing_px, "--focal_px": focal_px,
    }.items():  # fmt: skip
        if value is not None and not 0.0 < value < float("inf"):
            raise InputError(f"{value:g} is out of range", key=option, allowed="more than 0")
    from aerosim.tune.corrections import Corrections, correction_figures, walk_of
    from aerosim.tune.heights import DEG2, PCT2, Given, at_height, figures, write_table
    from aerosim.tune.records import Geometry, of_rates, of_run

    walk = walk_of(Corrections(corrections, count, size_deg, duration_s, route_km, ground_speed_m_s))
    if walk is not None and crab_walk_deg2_per_s is not None:
        raise InputError("is given besides corrections", key="--crab_walk_deg2_per_s", allowed="one of the two")
    if corrections_agl_m is not None and walk is None:
        raise InputError("has no effect without corrections", key="--corrections_agl_m")
    if height_agl_m is not None and not any(source.suffix.lower() == ".csv" for source in sources or ()):
        raise InputError("has no effect without a CSV file of rates", key="--height_agl_m")
    if walk is None and not sources:
        raise InputError("nothing to tune from", key="tune", allowed="runs, CSV files, or corrections")
    crab = crab_walk_deg2_per_s / DEG2 if crab_walk_deg2_per_s is not None else None
    given = Given(
        walk.squares.value if walk is not None else crab,
        vh_walk_pct2_per_s / PCT2 if vh_walk_pct2_per_s is not None else None,
        corrections_agl_m,
    )
    rows = Geometry(spacing_px, focal_px, 96)
    heights = []
    for source in sources or ():
        is_csv = source.suffix.lower() == ".csv"
        record = of_rates(source, height_agl_m, ground_speed_m_s, rows) if is_csv else of_run(source)
        heights.append(at_height(record, given))
    found: dict[str, Any] = {
        "corrections": None if walk is None else correction_figures(walk),
        "heights": [figures(each) for each in sorted(heights, key=lambda one: one.height)],
        "table": None,
    }
    if out is not None:
        if not heights:
            raise InputError("corrections alone make no table", key="--out", allowed="runs or CSV files besides")
        found["table"] = {"file": str(out), "rows": write_table(heights, out, overwrite)}
    print_json(found) if as_json else _show(found)
    return 0


def _between(found: dict[str, float] | None) -> str:
    return "-" if found is None else f"{found['value']:.3g}  [{found['low']:.2g}, {found['high']:.2g}]"


def _show(found: dict[str, Any]) -> None:
    """Tables on stdout; brackets hold 95 % limits."""
    from rich.console import Console
    from rich.table import Table

    console = Console(file=sys.stdout, highlight=False, markup=False)
    if found["corrections"] is not None:
        table = Table("b2 of the drift from corrections", "deg2/s")
        table.add_row("sum of squares over the time", _between(found["corrections"]["walk_deg2_per_s"]))
        largest = found["corrections"]["largest_each_interval_deg2_per_s"]
        table.add_row("the largest in each interval", f"{largest:.3g}")
        console.print(table)
    if found["heights"]:
        table = Table("above ground", *(f"{each['height_agl_m']:.0f} m" for each in found["heights"]))
        for name, cell in _LINES.items():
            cells = [cell(each) for each in found["heights"]]
            if set(cells) != {"-"}:
                table.add_row(name, *cells)
        console.print(table)
        console.print("in brackets: 95 % limits")
    if found["table"] is not None:
        print(found["table"]["file"])


def _of(*keys: str) -> Any:
    def cell(figures: dict[str, Any]) -> str:
        value: Any = figures
        for key in keys:
            value = None if value is None else value[key]
        return _between(value) if isinstance(value, dict) else "-" if value is None else f"{value:.3g}"

    return cell


_LINES = {
    "v/h [1/s]": _of("vh_per_s"),
    "time of a strip T [s]": _of("strip_time_s"),
    "drift: b2 [deg2/s]": _of("crab", "walk_deg2_per_s"),
    "drift: N0 [deg2]": _of("crab", "noise_deg2"),
    "drift: sigma [deg]": _of("crab", "sigma_deg"),
    "drift: gamma = b2 T/N0": _of("crab", "gamma"),
    "v/h: b2 [%2/s]": _of("vh", "walk_pct2_per_s"),
    "v/h: N0 [%2]": _of("vh", "noise_pct2"),
    "v/h: sigma [%]": _of("vh", "sigma_pct"),
    "v/h: gamma = b2 T/N0": _of("vh", "gamma"),
    "photos: greatest n error [%]": _of("photos", "greatest_n_error_pct"),
    "photos: b2 from it [%2/s]": _of("photos", "greatest_walk_pct2_per_s"),
    "photos: b2 by their spread [%2/s]": _of("photos", "walk_pct2_per_s"),
    "photos: N0 of an overlap [%2]": _of("photos", "noise_pct2"),
}
