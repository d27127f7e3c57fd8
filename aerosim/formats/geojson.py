"""GeoJSON (RFC 7946): longitude before latitude, degrees, WGS-84; a third number is the height, m."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NoReturn

from aerosim.errors import InputError
from aerosim.formats.features import Feature, Kind, place_of, ring, straight

DIGITS = 9  # of a degree: a tenth of a millimetre
ALLOWED = "LineString, MultiLineString, Polygon, Feature, FeatureCollection, GeometryCollection"


def parse(text: str, where: str) -> list[Feature]:
    """Lines and areas of a GeoJSON text.  where: file, for messages.  Raises InputError."""

    def no_number(word: str) -> NoReturn:
        raise InputError(f"{word} is no number in JSON", where=where)

    try:
        data = json.loads(text, parse_constant=no_number)
    except json.JSONDecodeError as error:
        raise InputError(f"is no JSON: {error.msg}", where=f"{where}:{error.lineno}") from error
    except (RecursionError, ValueError) as error:
        raise InputError("is no JSON: nested too deeply or with numbers too long", where=where) from error
    try:
        return list(_features(data, where, "", {}))
    except RecursionError as error:
        raise InputError("is nested too deeply", where=where) from error


def _list(value: Any, where: str, what: str) -> list[Any]:
    if not isinstance(value, list):
        raise InputError(f"{what} is no list", where=where)
    return value


def _features(data: Any, where: str, name: str, properties: Mapping[str, Any]) -> Iterator[Feature]:
    """Features of any GeoJSON object."""
    if not isinstance(data, dict) or not isinstance(data.get("type"), str):
        raise InputError("is no GeoJSON object", where=where, allowed=f"an object with type: {ALLOWED}")
    kind = data["type"]
    if kind == "FeatureCollection":
        _check_crs(data, where)
        for number, each in enumerate(_list(data.get("features"), where, "features")):
            yield from _features(each, f"{where}: feature {number}", "", {})
    elif kind == "Feature":
        own = data.get("properties")
        own = own if isinstance(own, dict) else {}
        if data.get("geometry") is None:
            raise InputError("feature without a geometry", where=where)
        yield from _features(data["geometry"], where, str(own.get("name") or ""), own)
    elif kind == "GeometryCollection":
        for each in _list(data.get("geometries"), where, "geometries"):
            yield from _features(each, where, name, properties)
    elif properties.get("kind") not in ("photo", "footprint"):  # what we write beside the lines
        yield from _geometry(kind, data.get("coordinates"), where, name, properties)


def _check_crs(data: Mapping[str, Any], where: str) -> None:
    """The old member `crs` may only say what RFC 7946 says anyway."""
    crs = data.get("crs")
    name = str((crs.get("properties") or {}).get("name")) if isinstance(crs, dict) else ""
    if crs is not None and not name.upper().endswith(("CRS84", "EPSG::4326", "EPSG:4326")):
        raise InputError(f"is in the CRS {name!r}", where=where, allowed="longitude and latitude, WGS-84")


def _geometry(
    kind: str, coordinates: Any, where: str, name: str, properties: Mapping[str, Any]
) -> Iterator[Feature]:
    kept = {key: each for key, each in properties.items() if isinstance(each, (str, int, float))}
    if kind in ("LineString", "MultiLineString"):
        for part in [coordinates] if kind == "LineString" else _list(coordinates, where, "coordinates"):
            points, height = _points(part, where)
            yield Feature("line", straight(points, where), name, height, kept, where)
    elif kind in ("Polygon", "MultiPolygon"):
        parts = [coordinates] if kind == "Polygon" else _list(coordinates, where, "coordinates")
        if len(parts) != 1:
            raise InputError(f"MultiPolygon of {len(parts)} parts", where=where, allowed="one area at a time")
        rings = _list(parts[0], where, "coordinates")
        if len(rings) != 1:
            problem = f"polygon with {len(rings) - 1} holes" if rings else "polygon without corners"
            raise InputError(problem, where=where, allowed="one outline without holes")
        points, height = _points(rings[0], where)
        yield Feature("area", ring(points, where), name, height, kept, where)
    else:
        raise InputError(f"geometry {kind!r} is neither a line nor an area", where=where, allowed=ALLOWED)


def _points(data: Any, where: str) -> tuple[list[tuple[float, float]], float | None]:
    """Points, rad, and the height of the first one (m), if it has one."""
    found, height = [], None
    for number, point in enumerate(_list(data, where, "coordinates")):
        here = f"{where}: point {number}"
        if not isinstance(point, list) or not 2 <= len(point) <= 4:
            raise InputError("is no position", where=here, allowed="[longitude, latitude] or [..., height]")
        found.append(place_of(point[0], point[1], here))
        if len(point) > 2:
            if not isinstance(point[2], (int, float)) or isinstance(point[2], bool) or not math.isfinite(point[2]):
                raise InputError(f"height {point[2]!r} is not a number", where=here, allowed="metres")
            height = float(point[2]) if number == 0 else height
    return found, height


def text(features: Sequence[Feature], title: str) -> str:
    """GeoJSON text of features, one a line; heights ellipsoidal as the RFC has them.  title: of the collection."""
    lines = ",\n".join(json.dumps(_feature(each), allow_nan=False) for each in features)
    return f'{{"type": "FeatureCollection", "name": {json.dumps(title)}, "features": [\n{lines}\n]}}\n'


def _feature(feature: Feature) -> dict[str, Any]:
    height = () if feature.height is None else (round(feature.height, 3),)
    points = [
        [round(math.degrees(lon), DIGITS), round(math.degrees(lat), DIGITS), *height]
        for lat, lon in feature.points
    ]
    shapes: dict[Kind, tuple[str, Any]] = {
        "line": ("LineString", points),
        "photo": ("Point", points[0]),
        "area": ("Polygon", [[*points, points[0]]]),
        "footprint": ("Polygon", [[*points, points[0]]]),
    }
    shape, coordinates = shapes[feature.kind]
    return {
        "type": "Feature",
        "properties": {"kind": feature.kind, "name": feature.name, **feature.properties},
        "geometry": {"type": shape, "coordinates": coordinates},
    }
