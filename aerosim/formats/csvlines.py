"""CSV: survey lines by their ends, or an area by its corners, in degrees, one a line."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence

from aerosim.errors import InputError
from aerosim.formats.features import Feature, place_of, ring, straight

LINE = ("start_latitude_deg", "start_longitude_deg", "end_latitude_deg", "end_longitude_deg")
CORNER = ("latitude_deg", "longitude_deg")
ALLOWED = f"{','.join(LINE)}[,name] for lines, {','.join(CORNER)} for an area"


def parse(text: str, where: str) -> list[Feature]:
    """Lines, or one area, of a CSV text with a head.  where: file, for messages.  Raises InputError."""
    reader = csv.reader(io.StringIO(text), strict=True)
    try:
        rows = [(reader.line_num, row) for row in reader if any(cell.strip() for cell in row)]
    except csv.Error as error:
        raise InputError(f"is no CSV: {error}", where=f"{where}:{reader.line_num}") from error
    first, head = rows[0]
    columns = [cell.strip().lower() for cell in head]
    for other, word in ((";", "semicolons"), ("\t", "tabs")):
        if len(columns) == 1 and other in columns[0]:
            raise InputError(f"columns are parted by {word}", where=f"{where}:{first}", allowed="commas")
    if len(set(columns)) != len(columns):
        raise InputError("a column is given twice", where=f"{where}:{first}", allowed=ALLOWED)
    for number, row in rows[1:]:
        if len(row) != len(columns):
            raise InputError(f"has {len(row)} values", where=f"{where}:{number}", allowed=f"{len(columns)}")
    table = [(f"{where}:{number}", dict(zip(columns, row, strict=True))) for number, row in rows[1:]]
    if set(columns) - {"name"} == set(LINE):
        return [_line(row, here) for here, row in table]
    if set(columns) == set(CORNER):
        corners = [place_of(row["longitude_deg"], row["latitude_deg"], here) for here, row in table]
        return [Feature("area", ring(corners, where), where=where)]
    raise InputError(f"columns {', '.join(head)[:100]!r} are not known", where=f"{where}:{first}", allowed=ALLOWED)


def _line(row: dict[str, str], where: str) -> Feature:
    start = place_of(row["start_longitude_deg"], row["start_latitude_deg"], where)
    end = place_of(row["end_longitude_deg"], row["end_latitude_deg"], where)
    return Feature("line", straight((start, end), where), row.get("name", "").strip(), where=where)


def text(features: Sequence[Feature], title: str) -> str:
    """CSV text of the lines among the features; title: not written, the format has no place for it."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*LINE, "name"])
    for feature in features:
        if feature.kind == "line":
            ends = [f"{math.degrees(angle):.9f}" for point in feature.points for angle in point]
            writer.writerow([*ends, feature.name])
    return out.getvalue()
