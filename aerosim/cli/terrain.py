"""`terrain info`: what a terrain is, before a flight over it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from aerosim.cli.console import Debug, Json, Quiet, Verbose, print_json, print_table
from aerosim.errors import InputError

app = typer.Typer(help="Terrain: what ships, and what a user's own files are.", no_args_is_help=False)

Datum = Annotated[
    str,
    typer.Option(
        "--vertical-datum",
        metavar="DATUM",
        help="Elevations are above: file, ellipsoidal, egm96, egm2008, or the undulation as a number of m.",
    ),
]


def datum_of(text: str) -> str | dict[str, float]:
    """Vertical datum of an option, as the scenario has it.  Raises InputError."""
    from aerosim.scenario.terrain import DATUMS

    if text in DATUMS:
        return text
    try:
        undulation = float(text)
    except ValueError:
        undulation = float("nan")
    if not abs(undulation) <= 120:
        allowed = f"allowed: {', '.join(DATUMS)}, or the undulation in m"
        raise InputError(f"{text!r} is no vertical datum", key="--vertical-datum", allowed=allowed)
    return {"undulation_m": undulation}


def _info(source: str, elevation: Path | None, datum: str) -> dict[str, Any]:
    from aerosim.world.terrain import Terrain, find_terrain

    if elevation is None:
        orthophoto, elevation_file = find_terrain(source)
    else:
        orthophoto, elevation_file = Path(source), elevation
    terrain = Terrain.open(orthophoto, elevation_file, vertical_datum=datum_of(datum))
    return dict(terrain.info())


@app.callback()
def _terrain() -> None:
    """Terrain: what ships, and what a user's own files are."""


@app.command()
def info(
    source: Annotated[str, typer.Argument(metavar="NAME|ORTHOPHOTO", help="A shipped terrain, or an orthophoto.")],
    elevation: Annotated[
        Path | None, typer.Argument(metavar="[ELEVATION]", help="The elevation model of it.")
    ] = None,
    *,
    vertical_datum: Datum = "file",
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Print extent, resolution, reference system, vertical datum and heights of a terrain."""
    found = _info(source, elevation, vertical_datum)
    (print_json if as_json else print_table)(found)
    return 0
