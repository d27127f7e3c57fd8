"""`aerosim sweep`, as a user meets it: results, exit codes, one line for each mistake, Ctrl-C."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from sweeps import WIND, files, tiny, tiny_file

from aerosim.cli.app import call
from aerosim.scenario.build import terrain_of
from aerosim.sweep.results import Sweep


def test_a_sweep_prints_its_figures_and_its_directory(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a sweep"
    options = ["sweep", str(tiny_file(tmp_path)), f"--vary={WIND}=0:6:6", "--workers=0", "--out", str(out)]
    assert call(options) == 0
    shown = capsys.readouterr()
    assert shown.out.splitlines()[-1] == str(out)
    assert call(["sweep", str(out), "--resume", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["done"], told["failed"], told["flown_now"], told["sweep"]) == (2, 0, 0, str(out))


def test_a_scenario_that_always_fails(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    land = terrain_of(tiny())
    lat = 36.52
    while not land.shortfall(*land.grid.from_geodetic(*np.radians([[lat, lat], [-84.38, -84.30]]))).max() > 0.0:
        lat += 0.002
    lat -= 0.004  # on the land, but the rows see 1.2 km to each side
    line = {"start_deg": [lat, -84.38], "end_deg": [lat, -84.35]}
    file = tiny_file(tmp_path, flight={"lines": [line]})
    code = call(["sweep", str(file), f"--vary={WIND}=0,3", "--workers=0", "--out", str(tmp_path / "s")])
    shown = capsys.readouterr()
    assert code == 3
    assert "failed because" in shown.out
    assert sum("left the terrain" in line for line in shown.out.splitlines()) == 1  # one row of reasons alike
    assert shown.err.splitlines()[-1] == "run failed: no run of the sweep was done"
    assert {row["status"] for row in Sweep(tmp_path / "s").table.to_pylist()} == {"failed"}


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--vary=air.wind.speed_ms=1"], "--vary air.wind.speed_ms: unknown key (did you mean speed_m_s?)"),
        (["--vary=air.wind.speed_m_s=1,-2"], "--vary air.wind.speed_m_s: -2 is out of range"),
        (["--vary=air.wind.speed_m_s="], "--vary air.wind.speed_m_s: has no values"),
        (["--vary=air.wind.speed_m_s=5:0:1"], "a step of 1 does not lead from 5 to 0"),
        (["--vary=air.wind.speed_m_s"], "--vary: 'air.wind.speed_m_s' varies nothing"),
        ([], "--vary: nothing is varied"),
        (["--vary=air.wind.speed_m_s=1", "--seeds=0"], "--seeds: 0 is no number of seeds"),
        (["--vary=air.wind.speed_m_s=1", "--workers=-1"], "--workers: -1 processes"),
        (["--vary=air.wind.speed_m_s=1", "--keep=all"], "--keep: 'all' is not known"),
        (["--vary=air.wind.speed_m_s=1", "--vary=air.wind.speed_m_s=2"], "is varied twice"),
        (["--vary=air.wind.speed_m_s=1", "--set=flight.heigt_m=1"], "did you mean height_m"),
        (["--vary=air.wind.speed_m_s=1", "--stop-when=x"], "--stop-when: 'x' is no rule"),
        (["--vary=air.wind.speed_m_s=1", "--retry-failed"], "--retry-failed"),
    ],
)
def test_a_mistake_is_one_line_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], says: str
) -> None:
    out = tmp_path / "s"
    assert call(["sweep", str(tiny_file(tmp_path)), "--out", str(out), *options]) == 2
    shown = capsys.readouterr()
    assert says in shown.err
    assert len(shown.err.splitlines()) == 1
    assert not out.exists()


def test_the_directory_of_another_sweep(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "s"
    command = ["sweep", str(tiny_file(tmp_path)), "--workers=0", "-q", "--out", str(out)]
    assert call([*command, f"--vary={WIND}=0"]) == 0
    there = {file: file.read_bytes() for file in out.rglob("*") if file.is_file()}
    capsys.readouterr()
    for more, says in (
        ([f"--vary={WIND}=0"], f"--out: {out} exists (another directory, or --resume)"),
        ([f"--vary={WIND}=0,5", "--resume"], f"--resume: {out} holds another sweep: vary.{WIND} differs ("),
    ):
        assert call([*command, *more]) == 2
        told, said = capsys.readouterr()
        assert told == ""
        assert said.startswith(says)
        assert len(said.splitlines()) == 1
    assert {file: file.read_bytes() for file in out.rglob("*") if file.is_file()} == there


FULL = """
import resource, sys
from aerosim.cli.app import call
from aerosim.sweep import driver
limit, inner = int(sys.argv[1]), driver._Course.fly
def full(*given):
    # the disk has room for files up to this size only, from now on
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    return inner(*given)
driver._Course.fly = full
sys.exit(call(sys.argv[2:]))
"""


@pytest.mark.parametrize(("room", "kept"), [(300, 0), (8_000, 3)], ids=["runs", "table"])
def test_a_full_disk_is_told_and_it_goes_on_when_there_is_room(tmp_path: Path, room: int, kept: int) -> None:
    """Room for no run's file (some 2 kB), then for those and not for the table (some 30 kB)."""
    pytest.importorskip("resource")
    out = tmp_path / "s"
    options = ["sweep", str(tiny_file(tmp_path)), f"--vary={WIND}=0:6:3", "--workers=0", "--out", str(out)]
    ended = subprocess.run(
        [sys.executable, "-c", FULL, str(room), *options], capture_output=True, text=True, timeout=120, check=False
    )
    assert ended.returncode == 3, ended.stderr
    assert ended.stdout == f"{out}\n"
    last = ended.stderr.splitlines()[-2:]
    assert last[0] == f"run failed: {out} cannot be written: File too large; --resume goes on"
    assert "Traceback" not in ended.stderr
    assert len(files(out)) == kept
    assert not list(out.rglob(".*.part*"))
    assert call(["sweep", str(out), "--resume", "--workers=0", "-q"]) == 0
    done = Sweep(out).summary
    assert (done["done"], done["flown_now"]) == (3, 3 - kept)


def test_an_interrupt_leaves_a_directory_that_resumes(tmp_path: Path) -> None:
    out = tmp_path / "s"
    command = [sys.executable, "-m", "aerosim", "sweep", str(tiny_file(tmp_path)), f"--vary={WIND}=0:20:1"]
    process = subprocess.Popen(
        [*command, "--workers=1", "--out", str(out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    while len(files(out)) < 2 and process.poll() is None:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    told, said = process.communicate(timeout=30)
    assert process.returncode == 130, said
    assert told.splitlines()[-1] == str(out)
    assert "--resume" in said
    assert "Traceback" not in said
    there = files(out)
    assert Sweep(out).summary["status"] == "interrupted"
    assert call(["sweep", str(out), "--resume", "-q"]) == 0
    now = files(out)
    assert len(now) == 21
    assert {name: now[name] for name in there} == there


@pytest.mark.parametrize("how", ["script", pytest.param("stdin", marks=pytest.mark.slow)])
def test_a_program_needs_no_main_guard(tmp_path: Path, how: str) -> None:
    """A plain script, and what a notebook is to a worker process: a program that has no file."""
    text = (
        "import aerosim\n"
        f"done = aerosim.sweep({str(tiny_file(tmp_path))!r}, {{{WIND!r}: [0, 6]}}, out='s', workers=2)\n"
        "print('done', done.table.num_rows)\n"
    )
    (tmp_path / "a script.py").write_text(text)
    command = [sys.executable, "a script.py"] if how == "script" else [sys.executable, "-"]
    given = text if how == "stdin" else None
    ended = subprocess.run(command, cwd=tmp_path, input=given, capture_output=True, text=True, check=False)
    assert ended.stdout.split() == ["done", "2"], ended.stderr
