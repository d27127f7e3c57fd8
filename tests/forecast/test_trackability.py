"""Trackability along a plan: a lake is found where it lies; figures, warnings, map."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from planned import EAST, NORTH, write_land

from aerosim.cli.app import call
from aerosim.forecast.check import Outlook, outlook
from aerosim.forecast.trackability import MOST_STATIONS, _longest, line_strips
from aerosim.report.track_map import fields_of, track_figure, track_png
from aerosim.scenario import Scenario, from_mapping, to_yaml

LAKE_M = 4000.0


def lake(folder: Path) -> None:
    """Land of 20 m cells at random, 24 x 8 km, with a strip of water of 4 km from north to south in its middle."""
    import rasterio

    write_land(folder, lambda x, y: 200.0 + 0.0 * x, half_east=12e3, half_north=4e3, cell=20.0)
    with rasterio.open(folder / "photo.tif", "r+") as photo:
        grey = photo.read(1)
        middle = grey.shape[1] // 2
        grey[:, middle - round(LAKE_M / 40.0) : middle + round(LAKE_M / 40.0)] = 50
        photo.write(grey, 1)


def scenario(folder: Path, **sections: Any) -> Scenario:
    """One line east over the middle of the lake, 17.9 km, and one beside it that leaves the land in the north."""
    files = {"orthophoto": str(folder / "photo.tif"), "elevation": str(folder / "heights.tif")}
    lines = [
        {"start_deg": [36.52, -87.10], "end_deg": [36.52, -86.90]},
        {"start_deg": [36.55, -87.10], "end_deg": [36.55, -86.90]},
    ]
    return from_mapping({
        "name": "lake",
        "terrain": {"source": files, "vertical_datum": "ellipsoidal", "outside": "mask"},
        "flight": {"lines": lines, "height_m": 3000},
        **sections,
    })  # fmt: skip


@pytest.fixture(scope="module")
def land(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lake")
    lake(folder)
    return folder


@pytest.fixture(scope="module")
def found(land: Path) -> Outlook:
    return outlook(scenario(land))


def test_stations_lie_along_the_lines(found: Outlook) -> None:
    track = found.track
    first = track.line == 0
    assert first.sum() == round(found.plan.lines[0].length / 250.0)
    assert track.length[first].sum() == pytest.approx(found.plan.lines[0].length)
    # the land's middle is that of the line, nearly, as `planned` has it; the grid is not turned there
    assert track.place[first].mean(axis=0) == pytest.approx((EAST, NORTH), abs=200.0)
    assert track.ahead[first] == pytest.approx(np.tile([1.0, 0.0], (first.sum(), 1)), abs=2e-3)
    assert track.width == pytest.approx(96 / 132.6 * 3000.0)


def test_the_lake_is_blind_and_the_land_is_not(found: Outlook) -> None:
    track = found.track
    first = track.line == 0
    off = np.abs(track.place[first, 0] - EAST)
    accepted = track.of("accepted")[first]
    # a pixel of the rows and its smear reach 30 m beyond a strip
    assert accepted[off < 0.5 * LAKE_M - 50.0].max() < 0.01
    beside = accepted[off > 0.5 * LAKE_M + 50.0]
    assert beside.mean() > 0.85
    assert beside.min() > 0.5  # one station is eight draws
    line = found.figures["lines"][0]
    assert line["strips_blind_m"] == pytest.approx(LAKE_M, abs=2 * 250.0)
    share = 1.0 - LAKE_M / found.plan.lines[0].length
    # cells of the size of a row's pixel: of strips that lie half a pixel aside some are refused, 87 % are left.
    # Flown over this land: 99 % in calm air, where all lie on whole pixels, two thirds in wind and turbulence
    assert line["strips_accepted_pct"] == pytest.approx(100.0 * share * beside.mean(), abs=3.0)
    assert 0.1 < line["strip_sd_deg"] < 0.3


def test_a_line_whose_rows_leave_the_land(found: Outlook) -> None:
    """3.3 km north of the middle: half a row of 2.2 km reaches beyond the 4 km."""
    line = found.figures["lines"][1]
    assert line["strips_accepted_pct"] is line["strip_sd_deg"] is line["strips_blind_m"] is None
    assert np.isnan(found.track.of("accepted")[found.track.line == 1]).all()


def test_warnings(found: Outlook, land: Path) -> None:
    blind = "line 0: hardly a strip will be recognised on 4."
    assert any(told.startswith(blind) for told in found.figures["warnings"])
    noisy = outlook(scenario(land, ccd_rows={"noise_grey": 60})).figures["warnings"]
    assert any(told.startswith("line 0: as few as") for told in noisy)
    ideal = outlook(scenario(land, control={"mode": "ideal"})).figures["warnings"]
    assert not any("strip" in told for told in ideal)


def test_a_long_plan_has_fewer_stations_a_kilometre(found: Outlook, monkeypatch: pytest.MonkeyPatch, land: Path):
    assert len(found.track.line) < MOST_STATIONS
    monkeypatch.setattr("aerosim.forecast.trackability.MOST_STATIONS", 30)
    few = outlook(scenario(land))
    assert abs(len(few.track.line) - 30) <= 1
    assert few.figures["lines"][0]["strips_blind_m"] == pytest.approx(LAKE_M, abs=2 * 1200.0)


@pytest.mark.parametrize(
    ("blind", "longest"), [([0, 0, 0], 0.0), ([1, 0, 1, 1], 500.0), ([1, 1, 1, 0], 750.0), ([], 0.0)]
)
def test_longest_stretch(blind: list[int], longest: float) -> None:
    assert _longest(np.array(blind, bool), np.full(len(blind), 250.0)) == longest


def test_figures_of_a_line_without_stations(found: Outlook) -> None:
    assert set(line_strips(found.track, 7).values()) == {None}


def test_map(found: Outlook) -> None:
    picture = np.asarray(Image.open(io.BytesIO(track_png(found))).convert("RGB")).astype(int)
    # 4 km of 17.9 are blind and dark violet: r < b, both dark
    dark = (picture[..., 2] > picture[..., 0] + 20) & (picture.sum(axis=-1) < 330) & (picture[..., 1] < 80)
    assert dark.sum() > 5000
    axes = track_figure(found).axes[0]
    assert {"0", "1"} <= {text.get_text() for text in axes.texts}
    outlines = fields_of(found.track)
    side = np.hypot(*(outlines[0, 0] - outlines[0, 3]))
    assert side == pytest.approx(found.track.length[0])
    assert np.hypot(*(outlines[0, 0] - outlines[0, 1])) == pytest.approx(found.track.width[0])


def test_both_maps_stand_below_each_other_or_side_by_side(found: Outlook, land: Path) -> None:
    wide = [ax.get_position() for ax in track_figure(found).axes[:2]]
    assert wide[0].x0 == pytest.approx(wide[1].x0, abs=0.01)
    assert wide[0].y0 > wide[1].y1
    line = {"start_deg": [36.505, -87.05], "end_deg": [36.535, -87.05]}
    tall = track_figure(outlook(scenario(land, flight={"lines": [line], "height_m": 3000})))
    tall.canvas.draw()
    places = [ax.get_position() for ax in tall.axes[:2]]
    assert places[0].y0 == pytest.approx(places[1].y0, abs=0.01)
    assert places[0].x1 < places[1].x0
    labels = [ax.get_xlabel() or ax.get_ylabel() for ax in tall.axes[2:]]
    assert any("accepted" in each for each in labels)
    assert any("deviation" in each for each in labels)


def test_command(land: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "lake.yaml"
    file.write_text(to_yaml(scenario(land)))
    assert call(["check", str(file), "--trackability", str(tmp_path / "t.png"), "--json"]) == 0
    out, err = capsys.readouterr()
    assert '"strips_blind_m"' in out
    assert "t.png" in err
    assert (tmp_path / "t.png").read_bytes()[:4] == b"\x89PNG"
    assert call(["check", str(file), "--trackability", str(tmp_path / "t.png")]) == 2
    assert "file exists" in capsys.readouterr().err
    assert call(["check", str(file), "--trackability", str(tmp_path / "t.jpg")]) == 2
    assert "ends in .png" in capsys.readouterr().err
    both = str(tmp_path / "b.png")
    assert call(["check", str(file), "--trackability", both, "--map", both]) == 2
    assert "another name" in capsys.readouterr().err
