"""Lines and areas in and out of map files, by the file's ending."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

from aerosim.errors import InputError
from aerosim.formats import csvlines, geojson, kml
from aerosim.formats.features import Feature

BYTES_MAX = 50_000_000
ENDINGS = ".geojson, .json, .kml, .csv"

Reader = Callable[[str, str], list[Feature]]
Writer = Callable[[Sequence[Feature], str], str]


def _module(path: Path, key: str) -> tuple[Reader, Writer]:
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
