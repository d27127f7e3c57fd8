"""The docs' picture of Fig. 3 of the 1988 paper: shift 3 at the fourth correlation, on the shipped land."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np

SCRIPT = Path(__file__).parents[2] / "docs" / "make_figures.py"


def test_fig3_case(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("make_figures", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    figures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(figures)
    row1, rows2 = figures.fig3_rows()
    # equation (2) divided by u, written out
    table = np.array([[np.abs(row1[k : k + 96] - row2).mean() for k in range(15)] for row2 in rows2])
    assert np.unravel_index(table.argmin(), table.shape) == (4 - 1, 7 + 3)
    # what is left there is the noise of both rows, 1.5 grey levels and rounding: mean of |N(0, 2 (1.5^2 + 1/12))|
    assert table.min() < 1.3 * np.sqrt(2 / np.pi * 2 * (1.5**2 + 1 / 12))
    # a trough: the other exposures stay well above it
    assert np.sort(table.min(axis=1))[1] > 3 * table.min()
    figures.fig3(tmp_path / "fig3.png")
    assert (tmp_path / "fig3.png").stat().st_size > 5000
