"""Wrong terrain, aircraft and directories through the command line: one line, exit 2, nothing left behind."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import rasterio
from rasterio.transform import from_origin

from aerosim.cli.app import call

# 20 x 10 km in UTM zone 32, 45.07 to 45.15 N, 9.0 to 9.25 E; the line is 15.7 km along it
EAST, NORTH = 500_000.0, 5_000_000.0
ROWS, COLUMNS, PIXEL = 200, 400, 50.0
SCENARIO = """\
name: bad
terrain:
  source: {orthophoto: orthophoto.tif, elevation: elevation.tif}
  vertical_datum: ellipsoidal
flight:
  height_m: 3000
  airspeed_m_s: 69.44
  lines:
    - {start_deg: [45.1, 9.03], end_deg: [45.1, 9.23]}
"""


def write_raster(
    file: str, values: np.ndarray, crs: str | None = "EPSG:32632", east: float = EAST, north: float = NORTH
) -> None:
    transform = from_origin(east, north, PIXEL, PIXEL)
    shape = {"height": values.shape[0], "width": values.shape[1], "count": 1, "dtype": values.dtype}
    with rasterio.open(file, "w", driver="GTiff", crs=crs, transform=transform, **shape) as data:
        data.write(values, 1)


def orthophoto(**place: object) -> None:
    texture = np.random.default_rng(1).integers(0, 255, (ROWS, COLUMNS)).astype(np.uint8)
    write_raster("orthophoto.tif", texture, **place)  # type: ignore[arg-type]


def elevation(**place: object) -> None:
    write_raster("elevation.tif", np.full((ROWS, COLUMNS), 200, np.float32), **place)  # type: ignore[arg-type]


@pytest.fixture
def refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., str]:
    """Line that `aerosim run` refuses a scenario with, over good rasters unless they are there already."""
    monkeypatch.chdir(tmp_path)
    orthophoto()
    elevation()

    def line(text: str = SCENARIO, *options: str) -> str:
        Path("bad.yaml").write_text(text)
        before = sorted(tmp_path.rglob("*"))
        code = call(["run", "bad.yaml", *options])
        out, err = capsys.readouterr()
        assert code == 2, out + err
        assert out == ""
        assert err.count("\n") == 1
        assert sorted(tmp_path.rglob("*")) == before
        return err.rstrip("\n")

    return line


Refused = Callable[..., str]


@pytest.mark.parametrize("speed", ["30", "140"])
def test_a_speed_that_the_aircraft_cannot_fly(refused: Refused, speed: str) -> None:
    line = refused(SCENARIO.replace("69.44", speed))
    assert line.startswith("bad.yaml:7: flight.airspeed_m_s: ")
    # the allowed range is told, and holds the default
    low, high = map(float, re.findall(r"([\d.]+) to ([\d.]+) m/s", line)[0])
    assert low < 69.44 < high


def test_a_height_that_the_aircraft_cannot_fly(refused: Refused) -> None:
    line = refused(SCENARIO.replace("3000", "15000"))
    assert re.match(r"bad\.yaml:[67]: flight\.", line)
    assert "cannot fly at 15200 m" in line  # 15000 m above terrain of 200 m


def test_more_fuel_than_the_tanks_hold(refused: Refused) -> None:
    assert refused(SCENARIO + "aircraft: {fuel_kg: 90000}\n").startswith("bad.yaml:10: aircraft.fuel_kg: ")


def test_an_aircraft_that_does_not_ship(refused: Refused) -> None:
    line = refused(SCENARIO + "aircraft: {model: survey_twn}\n")
    assert line.startswith("bad.yaml:10: aircraft.model: ")
    assert "survey_twin" in line


def test_a_terrain_that_does_not_ship(refused: Refused) -> None:
    text = re.sub(r"source: .*", "source: pine_montain", SCENARIO)
    line = refused(text)
    assert line.startswith("bad.yaml:3: terrain.source: ")
    assert "did you mean pine_mountain?" in line


def test_a_line_that_leaves_the_terrain(refused: Refused) -> None:
    # 9.30 E lies 3.6 km beyond the raster's edge at 9.254 E
    line = refused(SCENARIO.replace("9.23]", "9.30]"))
    assert line.startswith("bad.yaml:9: flight.lines.0")
    assert re.search(r"3\.[4-9]\d* km|3[4-9]\d\d m", line), line


def test_a_file_that_is_not_there(refused: Refused) -> None:
    Path("orthophoto.tif").unlink()
    line = refused()
    assert line.startswith("bad.yaml:3: terrain.source")
    assert "orthophoto.tif does not exist" in line


@pytest.mark.parametrize("file", ["orthophoto.tif", "elevation.tif"])
def test_a_file_that_is_no_raster(refused: Refused, file: str) -> None:
    Path(file).write_text("not a raster")
    line = refused()
    assert line.startswith("bad.yaml:3: terrain.source")
    assert file in line


@pytest.mark.parametrize("file", ["orthophoto.tif", "elevation.tif"])
def test_a_raster_cut_short(refused: Refused, file: str) -> None:
    data = Path(file).read_bytes()
    Path(file).write_bytes(data[: len(data) // 2])
    line = refused()
    assert line.startswith("bad.yaml:3: terrain.source")
    assert file in line
    assert "truncated" in line


@pytest.mark.parametrize("write", [orthophoto, elevation])
def test_a_raster_without_crs(refused: Refused, write: Callable[..., None]) -> None:
    write(crs=None)
    line = refused()
    assert line.startswith("bad.yaml:3: terrain.source")
    assert "no CRS" in line


def test_rasters_that_do_not_overlap(refused: Refused) -> None:
    elevation(east=EAST + 100_000)
    line = refused()
    assert line.startswith("bad.yaml:3: terrain.source")
    assert "do not overlap" in line


def test_heights_that_do_not_say_what_they_are_above(refused: Refused) -> None:
    line = refused(SCENARIO.replace("datum: ellipsoidal", "datum: file"))
    assert line.startswith("bad.yaml:4: terrain.vertical_datum: ")
    assert "undulation_m" in line


def test_orthometric_heights_are_never_taken_as_ellipsoidal(refused: Refused) -> None:
    # Caspian depth-free height system with no geoid grid in any wheel: EPSG:5611
    elevation(crs="EPSG:32632+5611")
    for datum in ("file", "ellipsoidal"):
        line = refused(SCENARIO.replace("datum: ellipsoidal", f"datum: {datum}"))
        assert line.startswith("bad.yaml:4: terrain.vertical_datum: ")


def test_an_output_directory_that_exists(refused: Refused) -> None:
    Path("there").mkdir()
    Path("there/mine.txt").write_text("keep")
    line = refused(SCENARIO, "--out", "there")
    assert "there" in line
    assert "--overwrite" in line
    assert Path("there/mine.txt").read_text() == "keep"


@pytest.mark.parametrize("out", ["bad.yaml", "bad.yaml/below", "/proc/none"])
def test_an_output_directory_that_cannot_be_made(refused: Refused, out: str) -> None:
    assert out in refused(SCENARIO, "--out", out)
    assert out in refused(SCENARIO, "--out", out, "--overwrite")


def test_a_flight_into_the_hills_is_refused(refused: Refused) -> None:
    heights = np.full((ROWS, COLUMNS), 200, np.float32)
    heights[80:120, 200:210] = 1100.0  # a ridge across the line; the mean stays near 225 m
    write_raster("elevation.tif", heights)
    line = refused(SCENARIO.replace("height_m: 3000", "height_m: 900"))
    assert "above the highest ground under line 0" in line
    assert re.search(r"flight\.height_m from 10\d\d on", line)


LINES = SCENARIO[SCENARIO.index("  lines:") :]
LEVELS = "[{{height_m: {}, speed_m_s: 5, from_deg: 0}}, {{height_m: {}, speed_m_s: {}, from_deg: 0}}]"
PROFILE = f"wind: {{{{profile: {LEVELS}}}}}"
SQUARE = "[[45.10, 9.08], [45.10, 9.16], [45.13, 9.16], [45.13, 9.08]]"


@pytest.mark.parametrize(
    ("air", "wanted"),
    [
        ("wind: {speed_m_s: 70, from_deg: 10}", r"air\.wind\.speed_m_s: 70 m/s is too much for an airspeed"),
        (
            PROFILE.format(0, 4000, 95),
            r"air\.wind: wind of 77 m/s cannot be flown against",
        ),
        (
            PROFILE.format(900, 900, 9),
            r"air\.wind\.profile\.1\.height_m: 900 m is not above the level before it",
        ),
        ("turbulence: {model: mil_f_8785c}", r"air\.turbulence\.severity: .* has no strength"),
        ("turbulence: {severity: light}", r"air\.turbulence\.severity: does not belong to model dryden"),
        ("gusts: [{start_s: 3, duration_s: 0}]", r"air\.gusts\.0\.duration_s: 0 is out of range"),
        (
            "thermals: [{center_deg: [45, 9], radius_m: 0, strength_m_s: 2}]",
            r"air\.thermals\.0\.radius_m: 0 is out",
        ),
    ],
)
def test_air_that_cannot_be(refused: Refused, air: str, wanted: str) -> None:
    assert re.match(rf"bad\.yaml:10: {wanted}", refused(f"{SCENARIO}air: {{{air}}}\n"))


@pytest.mark.parametrize(
    ("flight", "wanted"),
    [
        ("", r"flight\.lines: has no lines \(lines, area or file\)"),
        (f"  area: {{corners_deg: {SQUARE}}}\n{LINES}", r"flight\.area: is given besides lines"),
        ("  area: {corners_deg: []}", r"flight\.area\.corners_deg: has 0 values"),
        ("  area: {corners_deg: [[45.10, 9.08], [45.10, 9.16]]}", r"flight\.area\.corners_deg: has 2 values"),
        (
            "  area: {corners_deg: [[45.10, 9.08], [45.13, 9.16], [45.13, 9.08], [45.10, 9.16]]}",
            r"flight\.area: polygon crosses or touches itself at latitude 45\.11\d+, longitude 9\.12",
        ),
        ("  area: {corners_deg: [[45.1, 9.1], [45.1, 9.1], [45.1, 9.1]]}", r"flight\.area: polygon .*"),
        (f"  area: {{corners_deg: {SQUARE.replace('45.1', '44.1')}}}", r"flight\.area: .* beyond the terrain"),
        (
            f"  area: {{corners_deg: {SQUARE}, side_lap_pct: 95}}",
            r"flight\.area\.side_lap_pct: 95 is out of range",
        ),
        ("  file: none.geojson", r"flight\.file: cannot be read: No such file"),
        ("  file: orthophoto.tif", r"flight\.file: format \.tif is not known"),
        ("  replay: {file: none.csv, from_s: 5, to_s: 5}", r"flight\.replay\.to_s: 5 s is not after from_s"),
    ],
)
def test_lines_that_cannot_be(refused: Refused, flight: str, wanted: str) -> None:
    line = refused(SCENARIO.replace(LINES, flight + "\n"))
    assert re.match(rf"(\S+: )?{wanted}", line), line


HEAD = "t_s,latitude_deg,longitude_deg,height_m\n"


def track(*rows: str) -> str:
    """A straight flight of 100 s, one row each second, with the given rows put in its middle."""
    points = [f"{t},45.1,{9.03 + 0.001 * t:.6f},3200" for t in range(100)]
    return HEAD + "\n".join([*points[:50], *rows, *points[50:]]) + "\n"


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("", "empty"),
        (HEAD, "no row|no point|points"),
        (HEAD + "0,45.1,9.03,3200\n", "one point|1 point"),
        (track("20,45.1,9.08,3200"), r"fly\.csv:52: .*(backwards|after)"),
        (track("49,45.2,9.30,3200"), r"fly\.csv:5[12]: .*49"),
        (track("49.5,nan,9.0795,3200"), r"fly\.csv:52: .*latitude_deg"),
        (track("49.5,45.1,9.9795,3200"), r"fly\.csv:5[23]: .*m/s"),
        (track().replace("height_m", "altitude_km"), "altitude_km"),
        (track().replace("longitude_deg", "lon"), "longitude_deg"),
        (track().replace(",45.1,", ",45100,"), "latitude"),
        (track().replace(",", ";"), ";|semicolon"),
    ],
)
def test_trajectories_that_cannot_be(refused: Refused, text: str, wanted: str) -> None:
    Path("fly.csv").write_text(text)
    line = refused(SCENARIO.replace(LINES, "  replay: fly.csv\n"))
    assert "fly.csv" in line
    assert re.search(wanted, line), line
