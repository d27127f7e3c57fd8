"""The forecast against the wind triangle and the photogrammetrist's formulas, over made ground."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from rasterio.transform import from_origin

from aerosim.errors import InputError
from aerosim.forecast.check import forecast
from aerosim.scenario import load

TEXT = """\
name: try
terrain:
  source: {{orthophoto: photo.tif, elevation: heights.tif}}
  vertical_datum: ellipsoidal
air:
  wind: {{speed_m_s: {wind}, from_deg: {wind_from}}}
flight:
  height_m: 3000
  airspeed_m_s: {airspeed}
  lines:
    - {{start_deg: [36.52, -87.10], end_deg: [36.52, -86.90]}}
    - {{start_deg: [36.54, -86.90], end_deg: [36.54, -87.10]}}
control: {{mode: {mode}}}
mount: {{yaw_limit_deg: {yaw_limit}}}
frame_camera: {{focal_mm: 153, min_interval_s: {min_interval}}}
"""
DEFAULTS = {
    "wind": 10,
    "wind_from": 0,
    "airspeed": 70,
    "mode": "pipelined",
    "yaw_limit": 30,
    "min_interval": 2,
}
LENGTH = 3000.0 * 19167 * 0.012 / 153.0
Check = Callable[..., dict[str, Any]]


@pytest.fixture
def check(tmp_path: Path) -> Check:
    """Forecast over 60 km of ground at 300 m, risen by `slope` northwards from the first line; UTM 16."""

    def run(slope: float = 0.0, half_height: int = 100, **how: Any) -> dict[str, Any]:
        middle = 4_041_800.0
        north = middle + 100.0 * (half_height - 0.5 - np.arange(2 * half_height))
        heights = np.repeat((300.0 + slope * (north - middle))[:, None], 600, axis=1).astype(np.float32)
        grey = np.random.default_rng(1).integers(50, 200, heights.shape).astype(np.uint8)
        for name, values in (("heights", heights), ("photo", grey)):
            profile = {"driver": "GTiff", "count": 1, "dtype": values.dtype, "crs": "EPSG:32616"}
            place = from_origin(470_000.0, middle + 100.0 * half_height, 100.0, 100.0)
            with rasterio.open(
                tmp_path / f"{name}.tif", "w", width=600, height=2 * half_height, transform=place, **profile
            ) as file:
                file.write(values, 1)
        (tmp_path / "try.yaml").write_text(TEXT.format(**{**DEFAULTS, **how}))
        return forecast(load(tmp_path / "try.yaml"))

    return run


def test_crosswind_by_the_wind_triangle(check: Check) -> None:
    out, back = check()["lines"]
    # Wind from the north pushes an eastward flight to its right: positive drift, asin(10 / 70).
    assert out["course_deg"] == pytest.approx(90.0, abs=0.1)
    assert out["drift_deg"] == pytest.approx(np.degrees(np.arcsin(1.0 / 7.0)), abs=0.01)
    assert back["drift_deg"] == pytest.approx(-np.degrees(np.arcsin(1.0 / 7.0)), abs=0.01)
    assert out["ground_speed_m_s"] == pytest.approx(np.sqrt(70.0**2 - 10.0**2), abs=0.02)
    assert (out["crab_deg"], back["crab_deg"]) == (0.0, 0.0)


def test_up_and_down_the_wind(check: Check) -> None:
    found = check(wind_from=270)
    down, up = found["lines"]
    for line, speed in ((down, 80.0), (up, 60.0)):
        assert line["ground_speed_m_s"] == pytest.approx(speed, abs=0.01)
        assert line["vh_per_s"] == pytest.approx(speed / 3000.0, rel=1e-3)
        assert line["photo_interval_s"] == pytest.approx(0.4 * LENGTH / speed, rel=1e-3)
        assert line["photo_base_m"] == pytest.approx(0.4 * LENGTH, rel=1e-3)
        assert line["end_lap_pct"] == pytest.approx(60.0)
        assert line["blur_without_fmc_px"] == pytest.approx(speed * 0.003 / (3000.0 * 12e-6 / 0.153), rel=1e-3)
        # 0.2 deg of longitude at 36.52 deg, 1.1132 x cos = 17.9 km and 10 photos at 1.804 km and its end
        assert line["duration_s"] == pytest.approx(line["length_m"] * (1 + 3300 / 6.38e6) / speed, rel=1e-4)
        assert line["photos"] == 10
    assert down["length_m"] == pytest.approx(np.radians(0.2) * 6_385_700 * np.cos(np.radians(36.52)), rel=1e-3)
    flight = found["flight"]
    lines = sum(line["duration_s"] for line in (down, up))
    # Two run-ins of 60 s, and a turn of at least half a circle of V^2 / (g tan 18 deg).
    assert flight["turns_s"][0] > np.pi * 70.0 / (9.81 * np.tan(np.radians(18.0)))
    assert flight["duration_s"] == pytest.approx(lines + 120.0 + sum(flight["turns_s"]))
    assert found["photos"]["count"] == 20


def test_geometry_of_the_photos_and_rows(check: Check) -> None:
    found = check(wind=0)
    assert found["photos"]["footprint_along_m"] == pytest.approx(LENGTH, rel=1e-3)
    assert found["photos"]["gsd_m"] == pytest.approx(3000.0 * 12e-6 / 0.153, rel=1e-3)
    # Equation (1): n = d / (f dt v/h)
    assert found["rows"]["planned_n"] == pytest.approx(39.7 / (132.6 * 0.05 * 70.0 / 3000.0), rel=1e-3)
    json.dumps(found, allow_nan=False)


def test_relief_widens_the_range_of_the_gsd(check: Check) -> None:
    # Ground rising by 0.1 across the line, over half a photo to either side; the height is over both lines' mean.
    line = check(slope=0.1)["lines"][0]
    pixel = 12e-6 / 0.153
    width = LENGTH / 3000.0 * line["gsd_m"] / pixel
    assert (line["gsd_max_m"] - line["gsd_min_m"]) / pixel == pytest.approx(0.1 * width, rel=0.005)
    assert line["terrain_max_height_m"] - line["terrain_min_height_m"] == pytest.approx(0.1 * width, rel=0.005)
    scale = LENGTH / 3000.0 * line["gsd_min_m"] / pixel
    lap = 100.0 * (1.0 - line["photo_base_m"] / scale)
    assert line["end_lap_highest_ground_pct"] == pytest.approx(lap, abs=0.01)


def test_a_slow_camera_costs_end_lap_down_the_wind(check: Check) -> None:
    # 25.8 s are wanted in still air, 22.5 s at 80 m/s; the camera takes 25 s.
    down, up = check(wind_from=270, min_interval=25)["lines"]
    assert down["photo_interval_s"] == 25.0
    assert down["end_lap_pct"] == pytest.approx(100.0 * (1.0 - 80.0 * 25.0 / LENGTH), abs=0.05)
    assert up["end_lap_pct"] == pytest.approx(60.0)


def test_fixed_camera_keeps_the_crab_and_the_interval_of_still_air(check: Check) -> None:
    down, up = check(mode="fixed", wind_from=270)["lines"]
    assert down["end_lap_pct"] == pytest.approx(100.0 * (1.0 - 0.4 * 80.0 / 70.0), abs=0.05)
    assert up["end_lap_pct"] == pytest.approx(100.0 * (1.0 - 0.4 * 60.0 / 70.0), abs=0.05)
    out, back = check(mode="fixed")["lines"]
    assert (out["crab_deg"], back["crab_deg"]) == (out["drift_deg"], back["drift_deg"])


def test_a_mount_that_turns_less_than_the_drift_leaves_the_rest(check: Check) -> None:
    out, back = check(yaw_limit=5)["lines"]
    assert out["crab_deg"] == pytest.approx(out["drift_deg"] - 5.0)
    assert back["crab_deg"] == pytest.approx(back["drift_deg"] + 5.0)


def test_photos_that_reach_beyond_the_terrain_are_told(check: Check) -> None:
    assert check()["lines"][0]["photos_outside_m"] == 0.0
    # Ground to 3.0 km south and north of the middle, the first line 1.3 km off at most: photos reach 2.25 km.
    found = check(half_height=30)["lines"][1]["photos_outside_m"]
    assert 0.0 < found < LENGTH / 2.0


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"airspeed": 30}, r"try.yaml:9: flight.airspeed_m_s: airspeed of 30 m/s .* too near its stall"),
        ({"airspeed": 130}, r"flight.airspeed_m_s: .* faster than it may fly"),
        ({"half_height": 10}, r"flight.lines.1: the line leaves the terrain by \d+ m"),
    ],
)
def test_what_cannot_be_flown_is_refused_in_its_place(check: Check, how: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        check(**how)
