"""Heights below the aircraft against means of the surface itself, and windows that follow the flight."""

import math

import numpy as np
import pytest
import rasterio
from affine import Affine

from aerosim.frames import MapGrid
from aerosim.raster import sample
from aerosim.world.ground import GroundView, Spot, below
from aerosim.world.terrain import Terrain

EAST, NORTH, CELL = 700_000.0, 4_040_000.0, 10.0
LEVEL = np.array([EAST, NORTH, 0.0, 1.0, 1.0, 0.0])  # true north is grid north


def spot(surface, grid=LEVEL):
    """A spot over a surface of metres east and north of the point; 6 km square."""
    x, y = np.meshgrid(np.arange(-300, 301) * CELL, np.arange(300, -301, -1) * CELL)
    heights = np.asarray(surface(x, y) + 0.0 * x, np.float32)
    place = np.array([EAST - 3000.0, NORTH + 3000.0, CELL, -CELL])
    return Spot(np.asarray(grid), np.zeros_like(heights), place, heights, place)


def dense_means(surface, heading, along, across):
    """Mean over the rectangle and its middle line, by a fine sum in its own axes."""
    a, b = (np.linspace(-1.0, 1.0, 801)[:-1] + 1.0 / 800.0 for _ in range(2))
    ahead, right = np.meshgrid(a * along, b * across, indexing="ij")
    sin, cos = math.sin(heading), math.cos(heading)
    plane = surface(ahead * sin + right * cos, ahead * cos - right * sin)
    line = surface(b * across * cos, -b * across * sin)
    return float(np.mean(plane)), float(np.mean(line))


@pytest.mark.parametrize("heading", np.radians([0.0, 35.0, 90.0, 250.0]))
def test_slope(heading):
    found = below(spot(lambda x, y: 400.0 + 0.1 * x - 0.2 * y), heading, 450.0, 1080.0)
    # All three are centred on the nadir, whatever the heading.
    assert found == pytest.approx((400.0, 400.0, 400.0), abs=0.01)


@pytest.mark.parametrize("heading", np.radians([0.0, 35.0, 90.0, 250.0]))
def test_valley_and_hills_are_averaged_over_the_rectangle(heading):
    def valley(x, y):
        return 500.0 + 2e-4 * (0.8 * x + 0.6 * y) ** 2

    def hills(x, y):
        return 500.0 + 150.0 * np.sin(2.0 * np.pi * x / 2500.0 + 1.0) * np.cos(2.0 * np.pi * y / 3000.0)

    # Nine by five middles: the mean of a parabola comes out 1/25 too small along, 1/81 across; up to 1 m here.
    for surface in (valley, hills):
        found = below(spot(surface), heading, 450.0, 1080.0)
        mean, line = dense_means(surface, heading, 450.0, 1080.0)
        assert found.nadir == pytest.approx(surface(0.0, 0.0), abs=0.05)
        assert found.footprint == pytest.approx(mean, abs=1.0)
        assert found.strip == pytest.approx(line, abs=1.0)


def test_the_strip_lies_across():
    # A step in height 100 m ahead: the middle line does not see it, the rectangle does.
    found = below(spot(lambda x, y: np.where(y > 100.0, 600.0, 500.0)), 0.0, 450.0, 1080.0)
    assert found.strip == pytest.approx(500.0)
    assert found.footprint == pytest.approx(540.0)  # two of five lines


def test_direction_is_true_north_not_the_grids():
    # Meridians lean by 3 deg to the east of the grid's north: a ridge along the meridian stays under a northbound
    # aircraft's middle, and the strip across it sees the same as the ridge's profile.
    lean = math.radians(3.0)
    grid = [EAST, NORTH, math.sin(lean), math.cos(lean), math.cos(lean), -math.sin(lean)]

    def ridge(x, y):
        return 100.0 * (x * math.cos(lean) - y * math.sin(lean) > 0.0)

    # from 20 m to the right of the aircraft on the ground is high: four of nine points of every line
    found = below(spot(lambda x, y: ridge(x - 20.0, y), grid), 0.0, 1500.0, 1080.0)
    assert found.footprint == pytest.approx(100.0 * 4.0 / 9.0, abs=0.1)


def test_missing_ground_is_not_a_height():
    found = below(spot(lambda x, y: np.where(x > 500.0, np.nan, 300.0)), 0.0, 450.0, 1080.0)
    assert found.nadir == pytest.approx(300.0)
    assert math.isnan(found.footprint)
    assert math.isnan(found.strip)
    outside = below(spot(lambda x, y: 300.0, [EAST + 4000.0, *LEVEL[1:]]), 0.0, 450.0, 1080.0)
    assert all(math.isnan(value) for value in outside)


@pytest.fixture(scope="module")
def strip_of_land(tmp_path_factory):
    """An orthophoto and heights of 45 x 4 km that encode easting and northing, for windows of 20 km."""
    folder = tmp_path_factory.mktemp("land")
    cols, rows = 4500, 400
    x, y = (np.arange(cols) + 0.5) * CELL, -(np.arange(rows) + 0.5) * CELL
    bands = {
        "ortho": np.broadcast_to(np.mod(x, 2000.0) / 10.0, (rows, cols)).astype(np.uint8),
        "relief": (0.01 * x + 0.1 * y[:, None]).astype(np.float32),
    }
    for name, band in bands.items():
        with rasterio.open(
            folder / f"{name}.tif", "w", driver="GTiff", crs="EPSG:32616", count=1, height=rows, width=cols,
            dtype=band.dtype, transform=Affine(CELL, 0, EAST, 0, -CELL, NORTH),
        ) as file:  # fmt: skip
            file.write(band, 1)
            file.update_tags(VERTICAL_DATUM="ellipsoidal")
    return Terrain.open(folder / "ortho.tif", folder / "relief.tif", "file")


def test_windows_follow_the_aircraft(strip_of_land):
    grid = MapGrid("EPSG:32616")
    ends = grid.to_geodetic(np.array([EAST + 2000.0, EAST + 43_000.0]), np.full(2, NORTH - 2000.0))
    view = GroundView(strip_of_land, grid.local(*ends), 20.0)
    places = set()
    for e in np.arange(EAST + 2000.0, EAST + 43_000.0, 500.0):
        lat, lon = grid.to_geodetic(e, NORTH - 2000.0)
        here = view.around(float(lat), float(lon), 1500.0)
        assert here.grid[:2] == pytest.approx((e, NORTH - 2000.0), abs=2e-3)
        # relief known in closed form, 1.4 km around
        x0, y0, dx, dy = here.relief_place
        col, row = np.rint((e - x0) / dx + np.array([-140, 0, 140])), round((NORTH - 2000.0 - y0) / dy)
        for c in col.astype(int):
            expected = 0.01 * (x0 + c * dx - EAST) + 0.1 * (y0 + row * dy - NORTH)
            assert here.relief[row, c] == pytest.approx(expected, abs=0.01)
        # and grey, whole numbers of 10 m that start anew each 2 km
        x0, y0, dx, dy = here.ortho_place
        c = round((e - x0) / dx)
        assert here.ortho[row, c] == pytest.approx(math.floor(np.mod(x0 + c * dx - EAST, 2000.0) / 10.0), abs=0.01)
        places.add(tuple(here.relief_place))
    assert len(places) >= 2


def test_the_same_window_serves_as_long_as_it_can(strip_of_land):
    grid = MapGrid("EPSG:32616")
    lat, lon = grid.to_geodetic(EAST + 20_000.0, NORTH - 2000.0)
    view = GroundView(strip_of_land, grid.local(lat, lon), 20.0)
    first = view.around(float(lat), float(lon), 1000.0)
    second = view.around(float(lat), float(lon) + 1e-4, 1000.0)
    assert second.relief is first.relief
    assert second.ortho is first.ortho
    assert second.grid[0] - first.grid[0] == pytest.approx(1e-4 * 6378137.0 * math.cos(lat), rel=0.01)


def test_windows_are_half_a_pixel_fine(strip_of_land):
    grid = MapGrid("EPSG:32616")
    lat, lon = grid.to_geodetic(EAST + 20_000.0, NORTH - 2000.0)
    here = GroundView(strip_of_land, grid.local(lat, lon), 80.0).around(float(lat), float(lon), 1000.0)
    assert here.relief_place[2:] == pytest.approx([40.0, -40.0])
    # means of 4 x 4 cells of a plane are its values in the middle
    row = round((NORTH - 2000.0 - here.relief_place[1]) / -40.0)
    col = round((EAST + 20_000.0 - here.relief_place[0]) / 40.0)
    e, n = here.relief_place[:2] + here.relief_place[2:] * (col, row)
    assert here.relief[row, col] == pytest.approx(0.01 * (e - EAST) + 0.1 * (n - NORTH), abs=0.01)


def test_spot_and_raster_agree(strip_of_land):
    grid = MapGrid("EPSG:32616")
    lat, lon = grid.to_geodetic(EAST + 20_000.0, NORTH - 2000.0)
    here = GroundView(strip_of_land, grid.local(lat, lon), 20.0).around(float(lat), float(lon), 1500.0)
    window = strip_of_land.elevation(10.0).covering(EAST + 1e4, NORTH - 3000, EAST + 3e4, NORTH - 1000)
    nadir = below(here, 1.0, 400.0, 1000.0).nadir
    assert nadir == pytest.approx(float(sample(window, here.grid[0], here.grid[1])), abs=1e-3)
