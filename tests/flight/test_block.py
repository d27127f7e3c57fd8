"""Lines over an area: spacing and ends against closed forms and geodesics, gaps counted by the camera model."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from planned import CAMERA, ground_of, place, rectangle, write_land
from pyproj import Geod

from aerosim.errors import InputError
from aerosim.flight.block import Block, Ground, Wanted, plan_block
from aerosim.flight.order import flown, race_track
from aerosim.flight.plan import FlightPlan, Line
from aerosim.frames import Array, ecef_from_geodetic, mat_from_attitude
from aerosim.metrics.footprint import View
from aerosim.raster import sample
from aerosim.truth import CameraPose

GEOD = Geod(ellps="WGS84")
R = 6_371_000.0
WIDTH = 0.230 / 0.152  # of a photo over the distance; 19167 px of 12 um are 230.004 mm


@pytest.fixture(scope="module")
def flat(tmp_path_factory: pytest.TempPathFactory) -> Ground:
    """60 x 24 km at 600 m."""
    return ground_of(write_land(tmp_path_factory.mktemp("flat"), lambda x, y: 0.0 * x + 600.0, cell=100.0))


def hills(x: Array, y: Array) -> Array:
    """Ridges up to 1000 m, with valleys 700 m below."""
    return np.asarray(650.0 + 350.0 * np.sin(x / 900.0 + 0.3) * np.cos(y / 1100.0) + 0.02 * y)


@pytest.fixture(scope="module")
def rough(tmp_path_factory: pytest.TempPathFactory) -> Ground:
    folder = tmp_path_factory.mktemp("rough")
    return ground_of(write_land(folder, hills, half_east=10e3, half_north=8e3))


def degrees(point: tuple[float, float]) -> tuple[float, float]:
    """Longitude, latitude, deg, as pyproj takes them."""
    return math.degrees(point[1]), math.degrees(point[0])


def distance_to(line: Line, lon: float, lat: float) -> float:
    """Shortest distance (m) of a point from the geodesic through a line's ends, by pyproj alone."""
    start, end = degrees(line.start), degrees(line.end)
    azimuth, _, length = GEOD.inv(*start, *end)
    low, high = -0.8 * length, 1.8 * length
    for _ in range(6):
        along = np.linspace(low, high, 41)
        lons, lats, _ = GEOD.fwd(*(np.full(41, v) for v in start), np.full(41, azimuth), along)
        away = GEOD.inv(lons, lats, np.full(41, lon), np.full(41, lat))[2]
        k = int(np.argmin(away))
        low, high = along[max(k - 1, 0)], along[min(k + 1, 40)]
    return float(away.min())


@pytest.mark.parametrize("course_deg", [None, 37.0, 90.0])
def test_side_lap_over_flat_ground_is_the_closed_form(flat: Ground, course_deg: float | None) -> None:
    # 50 x 9 km, or 24 x 9 km across 37 deg; spacing on the ground (1 - p) w H, on the ellipsoid less by h/R.
    course = None if course_deg is None else math.radians(course_deg)
    corners = rectangle(50e3, 9e3) if course_deg != 37.0 else rectangle(24e3, 9e3)
    block = plan_block(corners, Wanted(2500.0, side_lap=0.3, course=course), CAMERA, flat)
    assert len(block.lines) >= 4
    assert (block.ground, block.height) == (pytest.approx(600.0), pytest.approx(3100.0))
    wanted = 0.7 * WIDTH * 2500.0 / (1.0 + 600.0 / R)
    for one, other in zip(block.lines[:-1], block.lines[1:], strict=True):
        for share in (0.05, 0.5, 0.95):  # over 50 km: neither the map's scale nor convergence may show
            azimuth, _, length = GEOD.inv(*degrees(one.start), *degrees(one.end))
            lon, lat, _ = GEOD.fwd(*degrees(one.start), azimuth, share * length)
            spacing = distance_to(other, lon, lat)
            # 0.1 % of a side lap of 30 % is 0.03 % of the width: 0.04 % of the spacing
            assert spacing == pytest.approx(wanted, rel=4e-4)


def test_ends_cover_the_area_with_a_photo_beyond(flat: Ground) -> None:
    # A rectangle along the lines: every line begins one base before it; photos stand symmetrically over it.
    block = plan_block(rectangle(20e3, 6e3), Wanted(2500.0, course=math.radians(90.0)), CAMERA, flat)
    base = 0.4 * WIDTH * 2500.0 / (1.0 + 3100.0 / R)
    assert block.base == pytest.approx(base, rel=1e-4)
    bases = math.ceil(20e3 / base + 2.0)
    for line in block.lines:
        assert line.length == pytest.approx((bases + 0.5) * base, rel=2e-5)
        west, east = sorted(degrees(point)[0] for point in (line.start, line.end))
        edges = sorted(degrees(place(x, 0.0))[0] for x in (-10e3, 10e3))
        metre = 1.0 / GEOD.inv(0.0, 36.52, 1.0, 36.52)[2]
        before, after = (edges[0] - west) / metre, (east - edges[1]) / metre
        assert min(before, after) >= base - 1.0
        assert abs(before - after) == pytest.approx(0.5 * base, abs=20.0)  # beyond the last photo
    # There and back.
    heads = [math.degrees(line.course) % 360.0 for line in block.lines]
    assert heads == [pytest.approx(90.0 if k % 2 == 0 else 270.0, abs=0.3) for k in range(len(heads))]


def test_surplus_is_shared_by_both_edges(flat: Ground) -> None:
    block = plan_block(rectangle(20e3, 6e3), Wanted(2500.0, course=math.radians(90.0)), CAMERA, flat)
    lats = [math.degrees(_halfway(line)[0]) for line in block.lines]
    north, south = max(lats), min(lats)
    edges = [degrees(place(0.0, y))[1] for y in (-3e3, 3e3)]
    assert edges[1] - north == pytest.approx(south - edges[0], abs=1e-5)
    # the least width beyond the edge is a tenth of a photo's
    assert (edges[1] - north) * 111_000.0 <= 0.4 * WIDTH * 2500.0


def level_shots(block: Block, agl: float) -> list[tuple[float, float, float]]:
    """Latitude, longitude, heading (rad) of level photos at the wanted base, by pyproj."""
    shots = []
    for line in block.lines:
        azimuth, _, length = GEOD.inv(*degrees(line.start), *degrees(line.end))
        base = 0.4 * WIDTH * agl / (1.0 + block.height / R)
        for k in range(int(length / base) + 1):
            lon, lat, back = GEOD.fwd(*degrees(line.start), azimuth, k * base)
            shots.append((math.radians(lat), math.radians(lon), math.radians(back + 180.0)))
    return shots


def seen(block: Block, ground: Ground, half_east: float, half_north: float, number: int = 61) -> Array:
    """How many photos show each point of a grid over a rectangle, by the camera model in e.  (number, number)."""
    points = [place(x, y) for y in np.linspace(-half_north, half_north, number)
              for x in np.linspace(-half_east, half_east, number)]  # fmt: skip
    lat, lon = np.transpose(points)
    e, n = ground.grid.from_geodetic(lat, lon)
    heights = sample(ground.elevation(0.0).covering(e.min(), n.min(), e.max(), n.max()), e, n)
    assert np.isfinite(heights).all()
    points_e = ecef_from_geodetic(lat, lon, heights)
    count = np.zeros(len(points), int)
    for shot_lat, shot_lon, heading in level_shots(block, block.height - block.ground):
        pose = CameraPose(
            0.0, shot_lat, shot_lon, block.height, np.zeros(3), mat_from_attitude(heading, 0.0, 0.0), np.zeros(3)
        )
        px = View(CAMERA, pose).pixels_of(points_e)
        count += (np.abs(px - CAMERA.centre) <= 0.5 * np.array([CAMERA.rows, CAMERA.cols])).all(axis=1)
    return count


@pytest.mark.parametrize("course_deg", [None, 20.0])
def test_no_gap_over_relief(rough: Ground, course_deg: float | None) -> None:
    # 400 m above the ridges, 750 m above the mean: over a ridge the photo is only half as wide.
    course = None if course_deg is None else math.radians(course_deg)
    corners = rectangle(10e3, 7e3)
    wanted = Wanted(750.0, side_lap=0.3, side_lap_min=0.1, end_lap=0.8, course=course)
    block = plan_block(corners, wanted, CAMERA, rough)
    least = min(block.spacing)
    assert least < 0.95 * 0.7 * WIDTH * 750.0, "the relief must have narrowed some lines"
    assert seen_at(block, rough, 0.8).min() >= 1
    # Spaced as over flat ground there are gaps: the count can see them.
    plain = plan_block(
        corners, Wanted(750.0, side_lap=0.1, side_lap_min=0.0, end_lap=0.8, course=course), CAMERA, rough
    )
    stretched = tuple(line for k, line in enumerate(plain.lines) if k % 2 == 0)
    assert seen_at(plain._replace(lines=stretched), rough, 0.8).min() == 0


def seen_at(block: Block, ground: Ground, end_lap: float) -> Array:
    assert end_lap == 0.8
    return seen(block, ground, 5e3, 3.5e3)


def test_a_turned_area_is_flown_along_its_length(flat: Ground) -> None:
    block = plan_block(rectangle(15e3, 4e3, turned_deg=-30.0), Wanted(2500.0), CAMERA, flat)
    assert math.degrees(block.course) % 180.0 == pytest.approx(60.0, abs=0.01)
    across = plan_block(
        rectangle(15e3, 4e3, turned_deg=-30.0), Wanted(2500.0, course=math.radians(150.0)), CAMERA, flat
    )
    assert len(across.lines) > 2 * len(block.lines)


def test_a_concave_area_is_flown_in_parts_or_through(flat: Ground) -> None:
    # A U of two arms 5 km wide; between them 6 km, or 3 km, which is less than a run-in of 4.2 km and two bases.
    def u(gap: float) -> Array:
        out = 5e3 + gap / 2
        ring = [(-out, -6e3), (out, -6e3), (out, 6e3), (gap / 2, 6e3), (gap / 2, -3e3), (-gap / 2, -3e3),
                (-gap / 2, 6e3), (-out, 6e3)]  # fmt: skip
        return np.array([place(x, y) for x, y in ring])

    east = math.radians(90.0)
    split = plan_block(u(14e3), Wanted(2500.0, course=east), CAMERA, flat)
    assert {name[-1] for name in split.tracks} >= {"a", "b"}
    # flown in their order: part a of a track eastward before b, westward after it
    for k in range(len(split.tracks) - 1):
        if split.tracks[k][:-1] == split.tracks[k + 1][:-1] and split.tracks[k][-1] in "ab":
            eastward = math.sin(split.lines[k].course) > 0.0
            assert (split.tracks[k][-1] == "a") is eastward
    through = plan_block(u(3e3), Wanted(2500.0, course=east), CAMERA, flat)
    assert len(through.lines) == len(through.spacing) + 1


def test_race_tracks_leave_lines_out() -> None:
    for number in range(1, 40):
        for leap in range(1, 9):
            assert sorted(race_track(number, leap)) == list(range(number))
    assert race_track(7, 4) == [0, 4, 1, 5, 2, 6, 3]


def test_race_track_turns_need_no_loop(flat: Ground) -> None:
    # Turns of 2.96 km in diameter, lines 1.1 km apart: at least three lines are left out.
    corners, plain = rectangle(12e3, 18e3), Wanted(1000.0, course=math.radians(90.0), turn_diameter=2960.0)
    sequential = plan_block(corners, plain, CAMERA, flat)
    race = plan_block(corners, Wanted(**{**vars(plain), "order": "race_track"}), CAMERA, flat)
    assert sorted(line.start for line in race.lines)[0][1] == pytest.approx(
        sorted(line.start for line in sequential.lines)[0][1], abs=1e-3
    )

    def duration(lines: Any) -> float:
        return FlightPlan(lines, 1600.0, 69.44).forecast().duration

    assert len(race.lines) == len(sequential.lines)
    assert duration(race.lines) < duration(sequential.lines)
    best = plan_block(corners, Wanted(**{**vars(plain), "order": "shortest"}), CAMERA, flat, duration=duration)
    assert duration(best.lines) <= duration(race.lines) + 1e-6
    with pytest.raises(InputError, match="shortest"):
        flown([1, 1], [1000.0], "shortest", 3000.0, lambda *_: sequential.lines[0], None)


def test_a_small_area_gets_a_line_that_can_be_flown(flat: Ground) -> None:
    block = plan_block(rectangle(50.0, 50.0), Wanted(300.0), CAMERA, flat)
    assert len(block.lines) == 1
    assert block.lines[0].length >= 500.0


@pytest.mark.parametrize(
    ("corners", "words"),
    [
        ([(-5e3, -5e3), (5e3, 5e3), (5e3, -5e3), (-5e3, 5e3)], "crosses or touches itself at latitude 36.52"),
        ([(-5e3, -5e3), (5e3, -5e3), (0.0, -5e3 + 1e-4)], "area of zero"),
        ([(-5e3, -5e3), (5e3, -5e3), (5e3, -5e3)], "2 distinct corners"),
        ([(-5e3, -5e3), (5e3, -5e3), (5e3, 5e3), (5e3, 9e3), (5e3, 5e3)], "crosses or touches itself"),
        ([(-50e3, -5e3), (5e3, -5e3), (5e3, 5e3)], "% of the area lie beyond the terrain"),
    ],
)
def test_polygons_that_are_none(flat: Ground, corners: list[tuple[float, float]], words: str) -> None:
    with pytest.raises(InputError, match=words):
        plan_block(np.array([place(*each) for each in corners]), Wanted(2500.0), CAMERA, flat)


def test_points_on_one_parallel_are_no_area(flat: Ground) -> None:
    # 18 km along a parallel bulge 5 m out of the plane's straight line: an area of 0.03 km2, which nobody meant.
    corners = np.radians([[36.52, -87.1], [36.52, -87.0], [36.52, -86.9]])
    with pytest.raises(InputError, match="area of zero"):
        plan_block(corners, Wanted(2500.0), CAMERA, flat)


def test_swapped_latitude_and_longitude_are_guessed(flat: Ground) -> None:
    with pytest.raises(InputError, match=r"100 % of the area lie beyond .*: latitude and longitude are swapped"):
        plan_block(rectangle(5e3, 5e3)[:, ::-1], Wanted(2500.0), CAMERA, flat)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"side_lap": 0.95}, "side lap of 95 %"),
        ({"side_lap": math.nan}, "side lap of nan"),
        ({"side_lap_min": 0.4}, "least side lap of 40 %"),
        ({"end_lap": 1.0}, "end lap of 100 %"),
        ({"beyond": 30}, "30 photos beyond"),
        ({"height": 500.0, "above_ground": False}, "not above the area's highest ground"),
        ({"height": 3.0}, "more than 1000 lines"),
        ({"order": "random"}, "'random' is not known"),
    ],
)
def test_wishes_that_make_no_plan(flat: Ground, wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        plan_block(rectangle(5e3, 5e3), Wanted(**{"height": 2500.0, **wrong}), CAMERA, flat)


def test_line_planes_stay_apart(tmp_path: Path, flat: Ground) -> None:
    """A line of the plan is the plane that the guidance flies: its middle lies where the block put it."""
    block = plan_block(rectangle(50e3, 6e3), Wanted(2500.0, course=math.radians(90.0)), CAMERA, flat)
    for one, other in zip(block.lines[:-1], block.lines[1:], strict=True):
        middle = ecef_from_geodetic(*_halfway(one), 0.0)
        assert abs(other.normal @ middle - other.offset) == pytest.approx(block.spacing[0], rel=4e-4)


def _halfway(line: Line) -> tuple[float, float]:
    lon, lat = GEOD.npts(*degrees(line.start), *degrees(line.end), 1)[0]
    return math.radians(lat), math.radians(lon)
