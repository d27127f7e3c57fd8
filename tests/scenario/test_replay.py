"""Section `flight.replay`: a file or a section, what is refused and where it is said."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flown_paths import columns_of, on_plane, race_track, write_csv

from aerosim.cli.app import call
from aerosim.errors import InputError
from aerosim.scenario import from_mapping
from aerosim.scenario.build import replayed, terrain_of
from aerosim.scenario.build.replay import replay_of
from aerosim.scenario.emit import to_yaml
from aerosim.scenario.load import load
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


def over_mountain(path: Path, height: Any, place: tuple[float, float] = (36.5, -84.3)) -> str:
    """Five minutes to the east over pine_mountain; height: of each second, m."""
    t = np.arange(0.0, 300.0)
    track = on_plane(t, 0.0 * t, 60.0 * t, height + 0.0 * t, (math.radians(place[0]), math.radians(place[1])))
    # The plane leaves the ellipsoid by 25 m in 18 km: heights as they are wanted.
    return str(write_csv(path / "low.csv", columns_of(track) | {"height_m": height + 0.0 * t}))


def build(replay: Any, **other: Any) -> Any:
    land = {"source": "pine_mountain", "outside": "mask"}
    made = from_mapping({"name": "x", "terrain": land, "flight": {"replay": replay}, **other})
    return replayed(made, terrain_of(made))


@pytest.mark.parametrize("height", [200.0, 600.0, 950.0])
def test_lines_through_the_land_are_refused_with_what_lifts_them(tmp_path: Path, height: float) -> None:
    file = over_mountain(tmp_path, height)
    with pytest.raises(InputError) as caught:
        build(file)
    error, said = caught.value, str(caught.value)
    assert error.key == "flight.replay"
    assert error.where == file
    found = re.search(
        r"line 0 is (\d+) m .* at \d+ s, (\d+) m (above|below) the highest ground.*\((\d+) m\)", said
    )
    assert found, said
    low, clear, high = float(found[1]), float(found[2]) * (1 if found[3] == "above" else -1), float(found[4])
    assert low == pytest.approx(height, abs=1.0)
    assert low - high == pytest.approx(clear, abs=1.0)
    # What is said to help, does; a metre less does not.
    offset = float(re.search(r"height_offset_m from (\d+) on", said)[1])  # type: ignore[index]
    _, route = build({"file": file, "height_offset_m": offset})
    assert route.plan.height == pytest.approx(high + 150.0, abs=1.5)
    with pytest.raises(InputError, match=r"14\d m above|150 m above"):
        build({"file": file, "height_offset_m": offset - 1.1})


def test_a_turn_through_the_land_is_refused_and_lines_above_it_are_not_enough(tmp_path: Path) -> None:
    t = np.arange(0.0, 300.0)
    deep = 2000.0 - 1900.0 * np.exp(-(((t - 150.0) / 25.0) ** 2))
    file = over_mountain(tmp_path, deep)
    with pytest.raises(
        InputError, match=r"the path is 1\d\d m above the ellipsoid at 1[45]\d s, \d+ m below the ground"
    ):
        build({"file": file, "line_min_m": 2000.0})
    replay, _ = build({"file": file, "line_min_m": 2000.0, "to_s": 90.0})
    assert len(replay.lines) == 1


def test_a_wind_that_the_ground_speed_cannot_bear_is_refused(tmp_path: Path) -> None:
    # From the side: 60 m/s over ground and w of wind are an airspeed of hypot(60, w); w is 0.8 of it at 80 m/s.
    file = over_mountain(tmp_path, 2000.0)
    build(file, air={"wind": {"speed_m_s": 79.0, "from_deg": 0}})
    with pytest.raises(InputError, match=r"81\.0 m/s of wind make an airspeed of 100\.\d m/s") as caught:
        build(file, air={"wind": {"speed_m_s": 81.0, "from_deg": 0}})
    assert caught.value.key == "air.wind"


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        ("flight", "height_m", 2000.0),
        ("flight", "height_above", "ellipsoid"),
        ("flight", "airspeed_m_s", 60.0),
        ("flight", "bank_max_deg", 25.0),
        ("flight", "pilot", "navigator"),
        ("flight", "navigator", {"look_s": 100.0}),
        ("aircraft", "model", "beaver"),
        ("aircraft", "fuel_kg", 300.0),
    ],
)
def test_keys_without_effect_are_refused(section: str, key: str, value: Any) -> None:
    data: dict[str, Any] = {"name": "x", "terrain": {"source": "pine_mountain"}, "flight": {"replay": "a.csv"}}
    data.setdefault(section, {})[key] = value
    with pytest.raises(InputError) as caught:
        from_mapping(data)
    assert caught.value.key == f"{section}.{key}"
    assert "has no effect beside flight.replay" in str(caught.value)


def test_every_default_may_stand_beside_a_replay(tmp_path: Path) -> None:
    made = scenario({"file": str(tmp_path / "a.csv"), "from_s": 3.0})
    (tmp_path / "resolved.yaml").write_text(to_yaml(made), encoding="utf-8")
    assert load(tmp_path / "resolved.yaml") == made


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
