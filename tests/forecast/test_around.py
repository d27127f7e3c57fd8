"""What `terrain make --around` takes, and the command itself."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from flown_paths import columns_of, race_track, write_csv

from aerosim.cli.app import call
from aerosim.errors import InputError
from aerosim.forecast.around import around

SQUARE = {
    "type": "Polygon",
    "coordinates": [[[9.0, 45.0], [9.01, 45.0], [9.01, 45.01], [9.0, 45.01], [9.0, 45.0]]],
}


def test_a_point() -> None:
    found = around("45.5,-9")
    assert np.degrees(found.ways[0][0]) == pytest.approx([45.5])
    assert np.degrees(found.ways[0][1]) == pytest.approx([-9.0])
    assert found.height is None


def test_a_trajectory(tmp_path: Path) -> None:
    track = race_track(rate=0.5)
    found = around(str(write_csv(tmp_path / "flight.csv", columns_of(track))))
    lat, lon = (np.concatenate(values) for values in zip(*found.ways, strict=True))
    for mine, true in ((lat, track.lat), (lon, track.lon)):
        # a place each 5 s: on a half circle of 1200 m that cuts off up to 150^2/2400 m, 1.5e-6 rad
        assert mine.min() == pytest.approx(true.min(), abs=3e-6)
        assert mine.max() == pytest.approx(true.max(), abs=3e-6)
    assert found.height == pytest.approx(1500.0, abs=3.0)


def test_an_area_is_gone_around(tmp_path: Path) -> None:
    file = tmp_path / "area.geojson"
    file.write_text(json.dumps(SQUARE))
    lat, lon = around(str(file)).ways[0]
    assert len(lat) == 5
    assert (lat[0], lon[0]) == (lat[-1], lon[-1])


@pytest.mark.parametrize("text", ["nothing.csv", "45", "95,9", "a,b"])
def test_what_is_neither(text: str) -> None:
    with pytest.raises(InputError) as caught:
        around(text)
    assert caught.value.key == "--around"


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flight = write_csv(tmp_path / "flight.csv", columns_of(race_track(rate=0.5)))
    out = tmp_path / "land"
    command = ["terrain", "make", "--around", str(flight), "--margin_m", "500", "--out", str(out)]
    assert call([*command, "--height_m", "300", "--relief_m", "10"]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines() == [str(out / "orthophoto.tif"), str(out / "elevation.tif")]
    # 1200 m above it a row's pixel is 9.05 m, a third of it 3 m
    assert "pixels of 3 m" in said.err
    assert call(command) == 2
    assert "file exists" in capsys.readouterr().err
    assert call([*command[:-1], str(tmp_path / "other"), "--height_m", "1450"]) == 2
    assert "--height_m" in capsys.readouterr().err
    assert call(["terrain", "info", *said.out.splitlines()]) == 0
