"""How a run ends: well, lost in the air, on a full disk, by Ctrl-C, by a fault of ours; and what is left then."""

from __future__ import annotations

import importlib
import json
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from flights import air, scenario

import aerosim
from aerosim.cli.app import call
from aerosim.errors import InputError, Interrupted, RunFailure
from aerosim.flight.aircraft import Aircraft
from aerosim.record import Run, open_run
from aerosim.rundir import LAST_WORDS, Staging
from aerosim.scenario import Scenario, from_mapping, to_yaml
from aerosim.simulate import ROOM, run

TABLES = {"telemetry.parquet", "matches.parquet", "photos.parquet", "lines.parquet"}
RECORD = {"scenario.yaml", "summary.json", "manifest.json", "run.log", *TABLES}


def listing(folder: Path) -> dict[str, bytes]:
    """Every file below a folder, hidden ones too, with its content."""
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}


def lose(monkeypatch: pytest.MonkeyPatch, error: BaseException, after: float = 60.0) -> None:
    """From some second of the flight on, the aircraft's state ends in an error."""
    state = Aircraft.state

    def failing(self: Aircraft) -> Any:
        found = state(self)
        if found.t > after:
            raise error
        return found

    monkeypatch.setattr(Aircraft, "state", failing)


@pytest.fixture
def earlier(tmp_path: Path) -> tuple[Path, dict[str, bytes]]:
    """A good earlier run, and its content."""
    out = tmp_path / "run"
    run(scenario(2.0), out)
    return out, listing(out)


def kept(path: Path, status: str) -> Run:
    """A run directory that has all of a record, readable and true to its manifest, and no leftovers."""
    found = open_run(path)
    assert found.status == status
    assert found.manifest["status"] == status
    assert found.summary["notes"]["status"]
    assert {file.name for file in path.iterdir()} == RECORD
    assert found.verify() == []
    for name in TABLES:
        pq.read_table(path / name)
    return found


def test_a_good_run_is_all_that_is_left(earlier: tuple[Path, dict[str, bytes]]) -> None:
    out, content = earlier
    assert set(content) == RECORD
    assert list(out.parent.iterdir()) == [out]
    assert open_run(out).status == "done"
    assert open_run(out).verify() == []


def test_a_run_replaces_another_only_when_told(earlier: tuple[Path, dict[str, bytes]]) -> None:
    out, content = earlier
    with pytest.raises(InputError, match=r"exists .*--overwrite") as refused:
        run(scenario(2.0), out)
    assert refused.value.key == "--out"
    assert listing(out.parent) == {f"run/{name}": each for name, each in content.items()}
    done = run(scenario(3.0), out, overwrite=True)
    assert list(out.parent.iterdir()) == [out]
    assert done.summary["flight"]["duration_s"] > json.loads(content["summary.json"])["flight"]["duration_s"] + 10


def test_an_aircraft_lost_keeps_the_record_up_to_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lose(monkeypatch, RunFailure("the aircraft was lost at 60 s"))
    with pytest.raises(RunFailure, match="lost") as failure:
        run(scenario(4.0), tmp_path / "run")
    assert failure.value.path == tmp_path / "run"
    found = kept(tmp_path / "run", "failed")
    assert found.summary["notes"]["status"] == "the aircraft was lost at 60 s"
    t = found.telemetry["t_s"].to_numpy()
    assert t[-1] == pytest.approx(60.0, abs=0.051)
    assert len(t) == pytest.approx(60.0 / 0.05, abs=2)
    assert found.matches.num_rows > 10
    # beyond exclude_first_s nothing was flown on the line: null with a reason, not zero
    assert "no survey line" in found.summary["notes"].get("crab.residual_rms_deg", "no survey line")


def test_relief_lost_after_landing_keeps_the_flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from aerosim.metrics.photos import Relief

    def broken(*_: Any) -> None:
        raise RunFailure("elevation.tif: cannot be read any more")

    monkeypatch.setattr(Relief, "under", broken)
    with pytest.raises(RunFailure, match="cannot be read any more"):
        run(scenario(4.0), tmp_path / "run")
    found = kept(tmp_path / "run", "failed")
    assert found.summary["photos"]["count"] == 0
    assert found.summary["flight"]["duration_s"] > 60.0
    assert found.matches.num_rows > 10


def test_a_failure_leaves_an_earlier_run_alone(
    earlier: tuple[Path, dict[str, bytes]], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out, content = earlier
    lose(monkeypatch, RunFailure("the aircraft was lost"))
    file = out.parent / "short.yaml"
    file.write_text(to_yaml(scenario(4.0)))
    for _ in range(2):  # a second failure takes the place of the first
        assert call(["run", str(file), "--out", str(out), "--overwrite"]) == 3
        shown = capsys.readouterr()
        assert shown.out == f"{out}.failed\n"
        assert "run failed: the aircraft was lost" in shown.err
        assert listing(out) == content
        kept(out.with_name("run.failed"), "failed")
        assert {each.name for each in out.parent.iterdir()} == {"run", "run.failed", "short.yaml"}


def test_gusts_beyond_flying_end_the_run_not_the_program(tmp_path: Path) -> None:
    """Real loss of the aircraft: no test double."""
    with pytest.raises(RunFailure) as failure:
        run(scenario(20.0, air=air(0.0, 0.0, turbulence=15.0)), tmp_path / "run")
    assert failure.value.path == tmp_path / "run"
    found = kept(tmp_path / "run", "failed")
    assert np.isfinite(found.telemetry["lat_deg"].to_numpy()).all()


def at_the_edge(outside: str) -> Scenario:
    """A line whose middle lies on the terrain, but not all that the rows see to its side."""
    from aerosim.scenario.build import terrain_of

    base = scenario(6.0)
    terrain = terrain_of(base)
    lon = base.flight.lines[0].start_deg[1], base.flight.lines[0].end_deg[1]
    lat = base.flight.lines[0].start_deg[0]
    while not terrain.shortfall(*terrain.grid.from_geodetic(*np.radians([[lat, lat], lon]))).max() > 0.0:
        lat += 0.002
    lat -= 0.004  # 200 to 450 m inside; the rows see 1.2 km to each side
    line = {"start_deg": [lat, lon[0]], "end_deg": [lat, lon[1]]}
    return from_mapping({
        "name": "edge", "terrain": {"source": "pine_mountain", "outside": outside},
        "flight": {"lines": [line], "run_in_s": 20}, "record": {"rrd": False, "report": False},
    })  # fmt: skip


def test_terrain_left_by_the_swath_ends_the_run(tmp_path: Path) -> None:
    with pytest.raises(RunFailure, match=r"line 0 left the terrain at [0-9.]+ s \([0-9]+ pixels are blind\)"):
        run(at_the_edge("fail"), tmp_path / "run")
    found = kept(tmp_path / "run", "failed")
    assert "left the terrain" in found.summary["notes"]["status"]


def test_masked_terrain_is_flown_over(tmp_path: Path) -> None:
    done = run(at_the_edge("mask"), tmp_path / "run")
    assert done.status == "done"
    on_line = np.array(done.telemetry["line"].to_pylist()) == 0
    assert on_line.sum() * 0.05 == pytest.approx(6000.0 / 69.44, rel=0.05)
    # blind pixels are the edge of the simulated world: no strip is made of them
    assert not any(done.matches["accepted"].to_pylist())


def interrupt_after(seconds: float) -> Callable[[float, float], None]:
    def progress(now: float, planned: float) -> None:
        if now > seconds:
            raise KeyboardInterrupt

    return progress


def test_ctrl_c_keeps_the_record_and_says_where(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt) as stop:
        run(scenario(4.0), tmp_path / "run", progress=interrupt_after(50.0))
    assert isinstance(stop.value, Interrupted)
    assert stop.value.path == tmp_path / "run"
    found = kept(tmp_path / "run", "interrupted")
    assert 50.0 <= found.telemetry["t_s"].to_numpy()[-1] < 55.0


def test_ctrl_c_leaves_an_earlier_run_alone(earlier: tuple[Path, dict[str, bytes]]) -> None:
    out, content = earlier
    with pytest.raises(Interrupted) as stop:
        run(scenario(4.0), out, overwrite=True, progress=interrupt_after(50.0))
    assert stop.value.path == out.with_name("run.failed")
    assert listing(out) == content
    kept(out.with_name("run.failed"), "interrupted")


def test_ctrl_c_while_writing_keeps_the_tables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from aerosim.report import page

    def stopped(path: Path) -> None:
        (path / ".report.html.1").write_text("half")
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(page, "write_report", stopped)
    with pytest.raises(Interrupted) as stop:
        run(scenario(2.0, record={"report": True}), tmp_path / "run")
    assert stop.value.path == tmp_path / "run"
    kept(tmp_path / "run", "interrupted")


@pytest.mark.parametrize("where", ["build", "flight", "writing"])
def test_a_fault_of_ours_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str) -> None:
    module = importlib.import_module("aerosim.simulate")
    fault = ZeroDivisionError("a fault of ours")

    def failing(*_: Any, **__: Any) -> Any:
        raise fault

    if where == "build":
        monkeypatch.setattr(module, "build", failing)
    elif where == "flight":
        lose(monkeypatch, fault, after=30.0)
    else:
        monkeypatch.setattr(module, "_draw", failing)
    with pytest.raises(ZeroDivisionError):
        run(scenario(2.0), tmp_path / "new" / "run")
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_cannot_begin_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A failure before there is a flight has no record: nothing is kept."""

    def failing(*_: Any, **__: Any) -> Any:
        raise RunFailure("the aircraft cannot be trimmed")

    monkeypatch.setattr(importlib.import_module("aerosim.simulate"), "build", failing)
    with pytest.raises(RunFailure) as failure:
        run(scenario(2.0), tmp_path / "new" / "run")
    assert failure.value.path is None
    assert list(tmp_path.iterdir()) == []


def refused(out: Path, *, overwrite: bool = False) -> str:
    """What is said of an output directory that cannot be; nothing changes below it."""
    with pytest.raises(InputError) as error:
        run(scenario(2.0), out, overwrite=overwrite)
    assert error.value.key == "--out"
    return str(error.value)


def test_output_directories_that_cannot_be(tmp_path: Path) -> None:
    file, folder, link = tmp_path / "file", tmp_path / "folder", tmp_path / "link"
    file.write_text("mine")
    folder.mkdir()
    (folder / "thesis.tex").write_text("mine")
    link.symlink_to(tmp_path / "gone")
    before = sorted(tmp_path.rglob("*"))
    for taken in (file, folder, link):
        assert refused(taken) == f"--out: {taken} exists (another directory, or --overwrite)"
        # what is no run is never replaced, whatever is told
        assert (
            refused(taken, overwrite=True)
            == f"--out: {taken} is not a run, it is not replaced (another directory)"
        )
    assert "cannot be written" in refused(file / "below")
    assert "cannot be written" in refused(file / "far" / "below")
    assert sorted(tmp_path.rglob("*")) == before
    assert file.read_text() == (folder / "thesis.tex").read_text() == "mine"


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a place where nobody can write")
def test_a_place_that_cannot_be_written() -> None:
    """Even the superuser makes no directories there."""
    assert refused(Path("/proc/self/run")).startswith("--out: /proc/self/run cannot be written")


FULL = """
import resource, sys
from importlib import import_module
from aerosim.cli.app import call
rundir, loop = import_module("aerosim.rundir"), import_module("aerosim.simulate")
where, limit, args = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
module, name = {"tables": (rundir, "_write_tables"), "pictures": (loop, "_draw")}[where]
inner = getattr(module, name)
def full(*given):
    # the disk has room for files up to this size only, from now on
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    return inner(*given)
setattr(module, name, full)
sys.exit(call(args))
"""


def fills_up(where: str, limit: int, out: Path, **record: Any) -> subprocess.CompletedProcess[str]:
    """`aerosim run` in a process whose disk fills up while the record is written."""
    pytest.importorskip("resource")
    file = out.parent / "short.yaml"
    file.write_text(to_yaml(scenario(2.0, record=record)))
    command = [sys.executable, "-c", FULL, where, str(limit)]
    return subprocess.run(
        [*command, "run", str(file), "--out", str(out), "--overwrite"],
        capture_output=True, text=True, timeout=45, check=False,
    )  # fmt: skip


@pytest.mark.parametrize("picture", ["report", "rrd"])
def test_a_disk_full_of_pictures_keeps_the_tables(earlier: tuple[Path, dict[str, bytes]], picture: str) -> None:
    out, content = earlier
    # smaller than either picture of this run; the tables are written already
    done = fills_up("pictures", 60_000, out, **{picture: True})
    assert done.returncode == 3, done.stdout + done.stderr
    assert done.stdout == f"{out}.failed\n"
    assert "run failed: the record could not be written" in done.stderr
    assert "Traceback" not in done.stderr
    assert listing(out) == content
    failed = out.with_name("run.failed")
    signals = {"rows.parquet", "mad.parquet"} if picture == "rrd" else set()
    assert {file.name for file in failed.iterdir()} == RECORD | signals
    found = open_run(failed)
    assert found.verify() == []
    assert "too large" in found.summary["notes"]["status"].lower()
    assert found.telemetry.num_rows > 900


def test_a_disk_full_of_tables_keeps_what_there_was_room_for(earlier: tuple[Path, dict[str, bytes]]) -> None:
    out, content = earlier
    done = fills_up("tables", 60_000, out)
    assert done.returncode == 3, done.stdout + done.stderr
    assert listing(out) == content
    found = open_run(out.with_name("run.failed"))
    assert found.status == "failed"
    # telemetry is the largest and did not fit; whatever is there is whole
    assert not list(found.path.glob("*.part*"))
    assert not [file for file in found.path.iterdir() if file.name.startswith(".")]
    assert set(found.manifest["outputs"]) == {f.name for f in found.path.iterdir()} - {"manifest.json", "run.log"}
    assert found.verify() == []
    for table in found.path.glob("*.parquet"):
        pq.read_table(table)


def test_no_room_at_the_start_is_wrong_input(tmp_path: Path) -> None:
    pytest.importorskip("resource")
    code = (
        "import resource, sys\n"
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({ROOM // 2}, resource.RLIM_INFINITY))\n"
        "from aerosim.cli.app import call\n"
        "sys.exit(call(['run', 'calm', '--out', sys.argv[1]]))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "new" / "run")],
        capture_output=True, text=True, timeout=45, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith(f"--out: {tmp_path}/new/run cannot be written: ")
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_room_is_really_taken(tmp_path: Path) -> None:
    """A sparse file would keep nothing."""
    staging = Staging(tmp_path / "run", False, 1_000_000)
    try:
        blocks = {file.name: file.stat().st_blocks * 512 for file in staging.path.iterdir()}
        assert blocks[".room"] >= 1_000_000
        assert blocks[".last"] >= LAST_WORDS
    finally:
        staging.discard()
    assert list(tmp_path.iterdir()) == []


def test_python_and_command_line_write_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The default place is runs/<name>/<seed>."""
    monkeypatch.chdir(tmp_path)
    done = aerosim.run(scenario(2.0))
    assert done.path == Path("runs/short/1")
    assert done.status == "done"
