"""`Sweep.plot`: curves of the means with their bands, over the keys that were asked for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from sweep_tables import grid, noise, table

from aerosim.errors import InputError
from aerosim.sweep.plotting import plot
from aerosim.sweep.stats import means

WIND, ROUGH, MODE = "air.wind.speed_m_s", "air.turbulence.sigma_m_s", "control.mode"
CRAB = "crab.residual_rms_deg"


def crab(point: Mapping[str, Any], seed: int) -> float:
    return point[WIND] * (0.8 if point[MODE] == "fixed" else 0.1) + point[ROUGH] + 0.1 * noise("air", seed)


@pytest.fixture(scope="module")
def swept() -> Any:
    """Three winds, two turbulences, two modes, four seeds."""
    return table(grid({WIND: (0, 10, 20), ROUGH: (0.0, 0.7), MODE: ("fixed", "pipelined")}), 4, {CRAB: crab})


def curves(ax: Any) -> dict[str, Any]:
    return {line.get_label(): line for line in ax.get_lines() if not line.get_label().startswith("_")}


def test_axes_of_their_own_choice(swept: Any) -> None:
    figure = plot(swept, CRAB)
    assert len(figure.axes) == 2
    assert [ax.get_title() for ax in figure.axes] == ["turbulence sigma 0 m/s", "turbulence sigma 0.7 m/s"]
    assert figure.axes[0].get_ylabel() == "crab, rms [deg]"
    assert {ax.get_xlabel() for ax in figure.axes} == {"wind speed [m/s]"}
    known = {tuple(m.values.values()): m.mean for m in means(swept, CRAB, (WIND, ROUGH, MODE))}
    for ax, rough in zip(figure.axes, (0.0, 0.7), strict=True):
        found = curves(ax)
        assert set(found) == {"fixed", "pipelined"}
        for mode, line in found.items():
            assert list(line.get_xdata()) == [0, 10, 20]
            assert list(line.get_ydata()) == [known[wind, rough, mode] for wind in (0, 10, 20)]


def test_bands_are_the_confidence_limits(swept: Any) -> None:
    figure = plot(swept, CRAB, x=WIND, curve="", panel="", level=0.9)
    (ax,) = figure.axes
    (band,) = ax.collections
    expected = means(swept, CRAB, [WIND], 0.9)
    corners = band.get_paths()[0].vertices
    for m in expected:
        at = [y for x, y in corners if x == m.values[WIND]]
        assert min(at) == pytest.approx(m.mean - m.half_width)
        assert max(at) == pytest.approx(m.mean + m.half_width)


def test_keys_that_are_asked_for(swept: Any) -> None:
    figure = plot(swept, CRAB, x=MODE, curve=ROUGH, panel="")
    (ax,) = figure.axes
    assert [tick.get_text() for tick in ax.get_xticklabels()] == ["fixed", "pipelined"]
    assert ax.get_legend_handles_labels()[1] == ["0 m/s", "0.7 m/s"]
    legends = figure.legends
    assert [each.get_title().get_text() for each in legends] == ["turbulence sigma"]


def test_it_is_drawn_to_a_file(swept: Any, tmp_path: Path) -> None:
    plot(swept, CRAB).savefig(tmp_path / "crab.png")
    assert (tmp_path / "crab.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("metric", "axes", "says"),
    [
        ("crab.residual_deg", {}, "did you mean crab.residual_rms_deg"),
        (CRAB, {"x": "air.wind.speed"}, "did you mean air.wind.speed_m_s"),
        (CRAB, {"x": WIND, "curve": WIND}, "a key is given twice"),
    ],
)
def test_names_that_are_wrong(swept: Any, metric: str, axes: dict[str, str], says: str) -> None:
    with pytest.raises(InputError, match=says):
        plot(swept, metric, **axes)
