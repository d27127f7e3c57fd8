"""From the scenario's keys to the parts of a run."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from flights import KM_PER_DEG, NORTH, WEST, scenario

from aerosim import run
from aerosim.errors import InputError, RunFailure
from aerosim.flight.navigator import Navigator
from aerosim.scenario.build import build, mean_wind, route_of, terrain_of
from aerosim.scenario.build.content import content_flown
from aerosim.scenario.build.route import ground_under
from aerosim.truth import AirState


def air_states(count: int, **air: Any) -> list[AirState]:
    """The air of a short flight, asked for at its start."""
    flight = build(scenario(4.0, air=air)).flight
    place = flight._guidance.plan.lines[0].start  # type: ignore[attr-defined]
    height = flight.plan.height
    return [flight._air.at(k, lambda: (*place, height)) for k in range(count)]  # type: ignore[attr-defined]


def test_wind_profile_is_taken_at_the_planned_height() -> None:
    # The ends of a profile are opposite winds, 6 m/s from the west and from the east: calm half way up.
    height = build(scenario(4.0)).flight.plan.height
    levels = [
        {"height_m": height - 1000.0, "speed_m_s": 6, "from_deg": 270},
        {"height_m": height + 2000.0, "speed_m_s": 6, "from_deg": 90},
    ]
    (found,) = air_states(1, wind={"profile": levels})
    assert found[:3] == pytest.approx((0.0, 6.0 * (1.0 - 2.0 / 3.0), 0.0), abs=1e-9)


def test_flat_land_lies_at_the_mean_and_has_a_flight_of_its_own() -> None:
    """Height above ground is another, so the flight is: runs over both lands must not share it."""
    rough, flat = scenario(4.0), scenario(4.0, terrain={"relief_factor": 0})
    routes = [route_of(each, terrain_of(each)) for each in (rough, flat)]
    line = routes[1].plan.lines[0]
    under = ground_under(flat, terrain_of(flat), line)
    assert under.low == under.high == pytest.approx(routes[1].ground, abs=1e-9)
    with rasterio.open(terrain_of(flat).elevation_file.path) as file:
        assert under.low == pytest.approx(file.read(1).mean(), abs=0.2)
    assert routes[1].plan.height == pytest.approx(routes[1].ground + 3000.0, abs=1e-9)
    assert content_flown(rough, routes[0]) != content_flown(flat, routes[1])


def test_shear_holds_above_the_ground_under_the_lines() -> None:
    made = scenario(
        4.0,
        flight={"height_m": 1500},
        air={
            "wind": {"speed_m_s": 10, "from_deg": 270},
            "shear": {"exponent": 0.5, "reference_agl_m": 3000, "veer_deg_per_km": 20},
        },
    )
    route = route_of(made, terrain_of(made))
    north, east, _ = mean_wind(made, route.plan, route.ground)
    assert math.hypot(north, east) == pytest.approx(10.0 * math.sqrt(0.5), rel=1e-9)
    # 1.5 km below the reference: backed by 30 deg, from 240 deg, so it blows to 60 deg
    assert math.degrees(math.atan2(east, north)) == pytest.approx(60.0, abs=1e-9)


def test_severity_is_another_word_for_sigma() -> None:
    light = air_states(200, turbulence={"model": "mil_f_8785c", "severity": "light"})
    one = air_states(200, turbulence={"sigma_m_s": 1.0})
    ratio = np.array([state.u for state in light]) / np.array([state.u for state in one])
    # MIL-F-8785C, figure 7 as JSBSim reads it: 6.7 ft/s at 7500 ft, 4.6 at 15000, exceeded once in a hundred
    height = build(scenario(4.0)).flight.plan.height / 0.3048
    assert ratio == pytest.approx(0.3048 * (6.7 - 2.1 * (height - 7500.0) / 7500.0), rel=1e-6)


def test_gust_comes_at_its_time() -> None:
    gust = {"start_s": 2, "duration_s": 4, "north_m_s": 3, "east_m_s": -2, "down_m_s": 1}
    found = air_states(200, gusts=[gust])
    # 40 states a second: its peak at 4 s, half of it at 3 and at 5 s
    assert found[160][:3] == pytest.approx((3.0, -2.0, 1.0), abs=1e-9)
    assert found[120][:3] == pytest.approx((1.5, -1.0, 0.5), abs=1e-9)
    assert found[40][:3] == (0.0, 0.0, 0.0)


def test_thermal_stands_where_it_is_put() -> None:
    thermal = {"center_deg": [NORTH, WEST], "radius_m": 300, "strength_m_s": 2.5}
    assert air_states(1, thermals=[thermal])[0][:3] == pytest.approx((0.0, 0.0, -2.5), abs=1e-6)
    away = {**thermal, "center_deg": [NORTH + 0.1, WEST]}
    assert air_states(1, thermals=[away])[0].wind_down == pytest.approx(0.0, abs=1e-6)


def test_mesoscale_wind_is_another_at_another_place() -> None:
    flight = build(scenario(4.0, air={"slow_wind": {"model": "mesoscale"}})).flight
    lat, lon = flight.plan.lines[0].start
    here = flight._air.at(1, lambda: (lat, lon, 3000.0))  # type: ignore[attr-defined]
    there = flight._air.at(2, lambda: (lat + 0.01, lon, 3000.0))  # type: ignore[attr-defined]
    assert 0.1 < math.hypot(here[0] - there[0], here[1] - there[1]) < 10.0


def lines_file(path: Path) -> Path:
    """The line of `scenario(4.0)` and one beside it, as GeoJSON."""
    east = WEST + 4.0 / KM_PER_DEG
    rows = [[[WEST, NORTH], [east, NORTH]], [[east, NORTH + 0.02], [WEST, NORTH + 0.02]]]
    features = [
        {
            "type": "Feature",
            "properties": {"name": f"strip {k}"},
            "geometry": {"type": "LineString", "coordinates": row},
        }
        for k, row in enumerate(rows)
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    return path


def test_lines_of_a_file_are_those_of_the_scenario(tmp_path: Path) -> None:
    file = str(lines_file(tmp_path / "lines.geojson"))
    given, read = scenario(4.0, back=True), scenario(4.0, flight={"lines": None, "file": file})
    found = route_of(read, terrain_of(read))
    assert found.plan == route_of(given, terrain_of(given)).plan
    assert found.names == ("strip 0", "strip 1")


def test_a_run_over_an_area_keeps_its_lines(tmp_path: Path) -> None:
    corners = [[NORTH, WEST + 0.06], [NORTH + 0.02, WEST + 0.06], [NORTH + 0.02, WEST + 0.1], [NORTH, WEST + 0.1]]
    done = run(
        scenario(flight={"lines": None, "area": {"corners_deg": corners, "course_deg": 0}, "height_m": 1500}),
        tmp_path / "run",
    )
    table = done.lines.to_pydict()
    assert table["name"] == ["1", "2", "3"][: len(table["name"])]
    # there and back, along the meridian
    assert np.sign(np.subtract(table["end_lat_deg"], table["start_lat_deg"])).tolist() == [
        (-1.0) ** k for k in range(len(table["name"]))
    ]
    assert sorted(set(done.telemetry["line"].to_pylist())) == [-1, *range(len(table["name"]))]
    # both edges of the area lie on photos
    photos = done.photos.to_pydict()
    assert min(photos["corner_rear_left_lon_deg"] + photos["corner_rear_right_lon_deg"]) < WEST + 0.06
    assert max(photos["corner_rear_left_lon_deg"] + photos["corner_rear_right_lon_deg"]) > WEST + 0.1


def test_pilot_by_word_of_mouth() -> None:
    crew = {"pilot": "navigator", "navigator": {"look_s": 30, "least_deg": 3}}
    law = build(scenario(4.0, flight=crew)).flight._guidance._law  # type: ignore[attr-defined]
    assert isinstance(law, Navigator)
    assert (law._p.look, law._p.least) == (30.0, 3)


def test_line_that_ends_before_a_strip_is_recognised() -> None:
    # The rows see the same ground 39.7/132.6 of the height apart: 898 m from 3000 m.
    with pytest.raises(InputError, match=r"line of [67]\d\d m ends before a first strip"):
        build(scenario(0.7))
    assert build(scenario(0.7, flight={"height_m": 1500})).route.plan.lines


def test_ground_that_is_hit_ends_the_run(tmp_path: Path) -> None:
    # The autopilot climbs by 3 m/s at most: air that sinks by 35 m/s carries the aircraft down.
    sinking = {"gusts": [{"start_s": 10, "duration_s": 120, "down_m_s": 35}]}
    with pytest.raises(RunFailure, match=r"hit the ground at \d+\.\d\d s") as failure:
        run(scenario(8.0, air=sinking, flight={"height_m": 900}), tmp_path / "run")
    assert failure.value.path == tmp_path / "run"
    from aerosim import open_run

    kept = open_run(tmp_path / "run")
    assert kept.status == "failed"
    assert 0.0 < kept.telemetry["agl_m"].to_pylist()[-1] < 5.0
