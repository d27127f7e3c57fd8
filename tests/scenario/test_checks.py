"""What must fit together across sections."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from aerosim.errors import InputError
from aerosim.scenario import load, parse_setting, whole_steps
from aerosim.scenario.available import AVAILABLE
from aerosim.scenario.checks import line_length
from aerosim.scenario.fields import field_at
from aerosim.scenario.flight import Line
from aerosim.scenario.scenario import Scenario

Write = Callable[[str | bytes], Path]


def refused_with(file: Path, setting: str) -> str:
    with pytest.raises(InputError) as caught:
        load(file, [parse_setting(setting)])
    return str(caught.value)


def test_whole_steps_counts_and_refuses() -> None:
    assert whole_steps(0.05, 1 / 120) == 6
    assert whole_steps(7 / 120, 1 / 120) == 7
    assert whole_steps(0.0583333, 1 / 120) == 7  # as a person writes 7/120
    assert whole_steps(3600.0, 1 / 1000) == 3_600_000
    assert whole_steps(0.052, 1 / 120) is None
    assert whole_steps(0.004, 1 / 120) is None


@pytest.mark.parametrize(
    ("setting", "line"),
    [
        # 0.052 s at 120 Hz is 6.24 steps: 6/120 and 7/120
        ("ccd_rows.period_s=0.052", "--set ccd_rows.period_s: 0.052 s is no whole number of steps of 120 Hz (nearest: 0.05 or 0.0583333)"),
        ("record.period_s=0.001", "--set record.period_s: 0.001 s is no whole number of steps of 120 Hz (nearest: 0.00833333)"),
        ("estimation.strip_period_s=0.12", "--set estimation.strip_period_s: 0.12 s is no whole number of row exposures of 0.05 s (nearest: 0.1 or 0.15)"),
        ("flight.lines.0.end_deg=[36.52, -84.38]", "--set flight.lines.0.end_deg: line ends where it starts (another point than start_deg)"),
        # 0.001 deg of latitude is 111 m
        ("flight.lines.0.end_deg=[36.521, -84.38]", "--set flight.lines.0.end_deg: line is only 111 m long (at least 500 m)"),
        ("air.wind.speed_m_s=60", "--set air.wind.speed_m_s: 60 m/s is too much for an airspeed of 69.44 m/s (at most 55.55)"),
        # footprint 3000 * 230/152 = 4539 m; 2 s of 69.44 m/s are 3.06 % of it
        ("control.end_lap_pct=95", None),
        ("frame_camera.min_interval_s=30", "{file}:1: control.end_lap_pct: 60 % needs a photo each 26.1 s, faster than frame_camera.min_interval_s (at most 54.11)"),
        ("frame_camera.focal_mm=30", "{file}:1: frame_camera.format_mm: 230 mm before a focal length of 30 mm sees the horizon (at most 210)"),
        ("frame_camera.pixel_um=900", None),
        ("ccd_rows.exposure_s=0.06", "--set ccd_rows.exposure_s: 0.06 s is longer than period_s (at most 0.05)"),
        ("ccd_rows.max_shift_px=48", "--set ccd_rows.max_shift_px: 48 is too much for rows of 96 px (less than 48)"),
        ("estimation.search_n=[1.6, 0.6]", "--set estimation.search_n: [1.6, 0.6] does not hold the planned n"),
        # planned n = 39.7 * 3000/(132.6 * 10 * 69.44) = 1.29
        ("ccd_rows.period_s=10", "--set ccd_rows.period_s: the rows see the same ground after 1.29 exposures: too few for a search (at most 3.88)"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(write: Write, good: str, setting: str, line: str | None) -> None:
    file = write(good)
    if line is None:
        load(file, [parse_setting(setting)])
    else:
        assert refused_with(file, setting).startswith(line.replace("{file}", str(file)))


def test_other_step_rates_change_what_is_whole(write: Write, good: str) -> None:
    file = write(good)
    assert load(file, [parse_setting("aircraft.step_rate_hz=100")]).ccd_rows.period_s == 0.05
    line = "ccd_rows.period_s: 0.05 s is no whole number of steps of 90 Hz (nearest: 0.0444444 or 0.0555556)"
    assert line in refused_with(file, "aircraft.step_rate_hz=90")


def test_line_length_against_the_ellipsoid() -> None:
    from pyproj import Geod

    geod = Geod(ellps="WGS84")
    for start, end in [
        ((36.52, -84.38), (36.52, -84.12)),
        ((-33.0, 25.0), (-33.2, 25.1)),
        ((10.0, 179.9), (10.0, -179.9)),
    ]:
        length = geod.inv(start[1], start[0], end[1], end[0])[2]
        # the sphere is off by less than the flattening, 1/298, times 1.7
        assert line_length(Line(start_deg=start, end_deg=end)) == pytest.approx(length, rel=0.0057)


# every key that is known but cannot be flown yet, with a value that will be right one day
NOT_YET = {
    "air.wind.profile": "[{height_m: 0, speed_m_s: 5, from_deg: 90}]",
    "air.shear.exponent": "0.14",
    "air.shear.veer_deg_per_km": "3",
    "air.turbulence.model": "von_karman",
    "air.gusts": "[{start_s: 10, duration_s: 2}]",
    "flight.replay": "a.csv",
    "flight.pilot": "navigator",
    "flight.area": "{corners_deg: [[1, 2], [1, 3], [2, 3]]}",
    "flight.file": "lines.csv",
    "mount.level": "stabilised",
    "control.mode": "my_modes:Mine",
    "frame_camera.write": "true",
    "frame_camera.render_pixel_um": "24",
    "navigation.smooth": "{p: 2, d: 2}",
}


def test_the_table_of_what_is_missing_has_a_case_each() -> None:
    assert set(NOT_YET) >= set(AVAILABLE)
    assert all(field_at(Scenario, tuple(key.split("."))) for key in AVAILABLE)


@pytest.mark.parametrize("key", AVAILABLE)
def test_what_cannot_be_flown_yet_is_refused(write: Write, good: str, key: str) -> None:
    section = "air.wind={profile: " + NOT_YET[key] + "}" if key == "air.wind.profile" else f"{key}={NOT_YET[key]}"
    line = refused_with(write(good), section)
    assert line.startswith(f"--set {key}: ")
    assert "not available in this version (allowed: " in line
