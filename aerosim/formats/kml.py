"""KML (OGC 07-147r2): placemarks with a line or a polygon; longitude before latitude, degrees, WGS-84."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NoReturn
from xml.parsers import expat
from xml.sax.saxutils import escape, quoteattr

from aerosim.errors import InputError
from aerosim.formats.features import Feature, place_of, ring, straight

DEPTH_MAX = 100
NAMESPACE = "http://www.opengis.net/kml/2.2"
GEOMETRIES = ("Point", "LineString", "LinearRing", "Polygon", "Model", "Track", "MultiTrack")
STYLES = {"line": "ff00a5ff", "area": "ff00ffff", "photo": "ffffffff", "footprint": "80ffffff"}  # aabbggrr


@dataclass
class _Element:
    """tag: without its namespace.  line: in the file, from 1.  name: the attribute of that name."""

    tag: str
    line: int
    name: str = ""
    text: str = ""
    parts: list[_Element] = field(default_factory=list)

    def all(self, tag: str) -> Iterator[_Element]:
        """Direct children of a tag."""
        return (part for part in self.parts if part.tag == tag)

    def word(self, tag: str) -> str:
        """Text of the first child of a tag, or nothing."""
        return next((part.text.strip() for part in self.all(tag)), "")


def _tree(text: str, where: str) -> _Element:
    """Elements of an XML text.  Document types, and with them entities of one's own, are refused."""
    parser = expat.ParserCreate(namespace_separator=" ")
    root = _Element("", 0)
    stack = [root]

    def refuse(*_: Any) -> NoReturn:
        raise InputError(
            "document types and entities are not read",
            where=f"{where}:{parser.CurrentLineNumber}",
            allowed="KML without <!DOCTYPE",
        )

    def start(name: str, attributes: dict[str, str]) -> None:
        if len(stack) > DEPTH_MAX:
            raise InputError("is nested too deeply", where=f"{where}:{parser.CurrentLineNumber}")
        element = _Element(name.rpartition(" ")[2], parser.CurrentLineNumber, attributes.get("name", ""))
        stack[-1].parts.append(element)
        stack.append(element)

    def end(_: str) -> None:
        stack[-1].text = "".join(pieces.pop(id(stack[-1]), ()))
        stack.pop()

    def characters(data: str) -> None:
        pieces.setdefault(id(stack[-1]), []).append(data)

    pieces: dict[int, list[str]] = {}
    parser.StartDoctypeDeclHandler = refuse
    parser.EntityDeclHandler = refuse
    parser.ExternalEntityRefHandler = refuse
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = characters
    try:
        parser.Parse(text.encode(), True)
    except expat.ExpatError as error:
        problem = expat.ErrorString(error.code)
        raise InputError(f"is no XML: {problem}", where=f"{where}:{error.lineno}") from error
    return root.parts[0]


def parse(text: str, where: str) -> list[Feature]:
    """Lines and areas of a KML text.  where: file, for messages.  Raises InputError."""
    # the text is Unicode by now, whatever encoding its first line states
    head, closed, rest = text.partition("?>")
    root = _tree("\n" * head.count("\n") + rest if closed and head.lstrip().startswith("<?xml") else text, where)
    if root.tag != "kml":
        raise InputError(f"is no KML: its root is {root.tag}", where=f"{where}:{root.line}", allowed="<kml>")
    return [feature for mark in _placemarks(root) for feature in _features(mark, where)]


def _placemarks(element: _Element) -> Iterator[_Element]:
    for part in element.parts:
        if part.tag == "Placemark":
            yield part
        else:
            yield from _placemarks(part)


def _features(mark: _Element, where: str) -> Iterator[Feature]:
    data = [each for extended in mark.all("ExtendedData") for each in extended.all("Data")]
    if any(each.name == "kind" and each.word("value") in ("photo", "footprint") for each in data):
        return  # what we write beside the lines
    shapes = list(_shapes(mark))
    if not shapes:
        raise InputError("placemark without a geometry", where=f"{where}:{mark.line}")
    for shape in shapes:
        yield _feature(shape, mark.word("name"), f"{where}:{shape.line}")


def _shapes(element: _Element) -> Iterator[_Element]:
    for part in element.parts:
        if part.tag == "MultiGeometry":
            yield from _shapes(part)
        elif part.tag in GEOMETRIES:
            yield part


def _feature(shape: _Element, name: str, where: str) -> Feature:
    if shape.tag == "LineString":
        points, height = _points(shape, where)
        return Feature("line", straight(points, where), name, height, {}, where)
    if shape.tag != "Polygon":
        raise InputError(f"{shape.tag} is neither a line nor an area", where=where, allowed="LineString, Polygon")
    if any(shape.all("innerBoundaryIs")):
        raise InputError("polygon with holes", where=where, allowed="one outline without holes")
    rings = [each for outer in shape.all("outerBoundaryIs") for each in outer.all("LinearRing")]
    if len(rings) != 1:
        raise InputError(f"polygon with {len(rings)} outlines", where=where, allowed="one")
    points, height = _points(rings[0], where)
    return Feature("area", ring(points, where), name, height, {}, where)


def _points(element: _Element, where: str) -> tuple[list[tuple[float, float]], float | None]:
    """Points, rad, and the altitude of the first one (m) if it has one."""
    found, height = [], None
    for number, word in enumerate(element.word("coordinates").split()):
        here = f"{where}: point {number}"
        parts = word.split(",")
        if not 2 <= len(parts) <= 3:
            raise InputError(f"{word[:40]!r} is no position", where=here, allowed="longitude,latitude[,altitude]")
        found.append(place_of(parts[0], parts[1], here))
        if len(parts) == 3:
            try:
                altitude = float(parts[2])
            except ValueError:
                altitude = math.nan
            if not math.isfinite(altitude):
                raise InputError(f"altitude {parts[2]!r} is not a number", where=here, allowed="metres")
            height = altitude if number == 0 else height
    return found, height


def text(features: Sequence[Feature], title: str) -> str:
    """KML text of features, drawn on the ground.

    Absolute altitudes of KML are above the geoid; the flying height, ellipsoidal, stands among the data instead.
    """
    styles = "".join(
        f'<Style id="{kind}"><LineStyle><color>{colour}</color><width>2</width></LineStyle>'
        f"<PolyStyle><fill>0</fill></PolyStyle></Style>\n"
        for kind, colour in STYLES.items()
    )
    marks = "".join(_placemark(each) for each in features)
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="{NAMESPACE}"><Document>\n'
        f"<name>{escape(title)}</name>\n{styles}{marks}</Document></kml>\n"
    )


def _placemark(feature: Feature) -> str:
    points = [f"{math.degrees(lon):.9f},{math.degrees(lat):.9f}" for lat, lon in feature.points]
    if feature.kind == "line":
        shape = f"<LineString><tessellate>1</tessellate><coordinates>{' '.join(points)}</coordinates></LineString>"
    elif feature.kind == "photo":
        shape = f"<Point><coordinates>{points[0]}</coordinates></Point>"
    else:
        outline = " ".join([*points, points[0]])
        shape = (
            f"<Polygon><tessellate>1</tessellate><outerBoundaryIs><LinearRing><coordinates>{outline}"
            f"</coordinates></LinearRing></outerBoundaryIs></Polygon>"
        )
    values = {"kind": feature.kind, "height_m": feature.height, **feature.properties}
    data = "".join(
        f"<Data name={quoteattr(key)}><value>{escape(str(value))}</value></Data>"
        for key, value in values.items()
        if value is not None
    )
    return (
        f"<Placemark><name>{escape(feature.name)}</name><styleUrl>#{feature.kind}</styleUrl>"
        f"<ExtendedData>{data}</ExtendedData>{shape}</Placemark>\n"
    )
