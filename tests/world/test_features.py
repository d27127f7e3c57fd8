"""Hard land painted into synthetic land: where it lies, what it looks like, and that it can be flown over."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from aerosim.cli.app import call
from aerosim.cli.terrain import feature_of
from aerosim.errors import InputError
from aerosim.forecast.check import outlook
from aerosim.frames import MapGrid
from aerosim.scenario import from_mapping
from aerosim.world.features import Feature, paint, placed
from aerosim.world.synthetic import Ground, make_terrain

GRID = MapGrid("EPSG:32632")
MIDDLE = tuple(np.radians([45.0, 9.0]))  # on the zone's meridian: grid north is true north
PIXEL = 5.0
LINE = (np.radians([45.0, 45.0]), np.radians([8.94, 9.06]))


def painted(*features: Feature, size: int = 400) -> NDArray[np.uint8]:
    """2 km around the middle, random land with features in it."""
    grey = np.random.default_rng(1).integers(60, 200, (size, size)).astype(np.uint8)
    e, n = (float(v) for v in GRID.from_geodetic(*MIDDLE))
    half = 0.5 * size * PIXEL
    paint(grey, e - half, n + half, PIXEL, tuple(placed(each, GRID, MIDDLE) for each in features))
    return grey


def test_lake() -> None:
    grey, bare = painted(Feature("lake", width=800.0)), painted()
    inside = np.s_[120:280, 120:280]  # 160 pixels of 5 m
    assert np.unique(grey[inside]).tolist() == [70]
    changed = grey != bare
    changed[inside] = False
    assert not changed.any()


@pytest.mark.parametrize("course", [0.0, 20.0, 90.0])
def test_rows_run_along_their_course_with_their_period(course: float) -> None:
    grey = painted(Feature("rows", period=100.0, course=np.radians(course), rest=0.0)).astype(float)
    power = np.abs(np.fft.fft2((grey - grey.mean()) * np.outer(np.hanning(400), np.hanning(400)))) ** 2
    row, col = np.unravel_index(power.argmax(), power.shape)
    wave = np.fft.fftfreq(400, PIXEL)[[row, col]]  # southward, eastward, 1/m
    assert 1.0 / np.hypot(*wave) == pytest.approx(100.0, rel=0.03)
    # the wave's direction is across the stripes, a right angle from their course
    across = np.degrees(np.arctan2(wave[1], -wave[0]))
    assert (across - course - 90.0 + 3.0) % 180.0 == pytest.approx(3.0, abs=2.5)


def test_rest_of_the_land_shows_through() -> None:
    plain, weak = (painted(Feature("rows", period=100.0, rest=rest)).astype(float) for rest in (0.0, 0.2))
    land = painted().astype(float)
    assert abs(np.corrcoef((weak - 0.8 * plain).ravel(), land.ravel())[0, 1]) > 0.95
    assert np.std(weak - 0.8 * plain) == pytest.approx(0.2 * land.std(), rel=0.05)


def test_lattice_repeats_itself_both_ways() -> None:
    grey = painted(Feature("lattice", period=100.0, rest=0.0)).astype(float)
    assert np.abs(grey[20:] - grey[:-20]).max() <= 1.0
    assert np.abs(grey[:, 20:] - grey[:, :-20]).max() <= 1.0
    assert grey.std() > 20.0


def test_later_features_lie_over_earlier_ones() -> None:
    grey = painted(Feature("rows"), Feature("lake", width=200.0))
    assert np.unique(grey[185:215, 185:215]).tolist() == [70]
    assert grey[:100].std() > 20.0


def test_options() -> None:
    found = feature_of("rows:period_m=68,course_deg=20,rest_pct=15,width_m=4000,lat_deg=45,lon_deg=9")
    assert found == Feature("rows", 4000.0, 68.0, np.radians(20.0), 0.15, (np.radians(45.0), np.radians(9.0)))
    assert feature_of("lake") == Feature("lake")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("pond", "no feature 'pond'"),
        ("lake:size=3", "no key 'size'"),
        ("lake:width_m=wide", "'wide' is no number"),
        ("lake:width_m=nan", "width of nan m"),
        ("rows:period_m=0", "period of 0 m"),
        ("rows:rest_pct=120", "rest of 120 %"),
        ("lake:lat_deg=45", "one of lat_deg and lon_deg"),
    ],
)
def test_wrong_options(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        feature_of(text)
    assert caught.value.key == "--feature"
    assert caught.value.allowed


def test_the_command_says_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(["terrain", "make", "--around", "45,9", "-o", str(tmp_path / "new"), "--feature", "pond"]) == 2
    assert "lake, rows, lattice" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_check_forecasts_the_lake_of_a_made_land(tmp_path: Path) -> None:
    """A line of 9.5 km over a lake of 3 km."""
    ground = Ground(100.0, 0.0, 7.5, 50.0, features=(Feature("lake", width=3000.0),))
    photo, heights = make_terrain([LINE], 2000.0, ground, tmp_path / "land")
    line = {"start_deg": [45.0, 8.94], "end_deg": [45.0, 9.06]}
    scenario = from_mapping({
        "name": "lake",
        "terrain": {"source": {"orthophoto": str(photo), "elevation": str(heights)}},
        "flight": {"lines": [line], "height_m": 3000},
    })  # fmt: skip
    figures = outlook(scenario).figures["lines"][0]
    assert figures["strips_blind_m"] == pytest.approx(3000.0, abs=2 * 250.0)
    assert figures["strips_accepted_pct"] == pytest.approx(100.0 * (1.0 - 3000.0 / 9460.0), abs=5.0)
