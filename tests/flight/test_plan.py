from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Geod

from aerosim.errors import InputError
from aerosim.flight.plan import FlightPlan, Line, wind_triangle
from aerosim.flight.turns import roll_lag, turn_radius
from aerosim.frames import ecef_from_geodetic, mat_ne

from .conftest import AIRSPEED, HEIGHT, beside, line_of

GEOD = Geod(ellps="WGS84")
BANK = math.radians(20.0)


@given(st.floats(-4.0, 4.0), st.floats(20.0, 120.0), st.floats(0.0, 0.95), st.floats(-4.0, 4.0))
def test_wind_triangle_closes(course: float, airspeed: float, share: float, wind_to: float) -> None:
    wind = share * airspeed * np.array([math.cos(wind_to), math.sin(wind_to)])
    heading, ground_speed = wind_triangle(course, airspeed, *wind)
    air = airspeed * np.array([math.cos(heading), math.sin(heading)])
    assert air + wind == pytest.approx(ground_speed * np.array([math.cos(course), math.sin(course)]), abs=1e-9)
    assert ground_speed > 0.0


def test_wind_from_the_left_makes_positive_drift() -> None:
    heading, ground_speed = wind_triangle(math.radians(90.0), AIRSPEED, -10.0, 0.0)
    assert math.radians(90.0) - heading == pytest.approx(math.asin(10.0 / AIRSPEED))
    assert ground_speed == pytest.approx(math.sqrt(AIRSPEED**2 - 100.0))


@pytest.mark.parametrize("wind", [(-70.0, 0.0), (0.0, 70.0), (-69.44, 0.0), (math.nan, 0.0)])
def test_wind_that_cannot_be_flown(wind: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="cannot be flown against"):
        wind_triangle(0.0, AIRSPEED, *wind)


@pytest.mark.parametrize(
    ("start", "end"),
    [((51.0, 13.0), (51.0, 13.7)), ((36.52, -84.38), (36.52, -84.12)), ((-30.0, 20.0), (-33.0, 18.0)),
     ((0.2, -0.3), (-0.1, 0.4)), ((70.0, 179.9), (70.2, 180.4))],
)  # fmt: skip
def test_line_on_the_ellipsoid(start: tuple[float, float], end: tuple[float, float]) -> None:
    line = Line(tuple(np.radians(start)), tuple(np.radians(end)))
    azimuth, _, length = GEOD.inv(start[1], start[0], end[1], end[0])
    # A plane section and the geodesic differ in length by 1e-10 of it at these lengths; Euler's radius midway
    # stands for the whole line, good to (length / radius)^2 / 24 of the ellipsoid's flattening.
    assert line.length == pytest.approx(length, rel=3e-6)
    assert math.degrees(line.course) % 360.0 == pytest.approx(azimuth % 360.0, abs=1e-3)
    middle = GEOD.npts(start[1], start[0], end[1], end[0], 1)[0]
    point = ecef_from_geodetic(*np.radians(middle[::-1]), 0.0)
    # The normal section leaves the geodesic by e2 d^3 / (24 R^2) at most: 0.3 m at 400 km.
    assert line.normal @ point == pytest.approx(line.offset, abs=0.02 + 0.3 * (length / 4e5) ** 3)
    for lat, lon in (line.start, line.end):
        assert line.normal @ ecef_from_geodetic(lat, lon, 0.0) == pytest.approx(line.offset, abs=1e-6)


def test_normal_points_to_the_right() -> None:
    line = line_of(0.0, 5000.0)
    north, east, down = mat_ne(*line.start) @ line.normal
    assert (north, east, down) == pytest.approx((0.0, 1.0, 0.0), abs=1e-3)


def test_run_in_lies_on_the_extension() -> None:
    line = line_of(30.0, 8000.0)
    lat, lon = line.before_start(4000.0, HEIGHT)
    point = ecef_from_geodetic(lat, lon, HEIGHT)
    assert line.normal @ point == pytest.approx(line.offset, abs=0.01)
    assert np.linalg.norm(point - line.end_points(HEIGHT)[0]) == pytest.approx(4000.0, abs=0.01)
    back, _, _ = GEOD.inv(math.degrees(lon), math.degrees(lat), *np.degrees(line.start)[::-1])
    assert math.degrees(line.course_at(lat, lon)) == pytest.approx(back, abs=1e-3)


def test_forecast_of_a_race_track_in_closed_form() -> None:
    # Two lines 400 m more than a turn's diameter apart, flown there and back without run-in in still air: the turn
    # is half a circle, 400 m straight in its middle, with the roll's lag before and after it.
    radius = turn_radius(AIRSPEED, 0.9 * BANK)
    first = line_of(0.0, 10_000.0, (0.0, 0.2))
    spacing = 2.0 * radius + 400.0
    second = Line(beside(first.end, spacing, 0.0), beside(first.start, spacing, 0.0))
    forecast = FlightPlan([first, second], 0.0, AIRSPEED, run_in_s=0.0, bank_max=BANK).forecast()
    turn = (math.pi * radius + 400.0) / AIRSPEED + 2.0 * roll_lag(0.9 * BANK)
    assert forecast.turn_s[0] == pytest.approx(turn, rel=0.001)
    # 10 km on the sphere of the equator is shorter on the ellipsoid's meridian by 0.67 %.
    assert forecast.line_s == pytest.approx([10_000.0 / AIRSPEED] * 2, rel=0.01)
    assert forecast.duration == pytest.approx(sum(forecast.line_s) + forecast.turn_s[0])


def test_forecast_knows_the_wind() -> None:
    lines = [line_of(90.0, 10_000.0)]
    forecast = FlightPlan(lines, HEIGHT, AIRSPEED, run_in_s=30.0).forecast(0.0, -10.0)
    assert forecast.ground_speed[0] == pytest.approx(AIRSPEED - 10.0, abs=0.01)
    assert forecast.line_s[0] == pytest.approx(lines[0].length_at(HEIGHT) / (AIRSPEED - 10.0), rel=1e-3)
    assert forecast.duration == pytest.approx(30.0 + forecast.line_s[0])


@pytest.mark.parametrize(
    ("start", "end"),
    [((0.9, 0.2), (0.9, 0.2)), ((0.9, 0.2), (0.9, 0.200001)), ((0.9, 0.2), (-0.9, 0.2)),
     ((1.57, 0.2), (1.56, 0.2)), ((math.nan, 0.2), (0.9, 0.2)), ((51.0, 13.0), (51.0, 14.0))],
)  # fmt: skip
def test_bad_lines(start: tuple[float, float], end: tuple[float, float]) -> None:
    with pytest.raises(InputError):
        Line(start, end)


@pytest.mark.parametrize(
    "wrong",
    [{"lines": []}, {"airspeed": 0.0}, {"airspeed": math.nan}, {"height": 1e6}, {"height": math.nan},
     {"run_in_s": -1.0}, {"run_in_s": math.inf}, {"bank_max": 0.0}, {"bank_max": 1.0}],
)  # fmt: skip
def test_bad_plans(wrong: dict[str, object]) -> None:
    right: dict[str, object] = {"lines": [line_of(0.0, 5000.0)], "height": HEIGHT, "airspeed": AIRSPEED}
    with pytest.raises(InputError):
        FlightPlan(**{**right, **wrong})  # type: ignore[arg-type]
