from __future__ import annotations

import math
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from aerosim import assets
from aerosim.cli.app import call
from aerosim.errors import InputError
from aerosim.flight import fdm, properties
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.limits import Limits
from aerosim.flight.own import contract, probe, xmlcheck
from aerosim.flight.own.probe import check_model
from aerosim.truth import AircraftState

from ..conftest import still

MODEL, PILOT, LIMITS = "own.xml", "Systems/autopilot.xml", "limits.yaml"
Make = Callable[..., Path]


@pytest.fixture
def own(folder: Path, tmp_path: Path) -> Make:
    """A user's folder: the survey twin under another name, texts of one file changed."""

    def make(file: str = MODEL, *changes: tuple[str, str], name: str = "own") -> Path:
        target = tmp_path / name
        shutil.copytree(folder, target)
        (target / "survey_twin.xml").rename(target / f"{name}.xml")
        path = target / file
        text = path.read_text(encoding="utf-8") if changes else ""
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        if changes:
            path.write_text(text, encoding="utf-8")
        return target

    return make


def refusal(folder: Path) -> str:
    with pytest.raises(InputError) as caught:
        check_model(folder, 120.0)
    line = str(caught.value)
    assert "\n" not in line
    assert "Traceback" not in line
    return line


def turbulent(folder: Path) -> list[AircraftState]:
    """A flight through air that shakes each quarter of a second, in a turn."""
    aircraft = Aircraft(folder, 120.0)
    aircraft.start(0.89, 0.2, 3000.0, 1.0, 69.44, (-8.0, 2.0, 0.0))
    aircraft.command_roll(0.2)
    states = []
    for step in range(80):
        air = still(-8.0 + math.sin(7.0 * step), 2.0)._replace(p=0.05 * math.cos(3.0 * step), r=0.01)
        aircraft.feel(air, (0.0,) * 9)
        aircraft.advance(30)
        states.append(aircraft.state())
    return states


@pytest.mark.parametrize("name", ["own", "my own twin", "Flugzeug für Übung", "飛行機", "twin.v2", "-x"])
def test_a_good_copy_passes_and_flies_the_same_to_the_bit(folder: Path, own: Make, name: str) -> None:
    copy = own(name=name)
    before = {path: path.stat().st_mtime_ns for path in copy.rglob("*")}
    check_model(copy, 120.0, 540.0)
    assert {path: path.stat().st_mtime_ns for path in copy.rglob("*")} == before
    assert turbulent(copy) == turbulent(folder)


def test_a_good_copy_in_other_shapes(own: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # The autopilot beside the model, a link to the folder under its name, a relative path, another rate, a thread.
    copy = own()
    (copy / PILOT).rename(copy / "autopilot.xml")
    check_model(copy, 240.0, 100.0)
    (tmp_path / "links").mkdir()
    link = tmp_path / "links" / "other"
    link.symlink_to(copy, target_is_directory=True)
    shutil.copy(copy / MODEL, copy / "other.xml")
    check_model(link, 120.0)
    Aircraft(link, 120.0)
    monkeypatch.chdir(copy)
    check_model(Path("."), 120.0)
    monkeypatch.chdir(tmp_path)
    found: list[InputError] = []

    def check() -> None:
        try:
            check_model(Path("own"), 60.0)
        except InputError as error:
            found.append(error)

    thread = threading.Thread(target=check)
    thread.start()
    thread.join()
    assert found == []


@pytest.mark.parametrize("name", sorted(p.parent.name for p in assets.folder("aircraft").glob("*/limits.yaml")))
def test_what_ships_passes(name: str) -> None:
    check_model(assets.folder("aircraft") / name, 120.0)


def test_tried_once_as_long_as_the_files_stay(own: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    copy = own(MODEL, ("aero/beta-rad", "aero/betta-rad"))
    first = refusal(copy)
    calls: list[list[str]] = []
    run = probe._run

    def count(arguments: list[str]) -> probe._End:
        calls.append(arguments)
        return run(arguments)

    monkeypatch.setattr(probe, "_run", count)
    assert refusal(copy) == first
    assert calls == []
    text = (copy / MODEL).read_text(encoding="utf-8")
    (copy / MODEL).write_text(text.replace("aero/betta-rad", "aero/beta-rad"), encoding="utf-8")
    check_model(copy, 120.0)
    assert len(calls) == 1
    # Fuel that it cannot carry is the scenario's fault, not the model's.
    check_model(copy, 120.0, 1e6)
    assert len(calls) == 1


SYSTEM = '<system file="autopilot"/>'
BOMB = """<!DOCTYPE fdm_config [<!ENTITY a "haha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">
<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]>
<fdm_config"""
OUTSIDE = '<!DOCTYPE fdm_config SYSTEM "file:///etc/hostname">\n<fdm_config'
LIFT = "<value>-5.66</value>"
CIRCLE = """<function name="aero/one"><sum><property>aero/two</property><value>1</value></sum></function>
<function name="aero/two"><sum><property>-aero/one</property><value>1</value></sum></function>
<axis name="X">"""

STATIC = {
    "no version of XML ends so early": (MODEL, (), r"own/own.xml:\d+: not well-formed XML: .+"),
    "entity bomb": (MODEL, ("<fdm_config", BOMB), r"own/own.xml:3: document type with entities \(plain XML"),
    "external entity": (MODEL, ("<fdm_config", OUTSIDE), r"own/own.xml:3: document type with entities"),
    "missing system file": (
        MODEL,
        (SYSTEM, '<system file="autopilott"/>'),
        r'own/own.xml:\d+: no file "autopilott" for <system> \(a file in own or own/Systems\)',
    ),
    "file above the folder": (
        MODEL,
        (SYSTEM, '<system file="../../autopilot"/>'),
        r'own/own.xml:\d+: file="../../autopilot" lies outside the folder \(files inside own/\)',
    ),
    "absolute file": (MODEL, (SYSTEM, '<system file="/etc/hostname"/>'), r'file="/etc/hostname" lies outside'),
    "includes itself": (
        PILOT,
        ('<system name="autopilot">', '<system name="autopilot"><system file="autopilot"/>'),
        r'own/Systems/autopilot.xml:\d+: file="autopilot" includes itself',
    ),
    "another root": (
        PILOT,
        ("system", "sistem"),
        r"own/Systems/autopilot.xml:\d+: root element <sistem> \(<system>\)",
    ),
    "NaN": (MODEL, (LIFT, "<value>nan</value>"), r"own/own.xml:\d+: <value> of 'nan' \(a finite number\)"),
    "comma": (MODEL, (LIFT, "<value>-5,66</value>"), r"own/own.xml:\d+: <value> of '-5,66' \(a finite number\)"),
    "circle": (
        MODEL,
        ('<axis name="X">', CIRCLE),
        r"own/own.xml:\d+: function without an end: aero/one -> aero/two -> aero/one",
    ),
    "output": (
        MODEL,
        ("<aerodynamics>", '<output name="x.csv" type="CSV" rate="1"/><aerodynamics>'),
        r"own/own.xml:\d+: <output> writes files or sends data by itself \(take it out",
    ),
    "input": (
        MODEL,
        ("<aerodynamics>", '<input port="5555"/><aerodynamics>'),
        r"own/own.xml:\d+: <input> listens to the network by itself",
    ),
    "child": (
        MODEL,
        ("<aerodynamics>", '<child name="survey_twin"/><aerodynamics>'),
        r"own/own.xml:\d+: <child> loads another model by itself",
    ),
    "name too long": (MODEL, ('"autopilot"', f'"{"a" * 5000}"'), r'own/own.xml:\d+: no file "aaa'),
    "nested": (MODEL, (LIFT, "<sum>" * 300 + LIFT + "</sum>" * 300), r"nested deeper than 200"),
}


@pytest.mark.parametrize("case", STATIC)
def test_refused_before_jsbsim_sees_it(own: Make, monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    file, change, message = STATIC[case]
    copy = own(file, *([change] if change else []))
    if not change:
        text = (copy / MODEL).read_bytes()
        (copy / MODEL).write_bytes(text[: len(text) // 2])
    monkeypatch.setattr(probe, "_run", None)
    assert re.search(message, refusal(copy))


def test_spoilt_bytes_are_read_or_refused(own: Make) -> None:
    # Bytes struck out, doubled, turned into others: the reader knows only two ends.
    copy, rng, refused = own(), np.random.default_rng(2), 0
    text = (copy / MODEL).read_bytes()
    for _ in range(300):
        first, length = rng.integers(0, len(text)), rng.integers(1, 30)
        middle = [b"", text[first : first + length] * 2, rng.bytes(length)][rng.integers(3)]
        (copy / MODEL).write_bytes(text[:first] + middle + text[first + length :])
        try:
            xmlcheck.check_xml(copy)
        except InputError:
            refused += 1
    assert 150 < refused < 300


LIMIT_CASES = {
    "model: own_twin\n": r"own/limits.yaml: lacks wing_area_m2 \(model, wing_area_m2",
    "model: [1\n": r"own/limits.yaml:2: not YAML: .+",
    "- 1\n": r"own/limits.yaml: no table of keys and values",
    "a: &a [1, 2]\nb: *a\n": r"own/limits.yaml:1: not a key and a plain value",
    "\xff": r"own/limits.yaml: not YAML in UTF-8",
    "model: x\n1: 2\n": r"own/limits.yaml:2: unknown key 1 \(model, wing_area_m2",
}


@pytest.mark.parametrize("text", LIMIT_CASES)
def test_limits_that_are_none(own: Make, text: str) -> None:
    copy = own()
    (copy / LIMITS).write_bytes(text.encode("latin-1"))
    assert re.search(LIMIT_CASES[text], refusal(copy))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("wing_area_m2", "-39", "wing_area_m2: -39 is not possible (1 to 1000 m2)"),
        ("wing_area_m2", "heavy", "wing_area_m2 is not a number"),
        ("lift_max", ".nan", "lift_max is not a number"),
        ("stall_margin", "0.5", "stall_margin: 0.5 is not possible (1 to 2)"),
        ("height_max_m", "-450", "height_max_m: -450 is not possible (above height_min_m"),
        ("alpha_max_deg", "0", "alpha_max_deg: 0 is not possible"),
        ("fuel_kg", "2000", "fuel_kg: 2000 is not possible (above 0, up to fuel_max_kg)"),
        ("fuel_max_kg", "9000", "fuel_max_kg: 9000 is not possible"),
        ("equivalent_airspeed_max_m_s", "30", "equivalent_airspeed_max_m_s: 30 is not possible (above"),
        ("model", "7", "model: 7 is not a text"),
        # Possible, but another aircraft's than the model's.
        ("wing_area_m2", "25", "wing area of 39.02 m2 in the model, wing_area_m2 of 25 in limits.yaml"),
        ("mass_empty_kg", "5000", "mass of 4600 kg in the model with 540 kg of fuel, mass_empty_kg and fuel of 5"),
    ],
)  # fmt: skip
def test_limits_that_cannot_be(own: Make, key: str, value: str, message: str) -> None:
    copy = own()
    text = (copy / LIMITS).read_text(encoding="utf-8")
    (copy / LIMITS).write_text(re.sub(rf"(?m)^{key}: \S+", f"{key}: {value}", text), encoding="utf-8")
    assert message in refusal(copy)


def test_folders_without_a_model(own: Make, tmp_path: Path) -> None:
    assert refusal(tmp_path / "none") == "no aircraft folder none"
    copy = own()
    assert "no aircraft folder own.xml" in refusal(copy / MODEL)
    (copy / MODEL).rename(copy / "other.xml")
    assert refusal(copy) == "own: no aircraft model own.xml in it (a file named like its folder)"
    (copy / "other.xml").rename(copy / MODEL)
    (copy / LIMITS).unlink()
    assert refusal(copy) == "own/limits.yaml: no such file"


def test_links_out_of_the_folder_and_too_large_files(own: Make, tmp_path: Path) -> None:
    copy = own()
    outside = tmp_path / "outside.xml"
    (copy / PILOT).rename(outside)
    (copy / PILOT).symlink_to(outside)
    assert 'file="autopilot" lies outside the folder' in refusal(copy)
    (copy / PILOT).unlink()
    (copy / PILOT).symlink_to(copy / PILOT)
    assert 'no file "autopilot" for <system>' in refusal(copy)
    (copy / PILOT).unlink()
    (copy / PILOT).write_bytes(b"<system>" + b" " * xmlcheck.FILE_MAX + b"</system>")
    assert refusal(copy) == "own/Systems/autopilot.xml: larger than 5 MB"


# Found only by JSBSim or in flight.
TRIED = {
    "unknown property in a function": (
        MODEL,
        (("aero/beta-rad", "aero/betta-rad"),),
        r"own/own.xml:\d+: JSBSim crashed \(SIGABRT\) while it was loaded: .* aero/betta-rad does not exist",
    ),
    "property of the contract": (
        MODEL,
        (("gust/r-rad_sec", "gust/rr-rad_sec"),),
        r"own: the model lacks the property gust/r-rad_sec \(rotation of the air about a body axis.*, rad/s\)",
    ),
    "no autopilot": (MODEL, ((SYSTEM, ""),), r"own.xml:\d+: JSBSim crashed .* The property \S+ does not exist"),
    "unit that JSBSim does not know": (MODEL, (('unit="FT2"', 'unit="ACRE"'),), r"own.xml:9: \S+ unit: .ACRE"),
    "written, but not by us": (
        PILOT,
        (
            (
                '<channel name="longitudinal">',
                '<channel name="longitudinal"><fcs_function name="trim/rudder-rad"><function><value>0</value>'
                "</function></fcs_function>",
            ),
        ),
        r"the property trim/rudder-rad cannot be written \(a plain <property>",
    ),
    "gusts without effect": (
        MODEL,
        (("<property>gust/q-rad_sec</property></diff", "<value>0</value></diff"),),
        r"the property gust/q-rad_sec does not take the aircraft along \(the aerodynamics see",
    ),
    "gusts with the other sign": (
        MODEL,
        (
            (
                "<difference><property>velocities/p-rad_sec</property><property>gust/p-rad_sec</property></difference>",
                "<sum><property>velocities/p-rad_sec</property><property>gust/p-rad_sec</property></sum>",
            ),
        ),
        r"the property gust/p-rad_sec does not take the aircraft along",
    ),
    "not finite": (
        MODEL,
        ((LIFT, "<quotient><value>0</value><value>0</value></quotient>"),),
        r"own: (not finite at \d+ m and \d+\.\d m/s|cannot be trimmed)",
    ),
    "elevator without effect": (
        MODEL,
        (("<value>-1.74</value>", "<value>0</value>"), ("<value>-0.608</value>", "<value>0</value>")),
        r"own: cannot be trimmed within limits.yaml, for example at \d+ m and \d+\.\d m/s: .* \(a steady level",
    ),
    "too little power": (
        PILOT,
        (("<value>924000.0</value>", "<value>92400.0</value>"),),
        r"cannot be trimmed within limits.yaml, for example at .* too little power for",
    ),
    "rolls the wrong way": (
        PILOT,
        (("<kp>0.8</kp>", "<kp>-0.8</kp>"), ("<ki>0.04</ki>", "<ki>0</ki>")),
        r"own/Systems/autopilot.xml:\d+: the autopilot rolled by -\d+",
    ),
    "roll not commanded": (
        PILOT,
        (("<property>ap/roll-cmd-rad</property></difference>", "<value>0</value></difference>"),),
        r"the autopilot rolled by -?\d\.\d deg in 3 s, ap/roll-cmd-rad rose by 6.0 deg",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", TRIED)
def test_refused_by_the_probe(own: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    file, changes, message = TRIED[case]
    copy = own(file, *changes)
    monkeypatch.chdir(tmp_path)
    assert re.search(message, refusal(copy))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["own"]


def test_a_model_without_an_end_is_ended(own: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    # Each function reads the next one twice: 2^40 evaluations, no circle.
    twice = "<sum><property>aero/f{0}</property><property>aero/f{0}</property></sum></function>"
    chain = "".join(f'<function name="aero/f{k}">' + twice.format(k - 1) for k in range(40, 0, -1))
    chain += '<function name="aero/f0"><value>0</value></function><axis name="X">'
    copy = own(MODEL, ('<axis name="X">', '<axis name="X">' + chain.replace('<axis name="X">', "")))
    monkeypatch.setattr(probe, "TIME_LIMIT_S", 1.5)
    children: list[subprocess.Popen[bytes]] = []
    popen = subprocess.Popen

    def remember(*arguments: object, **options: object) -> subprocess.Popen[bytes]:
        children.append(popen(*arguments, **options))  # type: ignore[call-overload]
        return children[-1]

    monkeypatch.setattr(subprocess, "Popen", remember)
    assert refusal(copy) == (
        "own: JSBSim did not end within 1.5 s while it was loaded (a model that steps in microseconds)"
    )
    assert children[0].poll() is not None
    if hasattr(os, "killpg"):
        with pytest.raises(ProcessLookupError):
            os.killpg(children[0].pid, 0)


def test_warnings_are_passed_on_at_once(own: Make) -> None:
    # A process that JSBSim ends has no time to tell them later.
    heard: list[str] = []
    with pytest.raises(InputError, match="refused"):
        fdm.load(own(MODEL, ('unit="FT2"', 'unit="ACRE"')), 120.0, heard.append)
    assert heard == ['own.xml:9: Supplied unit: "ACRE" does not exist (typo?).']


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not keep to the limit")
def test_memory_is_bounded() -> None:
    code = f"from aerosim.flight.own import probe; probe._bound(); bytearray({probe.MEMORY_LIMIT})"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert "MemoryError" in ended.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="other systems have other limits")
def test_a_trial_ends_though_nobody_waits_for_it() -> None:
    code = "from aerosim.flight.own import probe\nprobe.TIME_LIMIT_S = 0.5\nprobe._bound()\nwhile True: pass"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, timeout=30.0, check=False)
    assert ended.returncode == -signal.SIGXCPU


def test_the_words_of_a_crash() -> None:
    assert probe._last_words(["terminate called", "what():  the property x", ""]) == "the property x"
    assert probe._last_words(["one", "two", ""]) == "two"
    assert probe._last_words([]) == ""


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
@pytest.mark.parametrize(
    ("end", "message"),
    [
        (probe._End(-11, "trim", None, ""), "own: JSBSim crashed (SIGSEGV) while it was trimmed, as functions"),
        (probe._End(-9, "load", None, ""), "own: JSBSim crashed (SIGKILL) while it was loaded, as a model that"),
        (
            probe._End(1, "start", None, "no module"),
            "own: JSBSim crashed (exit code 1) before it was loaded: no mo",
        ),
        (probe._End(0, "fly", None, ""), "own: JSBSim crashed (exit code 0) in its first seconds of flight"),
    ],
)
def test_other_ends_of_the_probe(
    own: Make, monkeypatch: pytest.MonkeyPatch, end: probe._End, message: str
) -> None:
    monkeypatch.setattr(probe, "_run", lambda _: end)
    assert refusal(own()).startswith(message)


SCENARIO = """\
name: own
terrain: {source: pine_mountain}
aircraft: {model: ./own}
flight: {lines: [{start_deg: [36.52, -84.38], end_deg: [36.52, -84.12]}]}
"""


@pytest.mark.parametrize("verb", ["run", "check"])
def test_command_line_refuses_a_bad_model(
    own: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], verb: str
) -> None:
    # Loaded into the command's own process this model ends it with SIGABRT and a traceback.
    own(MODEL, ("aero/beta-rad", "aero/betta-rad"))
    monkeypatch.chdir(tmp_path)
    Path("own.yaml").write_text(SCENARIO, encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    assert call([verb, "own.yaml"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert re.fullmatch(r"own.yaml:3: aircraft.model: own/own.xml:\d+: JSBSim crashed .+ does not exist\n", err)
    assert sorted(tmp_path.rglob("*")) == before


def test_command_line_takes_a_good_model(
    own: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    own()
    (tmp_path / "missions").mkdir()
    monkeypatch.chdir(tmp_path)
    # Relative to the scenario file, not to where the command is given.
    Path("missions/own.yaml").write_text(SCENARIO.replace("./own", "../own"), encoding="utf-8")
    assert call(["check", "missions/own.yaml", "-q"]) == 0, capfd.readouterr()


# The page that tells users the contract.

PAGE = Path(__file__).parents[3] / "docs" / "own_aircraft.md"


def test_the_contract_is_what_the_aircraft_uses() -> None:
    assert sorted(each.name for each in contract.PROPERTIES) == sorted(properties.NAMES)


def rows(heading: str) -> list[list[str]]:
    section = PAGE.read_text(encoding="utf-8").split(f"\n## {heading}\n")[1].split("\n## ")[0]
    table = [line for line in section.splitlines() if line.startswith("| `")]
    return [[cell.strip().strip("`") for cell in line.strip("|").split(" | ")] for line in table]


def test_page_lists_the_properties_and_limits() -> None:
    found = rows("Properties that the model declares") + rows("Properties that JSBSim makes")
    wanted = [
        [
            each.name,
            each.unit,
            "aerosim" if each.written else each.made_by.replace("jsbsim", "JSBSim"),
            each.meaning,
        ]
        for each in contract.PROPERTIES
    ]
    assert found == wanted
    text = PAGE.read_text(encoding="utf-8")
    assert f"({probe.TIME_LIMIT_S:g} s) and memory ({probe.MEMORY_LIMIT >> 30} GB)" in text
    assert f"files above {xmlcheck.FILE_MAX / 1e6:g} MB, more than {xmlcheck.FILES_MAX} of them" in text
    assert f"deeper than {xmlcheck.DEPTH_MAX}" in text
    assert [row[0] for row in rows("limits.yaml")] == [field.name for field in fields(Limits)]
