"""`terrain info`: what a terrain is, before a flight over it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from aerosim.cli.console import Debug, Json, Quiet, Verbose, print_json, print_table
from aerosim.errors import InputError

DATUM_OPTION = "--vertical-datum"
# keys of the scenario in the errors of the terrain, as they are called here
OPTION_OF = {"terrain.source": "", "terrain.vertical_datum": DATUM_OPTION}

app = typer.Typer(help="Terrain: what ships, and what a user's own files are.", no_args_is_help=False)

Datum = Annotated[
    str,
    typer.Option(
        DATUM_OPTION,
        metavar="DATUM",
        help="Elevations are above: file, ellipsoidal, egm96, egm2008, or the undulation as a number of m.",
    ),
]


def datum_of(text: str) -> str | float:
    """Vertical datum of an option: a word, or a constant undulation in m.  Raises InputError."""
    from aerosim.scenario.terrain import DATUMS

    if text in DATUMS:
        return text
    # as a scenario has it, {undulation_m: 28.3}, or the number alone
    number = text.strip("{} ").removeprefix("undulation_m:")
    try:
        return float(number)
    except ValueError:
        allowed = f"allowed: {', '.join(DATUMS)}, or the undulation in m"
        raise InputError(f"{text!r} is no vertical datum", key=DATUM_OPTION, allowed=allowed) from None


def _info(source: str, elevation: Path | None, datum: str | float) -> dict[str, Any]:
    from aerosim.world.terrain import Terrain, find_terrain

    if elevation is None and Path(source).is_file():
        raise InputError(
            "an orthophoto needs its elevation beside it", where=source, allowed="ORTHOPHOTO ELEVATION"
        )
    files = find_terrain(source) if elevation is None else (Path(source), elevation)
    return Terrain.open(*files, vertical_datum=datum).info()


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
    try:
        found = _info(source, elevation, datum_of(vertical_datum))
    except InputError as error:
        raise replace(error, key=OPTION_OF.get(error.key, error.key)) from error
    (print_json if as_json else print_table)(found)
    return 0
