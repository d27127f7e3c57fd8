"""The commands as a user meets them: exit code, stdout, one line on stderr, nothing left behind."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

import errno
import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any, NamedTuple

import pytest

from aerosim.cli.app import call
from aerosim.errors import InputError, RunFailure
from aerosim.scenario import load

GOOD = """\
name: try
terrain: {source: pine_mountain}
flight:
  lines:
    - {start_deg: [36.52, -84.38], end_deg: [36.52, -84.12]}
"""


class Result(NamedTuple):
    code: int
    out: str
    err: str


Aerosim = Callable[..., Result]


@pytest.fixture
def aerosim(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Aerosim:
    """Runs a command line in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*args: str) -> Result:
        code = call(args)
        return Result(code, *capsys.readouterr())

    return run


@pytest.fixture
def flown(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
    """Stands in for the flight; what it was called with."""
    import aerosim as package

    calls: list[dict[str, Any]] = []

    def run(scenario: Any, out: Path | None = None, *, overwrite: bool = False, progress: Any = None) -> Any:
        calls.append({"scenario": scenario, "out": out, "overwrite": overwrite})
        if progress is not None:
            for second in range(101):
                progress(float(second), 100.0)
        summary = {
            "crab": {"residual_rms_deg": 1.25, "accepted_pct": None},
            "notes": {"crab.accepted_pct": "no strips"},
        }
        return SimpleNamespace(
            path=out or Path("runs", scenario.name, str(scenario.seed)), summary=summary, status="done"
        )

    monkeypatch.setattr(package, "run", run, raising=False)
    return calls


def refused(result: Result, line: str) -> None:
    assert result.code == 2
    assert result.out == ""
    assert result.err.rstrip("\n") == line


# --- what is there -------------------------------------------------------------------------------------------


def test_help_names_every_verb(aerosim: Aerosim) -> None:
    result = aerosim("--help")
    assert result.code == 0
    for verb in ("run", "check", "list", "new", "schema", "view", "report", "terrain"):
        assert f"\n  {verb} " in result.out
        assert aerosim(verb, "--help").code == 0


def test_version_is_the_packages(aerosim: Aerosim) -> None:
    from importlib.metadata import version

    assert aerosim("--version") == Result(0, f"aerosim {version('aerosim-survey')}\n", "")


def test_help_loads_no_heavy_library() -> None:
    """What would make `aerosim --help` slow: half a second is the limit, pydantic and numpy alone take a third of it."""
    heavy = "numpy pydantic rasterio pyproj matplotlib rerun jsbsim pyarrow scipy numba"
    code = (
        "import sys; from aerosim.cli.app import call; code = call(['--help'])\n"
        f"print([name for name in '{heavy}'.split() if name in sys.modules], file=sys.stderr); sys.exit(code)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"


def test_the_module_runs_as_the_command_does(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "aerosim", "run", "nowhere.yaml"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.startswith(
        "nowhere.yaml: no such scenario file or shipped name (shipped: block_area, calm,"
    )
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_reader_who_leaves_is_no_error() -> None:
    done = subprocess.run(
        f"{shlex.quote(sys.executable)} -m aerosim schema | head -n 1",
        shell=True,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stdout, done.stderr) == ("{\n", "")


# --- wrong command lines -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "line"),
    [
        ((), "Missing command (see aerosim --help)"),
        (("fly",), "No such command 'fly' (see aerosim --help)"),
        (("run",), "Missing argument 'SCENARIO' (see aerosim run --help)"),
        (("run", "calm", "--sed", "3"), "No such option: --sed"),
        (("run", "calm", "--seed", "x"), "Invalid value for '--seed': "),
        (
            ("run", "calm", "--seed", "-1"),
            "--seed: -1 is out of range (allowed: at least 0, at most 9007199254740992)",
        ),
        (("run", "calm", "--live"), "--live: is not available in this version (aerosim view RUN, afterwards)"),
        (("run", "croswind"), "croswind: no such scenario file or shipped name (did you mean crosswind?)"),
        (("check", "croswind"), "croswind: no such scenario file or shipped name (did you mean crosswind?)"),
        (
            ("run", "calm", "--set", "flight.height_m"),
            "--set: 'flight.height_m' sets nothing (KEY.PATH=VALUE, as air.wind.speed_m_s=5)",
        ),
        (
            ("run", "calm", "--set", "flight.speed=50"),
            "--set flight.speed: unknown key, without its unit (did you mean airspeed_m_s?)",
        ),
        (
            ("run", "calm", "--set", "control.mode=my_modes:Mine"),
            "--set control.mode: my_modes:Mine is not available in this version (allowed: fixed, ideal, navigator, "
            "schmelovsky_1988, pipelined, best, gnss_ins)",
        ),
        (
            ("run", "calm", "--set", "ccd_rows.period_s=0.052"),
            "--set ccd_rows.period_s: 0.052 s is no whole number of steps of 120 Hz (nearest: 0.05 or 0.0583333)",
        ),
        (
            ("new", "a/b"),
            "NAME: 'a/b' cannot be used (allowed: letters, digits, _ . -; the run directory is named after it)",
        ),
        (("view", "none"), "none: no such run directory"),
        (("report", "none"), "none: no such run directory"),
        (("terrain",), "Missing command (see aerosim terrain --help)"),
        (
            ("terrain", "info", "a.tif", "b.tif", "--vertical-datum", "sea"),
            "--vertical-datum: 'sea' is no vertical datum (allowed: file, ellipsoidal, egm96, egm2008, or the undulation in m)",
        ),
        (("terrain", "info", "a.tif", "b.tif"), "raster b.tif does not exist"),
    ],
)
def test_wrong_command_lines(
    aerosim: Aerosim, flown: list[dict[str, Any]], tmp_path: Path, args: tuple[str, ...], line: str
) -> None:
    result = aerosim(*args)
    assert result.code == 2
    assert result.out == ""
    assert result.err.startswith(line)
    assert result.err.count("\n") == 1
    assert not flown
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("verb", ["run", "check"])
@pytest.mark.parametrize(
    ("text", "line"),
    [
        (GOOD.replace("flight:", "fligt:"), "3: fligt: unknown key (did you mean flight?)"),
        (GOOD.replace("flight:", "flight:\n  airspeed: 60"), "4: flight.airspeed: unknown key, without its unit (did you mean airspeed_m_s?)"),
        (GOOD.replace("flight:", "flight:\n  height_m: high"), "4: flight.height_m: 'high' is not a number (allowed: a number, more than 0, at most 20000)"),
        (GOOD.replace("flight:", "flight:\n  height_m: .nan"), "4: flight.height_m: .nan is not a finite number (allowed: more than 0, at most 20000)"),
        (GOOD.replace("flight:", "flight:\n  height_m: -200"), "4: flight.height_m: -200 is out of range (allowed: more than 0, at most 20000)"),
        (GOOD + "record: {period_s: 0.06}", "6: record.period_s: 0.06 s is no whole number of steps of 120 Hz (nearest: 0.0583333 or 0.0666667)"),
        (GOOD + "name: again\n", "6: name: key is given twice (first in line 1)"),
        (GOOD + "purpose: !!python/name:os.system x\n", "6: purpose: tag tag:yaml.org,2002:python/name:os.system is not read (plain values)"),
        ("a: &a [x, x]\nb: &b [*a, *a]\nc: [*b, *b]\n", "1: a: anchors and aliases are not read (write the value out)"),
        ("a: " + "[" * 5000, "1: a.0: nested too deeply (at most 12 levels)"),
        ("", " is empty (a scenario; `aerosim new NAME` writes one to start from)"),
        ("\x7fELF\0\0\1", " is not a text file (YAML, UTF-8)"),
        ("- 1\n", "1: is no scenario (KEY: VALUE at the top level)"),
    ],
)  # fmt: skip
def test_wrong_files(
    aerosim: Aerosim, flown: list[dict[str, Any]], tmp_path: Path, verb: str, text: str, line: str
) -> None:
    Path("bad.yaml").write_text(text)
    refused(aerosim(verb, "bad.yaml"), f"bad.yaml:{line}")
    assert not flown
    assert [file.name for file in tmp_path.iterdir()] == ["bad.yaml"]


def test_a_file_without_permission(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("secret.yaml").write_text(GOOD)

    def denied(*_: Any, **__: Any) -> Any:  # root, as whom tests may run, reads everything
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(Path, "open", denied)
    refused(aerosim("run", "secret.yaml"), "secret.yaml: cannot be read: Permission denied")


# --- run -----------------------------------------------------------------------------------------------------


def test_run_ends_with_the_directory(aerosim: Aerosim, flown: list[dict[str, Any]]) -> None:
    Path("try.yaml").write_text(GOOD)
    result = aerosim("run", "try.yaml", "--seed", "7", "--set", "air.wind.speed_m_s=4")
    assert result.code == 0
    assert result.out.splitlines()[-1] == "runs/try/7"
    assert "crab.residual_rms_deg" in result.out
    assert flown[0]["scenario"] == load("try.yaml").model_copy(update={"seed": 7, "air": flown[0]["scenario"].air})
    assert flown[0]["scenario"].air.wind.speed_m_s == 4
    assert (flown[0]["out"], flown[0]["overwrite"]) == (None, False)
    aerosim("run", "try.yaml", "--out", "there", "--overwrite")
    assert (flown[1]["out"], flown[1]["overwrite"]) == (Path("there"), True)


@pytest.mark.parametrize(
    ("limit", "code", "line"),
    [
        ("crab.residual_rms_deg: {max: 1.25}", 0, "expect: met"),
        ("crab.residual_rms_deg: {max: 1.2}", 1, "expect not met: crab.residual_rms_deg is 1.25, above max 1.2"),
        ("crab.accepted_pct: {min: 0}", 1, "expect not met: crab.accepted_pct was not measured: no strips"),
    ],
)
def test_the_verdict_is_the_exit_code(
    aerosim: Aerosim, flown: list[dict[str, Any]], limit: str, code: int, line: str
) -> None:
    Path("try.yaml").write_text(f"{GOOD}expect: {{{limit}}}\n")
    result = aerosim("run", "try.yaml")
    assert result.code == code
    assert line in result.out.splitlines()
    assert result.out.splitlines()[-1] == "runs/try/1"
    assert aerosim("run", "try.yaml", "-q") == Result(code, "runs/try/1\n", "")
    document = json.loads(aerosim("run", "try.yaml", "--json").out)
    assert document["run"] == "runs/try/1"
    assert document["summary"]["crab"]["residual_rms_deg"] == 1.25
    assert document["unmet"] == ([] if code == 0 else [line.removeprefix("expect not met: ")])


def test_an_over_confident_filter_is_told_on_stderr(
    aerosim: Aerosim, flown: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    import aerosim as package

    found = {
        "strips": 240,
        "variance": 2.5,
        "variance_min": 0.8,
        "variance_max": 1.25,
        "verdict": "over-confident",
    }
    done = package.run(load("calm"))
    done.summary["consistency"] = {"drift": {"verdict": None}, "vh": found}
    monkeypatch.setattr(package, "run", lambda *_, **__: done)
    (line,) = aerosim("run", "calm").err.splitlines()
    assert line == (
        "warning: the v/h filter is over-confident: its innovations have 2.5 times the variance that it expects "
        "(0.8 to 1.2 would do, 240 strips)"
    )


def test_progress_is_on_stderr_and_plain_without_a_terminal(aerosim: Aerosim, flown: list[dict[str, Any]]) -> None:
    lines = aerosim("run", "calm").err.splitlines()
    assert lines[0].startswith("calm: 10 % of 100 s flown, ")
    assert len(lines) == 9
    assert all(line.endswith(" left") for line in lines)


def test_progress_on_a_terminal_is_a_bar_with_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    import io

    from aerosim.cli.console import progress_of, settings

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    settings.reset()
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    with progress_of("calm") as progress:
        assert progress is not None
        progress(30.0, 100.0)
    assert "30 of 100 s" in terminal.getvalue()
    assert "-:--:--" in terminal.getvalue()


def raising(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    import aerosim as package

    def run(*_: Any, **__: Any) -> Any:
        raise error

    monkeypatch.setattr(package, "run", run, raising=False)


def test_what_the_flight_refuses_points_at_its_line(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("try.yaml").write_text(GOOD)
    raising(monkeypatch, InputError("no terrain 'pine_mountain' ships", key="terrain.source", allowed="none"))
    refused(aerosim("run", "try.yaml"), "try.yaml:2: terrain.source: no terrain 'pine_mountain' ships (none)")
    setting = ("--set", "terrain.source=oak_valley")
    refused(aerosim("run", "try.yaml", *setting), "--set terrain.source: no terrain 'pine_mountain' ships (none)")
    raising(monkeypatch, InputError("exists", key="--out", allowed="--overwrite"))
    refused(aerosim("run", "try.yaml"), "--out: exists (--overwrite)")


def test_a_failed_run_is_3_and_keeps_its_record(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    failure = RunFailure("the aircraft was lost\nat 12 s")
    raising(monkeypatch, failure)
    assert aerosim("run", "calm") == Result(3, "", "run failed: the aircraft was lost at 12 s\n")
    failure.path = Path("runs/calm/1")  # type: ignore[attr-defined]
    result = aerosim("run", "calm")
    assert (result.code, result.out) == (3, "runs/calm/1\n")


def test_ctrl_c_is_130(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    raising(monkeypatch, KeyboardInterrupt())
    assert aerosim("run", "calm") == Result(130, "", "interrupted\n")
    stop = KeyboardInterrupt()
    stop.path = Path("runs/calm/1")  # type: ignore[attr-defined]
    raising(monkeypatch, stop)
    assert aerosim("run", "calm") == Result(130, "runs/calm/1\n", "interrupted\n")


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM])
def test_a_stop_in_flight_leaves_a_readable_record(tmp_path: Path, sign: signal.Signals) -> None:
    from aerosim import open_run

    command = [sys.executable, "-m", "aerosim", "run", "calm", "--out", "cut"]
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        assert " % of " in process.stderr.readline()  # a tenth is flown
        process.send_signal(sign)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert err.splitlines()[-1] == "interrupted"
    assert "Traceback" not in err
    kept = open_run(tmp_path / "cut")
    assert kept.status == "interrupted"
    assert 0 < len(kept.telemetry) < 20 * 900
    assert out.strip() in ("", "cut")


def test_a_traceback_only_with_debug(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    raising(monkeypatch, ZeroDivisionError("a fault\nof ours"))
    result = aerosim("run", "calm")
    assert (result.code, result.out) == (3, "")
    assert result.err == "internal error: ZeroDivisionError: a fault of ours (--debug shows where)\n"
    debug = aerosim("run", "calm", "--debug")
    assert debug.code == 3
    assert "Traceback" in debug.err
    assert "Traceback" not in aerosim("run", "calm").err  # the switch does not stick
    raising(monkeypatch, InputError("no good", key="name"))
    assert "Traceback" in aerosim("run", "calm", "--debug").err


# --- the other verbs -----------------------------------------------------------------------------------------


def test_check_prints_the_forecast(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("aerosim.forecast.check")
    forecast = {"duration_s": 812.5, "lines": [{"crab_deg": 8.28}, {"crab_deg": -0.5}], "none": None}
    module.forecast = lambda scenario: forecast | {"name": scenario.name}  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "aerosim.forecast.check", module)
    result = aerosim("check", "calm", "--set", "name=other")
    assert result.code == 0
    rows = dict(line.split(None, 1) for line in result.out.splitlines())
    assert rows == {
        "duration_s": "812.5",
        "lines.crab_deg": "8.28      -0.5",
        "none": "-",
        "name": "other",
    }
    assert json.loads(aerosim("check", "calm", "--json").out) == {**forecast, "name": "calm"}


def test_list_shows_what_ships(aerosim: Aerosim) -> None:
    lines = aerosim("list").out.splitlines()
    assert any(line.split(None, 1) == ["crosswind", load("crosswind").purpose] for line in lines)
    found = {each["name"]: each for each in json.loads(aerosim("list", "--json").out)}
    assert {"calm", "crosswind", "gusty"} <= set(found)
    assert all(each["purpose"] and each["verifies"] for each in found.values())


def test_new_writes_a_scenario_that_flies(aerosim: Aerosim, flown: list[dict[str, Any]]) -> None:
    result = aerosim("new", "survey")
    assert (result.code, result.out) == (0, "survey.yaml\n")
    assert load("survey.yaml").name == "survey"
    assert aerosim("run", "survey.yaml").code in (0, 1)
    Path("survey.yaml").write_text("mine")
    refused(aerosim("new", "survey"), "survey.yaml: file exists (another --out, or --overwrite)")
    assert Path("survey.yaml").read_text() == "mine"
    assert aerosim("new", "survey", "--overwrite").code == 0
    assert load("survey.yaml").name == "survey"
    refused(
        aerosim("new", "other", "--out", "no/where.yaml"),
        "no/where.yaml: cannot be written: No such file or directory",
    )


def test_schema_is_json(aerosim: Aerosim) -> None:
    assert set(json.loads(aerosim("schema").out)["required"]) == {"name", "terrain", "flight"}


def test_view_needs_a_recording_and_a_display(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    Path("run").mkdir()
    refused(aerosim("view", "run"), "run: the run has no run.rrd (fly it with record.rrd: true)")
    Path("run/run.rrd").write_bytes(b"RRF2")
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    refused(aerosim("view", "run"), "view: no display for the viewer (--web serves it for a browser)")


def test_view_starts_the_viewer(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    commands: list[list[str]] = []
    monkeypatch.setattr(subprocess, "call", lambda command, **_: commands.append(command) or 0)
    monkeypatch.setenv("DISPLAY", ":0")
    for run in ("one", "two"):
        Path(run).mkdir()
        Path(run, "run.rrd").write_bytes(b"RRF2")
    assert aerosim("view", "one", "two").code == 0
    assert commands[0][3:] == ["one/run.rrd", "two/run.rrd", "--port", "auto"]
    result = aerosim("view", "one", "--web")
    assert result.code == 0
    command = commands[1]
    assert command[command.index("--bind") + 1] == "127.0.0.1"
    web, data = (command[command.index(option) + 1] for option in ("--web-viewer-port", "--port"))
    assert result.out == f"http://127.0.0.1:{web}/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{data}%2Fproxy\n"


def test_report_makes_each_page_anew(aerosim: Aerosim, monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("aerosim.report.page")
    module.write_report = lambda run: run / "report.html"  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "aerosim.report.page", module)
    Path("one").mkdir()
    Path("two").mkdir()
    assert aerosim("report", "one", "two") == Result(0, "one/report.html\ntwo/report.html\n", "")
    refused(aerosim("report", "one", "none"), "none: no such run directory")
