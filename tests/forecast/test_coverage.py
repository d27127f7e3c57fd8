"""Coverage and side lap: against the camera model in e, closed forms, and land made to have gaps."""

# ruff: noqa: E501  (a table of warnings, one a line)

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from planned import CAMERA, MIDDLE, NORTH, ground_of, place, utm, write_land

from aerosim.flight.block import Wanted, plan_block
from aerosim.flight.plan import FlightPlan
from aerosim.forecast.check import Outlook, outlook
from aerosim.forecast.coverage import coverage
from aerosim.forecast.land import Land
from aerosim.forecast.shots import corners, planned
from aerosim.frames import Array, ecef_from_geodetic, geodetic_from_ecef, mat_from_attitude
from aerosim.metrics.footprint import Ground, Relief, View, footprint
from aerosim.polygon import ring_of
from aerosim.raster import sample
from aerosim.scenario import from_mapping
from aerosim.scenario.build import camera_of
from aerosim.truth import CameraPose

WIDTH = 0.230 / 0.152


def bumpy(x: Array, y: Array) -> Array:
    return np.asarray(500.0 + 250.0 * np.sin(x / 1300.0) * np.cos(y / 900.0))


def scenario_of(folder: Path, lines: list[tuple[float, float, float, float]], **sections: Any) -> Any:
    """Lines by east and north of both ends, m, over the land in a folder."""
    ends = [
        {"start_deg": np.degrees(place(a, b)).tolist(), "end_deg": np.degrees(place(c, d)).tolist()}
        for a, b, c, d in lines
    ]
    data: dict[str, Any] = {
        "name": "try",
        "terrain": {
            "source": {"orthophoto": str(folder / "photo.tif"), "elevation": str(folder / "heights.tif")},
            "vertical_datum": "ellipsoidal",
        },
        "flight": {"lines": ends, "height_m": 1500},
    }
    for key, values in sections.items():
        data[key] = {**data.get(key, {}), **values}
    return from_mapping(data)


@pytest.fixture(scope="module")
def hilly(tmp_path_factory: pytest.TempPathFactory) -> Outlook:
    """Two lines of 12 km, 1.5 km apart, in a wind across that the camera does not follow: crab of 8 deg."""
    folder = tmp_path_factory.mktemp("hilly")
    write_land(folder, bumpy, half_east=10e3, half_north=5e3)
    lines = [(-6e3, 700.0, 6e3, 800.0), (6e3, -800.0, -6e3, -700.0)]
    wind = {"wind": {"speed_m_s": 10, "from_deg": 0}}
    return outlook(scenario_of(folder, lines, air=wind, control={"mode": "fixed"}))


def poses(found: Outlook) -> list[CameraPose]:
    """Poses of the planned photos with the heading against true north: the plane's north turns with longitude."""
    lat, lon = np.moveaxis(found.land.plane.to_geodetic(found.shots.place), -1, 0)
    made = []
    for k, heading in enumerate(found.shots.heading):
        ahead = found.shots.place[k] + 100.0 * np.array([np.sin(heading), np.cos(heading)])
        lat1, lon1 = found.land.plane.to_geodetic(ahead)
        true = np.arctan2((lon1 - lon[k]) * np.cos(lat[k]) * 6.386e6, (lat1 - lat[k]) * 6.358e6)
        mat = mat_from_attitude(float(true), 0.0, 0.0)
        made.append(CameraPose(0.0, lat[k], lon[k], found.plan.height, np.zeros(3), mat, np.zeros(3)))
    return made


def test_counts_are_those_of_the_camera_model(hilly: Outlook) -> None:
    assert abs(hilly.figures["lines"][0]["crab_deg"]) > 8.0
    found = coverage(hilly.land, hilly.shots, hilly.ring)  # type: ignore[arg-type]
    rows, cols = np.nonzero(found.within)
    pick = np.random.default_rng(3).choice(len(rows), 4000, replace=False)
    x, y = found.x[cols[pick]], found.y[rows[pick]]
    lat, lon = np.moveaxis(hilly.land.plane.to_geodetic(np.column_stack([x, y])), -1, 0)
    points = ecef_from_geodetic(lat, lon, sample(hilly.land.relief, x, y))
    camera = camera_of(scenario_of(Path("x"), [(0.0, 0.0, 5e3, 0.0)]))
    expected, unsure = np.zeros(len(pick), int), np.zeros(len(pick), bool)
    for pose in poses(hilly):
        away = np.abs(View(camera, pose).pixels_of(points) - camera.centre) - 0.5 * np.array(
            [camera.rows, camera.cols]
        )
        edge = away.max(axis=1)
        expected += edge <= 0.0
        unsure |= np.abs(edge) < 10.0  # 1.5 m on the ground
    assert unsure.mean() < 0.1
    assert (found.counts[rows[pick], cols[pick]] == expected)[~unsure].all()


def test_footprints_are_where_rays_meet_level_ground(tmp_path: Path) -> None:
    terrain = write_land(tmp_path, lambda x, y: 0.0 * x + 300.0, half_east=8e3, half_north=5e3)
    found = outlook(scenario_of(tmp_path, [(-3e3, -900.0, 3e3, 900.0)]))
    pose = poses(found)[1]
    ground = Ground(terrain.grid, terrain.elevation())
    view = View(camera_of(scenario_of(tmp_path, [(0.0, 0.0, 5e3, 0.0)])), pose)
    seen = footprint(view, Relief(ground, np.array([pose.lat]), np.array([pose.lon])).under(view))
    lat, lon, _ = geodetic_from_ecef(view.to_ecef(seen.corners_n))
    assert corners(found.land, found.shots)[1] == pytest.approx(
        found.land.plane.to_plane(np.column_stack([lat, lon])), abs=1.0
    )


def test_side_lap_over_flat_ground_is_the_closed_form(tmp_path: Path) -> None:
    write_land(tmp_path, lambda x, y: 0.0 * x + 300.0, half_east=29e3, half_north=5e3, cell=100.0)
    lines = [(-25e3, 800.0, 25e3, 800.0), (25e3, -800.0, -25e3, -800.0)]
    figures = outlook(scenario_of(tmp_path, lines)).figures
    (pair,) = figures["side_lap"]
    lap = 100.0 * (1.0 - 1600.0 * (1.0 + 300.0 / 6.371e6) / (WIDTH * 1500.0))
    # 0.1 % of the lap; the Earth's curve under half a photo, 0.1 m of 1500, and 9 mm of the format, 0.002 %
    assert pair["side_lap_mean_pct"] == pytest.approx(lap, rel=1e-3)
    assert pair["side_lap_min_pct"] == pytest.approx(lap, rel=1e-3)
    assert pair["spacing_m"] == pytest.approx(1600.0, rel=1e-4)
    for line in figures["lines"]:
        assert line["end_lap_pct"] == pytest.approx(60.0, rel=1e-3)
        assert line["photo_base_m"] == pytest.approx(0.4 * WIDTH * 1500.0, rel=1e-3)
    shares = figures["coverage"]
    assert shares["seen_0_pct"] == 0.0
    assert sum(shares[f"seen_{k}_pct"] for k in ("0", "1", "2", "3_or_more")) == pytest.approx(100.0)


def test_side_lap_over_a_slope_in_closed_form(tmp_path: Path) -> None:
    # Ground rising northwards by s: to the north a photo reaches r with r = k (H - s r), k = w/2: r = k H/(1 + k s).
    slope = 0.1
    write_land(tmp_path, lambda x, y: 500.0 + slope * y, half_east=8e3, half_north=5e3, cell=100.0)
    found = outlook(scenario_of(tmp_path, [(-4e3, -800.0, 4e3, -800.0), (4e3, 800.0, -4e3, 800.0)]))
    half, height = WIDTH / 2.0, found.plan.height
    middle = float(utm().from_geodetic(*MIDDLE)[1]) - NORTH
    low, high = (height - 500.0 - slope * (middle + y) for y in (-800.0, 800.0))
    reach = half * low / (1.0 + half * slope) + half * high / (1.0 - half * slope)
    (pair,) = found.figures["side_lap"]
    # the made slope rises with northing, the lines stand on the plane: 2 mrad of convergence and 4e-4 of scale
    assert pair["side_lap_mean_pct"] == pytest.approx(100.0 * (1.0 - 1600.0 / reach), rel=5e-3)


def test_a_gap_is_found_and_placed(tmp_path: Path) -> None:
    # A round hill of 900 m in the middle, lines 2 km apart 1500 m above the plain: photos meet at 660 m above it.
    def hill(x: Array, y: Array) -> Array:
        return np.asarray(200.0 + 900.0 * np.exp(-((x - 1000.0) ** 2 + y**2) / 2.0 / 700.0**2))

    write_land(tmp_path, hill, half_east=9e3, half_north=5e3)
    lines = [(-5e3, 1000.0, 5e3, 1000.0), (5e3, -1000.0, -5e3, -1000.0)]
    height = {"height_m": 1600, "height_above": "ellipsoid"}
    found = outlook(scenario_of(tmp_path, lines, flight=height)).figures
    gaps = found["coverage"]["gaps"]
    assert len(gaps) >= 1
    middle = np.degrees(place(1000.0, 0.0))
    assert (gaps[0]["lat_deg"], gaps[0]["lon_deg"]) == pytest.approx(tuple(middle), abs=2e-3)
    assert found["side_lap"][0]["side_lap_min_pct"] < 0.0
    assert any("on no photo, the largest gap" in line for line in found["warnings"])


def area_over(folder: Path, east: float, north: float, **flight: Any) -> Any:
    """An area of so many m around the middle, its lines from west to east."""
    half = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    corners = [np.degrees(place(a * east, b * north)).tolist() for a, b in half]
    area = {"corners_deg": corners, "course_deg": 90.0, **flight}
    return scenario_of(folder, [], flight={"lines": None, "area": area})


def test_side_lap_is_judged_over_the_area_alone(tmp_path: Path) -> None:
    # A wall of 800 m 300 m east of the area: photos before and after it overlap less there, or not at all.
    def wall(x: Array, y: Array) -> Array:
        return np.asarray(np.where(x > 1800.0, 1100.0, 300.0) + 0.0 * y)

    write_land(tmp_path, wall, half_east=9e3, half_north=6e3)
    found = outlook(area_over(tmp_path, 3000.0, 5000.0, side_lap_pct=20, side_lap_min_pct=15)).figures
    assert len(found["lines"]) >= 3
    assert found["photos"]["side_lap_min_pct"] == pytest.approx(20.0, abs=0.5)  # flat: as asked for
    assert [pair["lines"] for pair in found["side_lap"]] == [
        f"{k}, {k + 1}" if found["side_lap"][0]["lines"] == "1, 2" else f"{k + 1}, {k}"
        for k in range(1, len(found["lines"]))
    ]
    assert not [line for line in found["warnings"] if "side lap" in line]


@pytest.mark.parametrize("course_deg", [90.0, 30.0])
def test_side_lap_is_nowhere_less_within_the_area(tmp_path: Path, course_deg: float) -> None:
    write_land(tmp_path, lambda x, y: 2.0 * bumpy(x, y) - 500.0, half_east=10e3, half_north=9e3)
    scenario = area_over(tmp_path, 7000.0, 6000.0, course_deg=course_deg, side_lap_pct=20, side_lap_min_pct=15)
    found = outlook(scenario).figures
    # a hair less where the relief between two of the planner's cells is higher than both
    assert found["photos"]["side_lap_min_pct"] > 14.8
    assert not [line for line in found["warnings"] if "side lap" in line]


def test_a_tiny_area_is_counted_on_a_finer_grid(tmp_path: Path) -> None:
    write_land(tmp_path, lambda x, y: 0.0 * x + 300.0, half_east=8e3, half_north=5e3, cell=100.0)
    found = outlook(area_over(tmp_path, 9.0, 11.0)).figures["coverage"]
    assert found["area_km2"] == pytest.approx(99e-6, rel=1e-3)
    assert sum(found[f"seen_{k}_pct"] for k in ("0", "1", "2", "3_or_more")) == pytest.approx(100.0)
    assert (found["seen_0_pct"], found["unknown_pct"]) == (0.0, 0.0)
    assert found["grid_m"] < 0.5


def test_neighbours_are_those_beside_each_other(tmp_path: Path) -> None:
    write_land(tmp_path, lambda x, y: 0.0 * x + 300.0, half_east=9e3, half_north=6e3, cell=100.0)
    # Out of order, one in two parts, one far off, one across all.
    lines = [
        (-5e3, 3000.0, 5e3, 3000.0), (-5e3, 0.0, -1e3, 0.0), (5e3, 1500.0, -5e3, 1500.0), (1e3, 0.0, 5e3, 0.0),
        (0.0, -4e3, 0.0, 4e3), (-5e3, -5e3, 5e3, -5e3),
    ]  # fmt: skip
    found = outlook(scenario_of(tmp_path, lines)).figures["side_lap"]
    assert sorted(tuple(sorted(pair["lines"].split(", "))) for pair in found) == [
        ("0", "2"),
        ("1", "2"),
        ("2", "3"),
    ]
    assert all(pair["spacing_m"] == pytest.approx(1500.0, rel=1e-3) for pair in found)


def test_one_line_has_neither_side_lap_nor_area(tmp_path: Path) -> None:
    write_land(tmp_path, lambda x, y: 0.0 * x + 300.0, half_east=8e3, half_north=3e3, cell=100.0)
    found = outlook(scenario_of(tmp_path, [(-4e3, 0.0, 4e3, 0.0)])).figures
    assert (found["side_lap"], found["coverage"], found["photos"]["side_lap_min_pct"]) == (None, None, None)


WARNED: list[tuple[dict[str, Any], str]] = [
    ({"air": {"wind": {"speed_m_s": 10, "from_deg": 0}}, "mount": {"yaw_limit_deg": 5}}, "lines 0, 1: drift of up to 8.3 deg, slow wind included, is beyond the mount's 5 deg"),
    ({"air": {"wind": {"speed_m_s": 15, "from_deg": 0}}}, "beyond the +-10.0 deg that the rows see: it is searched for"),
    ({"air": {"wind": {"speed_m_s": 10, "from_deg": 0}, "slow_wind": {"sigma_m_s": 1.5}}}, "beyond the +-10.0 deg that the rows see"),
    ({"flight": {"run_in_s": 30}}, "run-in of 30 s is shorter than the 45 s"),
    ({"control": {"fmc": False}}, "px without FMC is above 0.5 px"),
    ({"air": {"wind": {"speed_m_s": 20, "from_deg": 270}}, "frame_camera": {"min_interval_s": 13}}, "line 0: a photo each 10.2 s is wanted, the camera takes one each 13 s: end lap of 48.8 %"),
    ({"flight": {"height_m": 4000}}, "lines 0, 1: photos reach up to"),
]  # fmt: skip


@pytest.mark.parametrize(("sections", "words"), WARNED)
def test_what_a_navigator_would_object_to(tmp_path: Path, sections: dict[str, Any], words: str) -> None:
    write_land(tmp_path, lambda x, y: 0.0 * x + 300.0, half_east=8e3, half_north=3e3, cell=100.0)
    lines = [(-4e3, 700.0, 4e3, 700.0), (4e3, -700.0, -4e3, -700.0)]
    quiet = outlook(scenario_of(tmp_path, lines)).figures["warnings"]
    assert quiet == []
    told = outlook(scenario_of(tmp_path, lines, **sections)).figures["warnings"]
    assert [line for line in told if words in line], told


@pytest.mark.slow
def test_no_gap_in_any_area(tmp_path: Path) -> None:
    """Two hundred areas of any shape over ridges of 1000 m, from 200 m above them on: on no grid cell a gap."""
    terrain = write_land(tmp_path, bumpy, half_east=12e3, half_north=12e3)
    ground, rng = ground_of(terrain), np.random.default_rng(5)
    for number in range(200):
        angle = np.sort(rng.uniform(0.0, 2.0 * np.pi, rng.integers(3, 12)))
        if np.diff(np.append(angle, angle[0] + 2.0 * np.pi)).max() > np.pi - 0.05:
            continue  # the middle lies outside: such a star may cross itself
        radii = rng.uniform(600.0, 9000.0, len(angle))
        area = np.array([place(r * np.cos(a), r * np.sin(a)) for r, a in zip(radii, angle, strict=True)])
        course = None if rng.random() < 0.5 else float(rng.uniform(0.0, 6.28))
        wanted = Wanted(
            float(rng.uniform(500.0, 3500.0)), side_lap=float(rng.uniform(0.1, 0.8)), end_lap=0.8, course=course
        )
        block = plan_block(area, wanted, CAMERA, ground)
        land = Land(FlightPlan(block.lines, block.height, 70.0), terrain, CAMERA, area)
        base = 0.2 * WIDTH * (block.height - block.ground)
        counts = [int(line.length_at(block.height) / base) + 1 for line in block.lines]
        shots = planned(land, counts, [base] * len(counts), [0.0] * len(counts))
        seen = coverage(land, shots, ring_of(land.plane.to_plane(area)))
        assert seen.share(0) == 0.0, (number, wanted)
