"""What programs read of a run that failed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from aerosim import open_run
from aerosim.cli.app import call


def test_a_failed_run_tells_it_in_json_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    # 151 kg an hour: 2 kg last 48 s
    settings = ["aircraft.fuel_kg=2", "record.rrd=false", "record.report=false"]
    code = call(["run", "calm", "--json", "-q", *(part for text in settings for part in ("--set", text))])
    out, err = capsys.readouterr()
    found = json.loads(out)
    assert (code, found["status"], found["run"]) == (3, "failed", str(Path("runs/calm/1")))
    assert "fuel used up" in found["reason"]
    assert found["reason"] in err
    assert found["summary"] == open_run(found["run"]).summary
    assert 40.0 < found["summary"]["flight"]["duration_s"] < 56.0
