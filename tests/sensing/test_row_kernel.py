"""Where the rows' pixels look and how they blur, against geometry in ECEF and exact transfer functions."""

import math

import numpy as np
import pytest
from row_world import EAST, FOCAL, NORTH, RADIUS, SPACING, cells, level_ground, march, pose, rays, rows, spot

from aerosim.frames import MapGrid
from aerosim.sensing.row_kernel import index_map, relief_depth
from aerosim.world.ground import Spot

CRS = "EPSG:32633"
LAT, LON = 0.88, math.radians(15.0) + 0.02  # 1.15 deg east of the central meridian: grid north leans by 0.9 deg


def hills(base):
    def surface(x, y):
        return base + 150.0 * np.sin(2.0 * np.pi * x / 2000.0 + 1.0) * np.cos(2.0 * np.pi * y / 2600.0) + 0.05 * x

    return surface


def on_the_map(values, place, grid):
    """The same cells around a place of a real map."""
    moved = np.round(place[:2] + (np.array(grid[:2]) - (EAST, NORTH)))
    return values, np.array([*moved, *place[2:]])


@pytest.mark.parametrize("tilt", np.radians([0.0, 5.0, 20.0, 40.0]))
def test_flat_land_in_closed_form(tilt):
    relief, place = cells(lambda x, y: 250.0, half=4000.0, cell=100.0)
    d = (0.6 * math.sin(tilt), 0.8 * math.sin(tilt), math.cos(tilt))
    s, height = relief_depth(
        *d, 3250.0, 0.0, relief, index_map(np.array([EAST, NORTH, 0, 1, 1, 0.0]), place, 250.0)
    )
    # A ray from R + H cut with a sphere of R + h; the drop is taken to first order, which costs 1 mm at 40 deg.
    top, half = RADIUS + 3250.0, (RADIUS + 3250.0) * d[2]
    assert s == pytest.approx(half - math.sqrt(half**2 - top**2 + (RADIUS + 250.0) ** 2), abs=3e-3)
    assert height == pytest.approx(250.0)


def test_rays_that_meet_nothing():
    relief, place = cells(lambda x, y: 250.0, half=1000.0, cell=50.0)
    on_map = index_map(np.array([EAST, NORTH, 0, 1, 1, 0.0]), place, 250.0)
    for d in ((0.0, 1.0, 0.0), (0.1, 0.0, -1.0), (0.5, 0.0, 1.0)):  # level, up, past the window's edge
        assert np.isnan(relief_depth(*d, 3250.0, 0.0, relief, on_map)).all()


@pytest.mark.parametrize("base", [0.0, 600.0, 2000.0])
def test_depth_of_rays_to_hills_against_a_march_in_ecef(base):
    # The fixed point ends within 0.5 m of height and is carried on once more, which leaves slope (0.5) times
    # tan 27 deg of it at worst, 0.13 m; the linear map and the Earth's mean radius are worth a centimetre.
    grid = MapGrid(CRS).local(LAT, LON)(LAT, LON)
    relief, place = on_the_map(*cells(hills(base)), grid)
    where = pose(1.0, 0.05, -0.08, height=3000.0 + base, lat=LAT, lon=LON)
    on_map = index_map(np.array(grid), place, base)
    for ray in np.vstack([rays(1)[::6], rays(2)[::6]]):
        d = where.mat_nc @ ray / np.linalg.norm(ray)
        *_, h, length = march(where, d, CRS, relief, place)
        s, found = relief_depth(*d, where.height, base, relief, on_map)
        assert s == pytest.approx(length, abs=0.13)
        assert found == pytest.approx(h, abs=0.13)


@pytest.mark.parametrize("base", [0.0, 2000.0])
def test_pixels_of_both_rows_on_hills_against_a_march_in_ecef(base):
    # The orthophoto encodes easting, then northing; turned against the map, tilted, over hills.  0.04 m for the
    # digits (5000 m in 65535), the rest for depth: 0.13 m seen under 27 deg.
    grid = MapGrid(CRS).local(LAT, LON)(LAT, LON)
    relief, place = on_the_map(*cells(hills(base)), grid)
    where = pose(1.0, 0.05, -0.08, height=3000.0 + base, lat=LAT, lon=LON)
    met = {
        row: np.array([march(where, where.mat_nc @ ray, CRS, relief, place) for ray in rays(row)[::5]])
        for row in (1, 2)
    }
    for axis in (0, 1):
        photo, photo_place = cells(lambda x, y, k=axis: ((x, y)[k] + 2500.0) / 5000.0 * 255.0)
        photo, photo_place = on_the_map(photo, photo_place, grid)
        made = rows(base).expose(where, Spot(np.array(grid), photo, photo_place, relief, place))
        # Value 0 belongs to the first column or the last row of the photo.
        zero = (photo_place[0], photo_place[1] + photo_place[3] * (len(photo) - 1))[axis]
        for row, grey in ((1, made.row1), (2, made.row2)):
            assert zero + grey[::5] / 65535.0 * 5000.0 == pytest.approx(met[row][:, axis], abs=0.11)
        assert made.missing == 0


@pytest.mark.parametrize("heading_deg", [0.0, 90.0, 200.0, 325.0])
@pytest.mark.parametrize(("pitch_deg", "roll_deg"), [(0.0, 0.0), (3.0, 0.0), (0.0, 1.5), (-2.0, -4.0)])
def test_pixel_places_on_level_land(heading_deg, pitch_deg, roll_deg):
    where = pose(*np.radians([heading_deg, pitch_deg, roll_deg]))
    for axis in (0, 1):  # northing, easting
        made = rows().expose(where, spot(lambda x, y, k=axis: ((y, x)[k] + 2500.0) / 5000.0 * 255.0))
        for row, grey in ((1, made.row1), (2, made.row2)):
            found = grey / 65535.0 * 5000.0 - 2500.0
            assert found == pytest.approx(level_ground(where, row)[axis], abs=0.06)  # a digit is 0.08 m


def test_signs_of_the_rows():
    # Flying north: row I lies half the spacing to the north, row II as far to the south, columns grow to the east.
    north, east = (
        rows().expose(pose(), spot(lambda x, y, k=k: ((y, x)[k] + 2500.0) / 5000.0 * 255.0)) for k in (0, 1)
    )
    pixel = 3000.0 / FOCAL
    for grey, side in ((north.row1, 1.0), (north.row2, -1.0)):
        assert grey / 65535.0 * 5000.0 - 2500.0 == pytest.approx(side * SPACING / 2.0 * pixel, abs=0.5)
    for grey in (east.row1, east.row2):
        steps = np.diff(grey / 65535.0 * 5000.0)
        assert steps == pytest.approx(pixel, abs=0.2)


def test_roll_and_pitch_shift_the_picture():
    # Right wing down: the camera looks to the left, 1.5 deg by f tan 1.5 deg = 3.47 px of 7.54 mrad (the study's
    # figure: 5 deg of drift).  Nose up: it looks ahead.
    pixel = 3000.0 / FOCAL
    assert pixel / 3000.0 == pytest.approx(7.54e-3, abs=1e-5)
    east = spot(lambda x, y: (x + 2500.0) / 5000.0 * 255.0)
    rolled = rows().expose(pose(roll=math.radians(1.5)), east).row2 / 65535.0 * 5000.0 - 2500.0
    assert rolled[47:49].mean() / pixel == pytest.approx(-3.47, abs=0.02)
    assert math.degrees(math.atan(3.47 / SPACING)) == pytest.approx(5.0, abs=0.01)
    north = spot(lambda x, y: (y + 2500.0) / 5000.0 * 255.0)
    nose_up = rows().expose(pose(pitch=math.radians(1.0)), north).row2 / 65535.0 * 5000.0 - 2500.0
    still = rows().expose(pose(), north).row2 / 65535.0 * 5000.0 - 2500.0
    assert (nose_up - still)[47:49].mean() / pixel == pytest.approx(math.tan(math.radians(1.0)) * FOCAL, abs=0.1)


def test_pixels_without_land_read_zero_and_are_counted():
    # The land ends 500 m east of the nadir (flying north); a pixel's outermost sample is 0.33 px = 7.4 m further.
    land = spot(lambda x, y: np.where(x > 500.0, np.nan, 100.0))
    made = rows().expose(pose(), land)
    blind = {}
    for row, grey in ((1, made.row1), (2, made.row2)):
        east = level_ground(pose(), row)[1]
        sure = east > 500.0 + 10.0
        assert not grey[sure].any()
        assert (grey[east < 480.0] == 25_700.0).all()
        blind[row] = int((grey == 0.0).sum())
        assert sure.sum() <= blind[row] <= (east > 480.0).sum()
    assert made.missing == blind[1] + blind[2]
    # no relief is no land either
    hole = spot(lambda x, y: 100.0, lambda x, y: np.where(x > 500.0, np.nan, 0.0))
    assert rows().expose(pose(), hole).missing > 0.8 * made.missing
