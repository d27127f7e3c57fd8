"""The map of a plan: what it shows is there, and what is not there it does not show."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from planned import write_land

from aerosim.forecast.check import Outlook, outlook
from aerosim.report import plan_map
from aerosim.report.plan_map import figure_of, map_png
from aerosim.scenario import from_mapping


def plan_over(folder: Path, hill: float) -> Outlook:
    """Two lines 2 km apart, 1.4 km above a plain, with a hill of some height (m) between them."""
    write_land(
        folder, lambda x, y: 200.0 + hill * np.exp(-(x**2 + y**2) / 2 / 700.0**2), half_east=9e3, half_north=5e3
    )
    ends = [[36.53, -87.05], [36.53, -86.95], [36.512, -86.95], [36.512, -87.05]]
    lines = [{"start_deg": ends[0], "end_deg": ends[1]}, {"start_deg": ends[2], "end_deg": ends[3]}]
    files = {"orthophoto": str(folder / "photo.tif"), "elevation": str(folder / "heights.tif")}
    return outlook(
        from_mapping(
            {
                "name": "try",
                "terrain": {"source": files, "vertical_datum": "ellipsoidal"},
                "air": {"wind": {"speed_m_s": 6, "from_deg": 30}},
                "flight": {"lines": lines, "height_m": 1600, "height_above": "ellipsoid"},
            }
        )
    )


@pytest.mark.parametrize(("hill", "gaps"), [(0.0, False), (900.0, True)])
def test_gaps_are_red_and_only_they(tmp_path: Path, hill: float, gaps: bool) -> None:
    found = plan_over(tmp_path, hill)
    assert bool(found.figures["coverage"]["gaps"]) is gaps
    picture = np.asarray(Image.open(io.BytesIO(map_png(found))).convert("RGB")).astype(int)
    red = (picture[..., 0] > 150) & (picture[..., 1] < 70) & (picture[..., 2] < 70)
    assert bool(red.sum() > 500) is gaps
    # lines in blue, turns in violet, wind in vermilion
    for colour in ((0x00, 0x72, 0xB2), (0x5B, 0x3A, 0x8C), (0xD5, 0x5E, 0x00)):
        assert (np.abs(picture - np.array(colour)).max(axis=-1) < 12).sum() > 40


def test_lines_bear_their_names_and_many_footprints_are_thinned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = plan_over(tmp_path, 0.0)._replace(names=("4b", "7"))
    axes = figure_of(found).axes[0]
    assert {"4b", "7"} <= {text.get_text() for text in axes.texts}
    photos = len(found.shots.place)
    monkeypatch.setattr(plan_map, "MOST_FOOTPRINTS", photos - 1)
    thinned = figure_of(found)
    (shown,) = (each for each in thinned.axes[0].collections if type(each).__name__ == "PolyCollection")
    assert len(shown.get_paths()) == -(-photos // 2)
    assert "photo footprint, 1 of 2" in [text.get_text() for text in thinned.legends[0].get_texts()]


@pytest.mark.parametrize(("km2", "text"), [(67.58, "67.58 km²"), (0.05, "5 ha"), (99e-6, "99 m²")])
def test_areas_are_told_in_the_unit_that_suits_them(km2: float, text: str) -> None:
    assert plan_map._area(km2) == text
