"""`plan` and `check`: lines for an area, and what can be said of a flight before it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aerosim.cli.console import Debug, Json, Quiet, Verbose, print_columns, print_json, print_table, say
from aerosim.cli.flights import Seed, Settings, Source, placed, scenario_of
from aerosim.cli.terrain import DATUM_OPTION, Datum, datum_of
from aerosim.errors import InputError

if TYPE_CHECKING:
    from aerosim.forecast.check import Outlook

Out = Annotated[
    Path | None,
    typer.Option("--out", "-o", metavar="FILE", help="Write it to this .geojson, .kml or .csv (lines only)."),
]
Map = Annotated[Path | None, typer.Option("--map", metavar="FILE", help="Draw a map into this .png.")]
TrackMap = Annotated[
    Path | None,
    typer.Option(
        "--trackability", metavar="FILE", help="Draw where the rows will recognise the land into this .png."
    ),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace files that exist.")]

BESIDE_MAX = 8  # lines shown beside each other; more become a table
# of each line in a table: key, head
COLUMNS = {
    "course_deg": "course_deg", "length_m": "length_m", "duration_s": "time_s", "drift_deg": "drift_deg",
    "ground_speed_m_s": "speed_m_s", "photos": "photos", "photo_interval_s": "interval_s",
    "end_lap_highest_ground_pct": "end_lap_min_pct", "gsd_min_m": "gsd_min_m", "gsd_max_m": "gsd_max_m",
    "blur_px": "blur_px", "strips_accepted_pct": "strips_pct",
}  # fmt: skip


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"
    return "-" if value is None else str(value)


def _show(found: Mapping[str, Any], as_json: bool) -> None:
    """Figures on stdout, warnings on stderr as well."""
    for line in found.get("warnings", ()):
        say(f"warning: {line}")
    if as_json:
        print_json(found)
        return
    lines = found.get("lines") or ()
    if len(lines) <= BESIDE_MAX:
        print_table(found)
        return
    pairs = found.get("side_lap") or ()
    print_table({key: value for key, value in found.items() if key not in ("lines", "side_lap", "warnings")})
    print_columns([("name", *COLUMNS.values())] + [
        (str(line["name"]), *(_cell(line[key]) for key in COLUMNS)) for line in lines
    ])  # fmt: skip
    print_columns(
        [tuple(pairs[0])] + [tuple(_cell(each) for each in pair.values()) for pair in pairs] if pairs else []
    )


def _check_names(out: Path | None, picture: Path | None, overwrite: bool, track: Path | None = None) -> None:
    """What can be known about the files before the work is done."""
    if out is not None:
        from aerosim.formats.files import check_ending

        check_ending(out, "--out")
    for drawn, option in ((picture, "--map"), (track, "--trackability")):
        if drawn is not None and drawn.suffix.lower() != ".png":
            raise InputError(f"{drawn.name!r} is no picture", key=option, allowed="a name that ends in .png")
    if picture is not None and picture == track:
        raise InputError(f"{picture.name!r} is asked for twice", key="--trackability", allowed="another name")
    for file in (out, picture, track):
        if file is not None and file.exists() and not overwrite:
            raise InputError("file exists", where=str(file), allowed="another name, or --overwrite")


def _write(found: Outlook, out: Path | None, picture: Path | None, overwrite: bool, *, whole: bool) -> None:
    """The files asked for.  whole: photos and footprints besides the lines."""
    from aerosim.formats import files

    if out is not None:
        from aerosim.forecast import export

        shapes = export.everything(found) if whole and out.suffix.lower() != ".csv" else export.lines(found)
        files.write(out, shapes, title=str(found.figures["name"]), overwrite=overwrite)
        say(f"written: {out}")
    if picture is not None:
        from aerosim.report.plan_map import map_png

        files.save(picture, map_png(found), overwrite)
        say(f"written: {picture}")


def check(
    source: Source,
    *,
    seed: Seed = None,
    setting: Settings = None,
    out: Out = None,
    picture: Map = None,
    track: TrackMap = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Check a scenario and forecast its flight: plan, photos, laps, drift, duration; nothing is flown.

    --out writes lines, photo centres and footprints.
    """
    scenario = scenario_of(source, seed, setting)
    _check_names(out, picture, overwrite, track)
    try:
        if out is None and picture is None and track is None:
            from aerosim.forecast.check import forecast

            figures = forecast(scenario)
        else:
            from aerosim.forecast.check import outlook

            found = outlook(scenario)
            _write(found, out, picture, overwrite, whole=True)
            if track is not None:
                from aerosim.formats import files
                from aerosim.report.track_map import track_png

                files.save(track, track_png(found), overwrite)
                say(f"written: {track}")
            figures = found.figures
    except InputError as error:
        raise placed(scenario, error) from error
    _show(figures, as_json)
    return 0


def _pair_of(text: str, option: str) -> tuple[float, float]:
    """Two numbers with a comma between them."""
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{text!r} is no pair of numbers", key=option, allowed="230,230") from None
    return first, second


def _course_of(text: str) -> float | str:
    if text == "auto":
        return text
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{text!r} is no course", key="--course_deg", allowed="auto, or 0 to 360") from None


def _terrain_of(text: str, datum: str) -> dict[str, Any]:
    """Section `terrain` of a scenario from the options."""
    parts = text.split(",")
    if len(parts) > 2:
        raise InputError(f"{text!r} is no terrain", key="--terrain", allowed="NAME, or ORTHOPHOTO,ELEVATION")
    source = parts[0] if len(parts) == 1 else {"orthophoto": parts[0], "elevation": parts[1]}
    known = datum_of(datum)
    return {"source": source, "vertical_datum": known if isinstance(known, str) else {"undulation_m": known}}


# keys of the scenario in messages, as they are called here; those of the file AREA need no name
OPTIONS = {
    "terrain.source": "--terrain", "terrain.vertical_datum": DATUM_OPTION, "aircraft.model": "--aircraft",
    "air.wind": "--wind_m_s", "air.wind.speed_m_s": "--wind_m_s", "air.wind.from_deg": "--wind_from_deg",
    **dict.fromkeys(("flight.area", "flight.area.file", "flight.file"), ""),
    **{f"flight.{key}": f"--{key}" for key in ("height_m", "airspeed_m_s", "run_in_s", "bank_max_deg")},
    **{
        f"flight.area.{key}": f"--{key}"
        for key in ("course_deg", "side_lap_pct", "side_lap_min_pct", "photos_beyond", "order")
    },
    "control.end_lap_pct": "--end_lap_pct",
    **{
        f"frame_camera.{key}": f"--{key}"
        for key in ("focal_mm", "format_mm", "pixel_um", "exposure_s", "min_interval_s")
    },
}  # fmt: skip


HINTS = {
    "{orthophoto:, elevation:}": "ORTHOPHOTO,ELEVATION",
    "terrain.outside: mask flies it": "lines on the terrain; --terrain names another one",
    "frame_camera.min_interval_s": "--min_interval_s",
    "flight.height_m": "--height_m",
}


def _as_options(error: InputError, area: Path) -> InputError:
    """An error of the scenario that was made from the options, in their words."""
    key, problem, allowed = OPTIONS.get(error.key, error.key), error.problem, error.allowed
    for name, option in HINTS.items():
        problem, allowed = problem.replace(name, option), allowed.replace(name, option)
    return InputError(problem, key, allowed, error.where or ("" if key else str(area)))


def _by_height(error: InputError, gsd_m: float | None, height: float) -> InputError:
    """An error about a height that follows from the ground sampling distance."""
    if gsd_m is None or error.key != "flight.height_m":
        return error
    allowed = error.allowed.removeprefix("allowed: ")
    if error.problem.endswith("is out of range"):
        return InputError(f"{gsd_m:g} m is flown at {height:.0f} m", "--gsd_m", f"a height of {allowed} m")
    return InputError(f"{gsd_m:g} m: {error.problem}", "--gsd_m", allowed, error.where)


def plan(
    area: Annotated[Path, typer.Argument(metavar="AREA", help="GeoJSON, KML or CSV: one polygon, or lines.")],
    *,
    terrain: Annotated[
        str, typer.Option("--terrain", metavar="NAME|ORTHOPHOTO,ELEVATION", help="The land.")
    ] = "pine_mountain",
    vertical_datum: Datum = "file",
    height_m: Annotated[
        float | None, typer.Option("--height_m", help="Above the mean terrain.  [3000, or from --gsd_m]")
    ] = None,
    gsd_m: Annotated[
        float | None, typer.Option("--gsd_m", help="Pixel on the mean ground: gives the height.")
    ] = None,
    side_lap_pct: Annotated[float, typer.Option("--side_lap_pct", help="Over the mean ground.")] = 30.0,
    side_lap_min_pct: Annotated[
        float | None, typer.Option("--side_lap_min_pct", help="Nowhere less.  [10, or --side_lap_pct if less]")
    ] = None,
    end_lap_pct: Annotated[float, typer.Option("--end_lap_pct", help="Of photos on a line.")] = 60.0,
    course_deg: Annotated[
        str,
        typer.Option("--course_deg", metavar="auto|DEG", help="Of the lines; auto: the least number of lines."),
    ] = "auto",
    order: Annotated[str, typer.Option("--order", help="sequential, race_track or shortest.")] = "sequential",
    photos_beyond: Annotated[
        int, typer.Option("--photos_beyond", help="Photos before and after the area on each line.")
    ] = 1,
    focal_mm: Annotated[float, typer.Option("--focal_mm", help="Of the frame camera.")] = 152.0,
    format_mm: Annotated[
        str, typer.Option("--format_mm", metavar="ALONG,ACROSS", help="Its picture.")
    ] = "230,230",
    pixel_um: Annotated[float, typer.Option("--pixel_um", help="Its pixel.")] = 12.0,
    exposure_s: Annotated[float, typer.Option("--exposure_s", help="Its exposure time.")] = 0.003,
    min_interval_s: Annotated[float, typer.Option("--min_interval_s", help="Its shortest interval.")] = 2.0,
    airspeed_m_s: Annotated[float, typer.Option("--airspeed_m_s", help="True airspeed.")] = 69.44,
    wind_m_s: Annotated[float, typer.Option("--wind_m_s", help="Wind speed.")] = 0.0,
    wind_from_deg: Annotated[float, typer.Option("--wind_from_deg", help="Where the wind comes from.")] = 0.0,
    run_in_s: Annotated[float, typer.Option("--run_in_s", help="Straight flight before each line.")] = 60.0,
    bank_max_deg: Annotated[float, typer.Option("--bank_max_deg", help="Steepest bank in the turns.")] = 20.0,
    aircraft: Annotated[str, typer.Option("--aircraft", metavar="NAME", help="Which one.")] = "survey_twin",
    out: Out = None,
    picture: Map = None,
    overwrite: Overwrite = False,
    as_json: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Plan the lines that cover an area, and forecast their flight; nothing is flown.

    --out writes the lines, to be named in a scenario (flight.file).
    """
    _check_names(out, picture, overwrite)
    if height_m is not None and gsd_m is not None:
        raise InputError("given twice", key="--gsd_m", allowed="--height_m or --gsd_m")
    for option, value in (
        ("--height_m", height_m),
        ("--gsd_m", gsd_m),
        ("--focal_mm", focal_mm),
        ("--pixel_um", pixel_um),
    ):
        if value is not None and not 0.0 < value < float("inf"):
            raise InputError(f"{value:g} is out of range", key=option, allowed="more than 0")
    height = gsd_m * focal_mm / pixel_um * 1e3 if gsd_m is not None else height_m or 3000.0
    settings: dict[str, Any] = {
        "name": re.sub(r"[^A-Za-z0-9_-]", "_", area.stem)[:60].lstrip("_-") or "plan",
        "terrain": _terrain_of(terrain, vertical_datum),
        "air": {"wind": {"speed_m_s": wind_m_s, "from_deg": wind_from_deg}},
        "aircraft": {"model": aircraft},
        "flight": {
            "height_m": height, "airspeed_m_s": airspeed_m_s, "run_in_s": run_in_s, "bank_max_deg": bank_max_deg,
        },
        "control": {"end_lap_pct": end_lap_pct},
        "frame_camera": {
            "focal_mm": focal_mm, "format_mm": _pair_of(format_mm, "--format_mm"), "pixel_um": pixel_um,
            "exposure_s": exposure_s, "min_interval_s": min_interval_s,
        },
    }  # fmt: skip
    from aerosim.forecast.planner import plan_file

    least = min(side_lap_pct, 10.0) if side_lap_min_pct is None else side_lap_min_pct
    wanted = {
        "course_deg": _course_of(course_deg), "side_lap_pct": side_lap_pct, "side_lap_min_pct": least,
        "photos_beyond": photos_beyond, "order": order,
    }  # fmt: skip
    try:
        found = plan_file(area, settings, wanted)
    except InputError as error:
        raise _as_options(_by_height(error, gsd_m, height), area) from error
    _write(found, out, picture, overwrite, whole=False)
    _show(found.figures, as_json)
    return 0
