"""Section `flight.replay`: a file or a section, what is refused and where it is said."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flown_paths import columns_of, race_track, write_csv

from aerosim.cli.app import call
from aerosim.errors import InputError
from aerosim.scenario import from_mapping
from aerosim.scenario.build.replay import replay_of
from aerosim.scenario.replay import Replay
from aerosim.world.synthetic import Ground, make_terrain

PLACE = (math.radians(47.0), math.radians(11.0))


def scenario(replay: Any) -> Any:
    return from_mapping({"name": "x", "terrain": {"source": "pine_mountain"}, "flight": {"replay": replay}})


def test_a_name_is_the_section_with_its_defaults(tmp_path: Path) -> None:
    file = str(write_csv(tmp_path / "flight.csv", columns_of(race_track(rate=1.0, leg=8000.0))))
    assert scenario(file).flight.replay == file
    made = [replay_of(wanted, 20.0, (), None) for wanted in (file, scenario({"file": file}).flight.replay)]
    assert made[0].lines == made[1].lines


def test_keys_reach_the_replay_in_si(tmp_path: Path) -> None:
    file = str(write_csv(tmp_path / "flight.csv", columns_of(race_track(rate=1.0))))
    wanted = Replay(
        file=file, from_s=10.0, to_s=120.0, move_to_deg=(36.5, -84.3), height_offset_m=100.0, line_min_m=2000.0,
        angle_of_attack_deg=2.0,
    )  # fmt: skip
    replay = replay_of(wanted, 20.0, (), None)
    assert (replay.points.t[0], replay.points.t[-1]) == pytest.approx((10.0, 120.0), abs=0.6)
    assert np.degrees(replay.lines[0].line.start) == pytest.approx((36.5, -84.3), abs=1e-5)
    assert replay.height == pytest.approx(1600.0, abs=3.0)
    assert replay.level_pitch == pytest.approx(math.radians(2.0))


@pytest.mark.parametrize(
    ("replay", "key", "said"),
    [
        (3, "flight.replay", "neither a file nor a section"),
        ({}, "flight.replay.file", "is missing"),
        ({"file": "a.csv", "to_s": 1.0, "from_s": 2.0}, "flight.replay.to_s", "is not after from_s"),
        ({"file": "a.csv", "gap_max_s": 1e9}, "flight.replay.gap_max_s", "out of range"),
        ({"file": "a.csv", "gap_max": 10}, "flight.replay.gap_max", "did you mean gap_max_s?"),
        ({"file": "a.csv", "move_to_deg": [100, 0]}, "flight.replay.move_to_deg.0", "out of range"),
        ({"file": "a.csv", "line_min_m": 0}, "flight.replay.line_min_m", "out of range"),
    ],
)  # fmt: skip
def test_what_is_refused(replay: Any, key: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        scenario(replay)
    assert caught.value.key == key
    assert said in str(caught.value)


def test_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file beside its scenario; errors in it are said with its own line, errors in a key with that."""
    columns = columns_of(race_track(rate=1.0))
    write_csv(tmp_path / "flight.csv", columns)
    columns["latitude_deg"][20] = 947.0
    write_csv(tmp_path / "bad.csv", columns)
    way = (np.array([PLACE[0]]), np.array([PLACE[1]]))
    make_terrain([way], 9000.0, Ground(pixel=20.0), tmp_path / "land")
    file = tmp_path / "x.yaml"
    file.write_text(
        "name: x\nterrain: {source: {orthophoto: land/orthophoto.tif, elevation: land/elevation.tif}}\n"
        "flight:\n  run_in_s: 20\n  replay: {file: flight.csv, line_min_m: 3000}\n"
    )
    assert call(["check", str(file)]) == 0
    assert "flight.lines" in capsys.readouterr().out
    for name, line in (("bad.csv", f"{tmp_path / 'bad.csv'}:22: flight.replay: latitude_deg is 947"),
                       ("none.csv", f"{file}:5: flight.replay: no trajectory file")):  # fmt: skip
        text = file.read_text().replace("flight.csv", name)
        file.write_text(text)
        assert call(["check", str(file)]) == 2
        assert capsys.readouterr().err.startswith(line)
        file.write_text(text.replace(name, "flight.csv"))
