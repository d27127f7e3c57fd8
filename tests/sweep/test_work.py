"""One run of a sweep: its figures are the simulator's, its file is whole, its failure is a result."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from sweeps import WIND, spec, tiny

import aerosim
from aerosim.scenario import with_overrides
from aerosim.simulate import simulate
from aerosim.sweep import work
from aerosim.sweep.work import Result, Task, flat, read_result, result_file, run_one, write_result, write_whole


def task(out: Path, seed: int = 3, vary: dict[str, Any] | None = None, **settings: Any) -> Task:
    one = spec(vary or {WIND: [6], "control.mode": ["pipelined"]}, seeds=seed, **settings)
    return list(one.tasks(out))[-1]


def test_the_figures_are_those_of_the_run_alone(tmp_path: Path) -> None:
    asked = task(tmp_path)
    result = run_one(asked)
    alone = simulate(with_overrides(tiny(), {WIND: 6, "control.mode": "pipelined", "seed": 3})).summary
    assert (result.status, result.reason, result.seed, result.point) == ("done", "", 3, 0)
    for name, value in result.summary.items():
        if name.startswith("speed."):
            continue
        wanted: Any = alone
        for part in name.split("."):
            wanted = wanted[part]
        assert value == wanted, name
    assert result.summary["telemetry_sha256"] == alone["telemetry_sha256"]
    assert result.wall_s > 0.0
    assert read_result(result_file(tmp_path, asked.id)) == result
    assert os.listdir(tmp_path / "runs") == [f"{asked.id}.json"]


def test_records_are_kept_if_wanted(tmp_path: Path) -> None:
    asked = task(tmp_path, 1, keep="records")
    result = run_one(asked)
    run = aerosim.open_run(tmp_path / "records" / asked.id)
    assert run.verify() == []
    assert run.summary["telemetry_sha256"] == result.summary["telemetry_sha256"]


def test_a_flight_that_fails_is_a_result_without_figures(tmp_path: Path) -> None:
    """The line ends beyond the land: the run fails in flight."""
    far = tiny(flight={"lines": [{"start_deg": [36.52, -84.38], "end_deg": [36.52, -83.0]}]})
    result = run_one(task(tmp_path, 1, base=far))
    assert result.status == "failed"
    assert result.reason
    assert result.summary == {}
    assert json.loads(result_file(tmp_path, result.id).read_text())["reason"] == result.reason


def test_a_fault_of_the_program_is_a_failed_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work, "_flown", lambda _: 1 / 0)
    result = run_one(task(tmp_path))
    assert (result.status, result.reason) == ("failed", "internal error: ZeroDivisionError: division by zero")


def test_an_interrupt_is_no_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(_: Task) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(work, "_flown", stop)
    with pytest.raises(KeyboardInterrupt):
        run_one(task(tmp_path))
    assert not (tmp_path / "runs").exists()


def test_a_result_that_cannot_be_written_is_returned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work, "_flown", lambda _: ({"crab": {"residual_rms_deg": 1.0}}, "done", ""))
    (tmp_path / "file").write_text("")
    result = run_one(task(tmp_path / "file"))
    assert result.summary == {"crab.residual_rms_deg": 1.0}


def test_a_full_disk_leaves_the_file_that_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_whole(tmp_path / "a.json", "old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_whole(tmp_path / "a.json", "new")
    assert (tmp_path / "a.json").read_text() == "old"
    assert os.listdir(tmp_path) == ["a.json"]


@pytest.mark.parametrize("text", ["", "{", "[]", '{"id": "a"}', '{"id": "a", "what": 1}', "\0\0\0"])
def test_a_damaged_file_is_no_result(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.json").write_text(text)
    assert read_result(tmp_path / "a.json") is None
    assert read_result(tmp_path / "b.json") is None


def test_numbers_survive_the_file_bit_for_bit(tmp_path: Path) -> None:
    figures = {"a": 0.1 + 0.2, "b": 5e-324, "c": -0.0, "d": 1.7976931348623157e308, "e": 3, "f": None, "g": "word"}
    write_result(tmp_path, Result("x", 1, 2, "done", "", {"k": [1, 2.5]}, figures, 0.1))
    found = read_result(result_file(tmp_path, "x"))
    assert found is not None
    assert repr(dict(found.summary)) == repr(figures)


def test_a_flat_summary() -> None:
    summary = {"status": "done", "seed": 1, "notes": {"a": "b"}, "crab": {"x": {"y": 1}, "z": [1]}, "t": "q"}
    assert flat(summary) == {"crab.x.y": 1, "crab.z": "[1]", "t": "q"}
