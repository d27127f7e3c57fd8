"""Lines and areas through GeoJSON, KML and CSV: there and back, by other readers, and whatever is wrong in them."""

from __future__ import annotations

# ruff: noqa: E501  (tables of broken files, one a line)
import csv
import json
import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from aerosim.errors import InputError
from aerosim.formats import files
from aerosim.formats.features import Feature

LINES = [
    Feature("line", ((0.6374, -1.4727), (0.6374, -1.4682)), "1 <west & east>", 3521.25, {"photos": 12, "line": 0}),
    Feature("line", ((0.6377, -1.4682), (0.6377, -1.4727)), "2ä", 3521.25, {"photos": 13, "line": 1}),
]
AREA = Feature("area", ((0.6374, -1.4727), (0.6374, -1.4682), (0.6380, -1.4700)), "wood", None, {})
PHOTO = Feature("photo", ((0.6374, -1.4727),), "photo 0", 3500.0, {"photo": 0})
PRINT = Feature("footprint", ((0.63, -1.47), (0.64, -1.47), (0.64, -1.46), (0.63, -1.46)), "photo 0", None, {})


@pytest.mark.parametrize("ending", ["geojson", "json", "kml", "csv", "KML"])
def test_lines_come_back_to_a_tenth_of_a_millimetre(tmp_path: Path, ending: str) -> None:
    file = tmp_path / f"lines.{ending}"
    files.write(file, [*LINES, PHOTO, PRINT], title="a & b")
    found = files.read(file)
    assert [each.kind for each in found] == ["line", "line"]  # photos and footprints are not read as plans
    for before, after in zip(LINES, found, strict=True):
        assert np.abs(np.array(before.points) - np.array(after.points)).max() * 6.4e6 < 1e-4
        assert after.name == before.name


@pytest.mark.parametrize("ending", ["geojson", "kml"])
def test_an_area_comes_back(tmp_path: Path, ending: str) -> None:
    files.write(tmp_path / f"area.{ending}", [AREA], title="area")
    (found,) = files.read(tmp_path / f"area.{ending}")
    assert (found.kind, found.name) == ("area", "wood")
    assert np.array(found.points) == pytest.approx(np.array(AREA.points), abs=1e-11)


def test_geojson_is_what_the_rfc_says(tmp_path: Path) -> None:
    files.write(tmp_path / "all.geojson", [*LINES, AREA, PHOTO, PRINT], title="all")
    data = json.loads((tmp_path / "all.geojson").read_text())
    assert data["type"] == "FeatureCollection"
    shapes = [each["geometry"]["type"] for each in data["features"]]
    assert shapes == ["LineString", "LineString", "Polygon", "Point", "Polygon"]
    line = data["features"][0]
    # longitude, latitude, ellipsoidal height
    start = [math.degrees(-1.4727), math.degrees(0.6374), 3521.25]
    assert line["geometry"]["coordinates"][0] == pytest.approx(start)
    assert line["properties"] == {"kind": "line", "name": "1 <west & east>", "photos": 12, "line": 0}
    ring = data["features"][2]["geometry"]["coordinates"][0]
    assert ring[0] == ring[-1]
    assert len(ring) == 4


def test_kml_is_read_by_another_parser(tmp_path: Path) -> None:
    files.write(tmp_path / "all.kml", [*LINES, AREA, PHOTO, PRINT], title="a <b>")
    space = {"k": "http://www.opengis.net/kml/2.2"}
    root = ElementTree.parse(tmp_path / "all.kml").getroot()
    assert root.find("k:Document/k:name", space).text == "a <b>"  # type: ignore[union-attr]
    marks = root.findall(".//k:Placemark", space)
    assert [mark.find("k:name", space).text for mark in marks][:2] == ["1 <west & east>", "2ä"]  # type: ignore[union-attr]
    words = marks[0].find(".//k:coordinates", space).text.split()  # type: ignore[union-attr]
    lon, lat = (float(part) for part in words[0].split(","))
    assert (lon, lat) == pytest.approx((math.degrees(-1.4727), math.degrees(0.6374)))


def test_csv_has_its_columns(tmp_path: Path) -> None:
    files.write(tmp_path / "lines.csv", LINES, title="")
    with (tmp_path / "lines.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert float(rows[1]["end_longitude_deg"]) == pytest.approx(math.degrees(-1.4727))
    assert rows[1]["name"] == "2ä"


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(-80, 80), st.floats(-180, 180)), min_size=2, max_size=2, unique=True))
def test_any_line_comes_back(ends: list[tuple[float, float]]) -> None:
    from aerosim.formats import csvlines, geojson, kml

    assume(np.abs(np.subtract(*ends)).max() > 1e-8)  # the digits written tell them apart
    line = Feature("line", tuple((math.radians(a), math.radians(b)) for a, b in ends), "x")
    for module in (geojson, kml, csvlines):
        (found,) = module.parse(module.text([line], "t"), "f")
        assert np.array(found.points) == pytest.approx(np.array(line.points), abs=1e-11)


NAMESPACES = ["", ' xmlns="http://earth.google.com/kml/2.0"', ' xmlns="http://www.opengis.net/kml/2.2"']
RING = "-84.3,36.5,0 -84.2,36.5,0\n -84.2,36.6,0 -84.3,36.5,0"
POLYGON = f"<Polygon><outerBoundaryIs><LinearRing><coordinates>{RING}</coordinates></LinearRing></outerBoundaryIs>"


@pytest.mark.parametrize("space", NAMESPACES)
@pytest.mark.parametrize("head", ["", '<?xml version="1.0" encoding="ISO-8859-1"?>\n'])
def test_kml_of_other_programs(tmp_path: Path, space: str, head: str) -> None:
    text = (
        f"{head}<kml{space}><Document><Folder><Placemark><name> a </name><MultiGeometry>{POLYGON}</Polygon>"
        "<LineString><coordinates>-84.3,36.5 -84.2,36.5</coordinates></LineString>"
        "</MultiGeometry></Placemark></Folder></Document></kml>"
    )
    (tmp_path / "a.kml").write_text(text)
    area, line = files.read(tmp_path / "a.kml")
    assert (area.kind, line.kind, area.name, area.height) == ("area", "line", "a", 0.0)
    assert len(area.points) == 3
    assert np.degrees(line.points[0]) == pytest.approx((36.5, -84.3))


def test_csv_of_an_area_and_of_windows(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_bytes(
        b"\xef\xbb\xbfLatitude_deg, longitude_deg\r\n36.5,-84.3\r\n36.5,-84.2\r\n36.6,-84.2\r\n"
    )
    (area,) = files.read(tmp_path / "a.csv")
    assert (area.kind, len(area.points)) == ("area", 3)


def geo(kind: str, coordinates: str) -> str:
    return f'{{"type": "Feature", "properties": {{}}, "geometry": {{"type": "{kind}", "coordinates": {coordinates}}}}}'


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.shp", "x", "a.shp: format .shp is not known (.geojson, .json, .kml, .csv)"),
        ("a.kmz", "x", "unpack the .kmz first"),
        ("a", "x", "format without ending is not known"),
        ("a.geojson", "", "a.geojson: is empty"),
        ("a.geojson", "{\n\n nonsense}", "a.geojson:3: is no JSON"),
        ("a.geojson", "[" * 100000, "is no JSON"),
        ("a.geojson", '{"type": "Topology"}', "a.geojson: geometry 'Topology' is neither"),
        ("a.geojson", "[1, 2]", "is no GeoJSON object"),
        ("a.geojson", '{"type": "FeatureCollection", "features": []}', "holds neither a line nor an area"),
        ("a.geojson", '{"type": "FeatureCollection", "features": [{"type": "Feature", "geometry": null}]}', "a.geojson: feature 0: feature without a geometry"),
        ("a.geojson", geo("Point", "[1, 2]"), "geometry 'Point' is neither a line nor an area"),
        ("a.geojson", geo("LineString", "[[1, 2], [3, 4], [5, 6]]"), "line with 3 points (two: a survey line is straight"),
        ("a.geojson", geo("LineString", "[[1, 2], [1, 2]]"), "line ends where it starts"),
        ("a.geojson", geo("LineString", "[[1, NaN], [1, 2]]"), "NaN is no number"),
        ("a.geojson", geo("LineString", "[[1, 1e999], [1, 2]]"), "a.geojson: point 0: latitude inf is not a finite number"),
        ("a.geojson", geo("LineString", '[[1, "x"], [1, 2]]'), "point 0: latitude 'x' is not a number"),
        ("a.geojson", geo("LineString", "[[1, true], [1, 2]]"), "point 0: latitude True is not"),
        ("a.geojson", geo("LineString", "[[1], [1, 2]]"), "point 0: is no position"),
        ("a.geojson", geo("LineString", '[[1, 2, "x"], [1, 3]]'), "height 'x' is not a number"),
        ("a.geojson", geo("LineString", "[[36.5, -100], [36.5, -101]]"), "latitude of -100 deg: are latitude and longitude swapped?"),
        ("a.geojson", geo("LineString", "[[1000, 2], [1, 2]]"), "longitude of 1000 deg"),
        ("a.geojson", geo("Polygon", "[[[1, 2], [3, 4], [1, 2]]]"), "polygon with 2 distinct corners"),
        ("a.geojson", geo("Polygon", "[]"), "polygon without corners"),
        ("a.geojson", geo("Polygon", "[[[1, 2], [3, 4], [5, 2]], [[2, 2], [3, 3], [4, 2]]]"), "polygon with 1 holes"),
        ("a.geojson", geo("MultiPolygon", "[[[[1, 2], [3, 4], [5, 2]]], [[[2, 2], [3, 3], [4, 2]]]]"), "MultiPolygon of 2 parts"),
        ("a.geojson", '{"type": "FeatureCollection", "crs": {"properties": {"name": "EPSG:25832"}}, "features": []}', "is in the CRS 'EPSG:25832'"),
        ("a.kml", "<kml><a></kml>", "a.kml:1: is no XML"),
        ("a.kml", "<gpx/>", "a.kml:1: is no KML: its root is gpx"),
        ("a.kml", '<?xml version="1.0"?>\n<!DOCTYPE kml [<!ENTITY a "b">]>\n<kml>&a;</kml>', "a.kml:2: document types and entities are not read"),
        ("a.kml", '<!DOCTYPE kml SYSTEM "file:///etc/passwd"><kml/>', "document types and entities"),
        ("a.kml", "<kml>" + "<a>" * 5000, "nested too deeply"),
        ("a.kml", "<kml>\n<Placemark>\n</Placemark></kml>", "a.kml:2: placemark without a geometry"),
        ("a.kml", "<kml>\n<Placemark>\n<Point/></Placemark></kml>", "a.kml:3: Point is neither"),
        ("a.kml", "<kml><Placemark><LineString><coordinates>1,2 3</coordinates></LineString></Placemark></kml>", "point 1: '3' is no position"),
        ("a.kml", "<kml><Placemark><LineString><coordinates>1,2 3,x</coordinates></LineString></Placemark></kml>", "latitude 'x' is not a number"),
        ("a.kml", "<kml><Placemark><LineString><coordinates>1,2,nan 3,1</coordinates></LineString></Placemark></kml>", "altitude 'nan' is not"),
        ("a.kml", f"<kml><Placemark>{POLYGON}<innerBoundaryIs/></Polygon></Placemark></kml>", "polygon with holes"),
        ("a.kml", "<kml><Placemark><Polygon/></Placemark></kml>", "polygon with 0 outlines"),
        ("a.csv", "lat;lon\n1;2\n", "a.csv:1: columns are parted by semicolons"),
        ("a.csv", "latitude_deg,longitude_deg\n1,2\n1,2,3\n", "a.csv:3: has 3 values (2)"),
        ("a.csv", "latitude_deg,longitude_deg\n1,2\nx,3\n", "a.csv:3: latitude 'x' is not a number"),
        ("a.csv", "latitude_deg,longitude_deg\n1,2\n,3\n", "a.csv:3: latitude '' is not a number"),
        ("a.csv", "latitude_deg,latitude_deg\n1,2\n", "a column is given twice"),
        ("a.csv", 'latitude_deg,longitude_deg\n"1,2\n', "is no CSV"),
        ("a.csv", "latitude_deg,longitude_deg\n", "polygon with 0 distinct corners"),
        ("a.csv", "start_latitude_deg,start_longitude_deg,end_latitude_deg,end_longitude_deg\n", "holds neither"),
        ("a.csv", "start_latitude_deg,start_longitude_deg,end_latitude_deg,end_longitude_deg\n1,2,95,3\n", "a.csv:2: latitude of 95 deg"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told_with_its_place(tmp_path: Path, name: str, text: str, words: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError) as caught:
        files.read(tmp_path / name)
    line = str(caught.value)
    assert words in line
    assert "\n" not in line


def test_files_that_cannot_be_read_or_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none.kml: cannot be read: No such file"):
        files.read(tmp_path / "none.kml")
    (tmp_path / "b.kml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="is not a text file"):
        files.read(tmp_path / "b.kml")
    with pytest.raises(InputError, match="file exists"):
        files.write(tmp_path / "b.kml", LINES, title="")
    files.write(tmp_path / "b.kml", LINES, title="", overwrite=True)
    with pytest.raises(InputError, match="cannot be written"):
        files.write(tmp_path / "no" / "b.kml", LINES, title="")
    with pytest.raises(InputError, match=r"--out: format .txt is not known"):
        files.write(tmp_path / "b.txt", LINES, title="")
    assert sorted(file.name for file in tmp_path.iterdir()) == ["b.kml"]
