"""The notebooks: what is stored was executed, and they can be executed anew with a short parameter."""

from __future__ import annotations

import json
import re
from base64 import b64decode
from io import BytesIO
from math import asin, degrees
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
from flights import KM_PER_DEG, NORTH, WEST

import aerosim
from aerosim.errors import InputError
from aerosim.scenario.control import MODES
from aerosim.sweep.results import Sweep

FOLDER = Path(__file__).parents[1] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
MODE, SIGMA, WIND = "control.mode", "air.turbulence.sigma_m_s", "air.wind.speed_m_s"
CRAB = "crab.residual_rms_deg"
SLOW_M_S = 0.1
SHORT: dict[str, Any] = {
    "TURBULENCE_M_S": [0, 1],
    "CROSSWIND_M_S": [0, 8],
    "SEEDS": 2,
    "MODES": ["fixed", "schmelovsky_1988", "pipelined", "ideal"],
    "OVERRIDES": {
        "flight.lines": [{"start_deg": [NORTH, WEST], "end_deg": [NORTH, WEST + 5.0 / KM_PER_DEG]}],
        "flight.run_in_s": 10,
        "ccd_rows.period_s": 0.1,
        "record.exclude_first_s": 15,
        "air.slow_wind.sigma_m_s": SLOW_M_S,
    },
    "WORKERS": 0,
    "OUT": "short",
}
# told by the executed copy: what is drawn in its first figure
DRAWN = """
import json
print(json.dumps(all_modes))
print(json.dumps([
    [[line.get_ydata().tolist() for line in ax.get_lines()],
     [band.get_paths()[0].vertices[:, 1].tolist() for band in ax.collections]]
    for ax in figure_crab.axes
]))
"""


def code_cells(notebook: Any) -> list[Any]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def outputs(notebook: Any) -> list[Any]:
    return [output for cell in code_cells(notebook) for output in cell.outputs]


def pictures(notebook: Any) -> list[bytes]:
    return [b64decode(out.data["image/png"]) for out in outputs(notebook) if "image/png" in out.get("data", {})]


def words(notebook: Any) -> str:
    """All that a reader reads, without the pictures."""
    told = [cell.source for cell in notebook.cells]
    for output in outputs(notebook):
        told.append(str(output.get("text", "")))
        told += [str(text) for kind, text in output.get("data", {}).items() if kind.startswith("text/")]
    return "\n".join(told)


def parameters(notebook: Any) -> dict[str, Any]:
    """Values of the cell that is tagged `parameters`: plain assignments."""
    (cell,) = [each for each in notebook.cells if "parameters" in each.metadata.get("tags", [])]
    values: dict[str, Any] = {}
    exec(cell.source, values)
    return {name: value for name, value in values.items() if name.isupper()}


def flyable(mode: str, overrides: dict[str, Any]) -> bool:
    try:
        aerosim.load_scenario("crosswind", {**overrides, MODE: mode})
    except InputError:
        return False
    return True


def assert_clean(notebook: Any) -> None:
    """Executed from top to bottom, without an error or a warning, and nothing of the machine in it."""
    cells = code_cells(notebook)
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    assert {output.output_type for output in outputs(notebook)} <= {"stream", "display_data", "execute_result"}
    assert not [output for output in outputs(notebook) if output.get("name") == "stderr"]
    assert not re.findall(r"(?<![\w./])/(?:home|root|tmp|usr|opt|work|var|mnt|Users)/|\b[A-Z]:\\", words(notebook))


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Sweep]:
    """The disturbance sweep in an empty folder: lines of 5 km, 2 x 2 points for each mode, two seeds."""
    from nbclient import NotebookClient

    folder = tmp_path_factory.mktemp("notebook")
    notebook = nbformat.read(FOLDER / "disturbance_sweep.ipynb", as_version=4)
    assert set(SHORT) <= set(parameters(notebook))
    (cell,) = [each for each in notebook.cells if "parameters" in each.metadata.get("tags", [])]
    cell.source += "\n" + "\n".join(f"{name} = {value!r}" for name, value in SHORT.items())
    notebook.cells.append(nbformat.v4.new_code_cell(DRAWN))
    resources = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, timeout=300, kernel_name="python3", resources=resources).execute()
    return notebook, aerosim.open_sweep(folder / "short")


def test_there_are_notebooks() -> None:
    assert "disturbance_sweep.ipynb" in [file.name for file in NOTEBOOKS]


@pytest.mark.parametrize("file", NOTEBOOKS, ids=lambda file: file.stem)
def test_what_is_stored_was_executed(file: Path) -> None:
    notebook = nbformat.read(file, as_version=4)
    nbformat.validate(notebook)
    assert_clean(notebook)
    assert pictures(notebook)
    assert file.stat().st_size < 1.5e6


def test_stored_outputs_are_of_the_stored_parameters() -> None:
    notebook = nbformat.read(FOLDER / "disturbance_sweep.ipynb", as_version=4)
    at = parameters(notebook)
    told = re.search(r"(\d+) points with (\d+) seeds: (\d+) runs flown, (\d+) failed", words(notebook))
    modes = re.search(r"modes that are compared: (.+)", words(notebook).split("## Before flying")[-1])
    assert told is not None
    assert modes is not None
    points, seeds, done, failed = map(int, told.groups())
    count = len(modes[1].split(", ")) * len(at["TURBULENCE_M_S"]) * len(at["CROSSWIND_M_S"])
    assert (points, seeds, done, failed) == (count, at["SEEDS"], count * at["SEEDS"], 0)


def test_short_execution_is_clean(short: tuple[Any, Sweep]) -> None:
    assert_clean(short[0])


def test_every_figure_shows_something(short: tuple[Any, Sweep]) -> None:
    from matplotlib.image import imread

    found = pictures(short[0])
    assert len(found) == 6
    for picture in found:
        pixels = imread(BytesIO(picture))[..., :3]
        assert pixels.shape[1] < 1200
        # a frame and its ticks alone colour 1 to 2 %, and are grey
        assert (np.ptp(pixels, axis=2) > 0.2).mean() > 0.001


def told_by(notebook: Any) -> tuple[list[str], list[Any]]:
    """All modes that the notebook would fly by itself; panels of its first figure."""
    text = "".join(output.text for output in code_cells(notebook)[-1].outputs)
    first, second = text.splitlines()
    return json.loads(first), json.loads(second)


def test_modes_are_those_that_can_be_flown(short: tuple[Any, Sweep]) -> None:
    """The short sweep is of four; left alone, the notebook takes whatever later versions can fly too."""
    modes, _ = told_by(short[0])
    assert modes == [mode for mode in MODES if flyable(mode, SHORT["OVERRIDES"])]
    assert set(SHORT["MODES"]) <= set(modes)


def test_every_point_and_seed_has_its_row(short: tuple[Any, Sweep]) -> None:
    rows = short[1].table.select([MODE, SIGMA, WIND, "seed", "status"]).to_pylist()
    want = [(m, s, w, seed) for m in SHORT["MODES"] for s in (0, 1) for w in (0, 8) for seed in (1, 2)]
    assert [(row[MODE], row[SIGMA], row[WIND], row["seed"]) for row in rows] == want
    assert {row["status"] for row in rows} == {"done"}


def test_bands_hold_the_means(short: tuple[Any, Sweep]) -> None:
    """In the first figure: a panel for each crosswind, a curve and a band for each mode."""
    notebook, sweep = short
    _, panels = told_by(notebook)
    modes = SHORT["MODES"]
    for wind, (curves, bands) in zip((0, 8), panels, strict=True):
        assert len(curves) == len(bands) == len(modes)
        for mode, curve, band in zip(modes, curves, bands, strict=True):
            at = [m for m in sweep.means(CRAB) if m.values[MODE] == mode and m.values[WIND] == wind]
            assert curve == pytest.approx([m.mean for m in at])
            assert all(m.half_width > 0.0 for m in at)
            assert min(band) == pytest.approx(min(m.mean - m.half_width for m in at))
            assert max(band) == pytest.approx(max(m.mean + m.half_width for m in at))


def test_fixed_has_the_drift_of_the_wind_triangle(short: tuple[Any, Sweep]) -> None:
    """Mean of two lines, each in a slow wind of its own: within four of its standard deviations."""
    speed = 69.44  # airspeed of the shipped scenario, m/s
    at = {
        m.values[WIND]: m.mean for m in short[1].means(CRAB) if (m.values[MODE], m.values[SIGMA]) == ("fixed", 0)
    }
    spread = degrees(SLOW_M_S / speed) / 2**0.5
    assert at[0] < 4.0 * spread + 0.05  # 0.05: what the tracking of the line itself wanders by
    assert at[8] == pytest.approx(degrees(asin(8.0 / speed)), abs=4.0 * spread)


def test_modes_are_ranked_in_crosswind(short: tuple[Any, Sweep]) -> None:
    """In crosswind and calm air: any measuring is better than none, the truth is better than measuring."""
    at = {m.values[MODE]: m.mean for m in short[1].means(CRAB) if (m.values[SIGMA], m.values[WIND]) == (0, 8)}
    for mode in ("schmelovsky_1988", "pipelined"):
        assert at["ideal"] < at[mode] < at["fixed"] / 3.0
