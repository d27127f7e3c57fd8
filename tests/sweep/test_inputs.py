"""Files of the user: a changed one makes other runs, and a directory with runs of the old one is refused."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any

import pytest
from sweeps import MODES, spec, tiny

from aerosim import assets
from aerosim.errors import InputError
from aerosim.scenario import Scenario
from aerosim.sweep import folder, inputs
from aerosim.sweep.inputs import content, files_in
from aerosim.sweep.specfile import load_sweep, sweep_text

LINES = '{"type": "LineString", "coordinates": [[-84.38, 36.52], [-84.36, %s]]}'


def lines(file: Path, end: float = 36.52) -> str:
    file.write_text(LINES % end)
    return str(file)


def over(file: str) -> Scenario:
    """A scenario whose lines are in a file."""
    return tiny(flight={"file": file, "lines": None})


def names(vary: dict[str, Any], base: Scenario) -> list[str]:
    return [task.id for task in spec(vary, base).tasks(Path("x"))]


def begun(out: Path, *args: Any, **settings: Any) -> bool:
    with folder.opened(out, spec(*args, **settings), resume=True) as found:
        return found


def test_a_changed_file_is_refused_and_the_old_one_goes_on(tmp_path: Path) -> None:
    base = over(lines(tmp_path / "l.geojson"))
    first = names(MODES, base)
    assert not begun(tmp_path / "s", MODES, base)
    lines(tmp_path / "l.geojson", 36.53)
    assert not set(names(MODES, base)) & set(first)
    with pytest.raises(InputError, match=r"l.geojson has changed since .* was begun \(the file as it was"):
        begun(tmp_path / "s", MODES, base)
    lines(tmp_path / "l.geojson")
    assert names(MODES, base) == first
    assert begun(tmp_path / "s", MODES, base, seeds=3)
    assert names(MODES, load_sweep(tmp_path / "s" / "sweep.yaml").scenario) == first
    (tmp_path / "l.geojson").unlink()
    with pytest.raises(InputError, match=r"l.geojson cannot be read any more"):
        begun(tmp_path / "s", MODES, base)


def test_of_varied_files_only_the_runs_that_read_them_change(tmp_path: Path) -> None:
    """And a file that comes later is none that has changed."""
    vary = {"flight.file": [lines(tmp_path / "a.geojson"), str(tmp_path / "b.geojson")]}
    base = over(str(tmp_path / "unread.geojson"))
    first = names(vary, base)
    assert list(spec(vary, base).inputs) == vary["flight.file"]
    assert not begun(tmp_path / "s", vary, base)
    lines(tmp_path / "b.geojson")
    lines(tmp_path / "unread.geojson")
    assert [a == b for a, b in zip(names(vary, base), first, strict=True)] == [True, False]
    assert begun(tmp_path / "s", vary, base)
    lines(tmp_path / "b.geojson", 36.53)
    with pytest.raises(InputError, match=r"b.geojson has changed"):
        begun(tmp_path / "s", vary, base)


def test_paths_in_mappings_are_found_and_names_of_what_ships_are_none(tmp_path: Path) -> None:
    pair = {"orthophoto": str(tmp_path / "o.tif"), "elevation": str(tmp_path / "e.tif")}
    assert files_in({"terrain": {"source": pair}, "aircraft": {"model": "beaver"}}) == list(pair.values())
    assert files_in({"terrain.source": "pine_mountain", "flight.replay": {"file": str(tmp_path / "r.csv")}}) == [
        str(tmp_path / "r.csv")
    ]
    assert "inputs" not in sweep_text(spec())


def test_the_model_files_of_an_aircraft_count(tmp_path: Path) -> None:
    model = tmp_path / "mine"
    shutil.copytree(assets.folder("aircraft") / "beaver", model)
    before = content(model)
    (model / "notes.txt").write_text("not read")
    assert content(model) == before
    shutil.copytree(model, tmp_path / "twin of mine")
    assert content(tmp_path / "twin of mine") == before
    limits = model / "limits.yaml"
    limits.write_text(limits.read_text() + "\n# more\n")
    assert content(model) != before


def test_a_large_file_is_told_by_size_time_and_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "large.tif"
    data = bytes(range(200))
    file.write_bytes(data)
    whole = content(file)
    os.utime(file, ns=(1, 1))
    assert content(file) == whole
    monkeypatch.setattr(inputs, "WHOLE", 100)
    monkeypatch.setattr(inputs, "EDGE", 50)
    found = {content(file)}
    for changed in (data[:-1], b"x" + data[1:], data[:-1] + b"x"):
        file.write_bytes(changed)
        os.utime(file, ns=(1, 1))
        found.add(content(file))
    os.utime(file, ns=(1, 2))
    found.add(content(file))
    assert len(found) == 5
    assert content(tmp_path / "none.tif") is None
