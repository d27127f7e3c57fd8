"""What map files hold for a survey: lines, areas, photos; and the way to them by a file's name."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

from aerosim.errors import InputError

Kind = Literal["line", "area", "photo", "footprint"]
Property = str | int | float | None

BYTES_MAX = 50_000_000
ENDINGS = ".geojson, .json, .kml, .csv"


class Feature(NamedTuple):
    """One line, area, photo centre or footprint.

    points: latitude, longitude, rad; an area's or footprint's ring without the repeated first point.  height:
    ellipsoidal, m, if known.  properties: names carry their units.  where: place in the file it was read from.
    """

    kind: Kind
    points: tuple[tuple[float, float], ...]
    name: str = ""
    height: float | None = None
    properties: Mapping[str, Property] = {}
    where: str = ""


Reader = Callable[[str, str], list[Feature]]
Writer = Callable[[Sequence[Feature], str], str]


def _module(path: Path, key: str) -> tuple[Reader, Writer]:
    from aerosim.formats import csvlines, geojson, kml

    known: dict[str, tuple[Reader, Writer]] = {
        ".geojson": (geojson.parse, geojson.text),
        ".json": (geojson.parse, geojson.text),
        ".kml": (kml.parse, kml.text),
        ".csv": (csvlines.parse, csvlines.text),
    }
    if path.suffix.lower() not in known:
        hint = "; unpack the .kmz first" if path.suffix.lower() == ".kmz" else ""
        raise InputError(
            f"format {path.suffix or 'without ending'} is not known",
            key=key,
            allowed=f"{ENDINGS}{hint}",
            where="" if key else str(path),
        )
    return known[path.suffix.lower()]


def read(path: Path) -> list[Feature]:
    """Lines and areas of a GeoJSON, KML or CSV file, by its ending; photos and footprints of ours left out.

    Raises InputError with the place in the file: not readable, wrong format, unknown geometry, no number, latitude
    and longitude out of range.
    """
    parse, _ = _module(path, "")
    try:
        with path.open("rb") as stream:
            data = stream.read(BYTES_MAX + 1)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=str(path)) from error
    if len(data) > BYTES_MAX:
        raise InputError("is too large for lines or an area", allowed="at most 50 MB", where=str(path))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("is not a text file", allowed=f"{ENDINGS}, UTF-8", where=str(path)) from error
    if not text.strip():
        raise InputError("is empty", allowed="survey lines, or the outline of an area", where=str(path))
    found = [each for each in parse(text, str(path)) if each.kind in ("line", "area")]
    if not found:
        raise InputError("holds neither a line nor an area", allowed="a LineString or a Polygon", where=str(path))
    return found


def check_ending(path: Path, key: str) -> None:
    """Raise InputError for a file name from which no format follows.  key: option that named it."""
    _module(path, key)


def write(path: Path, features: Sequence[Feature], *, title: str, overwrite: bool = False) -> None:
    """Write features in the format of the file's ending: GeoJSON, KML, or CSV (lines only).

    Raises InputError for an unknown ending, a file that exists, or one that cannot be written; nothing is left
    behind then.
    """
    _, text = _module(path, "--out")
    save(path, text(features, title).encode(), overwrite)


def save(path: Path, data: bytes, overwrite: bool) -> None:
    """Write a file whole or not at all.  Raises InputError: it exists, or cannot be written."""
    if path.exists() and not overwrite:
        raise InputError("file exists", where=str(path), allowed="another name, or --overwrite")
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(data)
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InputError(f"cannot be written: {error.strerror}", where=str(path)) from error


def place_of(longitude: object, latitude: object, where: str) -> tuple[float, float]:
    """Latitude and longitude, rad, of values in degrees.  Raises InputError for what is no place on Earth."""
    values = []
    for name, value in (("longitude", longitude), ("latitude", latitude)):
        try:
            number = math.nan if isinstance(value, bool) else float(value)  # type: ignore[arg-type]
        except (TypeError, ValueError):
            raise InputError(f"{name} {value!r} is not a number", where=where, allowed="degrees") from None
        if not math.isfinite(number):
            raise InputError(f"{name} {value!r} is not a finite number", where=where, allowed="degrees")
        values.append(number)
    lon, lat = values
    if abs(lat) > 90.0:
        swapped = ": are latitude and longitude swapped?" if abs(lat) <= 180.0 and abs(lon) <= 90.0 else ""
        raise InputError(f"latitude of {lat:g} deg{swapped}", where=where, allowed="-90 to 90 deg")
    if abs(lon) > 360.0:
        raise InputError(f"longitude of {lon:g} deg", where=where, allowed="-180 to 180 deg")
    return math.radians(lat), math.radians(lon)


def ring(points: Sequence[tuple[float, float]], where: str) -> tuple[tuple[float, float], ...]:
    """Corners of a closed ring, each once.  Raises InputError for fewer than three."""
    corners = tuple(points[:-1]) if len(points) > 1 and points[0] == points[-1] else tuple(points)
    if len(set(corners)) < 3:
        raise InputError(f"polygon with {len(set(corners))} distinct corners", where=where, allowed="at least 3")
    return corners


def straight(points: Sequence[tuple[float, float]], where: str) -> tuple[tuple[float, float], ...]:
    """The two points of a survey line.  Raises InputError for any other number."""
    if len(points) != 2:
        raise InputError(
            f"line with {len(points)} points", where=where, allowed="two: a survey line is straight; split it"
        )
    if points[0] == points[1]:
        raise InputError("line ends where it starts", where=where)
    return tuple(points)
