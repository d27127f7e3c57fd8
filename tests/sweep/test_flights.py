"""Flown trajectories on disk: found again, told apart by what makes a flight, bounded, shared, never broken."""

from __future__ import annotations

import errno
import json
import logging
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flights import WEST, scenario
from flown_paths import columns_of, race_track, write_csv
from kept_flights import MadeUp, fly_one, sortie
from sweeps import tiny

from aerosim import assets
from aerosim.errors import InputError
from aerosim.flight.interface import Flight, Recordable, Sortie
from aerosim.flight.recorded import RecordedFlight
from aerosim.scenario import Scenario, from_mapping, with_overrides
from aerosim.scenario.available import AVAILABLE
from aerosim.scenario.build import build
from aerosim.scenario.fields import sections_in, walk
from aerosim.simulate import simulate
from aerosim.sweep.flights import STALE_S, Flights, program
from aerosim.sweep.order import may_influence_flight


class _ContentError(Exception):
    """Ends the building of a run as soon as the flight's content is known."""


def content(wanted: Scenario) -> str:
    def source(asked: Sortie, fly: Callable[[], Recordable]) -> Flight:
        raise _ContentError(asked.content())

    with pytest.raises(_ContentError) as caught:
        build(wanted, source)
    return str(caught.value)


def trace(wanted: Scenario) -> bytes:
    """The flight as it is flown directly, each tenth of a second."""
    flight, out = build(wanted).flight, []
    while not flight.done:
        out.append([*flight.state(), *flight.air, flight.line, flight.cross_track])
        flight.advance(max(1, wanted.aircraft.step_rate_hz // 10))
    return np.array(out).tobytes()


LINES = {"flight.lines": [{"start_deg": [36.52, WEST], "end_deg": [36.52, WEST + 0.02]}]}
AREA = {
    "corners_deg": [[36.52, -84.3], [36.53, -84.3], [36.53, -84.28], [36.52, -84.28]],
    "course_deg": 90.0,
    "side_lap_pct": 60.0,
}
GUST = {"start_s": 3.0, "duration_s": 4.0, "north_m_s": 1.0, "east_m_s": 1.0, "down_m_s": 1.0}
LEVELS = [
    {"height_m": 0.0, "speed_m_s": 4.0, "from_deg": 10.0},
    {"height_m": 4e3, "speed_m_s": 8.0, "from_deg": 50.0},
]
THERMAL = {"center_deg": [36.52, WEST + 0.01], "radius_m": 900.0, "strength_m_s": 2.0}
# first part of a key -> what makes it count
CONTEXT: list[tuple[str, dict[str, Any]]] = [
    ("air.wind.profile", {"air.wind": {"profile": LEVELS}}),
    ("air.wind.", {"air.wind": {"speed_m_s": 5.0, "from_deg": 20.0}}),
    ("air.shear.", {"air.wind.speed_m_s": 5.0, "air.shear": {"exponent": 0.2, "veer_deg_per_km": 3.0}}),
    ("air.gusts", {"air.gusts": [GUST]}),
    ("air.thermals_drift", {"air.thermal_field": {"spacing_m": 2000.0}, "air.wind.speed_m_s": 5.0}),
    ("air.thermals", {"air.thermals": [THERMAL]}),
    ("air.thermal_field", {"air.thermal_field": {"spacing_m": 2000.0, "radius_m": 300.0}}),
    ("air.slow_wind.", {"air.slow_wind.sigma_m_s": 1.0}),
    ("air.turbulence.", {"air.turbulence.sigma_m_s": 1.0}),
    ("flight.navigator.", {"flight.pilot": "navigator"}),
    ("frame_camera.", {"flight.lines": None, "flight.area": AREA}),
    ("control.end_lap_pct", {"flight.lines": None, "flight.area": AREA}),
    ("control.navigator.", {"control.mode": "navigator"}),
    ("estimation.aiding", {"control.mode": "best"}),
    ("estimation.distortion", {"control.mode": "best"}),
    ("ccd_rows.faults.", {"ccd_rows.faults": {}}),
    ("mount.faults.", {"mount.faults": {"stuck_from_s": 1.0, "stuck_until_s": 2.0}}),
    ("navigation.imu.", {"navigation": {"gnss": None, "ins": None, "imu": {}}}),
    ("navigation.", {"control.mode": "gnss_ins"}),
]  # fmt: skip
# what only an area's plan asks of the camera and of the controller
OF_AREA = ("control.end_lap_pct", "frame_camera.focal_mm", "frame_camera.format_mm", "frame_camera.pixel_um")
# keys that no flight is made from, whatever is planned
NOT_FLOWN = (
    "ccd_rows.",
    "estimation.",
    "mount.",
    "record.",
    "control.mode",
    "control.fmc",
    "control.navigator.",
    "navigation.",
    "name",
    "purpose",
)


def closed(key: str) -> bool:
    """Whether this version knows but one value of a key."""
    return any(len(values) == 1 and f"{key}.".startswith(f"{name}.") for name, values in AVAILABLE.items())


def candidates(key: str, value: Any) -> list[Any]:
    """Other values of a key, nearest first."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 1, value + 8, 2 * value, value - 1]
    if isinstance(value, float):
        return [value + 0.25, 2.0 * value, value / 2.0, value + 1 / 120, value - 0.25, value * 1.01]
    if isinstance(value, tuple) and value and isinstance(value[0], float):
        return [(*value[:-1], 1.001 * value[-1])]
    words = {"schema": [], "name": ["other"], "purpose": ["other"], "verifies": [["other"]], "expect": [{}]}
    more = {
        "seed": [2],
        "aircraft.model": ["beaver"],
        "terrain.source": [],
        "terrain.vertical_datum": ["ellipsoidal", {"undulation_m": -20.0}],
        "air.turbulence.model": ["von_karman"],
        "aircraft.fuel_kg": [300.0],
        "flight.height_above": ["ellipsoid"],
        "flight.pilot": ["navigator"],
    }
    tried = words.get(key, more.get(key, []))
    plain = [0.5, 2.0, "none", "mask", "airframe", "padded", "best", "fixed", "von_karman", "mesoscale", "light"]
    return tried or [*plain, "riccati", "schmelovsky_1988", True, False]


def base_of(key: str) -> Scenario:
    changes = next((changes for start, changes in CONTEXT if key.startswith(start)), {})
    base = with_overrides(tiny(), LINES)
    return with_overrides(base, changes)


def value_at(wanted: Scenario, key: str) -> tuple[str, Any]:
    """Path of a key, the first of every list, and its value.  Raises AttributeError where there is none."""
    here, path = wanted, []
    for name in key.split("."):
        if isinstance(here, tuple) and here and not isinstance(here[0], (int, float)):
            here, path = here[0], [*path, "0"]
        here, path = getattr(here, {"schema": "schema_version"}.get(name, name)), [*path, name]
    return ".".join(path), here


def changed(key: str) -> tuple[Scenario, Scenario] | None:
    """A scenario and the same with another value of a key; None where there is no such value."""
    base = base_of(key)
    try:
        path, value = value_at(base, key)
    except AttributeError:
        return None
    for other in candidates(key, value):
        try:
            found = with_overrides(base, {path: other})
            if found != base:
                content(found)
                return base, found
        except InputError:
            continue
    return None


KEYS = [key for key, info in walk(Scenario) if not sections_in(info.annotation) and not closed(key)]
# tried by tests of their own below, or without a second value that can be flown
APART = (
    *("flight.replay", "flight.area", "flight.file", "flight.lines", "terrain.", "estimation.table"),
    *("schema", "expect", "verifies"),
)


@pytest.mark.parametrize("section", sorted({key.split(".")[0] for key in KEYS if not key.startswith(APART)}))
def test_every_key_is_in_the_content_or_changes_no_flight(section: str) -> None:
    tried = []
    for key in KEYS:
        if key.split(".")[0] != section or key.startswith(APART):
            continue
        if (pair := changed(key)) is None:
            continue
        tried.append(key)
        base, other = pair
        alike = content(base) == content(other)
        assert not alike or trace(base) == trace(other), key
        if key.startswith(NOT_FLOWN) or (section == "frame_camera" and key not in OF_AREA):
            assert alike, f"{key} keeps flights apart that are the same"
        if key != "seed" and not may_influence_flight(key, base.flight.area is not None):  # of the same seed
            assert alike, f"the order of runs takes no notice of {key}"
    wanted = [key for key in KEYS if key.split(".")[0] == section and not key.startswith(APART)]
    assert len(tried) >= 0.75 * len(wanted), f"not tried: {sorted(set(wanted) - set(tried))}"


@pytest.mark.parametrize(
    ("changes", "alike"),
    [
        ({"flight.lines.0.end_deg": [36.52, WEST + 0.021]}, False),
        ({"terrain.outside": "mask"}, True),
        ({"control.end_lap_pct": 70.0}, True),
        ({"frame_camera.focal_mm": 300.0}, True),
    ],
)
def test_what_the_plan_makes_of_a_key_counts(changes: dict[str, Any], alike: bool) -> None:
    """Of the land what it makes of heights; of camera and end lap nothing, where lines are given."""
    base = base_of("seed")
    assert (content(base) == content(with_overrides(base, changes))) == alike


@pytest.mark.parametrize("key", ["photos_beyond", "course_deg", "corners_deg"])
def test_an_area_s_keys_count(key: str) -> None:
    other = {"photos_beyond": 2, "course_deg": 80.0,
             "corners_deg": [[36.52, -84.3], [36.535, -84.3], [36.53, -84.28], [36.52, -84.28]]}[key]  # fmt: skip
    base = base_of("control.end_lap_pct")
    assert content(base) != content(with_overrides(base, {f"flight.area.{key}": other}))


@pytest.mark.parametrize(
    "change",
    [
        {"from_s": 5.0},
        {"height_offset_m": 1510.0},
        {"angle_of_attack_deg": 2.0},
        {"move_to_deg": [36.49, -84.31]},
    ],
)
def test_a_replay_s_keys_and_its_file_count(change: dict[str, Any], tmp_path: Path) -> None:
    columns = columns_of(race_track(rate=1.0))
    file = write_csv(tmp_path / "flight.csv", columns)

    def again(**more: Any) -> Scenario:
        part = {"file": str(file), "move_to_deg": [36.49, -84.3], "height_offset_m": 1500.0, "line_min_m": 3000.0}
        return from_mapping({
            "name": "again", "terrain": {"source": "pine_mountain"}, "flight": {"replay": {**part, **more}},
        })  # fmt: skip

    base = content(again())
    assert base == content(with_overrides(again(), {"control.mode": "fixed", "record.period_s": 0.1}))
    assert base != content(again(**change))
    columns["height_m"][30] += 5.0
    write_csv(file, columns)
    assert base != content(again())


def test_the_aircraft_s_files_count(tmp_path: Path) -> None:
    folder = tmp_path / "survey_twin"
    shutil.copytree(assets.folder("aircraft") / "survey_twin", folder)
    base = with_overrides(base_of("seed"), {"aircraft.model": str(folder)})
    before = content(base)
    part = next(iter(sorted(folder.rglob("*.xml"))))
    part.write_text(part.read_text(encoding="utf-8") + "<!-- another -->\n", encoding="utf-8")
    assert content(base) != before


def test_libraries_and_machine_count(monkeypatch: pytest.MonkeyPatch) -> None:
    before = program.__wrapped__()
    assert program.__wrapped__() == before
    monkeypatch.setattr("aerosim.sweep.flights.platform.machine", lambda: "another")
    assert program.__wrapped__() != before
    monkeypatch.undo()
    monkeypatch.setattr("aerosim.sweep.flights.metadata.version", lambda name: "0")
    assert program.__wrapped__() != before


def fresh_source(tmp_path: Path, bytes_max: int = 1 << 30) -> Flights:
    """As another process has it: nothing in memory."""
    return Flights(tmp_path / "flights", bytes_max)


def files(tmp_path: Path) -> list[Path]:
    return sorted((tmp_path / "flights").glob("*.flight"))


def test_runs_of_one_flight_are_those_of_their_own(tmp_path: Path) -> None:
    for mode in ("pipelined", "fixed", "ideal"):
        wanted, kept = scenario(3.0, control={"mode": mode}), fresh_source(tmp_path)
        found, direct = simulate(wanted, flights=kept), simulate(wanted)
        assert found.summary["telemetry_sha256"] == direct.summary["telemetry_sha256"]
        assert kept.flown == (mode == "pipelined")
    assert len(files(tmp_path)) == 1


@pytest.mark.parametrize("damage", ["bit", "cut", "empty", "other"])
def test_a_damaged_file_is_flown_anew(damage: str, tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    fly = lambda: MadeUp(1, 40_000)  # noqa: E731
    state = fresh_source(tmp_path)(sortie("a"), fly).state()
    (file,) = files(tmp_path)
    whole = file.read_bytes()
    middle = len(whole) // 2
    bit = whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]
    file.write_bytes({"bit": bit, "cut": whole[:middle], "empty": b"", "other": b"x" * 5000}[damage])
    again = fresh_source(tmp_path)
    with caplog.at_level(logging.WARNING, "aerosim"):
        assert np.array(again(sortie("a"), fly).state()).tobytes() == np.array(state).tobytes()
    assert again.flown == 1
    assert "is flown anew" in caplog.text
    assert file.read_bytes() == whole


def test_the_folder_is_bounded_and_what_was_not_used_goes_first(tmp_path: Path) -> None:
    fly = lambda: MadeUp(1, 40_000)  # noqa: E731
    fresh_source(tmp_path)(sortie("first"), fly)
    size = files(tmp_path)[0].stat().st_size
    files(tmp_path)[0].unlink()
    most = 3 * size + size // 2

    def ask(name: str) -> int:
        kept = fresh_source(tmp_path, most)
        kept(sortie(name), fly)
        time.sleep(0.01)  # the clock of the file system
        assert sum(each.stat().st_size for each in (tmp_path / "flights").iterdir()) <= most
        return kept.flown

    assert [ask(name) for name in "abcaabcd"] == [1, 1, 1, 0, 0, 0, 0, 1]
    assert [ask(name) for name in "bcd"] == [0, 0, 0]  # a went
    assert [ask(name) for name in "acdb"] == [1, 0, 0, 1]  # b went for a, then came back
    kept = fresh_source(tmp_path, size // 2)
    assert isinstance(kept(sortie("large"), fly), RecordedFlight)
    assert len(files(tmp_path)) == 3


def test_processes_that_want_the_same_flight_at_once(tmp_path: Path) -> None:
    """Four of them: one flies, the others wait for it; a second flight is another's."""
    code = "import json,sys; sys.path[:]=json.loads(sys.argv[1]); from kept_flights import fly_one; " \
           "print(json.dumps(fly_one(sys.argv[2], sys.argv[3], 5, 0.5)))"  # fmt: skip
    path = [str(Path(__file__).parents[1]), *filter(None, sys.path)]
    started = [
        subprocess.Popen(
            [sys.executable, "-c", code, json.dumps(path), str(tmp_path / "flights"), name],
            stdout=subprocess.PIPE, text=True,
        )
        for name in ("same", "same", "same", "other")
    ]  # fmt: skip
    said = [json.loads(process.communicate(timeout=60)[0]) for process in started]
    assert sum(flown for flown, _ in said[:3]) == 1
    assert said[3][0] == 1
    assert {repr(state) for _, state in said} == {repr(fly_one(str(tmp_path / "flights"), "same", 5, 0.0)[1])}
    assert len(files(tmp_path)) == 2
    assert not list((tmp_path / "flights").glob(".*.part"))


def test_what_a_killed_process_left_is_removed(tmp_path: Path) -> None:
    kept = fresh_source(tmp_path)
    old, new = (kept.folder / f".{name}.part" for name in ("old", "new"))
    for part in (old, new):
        part.write_bytes(b"half")
    os.utime(old, (time.time() - 2 * STALE_S,) * 2)
    kept(sortie("a"), lambda: MadeUp(1, 40_000))
    assert (old.exists(), new.exists()) == (False, True)
    assert len(files(tmp_path)) == 1


def test_a_full_disk_costs_time_and_is_said_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    write = Path.write_bytes

    def full(self: Path, data: Any) -> int:
        if self.suffix == ".part":
            write(self, data[:1000])
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(self, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    kept = fresh_source(tmp_path)
    with caplog.at_level(logging.WARNING, "aerosim"):
        assert isinstance(kept(sortie("a"), lambda: MadeUp(1, 40_000)), RecordedFlight)
        assert isinstance(kept(sortie("b"), lambda: MadeUp(1, 40_000)), MadeUp)
        wanted = scenario(2.0)
        assert simulate(wanted, flights=kept).status == "done"
    assert [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING] == [
        f"{kept.folder} keeps no more flights, each run flies its own: No space left on device"
    ]
    assert [each.name for each in kept.folder.iterdir() if each.suffix != ".lock"] == []


def test_a_folder_that_cannot_be_made_costs_time(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / "flights").write_text("a file in the way")
    with caplog.at_level(logging.WARNING, "aerosim"):
        kept = fresh_source(tmp_path)
        assert isinstance(kept(sortie("a"), lambda: MadeUp(1, 40_000)), MadeUp)
    assert len(caplog.records) == 1
