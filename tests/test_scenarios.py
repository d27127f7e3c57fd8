"""Every shipped scenario is flown, as a user does it, and meets its `expect`."""

from __future__ import annotations

from pathlib import Path

import pytest

from aerosim.cli.app import call
from aerosim.scenario import load, shipped


def test_something_ships() -> None:
    assert {"calm", "crosswind", "gusty"} <= set(shipped())


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_scenario_meets_its_expect(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert load(name).expect, "a scenario that expects nothing proves nothing"
    code = call(["run", name, "--out", str(tmp_path / "run")])
    shown = capsys.readouterr()
    assert code == 0, shown.out + shown.err
    assert shown.out.splitlines()[-2:] == ["expect: met", str(tmp_path / "run")]
