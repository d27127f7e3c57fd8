"""`terrain info`, `make` and `mirror`: what a terrain is, and land for a flight that has none, or too little."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from aerosim.cli.console import Debug, Json, Quiet, Verbose, print_json, print_table, progress_of, say
from aerosim.errors import InputError

if TYPE_CHECKING:
    from aerosim.world.features import Feature
    from aerosim.world.terrain import Terrain

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


def _opened(source: str, elevation: Path | None, datum: str) -> Terrain:
    """The terrain of the arguments, its errors with the names that keys have here.  Raises InputError."""
    try:
        return _open(source, elevation, datum_of(datum))
    except InputError as error:
        allowed = error.allowed.replace("{orthophoto:, elevation:}", "ORTHOPHOTO ELEVATION")
        raise replace(error, key=OPTION_OF.get(error.key, error.key), allowed=allowed) from error


def _open(source: str, elevation: Path | None, datum: str | float) -> Terrain:
    from aerosim.world.terrain import Terrain, find_terrain

    if elevation is None and Path(source).suffix and not Path(source).exists():
        raise InputError("no such file", where=source, allowed="ORTHOPHOTO ELEVATION, or the name of a terrain")
    if elevation is None and Path(source).is_file():
        raise InputError(
            "an orthophoto needs its elevation beside it", where=source, allowed="ORTHOPHOTO ELEVATION"
        )
    files = find_terrain(source) if elevation is None else (Path(source), elevation)
    return Terrain.open(*files, vertical_datum=datum)


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
    found = _opened(source, elevation, vertical_datum).info()
    (print_json if as_json else print_table)(found)
    return 0


# options of a feature: name of the field, factor to SI
FEATURE_KEYS = {
    "width_m": ("width", 1.0), "period_m": ("period", 1.0), "course_deg": ("course", math.radians(1.0)),
    "rest_pct": ("rest", 0.01), "lat_deg": ("lat", math.radians(1.0)), "lon_deg": ("lon", math.radians(1.0)),
}  # fmt: skip


def feature_of(text: str) -> Feature:
    """A feature of the land from `KIND:key=value,...`.  Raises InputError."""
    from aerosim.world.features import Feature

    kind, _, rest = text.partition(":")
    found: dict[str, float] = {}
    for part in filter(None, rest.split(",")):
        key, _, value = part.partition("=")
        if key not in FEATURE_KEYS:
            raise InputError(f"no key {key!r} of a feature", key="--feature", allowed=", ".join(FEATURE_KEYS))
        name, factor = FEATURE_KEYS[key]
        try:
            found[name] = factor * float(value)
        except ValueError:
            raise InputError(f"{value!r} is no number", key="--feature", allowed=f"{key}=NUMBER") from None
    lat, lon = found.pop("lat", None), found.pop("lon", None)
    if (lat is None) != (lon is None):
        raise InputError("one of lat_deg and lon_deg", key="--feature", allowed="both, or none")
    centre = None if lat is None or lon is None else (lat, lon)
    return Feature(kind, centre=centre, **found)


def _pixel(pixel_m: float | None, above: float) -> tuple[float, float]:
    """Pixel of the orthophoto, and of the rows on the ground, m.  above: flying height over the ground, m."""
    # a pixel of the rows sees 1/132.6 of the height; the ground is read at half of that, a third is finer
    detail = max(above, 200.0) / 132.6
    return (pixel_m if pixel_m is not None else max(round(detail / 3.0, 1), 0.5)), detail


@app.command()
def make(
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="New folder for the two files.")],
    around: Annotated[
        str,
        typer.Option(
            "--around",
            metavar="FILE|LAT,LON",
            help="A trajectory, lines or an area (.geojson, .kml, .csv), or a point in deg.",
        ),
    ],
    *,
    margin_m: Annotated[float, typer.Option("--margin_m", help="Land to either side.")] = 5000.0,
    height_m: Annotated[float, typer.Option("--height_m", help="Mean of the land, above the ellipsoid.")] = 0.0,
    relief_m: Annotated[float, typer.Option("--relief_m", help="Standard deviation of its heights.")] = 0.0,
    flown_m: Annotated[
        float | None,
        typer.Option(
            "--flown_m",
            show_default=False,
            help="Flying height above the ellipsoid, which sets how fine the land is.  "
            "[that of the trajectory, else 3000 m above the land]",
        ),
    ] = None,
    pixel_m: Annotated[
        float | None,
        typer.Option("--pixel_m", show_default=False, help="Of the orthophoto.  [a third of a row's pixel]"),
    ] = None,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Another seed is other land.")] = 1,
    feature: Annotated[
        list[str] | None,
        typer.Option(
            "--feature",
            metavar="KIND[:KEY=VALUE,...]",
            show_default=False,
            help="A square of hard land: lake, rows (ploughed, stripes) or lattice; keys width_m, period_m, "
            "course_deg, rest_pct, lat_deg, lon_deg.  [all over; in the middle; again for more]",
        ),
    ] = None,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Make synthetic land for a flight: textured orthophoto and elevation, as two GeoTIFF files.

    The last lines printed are the files: orthophoto, elevation.
    """
    from aerosim.forecast.around import around as ways_of
    from aerosim.world.synthetic import Ground, make_terrain

    found = ways_of(around)
    flown = flown_m if flown_m is not None else found.height
    above = 3000.0 if flown is None else flown - height_m
    if above < 100.0:
        raise InputError(
            f"land at {height_m:g} m is {above:.0f} m below the flight", key="--height_m", allowed="100 m and more"
        )
    pixel, detail = _pixel(pixel_m, above)
    ground = Ground(
        height_m, relief_m, pixel, max(25.0, 4.0 * pixel), detail, seed, tuple(map(feature_of, feature or ()))
    )
    say(f"land with pixels of {pixel:g} m, for a flight {above:.0f} m above it")
    with progress_of("land", "tiles") as progress:
        files = make_terrain(found.ways, margin_m, ground, out, progress)
    for file in files:
        print(file)
    return 0


@app.command()
def mirror(
    source: Annotated[str, typer.Argument(metavar="NAME|ORTHOPHOTO", help="A shipped terrain, or an orthophoto.")],
    elevation: Annotated[
        Path | None, typer.Argument(metavar="[ELEVATION]", help="The elevation model of it.")
    ] = None,
    *,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="New folder for the two files.")],
    length_m: Annotated[float, typer.Option("--length_m", help="Of the strip.")],
    along: Annotated[
        str, typer.Option("--along", metavar="north|east", help="Where it goes from the land's edge.")
    ] = "north",
    vertical_datum: Datum = "file",
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Make a long strip out of short land: repeated, every second time mirrored, so that it has no seams.

    The last lines printed are the files: orthophoto, elevation.
    """
    from aerosim.world.mirror import mirror_terrain

    terrain = _opened(source, elevation, vertical_datum)
    with progress_of("land", "tiles") as progress:
        files = mirror_terrain(terrain, length_m, out, along, progress)
    for file in files:
        print(file)
    return 0
