"""The figure that a notebook is given."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np
import pytest
from sweep_tables import grid, noise, table

from aerosim.errors import InputError
from aerosim.sweep.plotting import plot

WIND, MODE = "air.wind.speed_m_s", "control.mode"
CRAB = "crab.residual_rms_deg"
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def made() -> Any:
    points = grid({WIND: [0, 5, 10], MODE: ["fixed", "ideal"]})
    return table(points, 4, {CRAB: lambda p, seed: (p[MODE] == "fixed") * p[WIND] + 0.1 * noise("crab", seed)})


def test_a_notebook_shows_it_without_being_set_up(made: Any) -> None:
    """IPython asks an object for its picture under this name; what is changed afterwards is in the picture."""
    from matplotlib.image import imread

    figure = plot(made, CRAB, x=WIND, curve=MODE)
    before = figure._repr_png_()
    assert before.startswith(PNG)
    assert np.ptp(imread(BytesIO(before))[..., :3]) > 0.5
    figure.axes[0].set_ylim(0.0, 100.0)
    assert figure._repr_png_() != before


def test_curves_are_the_means(made: Any) -> None:
    figure = plot(made, CRAB, x=WIND, curve=MODE)
    fixed, ideal = (line.get_ydata() for line in figure.axes[0].get_lines()[:2])
    assert fixed - ideal == pytest.approx([0.0, 5.0, 10.0])


def test_a_panel_for_each_value(made: Any) -> None:
    figure = plot(made, CRAB, x=WIND, panel=MODE, curve="")
    assert [ax.get_title() for ax in figure.axes] == ["control mode fixed", "control mode ideal"]


@pytest.mark.parametrize(
    ("axes", "named"), [({"x": "air.wind"}, "air.wind.speed_m_s"), ({"x": WIND, "panel": WIND}, "another key")]
)
def test_keys_that_are_wrong(made: Any, axes: dict[str, str], named: str) -> None:
    with pytest.raises(InputError, match=named):
        plot(made, CRAB, **axes)
