"""`aerosim plan` and `aerosim check` as a user meets them: figures, files, warnings, refusals."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from aerosim.cli.app import call
from aerosim.formats import files

AREA = '{"type": "Polygon", "coordinates": [[[-84.30, 36.50], [-84.20, 36.50], [-84.20, 36.56], [-84.30, 36.54]]]}'
CHECK = """\
name: try
terrain: {source: pine_mountain}
air: {wind: {speed_m_s: 10, from_deg: 0}}
flight:
  lines:
    - {start_deg: [36.52, -84.38], end_deg: [36.52, -84.12]}
    - {start_deg: [36.54, -84.12], end_deg: [36.54, -84.38]}
"""


class Result(NamedTuple):
    code: int
    out: str
    err: str


Aerosim = Callable[..., Result]


@pytest.fixture
def aerosim(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Aerosim:
    """Runs a command line in a folder that holds area.geojson and try.yaml."""
    monkeypatch.chdir(tmp_path)
    Path("area.geojson").write_text(AREA)
    Path("try.yaml").write_text(CHECK)

    def run(*args: str) -> Result:
        code = call(args)
        return Result(code, *capsys.readouterr())

    return run


@pytest.mark.parametrize("ending", ["geojson", "kml", "csv"])
def test_a_plan_is_written_named_in_a_scenario_and_checked(aerosim: Aerosim, ending: str) -> None:
    planned = aerosim("plan", "area.geojson", "--height_m", "1500", "--out", f"lines.{ending}", "--json")
    assert planned.code == 0, planned.err
    figures = json.loads(planned.out)
    lines = files.read(Path(f"lines.{ending}"))
    assert len(lines) == figures["flight"]["lines"] == len(figures["lines"]) >= 3
    assert [line.name for line in lines] == [str(k + 1) for k in range(len(lines))]
    scenario = f"name: again\nterrain: {{source: pine_mountain}}\nflight: {{file: lines.{ending}, height_m: {figures['flight']['height_m']}, height_above: ellipsoid}}\n"
    Path("again.yaml").write_text(scenario)
    again = json.loads(aerosim("check", "again.yaml", "--json").out)
    assert again["flight"]["duration_s"] == pytest.approx(figures["flight"]["duration_s"], rel=1e-6)
    assert again["photos"]["count"] == figures["photos"]["count"]
    # the file of lines is a plan by itself as well
    third = aerosim("plan", f"lines.{ending}", "--height_m", "1500", "--json")
    assert third.code == 0, third.err
    assert len(json.loads(third.out)["lines"]) == len(lines)


def test_a_plan_is_the_same_from_a_scenario(aerosim: Aerosim) -> None:
    planned = json.loads(
        aerosim("plan", "area.geojson", "--height_m", "1500", "--order", "race_track", "--json").out
    )
    Path("a.yaml").write_text(
        "name: area\nterrain: {source: pine_mountain}\n"
        "flight: {area: {file: area.geojson, order: race_track}, height_m: 1500}\n"
    )
    assert json.loads(aerosim("check", "a.yaml", "--json").out) == planned


def test_gsd_gives_the_height(aerosim: Aerosim) -> None:
    # 0.12 m x 152 mm / 12 um = 1520 m
    figures = json.loads(aerosim("plan", "area.geojson", "--gsd_m", "0.12", "--json").out)
    assert figures["flight"]["height_m"] - figures["flight"]["terrain_mean_height_m"] == pytest.approx(1520.0)
    assert figures["photos"]["gsd_m"] == pytest.approx(0.12)
    assert figures["photos"]["gsd_min_m"] < 0.12 < figures["photos"]["gsd_max_m"]
    assert figures["coverage"]["gaps"] == []


def test_the_table_names_what_a_crew_asks_for(aerosim: Aerosim) -> None:
    result = aerosim("plan", "area.geojson", "--height_m", "700", "--wind_m_s", "10", "--wind_from_deg", "200")
    assert result.code == 0
    for word in (
        "flight.lines",
        "photos.count",
        "flight.duration_s",
        "storage.picture_mb",
        "photos.gsd_min_m",
        "photos.gsd_max_m",
        "photos.rate_wanted_max_per_min",
        "photos.side_lap_min_pct",
        "photos.side_lap_mean_pct",
        "coverage.seen_0_pct",
        "coverage.gaps",
    ):
        assert f"\n{word} " in result.out
    (head,) = (line for line in result.out.splitlines() if line.startswith("name ") and "course" in line)
    assert {"name", "course_deg", "drift_deg", "photos", "interval_s", "blur_px"} <= set(head.split())
    assert all(line.startswith("warning: ") for line in result.err.splitlines())
    assert "blur of" in result.err
    assert aerosim("plan", "area.geojson", "--height_m", "700", "-q").err == ""


def test_maps_are_pictures(aerosim: Aerosim) -> None:
    from PIL import Image

    result = aerosim("check", "try.yaml", "--map", "map.png", "--out", "all.geojson")
    assert result.code == 0, result.err
    assert "written: map.png" in result.err
    picture = np.asarray(Image.open("map.png").convert("RGB"))
    assert picture.shape[1] == 1300
    # green land, not an empty frame
    assert (picture[..., 1].astype(int) > picture[..., 2].astype(int) + 15).mean() > 0.2
    kinds = [each["properties"]["kind"] for each in json.loads(Path("all.geojson").read_text())["features"]]
    assert (kinds.count("line"), kinds.count("area")) == (2, 1)
    assert kinds.count("photo") == kinds.count("footprint") == 26
    # what check wrote is a plan again
    assert len(files.read(Path("all.geojson"))) == 3


def test_check_tells_its_warnings_in_both_ways(aerosim: Aerosim) -> None:
    result = aerosim("check", "try.yaml", "--set", "flight.run_in_s=20", "--json")
    assert result.code == 0
    (told,) = json.loads(result.out)["warnings"]
    assert result.err == f"warning: {told}\n"
    assert told.startswith("run-in of 20 s is shorter than the 45 s")


def test_too_little_power_is_told_before_the_flight(aerosim: Aerosim) -> None:
    result = aerosim("check", "try.yaml", "--set", "flight.height_m=6500", "--set", "flight.airspeed_m_s=100")
    assert result.code == 2
    assert "has too little power for 100 m/s" in result.err
    assert result.err.startswith("--set flight.airspeed_m_s: ")


BOW = '{"type": "Polygon", "coordinates": [[[-84.3, 36.5], [-84.2, 36.56], [-84.2, 36.5], [-84.3, 36.56]]]}'
SWAPPED = '{"type": "Polygon", "coordinates": [[[36.5, -84.3], [36.5, -84.2], [36.56, -84.2]]]}'
SHORT = '{"type": "LineString", "coordinates": [[-84.3, 36.5], [-84.2999, 36.5]]}'
TINY = "start_latitude_deg,start_longitude_deg,end_latitude_deg,end_longitude_deg\n36.5,-84.3,36.5,-84.2\n36.5,-84.3,36.5,-84.297\n"


@pytest.mark.parametrize(
    ("name", "text", "args", "words"),
    [
        ("a.geojson", BOW, (), "a.geojson: polygon crosses or touches itself at latitude 36.53"),
        ("a.geojson", SWAPPED, (), "latitude and longitude are swapped"),
        ("a.geojson", SHORT, (), "line of 0.00895"),
        ("a.csv", TINY, (), "ends before a first strip is recognised"),
        ("a.geojson", AREA.replace("36.56", "38.56"), (), "a.geojson: "),
        ("a.geojson", AREA, ("--height_m", "200", "--min_interval_s", "0.5"), "--height_m: 860 m above the ellipsoid is not above the area's highest ground"),
        ("a.geojson", AREA, ("--height_m", "-5"), "--height_m: -5 is out of range (more than 0)"),
        ("a.geojson", AREA, ("--height_m", "30000"), "--height_m: 30000.0 is out of range"),
        ("a.geojson", AREA, ("--height_m", "900", "--gsd_m", "0.1"), "--gsd_m: given twice (--height_m or --gsd_m)"),
        ("a.geojson", AREA, ("--gsd_m", "2"), "--gsd_m: 2 m is flown at 25333 m (a height of more than 0, at most 20000 m)"),
        ("a.csv", "latitude_deg;longitude_deg\n36.5;-84.3\n", (), "a.csv:1: columns are parted by semicolons (commas)"),
        ("a.geojson", AREA, ("--terrain", "nowhere"), "or ORTHOPHOTO,ELEVATION)"),
        ("a.geojson", AREA, ("--gsd_m", "nan"), "--gsd_m: nan is out of range"),
        ("a.geojson", AREA, ("--course_deg", "north"), "--course_deg: 'north' is no course (auto, or 0 to 360)"),
        ("a.geojson", AREA, ("--course_deg", "400"), "--course_deg: 400.0 is out of range"),
        ("a.geojson", AREA, ("--side_lap_pct", "95"), "--side_lap_pct: 95.0 is out of range"),
        ("a.geojson", AREA, ("--side_lap_min_pct", "50"), "--side_lap_min_pct: 50 % is more than side_lap_pct (at most 30)"),
        ("a.geojson", AREA, ("--end_lap_pct", "99"), "--end_lap_pct: 99.0 is out of range"),
        ("a.geojson", AREA, ("--order", "fastest"), "--order: 'fastest' is not known (allowed: sequential, race_track, shortest; did you mean shortest?)"),
        ("a.geojson", AREA, ("--format_mm", "230"), "--format_mm: '230' is no pair of numbers (230,230)"),
        ("a.geojson", AREA, ("--wind_m_s", "60"), "--wind_m_s: 60 m/s is too much for an airspeed of 69.44 m/s"),
        ("a.geojson", AREA, ("--terrain", "oak_valley"), "--terrain: no terrain 'oak_valley' ships"),
        ("a.geojson", AREA, ("--terrain", "a,b,c"), "--terrain: 'a,b,c' is no terrain"),
        ("a.geojson", AREA, ("--aircraft", "glider"), "--aircraft: "),
        ("a.geojson", AREA, ("--out", "a.shp"), "--out: format .shp is not known"),
        ("a.geojson", AREA, ("--out", "a.geojson"), "a.geojson: file exists (another name, or --overwrite)"),
        ("a.geojson", AREA, ("--map", "a.gif"), "--map: 'a.gif' is no picture"),
        ("b.geojson", AREA, (), "a.geojson: cannot be read: No such file or directory"),
    ],
)  # fmt: skip
def test_what_cannot_be_planned(
    aerosim: Aerosim, tmp_path: Path, name: str, text: str, args: tuple[str, ...], words: str
) -> None:
    Path(name).write_text(text)
    before = sorted(file.name for file in tmp_path.iterdir())
    result = aerosim("plan", "a.csv" if name == "a.csv" else "a.geojson", *args)
    assert (result.code, result.out) == (2, "")
    assert result.err.count("\n") == 1
    assert words in result.err
    assert sorted(file.name for file in tmp_path.iterdir()) == before


def test_what_check_wrote_is_flown_and_planned_again(aerosim: Aerosim) -> None:
    Path("a.yaml").write_text(
        "name: a\nterrain: {source: pine_mountain}\nflight: {area: {file: area.geojson}, height_m: 1500}\n"
    )
    first = json.loads(aerosim("check", "a.yaml", "--out", "x.geojson", "--json").out)
    names = [line["name"] for line in first["lines"]]
    assert names == [str(k + 1) for k in range(len(names))]
    assert [pair["lines"].split(", ") for pair in first["side_lap"]] == [list(pair) for pair in pairwise(names)]
    shapes = [each["properties"] for each in json.loads(Path("x.geojson").read_text())["features"]]
    assert {each["line"] for each in shapes if each["kind"] == "photo"} == set(names)
    assert [each["telemetry_line"] for each in shapes if each["kind"] == "line"] == list(range(len(names)))
    for key in ("flight.file=x.geojson", "flight.area.file=x.geojson"):
        head = (
            "flight: {height_m: 1500, area: {file: x.geojson}}"
            if "area" in key
            else ("flight: {height_m: 1500, file: x.geojson}")
        )
        Path("b.yaml").write_text(f"name: b\nterrain: {{source: pine_mountain}}\n{head}\n")
        again = json.loads(aerosim("check", "b.yaml", "--json").out)
        assert [line["name"] for line in again["lines"]] == names
    planned = json.loads(aerosim("plan", "x.geojson", "--height_m", "1500", "--json").out)
    assert planned["coverage"]["area_km2"] == pytest.approx(first["coverage"]["area_km2"], rel=1e-6)


def test_a_line_with_swapped_places_is_guessed(aerosim: Aerosim) -> None:
    Path("try.yaml").write_text(
        CHECK.replace("[36.52, -84.38]", "[-84.38, 36.52]").replace("[36.52, -84.12]", "[-84.12, 36.52]")
    )
    result = aerosim("check", "try.yaml")
    assert result.code == 2
    assert "latitude and longitude are swapped" in result.err


def test_a_terrain_file_that_is_missing(aerosim: Aerosim) -> None:
    assert aerosim("terrain", "info", "nofile.tif").err.startswith("nofile.tif: no such file")
