"""Errors of the loader: file, line, key, what is wrong, what is allowed; overrides; paths; places."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import pytest
from pydantic import ValidationError

from aerosim.errors import InputError
from aerosim.scenario import Scenario, from_mapping, load, load_scenario, parse_setting, shipped, with_overrides

Refused = Callable[[str | bytes], str]
Write = Callable[[str | bytes], Path]


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("air:", "airr:", "try.yaml:4: airr: unknown key (did you mean air?)"),
        ("  airspeed_m_s: 69.44", "  air_speed_m_s: 70", "try.yaml:8: flight.air_speed_m_s: unknown key (did you mean airspeed_m_s?)"),
        ("airspeed_m_s:", "airspeed:", "try.yaml:8: flight.airspeed: unknown key, without its unit (did you mean airspeed_m_s?)"),
        ("airspeed_m_s:", "speed:", "try.yaml:8: flight.speed: unknown key, without its unit (did you mean airspeed_m_s?)"),
        ("airspeed_m_s:", "airspeed_kn:", "try.yaml:8: flight.airspeed_kn: unknown key (did you mean airspeed_m_s?)"),
        ("{speed_m_s:", "{speed:", "try.yaml:5: air.wind.speed: unknown key, without its unit (did you mean speed_m_s?)"),
        ("terrain:", "wind: 3\nterrain:", "try.yaml:2: wind: unknown key here (did you mean air.wind?)"),
        ("name: try", "name: try\nfmc: true", "try.yaml:2: fmc: unknown key here (did you mean control.fmc?)"),
        ("height_m: 3000", "height_m: -3000", "try.yaml:7: flight.height_m: -3000 is out of range (allowed: more than 0, at most 20000)"),
        ("height_m: 3000", "height_m: .nan", "try.yaml:7: flight.height_m: .nan is not a finite number (allowed: more than 0, at most 20000)"),
        ("height_m: 3000", "height_m: .inf", "try.yaml:7: flight.height_m: .inf is not a finite number (allowed: more than 0, at most 20000)"),
        ("height_m: 3000", 'height_m: "3000"', "try.yaml:7: flight.height_m: '3000' is not a number (allowed: a number, more than 0, at most 20000)"),
        ("height_m: 3000", "height_m: 3000 m", "try.yaml:7: flight.height_m: '3000 m' is not a number (allowed: a number, more than 0, at most 20000)"),
        ("height_m: 3000", "height_m: true", "try.yaml:7: flight.height_m: true is not a number (allowed: a number, more than 0, at most 20000)"),
        ("height_m: 3000", "height_m:", "try.yaml:7: flight.height_m: null is not a number (allowed: a number, more than 0, at most 20000)"),
        ("height_m: 3000", "height_above: sea", "try.yaml:7: flight.height_above: 'sea' is not known (allowed: mean_terrain, ellipsoid)"),
        ("from_deg: 0", "from_deg: 361", "try.yaml:5: air.wind.from_deg: 361 is out of range (allowed: at least 0, at most 360)"),
        ("from_deg: 0", "from_deg: -10", "try.yaml:5: air.wind.from_deg: -10 is out of range (allowed: at least 0, at most 360)"),
        ("[36.52, -84.12]", "[136.52, -84.12]", "try.yaml:11: flight.lines.0.end_deg.0: 136.52 is out of range (allowed: at least -90, at most 90)"),
        ("[36.52, -84.12]", "[36.52]", "try.yaml:11: flight.lines.0.end_deg: has 1 value (at least 2)"),
        ("[36.52, -84.12]", "[36.52, -84.12, 300]", "try.yaml:11: flight.lines.0.end_deg: has 3 values (allowed: 2)"),
        ("[36.52, -84.12]", "east", "try.yaml:11: flight.lines.0.end_deg: 'east' is not a list (allowed: a list)"),
        ("source: pine_mountain", "source: 3", "try.yaml:3: terrain.source: is neither a name nor a pair of files (allowed: the name of a shipped terrain, or {orthophoto: FILE, elevation: FILE})"),
        ("source: pine_mountain", "source: {orthophoto: a.tif}", "try.yaml:3: terrain.source.elevation: is missing (elevation model, GeoTIFF, heights in m)"),
        ("source: pine_mountain", "source: pine_mountain\n  vertical_datum: egm69", "try.yaml:4: terrain.vertical_datum: 'egm69' is not known (allowed: file, ellipsoidal, egm96, egm2008, or {undulation_m: VALUE}; did you mean egm96?)"),
        ("name: try", "name: a/b", "try.yaml:1: name: 'a/b' cannot be used (allowed: letters, digits, _ . -; the run directory is named after it)"),
        ("name: try\n", "", "try.yaml:1: name: is missing (letters, digits, _ . -; the run directory is named after it)"),
        ("name: try", "name: try\nschema: 2", "try.yaml:2: schema: 2 is not known (allowed: 1)"),
        ("name: try", "name: try\nmount: null", "try.yaml:2: mount: null is not a section (allowed: a section of KEY: VALUE lines)"),
        ("name: try", "name: try\nseed: 1.5", "try.yaml:2: seed: 1.5 is not a whole number (allowed: a whole number, at least 0, at most 9007199254740992)"),
        ("name: try", "name: try\ncontrol: {mode: pipelind}", "try.yaml:2: control.mode: unknown mode 'pipelind' (allowed: fixed, ideal, navigator, schmelovsky_1988, pipelined, best, gnss_ins; did you mean pipelined?)"),
        ("name: try", "name: try\nccd_rows: {exposure_s: fast}", "try.yaml:2: ccd_rows.exposure_s: 'fast' is not known (allowed: auto, or a number)"),
        ("name: try", "name: try\nexpect: {crab.residual_deg: {max: 2}}", "try.yaml:2: expect.crab.residual_deg: is no number of summary.json (did you mean crab.residual_rms_deg?)"),
        ("name: try", "name: try\nexpect: {crab.settle_s: {}}", "try.yaml:2: expect.crab.settle_s: asks for nothing (allowed: {min: NUMBER}, {max: NUMBER} or both)"),
        ("name: try", "name: try\nexpect: {crab.settle_s: {min: 3, max: 2}}", "try.yaml:2: expect.crab.settle_s: min 3 is above max 2 (min at most max)"),
    ],
)  # fmt: skip
def test_each_fault_has_its_line(refused: Refused, good: str, old: str, new: str, line: str) -> None:
    assert good.count(old) == 1
    assert refused(good.replace(old, new)) == line


def test_of_several_faults_the_lowest_line_is_told(refused: Refused, good: str) -> None:
    text = good.replace("height_m: 3000", "height_m: -1").replace("pine_mountain", "5") + "zzz: 1\n"
    assert refused(text).startswith("try.yaml:3: terrain.source: ")
    assert refused(text.replace("source: 5", "source: pine_mountain")).startswith("try.yaml:7: flight.height_m: ")


@pytest.mark.parametrize(
    ("setting", "line"),
    [
        ("air.wind.speed=5", "--set air.wind.speed: unknown key, without its unit (did you mean speed_m_s?)"),
        ("air.wnd.speed_m_s=5", "--set air.wnd: unknown key (did you mean wind?)"),
        ("flight.height_m=-3", "--set flight.height_m: -3 is out of range (allowed: more than 0, at most 20000)"),
        ("flight.lines.0.start_deg.0=99", "--set flight.lines.0.start_deg.0: 99 is out of range (allowed: at least -90, at most 90)"),
        ("flight.lines.1.start_deg=[1, 2]", "--set flight.lines.1.start_deg: the list has no element '1' (allowed: 0 to 0)"),
        ("terrain.relief_factor=-0.5", "--set terrain.relief_factor: -0.5 is out of range (allowed: at least 0, at most 10)"),
        ("flight.lines=[]", "--set flight.lines: has 0 values (allowed: at least 1)"),
        ("expect.crab.rms.max=3", "--set expect.crab.rms: is no number of summary.json (did you mean crab.residual_rms_deg?)"),
        ("seed=*x", "--set seed: anchors and aliases are not read (write the value out)"),
        ("seed=[", "--set seed: is no YAML"),
        ("seed", "--set: 'seed' sets nothing (KEY.PATH=VALUE, as air.wind.speed_m_s=5)"),
        ("air..wind=3", "--set: 'air..wind=3' sets nothing (KEY.PATH=VALUE, as air.wind.speed_m_s=5)"),
        ("=3", "--set: '=3' sets nothing (KEY.PATH=VALUE, as air.wind.speed_m_s=5)"),
    ],
)  # fmt: skip
def test_settings_go_through_the_same_check(write: Write, good: str, setting: str, line: str) -> None:
    with pytest.raises(InputError) as caught:
        load(write(good), [parse_setting(setting)])
    assert str(caught.value).startswith(line)


def test_a_setting_replaces_one_value(write: Write, good: str) -> None:
    file = write(good)
    texts = ["air.wind.speed_m_s=7.5", "expect.crab.residual_rms_deg.max=2", "air.turbulence={sigma_m_s: 0.3}"]
    texts += ["expect.crab.split_deg.lag.max=0.5", "expect.vh.split_pct.relief={max: 4}"]
    got = load(file, [parse_setting(text) for text in texts])
    assert got.air.wind.model_dump() == {"speed_m_s": 7.5, "from_deg": 0.0}
    assert got.expect["crab.residual_rms_deg"].max == 2
    assert got.expect["crab.split_deg.lag"].max == 0.5
    assert got.expect["vh.split_pct.relief"].max == 4
    assert got.air.turbulence.sigma_m_s == 0.3
    assert got.flight == load(file).flight
    assert got.where("air.wind.speed_m_s") == "--set"
    assert got.where("air.wind.from_deg") == f"{file}:5"


def test_overrides_from_python(write: Write, good: str) -> None:
    assert load_scenario(write(good), {"seed": 5, "flight.height_m": 2500}).seed == 5
    with pytest.raises(InputError, match=r"^override flight\.height: unknown key, without its unit"):
        load_scenario(write(good), {"flight.height": 2500})


def test_a_setting_mends_what_the_file_has_wrong(write: Write, good: str) -> None:
    file = write(good.replace("height_m: 3000", "height_m: -1"))
    assert load(file, [parse_setting("flight.height_m=2000")]).flight.height_m == 2000


def test_places_point_at_the_nearest_key_written(write: Write, good: str) -> None:
    file = write(good)
    got = load(file)
    assert got.where("terrain.source") == f"{file}:3"
    assert got.where("flight.lines.0") == f"{file}:10"
    assert got.where("flight.bank_max_deg") == f"{file}:6"
    assert got.where("record.period_s") == f"{file}:1"
    assert str(got.error("terrain.source", "is dry", "water")) == f"{file}:3: terrain.source: is dry (water)"
    late = InputError("is dry", key="terrain.source")
    assert str(got.place(late)) == f"{file}:3: terrain.source: is dry"
    placed = InputError("is dry", where="elsewhere")
    assert got.place(placed) is placed


def test_paths_are_relative_to_the_file(
    write: Write, good: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = write(good.replace("pine_mountain", "{orthophoto: land/a.tif, elevation: /abs/b.tif}"))
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    monkeypatch.chdir(elsewhere)
    source = load(file).terrain.source
    assert not isinstance(source, str)
    assert source.orthophoto == str((tmp_path / "land/a.tif").resolve())
    assert source.elevation == "/abs/b.tif"
    # those of an option are relative to where the user stands
    source = load(file, [parse_setting("terrain.source.orthophoto=c.tif")]).terrain.source
    assert not isinstance(source, str)
    assert source.orthophoto == str((elsewhere / "c.tif").resolve())


def test_names_of_shipped_scenarios(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert {"crosswind", "gusty", "calm"} <= set(shipped())
    assert load("calm").name == "calm"
    with pytest.raises(
        InputError, match=r"^croswind: no such scenario file or shipped name \(did you mean crosswind\?\)"
    ):
        load("croswind")
    with pytest.raises(
        InputError, match=r"no such scenario file or shipped name \(shipped: block_area, calm, crosswind, gusty"
    ):
        load("zzzz.yaml")
    with pytest.raises(InputError, match=r"is a folder"):
        load(tmp_path)
    with pytest.raises(InputError, match=r"cannot be read: File name too long"):
        load("x" * 5000)


def test_mode_1988_sets_its_defaults_unless_told_otherwise(write: Write, good: str) -> None:
    file = write(good + "control: {mode: schmelovsky_1988}\n")
    got = load(file)
    assert (got.ccd_rows.mounted_on, got.ccd_rows.extension) == ("airframe", "padded")
    assert got.estimation.strip_period_s is None
    assert not got.estimation.subpixel
    assert (got.estimation.crab.gamma, got.estimation.vh.gamma) == (0.01, 0.01)
    assert got.ccd_rows.pixels_px == 96
    told = load(file, [parse_setting("estimation.crab.gamma=null"), parse_setting("ccd_rows.mounted_on=camera")])
    assert told.estimation.crab.gamma is None
    assert told.estimation.vh.gamma == 0.01
    assert told.ccd_rows.mounted_on == "camera"


def test_another_mode_brings_its_own_defaults(write: Write, good: str) -> None:
    base = load(write(good))
    old = with_overrides(base, {"control.mode": "schmelovsky_1988"})
    assert old.ccd_rows.mounted_on == "airframe"
    assert with_overrides(old, {"control.mode": "pipelined"}) == base
    changed = base.model_copy(update={"seed": 7})
    assert with_overrides(changed, {"flight.height_m": 2000}).seed == 7


def test_from_a_mapping(good: str, write: Write) -> None:
    from aerosim.scenario.reader import parse

    assert from_mapping(parse(good, "x")[0]) == load(write(good))
    with pytest.raises(InputError, match=r"^terrain: is missing \(which land is flown over\)$"):
        from_mapping({"name": "x", "flight": {"lines": [{"start_deg": [1, 2], "end_deg": [1, 3]}]}})


def test_a_scenario_cannot_be_changed_and_can_be_sent(write: Write, good: str) -> None:
    got = load(write(good))
    with pytest.raises(ValidationError, match="frozen"):
        got.flight.height_m = 2000  # type: ignore[misc]
    sent = pickle.loads(pickle.dumps(got))
    assert sent == got
    assert isinstance(sent, Scenario)
    assert sent.where("terrain.source") == got.where("terrain.source")
