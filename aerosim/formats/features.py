"""What map files hold for a survey: lines, areas, photos."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

from aerosim.errors import InputError

Kind = Literal["line", "area", "photo", "footprint"]
Property = str | int | float | None


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
