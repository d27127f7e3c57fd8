"""Terrain of two files: working grid, heights, grey, outline, corridor; what ships."""

from pathlib import Path

import numpy as np
import pytest
import rasterio
from affine import Affine
from pyproj import Geod, Transformer

from aerosim.errors import InputError
from aerosim.raster import sample
from aerosim.rasterfile import RasterFile
from aerosim.world.terrain import Terrain, find_terrain, working_grid

EAST, NORTH = 740_000.0, 4_050_000.0
TAGS = {"VERTICAL_DATUM": "ellipsoidal"}


def write(path: Path, bands, pixel, east=EAST, north=NORTH, crs="EPSG:32616", transform=None, **options):
    bands = np.asarray(bands)
    count, rows, cols = bands.shape
    with rasterio.open(
        path, "w", driver="GTiff", crs=crs, count=count, height=rows, width=cols, dtype=bands.dtype,
        transform=transform or Affine(pixel, 0, east, 0, -pixel, north), **options,
    ) as file:  # fmt: skip
        file.write(bands)
        file.update_tags(**TAGS)
    return path


def plane(e, n):
    return 300.0 + 0.05 * (e - EAST) + 0.02 * (n - NORTH)


@pytest.fixture
def files(tmp_path):
    """An orthophoto of 5 x 4 km and a tilted plane of 6 x 5 km around it."""
    rng = np.random.default_rng(1)
    photo = write(tmp_path / "o.tif", rng.integers(0, 256, (3, 400, 500), dtype=np.uint8), 10.0)
    e, n = np.meshgrid(EAST - 500 + 25 * (np.arange(240) + 0.5), NORTH + 500 - 25 * (np.arange(200) + 0.5))
    return photo, write(tmp_path / "e.tif", [plane(e, n).astype(np.float32)], 25.0, EAST - 500, NORTH + 500)


@pytest.fixture
def terrain(files):
    return Terrain.open(*files, "file")


def test_heights_and_grey_at_points(terrain, files):
    e, n = np.random.default_rng(2).uniform((EAST + 20, NORTH - 3900), (EAST + 4900, NORTH - 20), (50, 2)).T
    heights = terrain.elevation().covering(e.min(), n.min(), e.max(), n.max())
    assert sample(heights, e, n) == pytest.approx(plane(e, n), abs=1e-3)
    grey = terrain.orthophoto().covering(e.min(), n.min(), e.max(), n.max())
    with rasterio.open(files[0]) as file:
        red, green, blue = file.read()[:, 120, 77].astype(float)
    at_centre = sample(grey, EAST + 775.0, NORTH - 1205.0)
    assert float(at_centre) == pytest.approx(0.299 * red + 0.587 * green + 0.114 * blue, abs=1e-3)


def test_undulation_given_is_added(files, tmp_path):
    with rasterio.open(files[1]) as file, rasterio.open(tmp_path / "silent.tif", "w", **file.profile) as silent:
        silent.write(file.read())
    terrain = Terrain.open(files[0], tmp_path / "silent.tif", 30.0)
    e, n = EAST + 1000.0, NORTH - 1000.0
    assert float(sample(terrain.elevation().covering(e, n, e, n), e, n)) == pytest.approx(
        plane(e, n) + 30.0, abs=1e-3
    )


@pytest.mark.parametrize("factor", [0.0, 0.5, 2.0])
def test_relief_is_scaled_about_the_mean_of_the_elevation_file(files, factor):
    # the plane's mean is its height in the middle of the elevation file, 2500 m east and 2000 m south
    mean = plane(EAST + 2500.0, NORTH - 2000.0)
    land = Terrain.open(*files, "file", factor)
    e, n = EAST + np.array([20.0, 2100.0, 4900.0]), NORTH - np.array([3900.0, 700.0, 30.0])
    wanted = mean + factor * (plane(e, n) - mean)
    found = land.elevation(50.0).covering(e.min(), n.min(), e.max(), n.max())
    assert sample(found, e, n) == pytest.approx(wanted, abs=0.01)
    assert land.heights(e, n) == pytest.approx(wanted, abs=0.01)
    under = land.mean_height(e[[0, 2]], n[[0, 2]], 10.0)
    assert under.high - under.low == pytest.approx(factor * abs(plane(e[2], n[2]) - plane(e[0], n[0])), rel=0.02)


def test_flat_land_is_flat_to_the_bit_and_keeps_its_holes(files, tmp_path):
    with rasterio.open(files[1]) as file:
        heights = file.read()
    heights[0, 100:110, 100:110] = -9999.0
    holed = write(tmp_path / "holed.tif", heights, 25.0, EAST - 500, NORTH + 500, nodata=-9999.0)
    flat = Terrain.open(files[0], holed, "file", 0.0).elevation().covering(EAST, NORTH - 3990, EAST + 4990, NORTH)
    known = flat.values[np.isfinite(flat.values)]
    assert np.unique(known).size == 1
    assert np.isnan(flat.values).sum() >= 100
    empty = write(tmp_path / "empty.tif", np.full_like(heights, -9999.0), 25.0, EAST, NORTH, nodata=-9999.0)
    raster = Terrain.open(files[0], empty, "file", 0.0).elevation()
    with pytest.raises(InputError, match=r"elevation .* is empty"):
        raster.covering(EAST, NORTH - 90, EAST + 90, NORTH)


def test_heights_at_points_of_a_path(terrain):
    # Straight down the slope, and one point beyond the raster.
    e, n = EAST + np.array([0.0, 700.0, 4000.0, 9000.0]), NORTH - np.array([0.0, 700.0, 3500.0, 0.0])
    found = terrain.heights(e, n)
    assert found[:3] == pytest.approx(plane(e, n)[:3], abs=1e-2)
    assert np.isnan(found[3])


def test_shortfall_says_by_how_much(terrain):
    # The outline is that of the orthophoto, the smaller one, through the centres of its outer pixels.
    west = EAST + 5.0
    found = terrain.shortfall([west + 1.0, west - 700.0, EAST + 2500.0, EAST + 5200.0], [NORTH - 2000.0] * 4)
    assert found == pytest.approx([0.0, 700.0, 0.0, 205.0], abs=1e-6)
    assert terrain.shortfall(EAST + 100.0, NORTH + 45.0) == pytest.approx([50.0])
    assert terrain.contains([EAST + 10.0, EAST + 4990.0], [NORTH - 10.0, NORTH - 3990.0])
    assert not terrain.contains([EAST + 10.0, EAST + 4998.0], [NORTH - 10.0, NORTH - 3990.0])


def test_mean_height_under_a_line_is_the_planes(terrain):
    e, n = np.array([EAST + 1000.0, EAST + 4000.0]), np.array([NORTH - 3000.0, NORTH - 1000.0])
    found = terrain.mean_height(e, n, 400.0)
    # On a plane the mean of a corridor is the height of its middle, the extremes lie at its corners.
    assert found.mean == pytest.approx(plane(e.mean(), n.mean()), abs=0.01)
    ahead = np.array([3.0, 2.0]) / np.hypot(3.0, 2.0)
    corners = [
        (x + s * 400 * ahead[1], y - s * 400 * ahead[0]) for x, y in zip(e, n, strict=True) for s in (-1, 1)
    ]
    heights = [plane(*c) for c in corners]
    assert (found.low, found.high) == pytest.approx((min(heights), max(heights)), abs=0.01)
    assert found.missing == 0.0


def test_mean_height_tells_what_is_missing(terrain):
    # Elevation ends 1000 m (less half a cell) east of the orthophoto's corner: half of this line has none.
    found = terrain.mean_height([EAST + 4487.5, EAST + 6487.5], [NORTH - 2000.0] * 2, 100.0)
    assert found.missing == pytest.approx(0.5, abs=0.02)
    with pytest.raises(InputError, match="no elevation under the line"):
        terrain.mean_height([EAST + 8000.0, EAST + 9000.0], [NORTH] * 2, 100.0)


def test_picture_is_in_colour_bounded_and_placed(terrain, files):
    picture, grey = terrain.picture(max_px=100)
    assert picture.dtype == np.uint8
    assert max(picture.shape[:2]) <= 102
    with rasterio.open(files[0]) as file:
        blocks = file.read().reshape(3, 80, 5, 100, 5).mean(axis=(2, 4))
    row, col = 40, 30
    e, n = EAST + 50.0 * (col + 0.5), NORTH - 50.0 * (row + 0.5)
    found = picture[round((n - grey.y0) / grey.dy), round((e - grey.x0) / grey.dx)]
    assert np.abs(found - blocks[:, row, col]).max() < 1.0


def test_contrast_is_that_of_means_over_row_pixels(terrain):
    facts = terrain.info(row_pixel_m=20.0)
    # Bands of even noise, 256 / sqrt(12) = 73.9 each, weighted to luma: 49.4; means of 2 x 2 pixels halve that.
    assert facts["strip_contrast_median_grey"] == pytest.approx(24.7, rel=0.02)
    # 2 columns of 2000 m by 13 rows of 300 m, and 16 by 1 the other way.
    assert facts["strips"] == 2 * 13 + 16 * 1
    assert facts["height_min_m"] == pytest.approx(plane(EAST + 5.0, NORTH - 3995.0), abs=1.5)
    assert facts["elevation_missing_pct"] == 0.0


@pytest.mark.parametrize(
    ("crs", "at", "expected"),
    [
        ("EPSG:4326", (-84.25, 36.5), 32616),
        ("EPSG:4326", (24.4, -33.7), 32735),
        ("EPSG:4326", (179.99, -17.0), 32760),
        ("EPSG:3857", (-84.25, 36.5), 32616),
        ("EPSG:2225", (-122.0, 40.5), 32610),
        ("EPSG:32617", (-84.25, 36.5), 32617),
        ("EPSG:2154", (3.0, 46.0), 2154),
    ],
)
def test_working_grid(tmp_path, crs, at, expected):
    x, y = Transformer.from_crs("EPSG:4326", crs, always_xy=True).transform(*at)
    size = 1e-5 if crs == "EPSG:4326" else 1.0
    path = write(tmp_path / "o.tif", np.zeros((1, 8, 8), np.uint8), size, x, y, crs)
    assert working_grid(RasterFile(path)).crs.to_epsg() == expected


def test_sixteen_bits_become_grey_levels(files, tmp_path):
    values = np.random.default_rng(3).integers(100, 2001, (1, 300, 300), dtype=np.uint16)
    photo = write(tmp_path / "16.tif", values, 10.0)
    grey = Terrain.open(photo, files[1], "file").orthophoto().covering(EAST, NORTH - 3000, EAST + 3000, NORTH)
    known = grey.values[np.isfinite(grey.values)]
    # White is the 99.9th percentile of even numbers from 100 to 2000: 1998 becomes 255.
    assert known.max() == pytest.approx(255.0 * 2000 / 1998.1, rel=2e-3)
    assert known.min() == pytest.approx(255.0 * 100 / 1998.1, rel=2e-3)


def test_files_that_do_not_overlap(files, tmp_path):
    far = write(tmp_path / "far.tif", np.full((1, 40, 40), 5, np.float32), 25.0, EAST + 90_000)
    with pytest.raises(InputError, match="do not overlap"):
        Terrain.open(files[0], far, "file")


def test_empty_orthophoto_of_sixteen_bits(files, tmp_path):
    photo = write(tmp_path / "black.tif", np.zeros((1, 40, 40), np.uint16), 25.0)
    with pytest.raises(InputError, match="empty or black"):
        Terrain.open(photo, files[1], "file")


def test_unknown_terrain_names_the_nearest():
    with pytest.raises(InputError, match="did you mean pine_mountain"):
        find_terrain("pine_mountian")
    with pytest.raises(InputError, match="shipped: pine_mountain"):
        find_terrain("matterhorn")
    with pytest.raises(InputError, match="no terrain"):
        find_terrain("../scenarios")


@pytest.fixture(scope="module")
def shipped():
    return Terrain.open(*find_terrain("pine_mountain"), "file")


class TestShipped:
    """What data and lines need of the terrain that ships."""

    LINES = (((36.52, -84.38), (36.52, -84.12)), ((36.54, -84.12), (36.54, -84.38)))

    def test_size_on_disk(self):
        assert sum(p.stat().st_size for p in find_terrain("pine_mountain")) < 12e6

    def test_lines_of_23_km_with_their_swath_lie_inside(self, shipped):
        geod = Geod(ellps="WGS84")
        for (lat1, lon1), (lat2, lon2) in self.LINES:
            azimuth, _, length = geod.inv(lon1, lat1, lon2, lat2)
            assert length > 23_000.0
            # 2.3 km around both ends: the photos' half footprint.
            for lon, lat in ((lon1, lat1), (lon2, lat2)):
                for turn in (0.0, 90.0, 180.0, 270.0):
                    x, y, _ = geod.fwd(lon, lat, azimuth + turn, 2300.0)
                    assert shipped.contains(*shipped.grid.from_geodetic(np.radians(y), np.radians(x)))

    def test_relief_is_srtm_on_the_ellipsoid(self, shipped):
        from matplotlib.cbook import get_sample_data

        with np.load(str(get_sample_data("jacksboro_fault_dem.npz", asfileobj=False))) as data:
            heights, north, west = data["elevation"].astype(float), float(data["ymin"]), float(data["xmin"])
        row, col = (a.ravel() for a in np.meshgrid(np.arange(190, 300, 7), np.arange(30, 370, 9), indexing="ij"))
        lat, lon = north - (row + 0.5) / 1200.0, west + (col + 0.5) / 1200.0
        e, n = shipped.grid.from_geodetic(np.radians(lat), np.radians(lon))
        window = shipped.elevation().covering(e.min(), n.min(), e.max(), n.max())
        off = sample(window, e, n) - heights[row, col]
        # EGM96 has -30.34 to -31.04 m over this land; what is left is cubic against bilinear within 25 m.
        assert np.median(off) == pytest.approx(-30.7, abs=0.3)
        assert off.std() < 0.5

    def test_rows_see_contrast_everywhere(self, shipped):
        facts = shipped.info()
        assert facts["elevation_missing_pct"] == 0.0
        assert facts["strip_contrast_p05_grey"] > 10.0
        assert facts["strip_contrast_min_grey"] > 8.0
        assert facts["vertical_datum"] == "ellipsoidal"
        assert facts["orthophoto_pixel_m"] == 5.0

    def test_texture_has_no_lattice(self, shipped):
        # A recogniser would lock onto a repetition: no second peak of the autocorrelation within 2 km.
        e, n = shipped.grid.from_geodetic(np.radians(36.53), np.radians(-84.15))
        window = shipped.orthophoto(20.0).covering(
            float(e) - 4000, float(n) - 4000, float(e) + 4000, float(n) + 4000
        )
        row, col = (
            round((float(n) + 4000 - window.y0) / window.dy),
            round((float(e) - 4000 - window.x0) / window.dx),
        )
        patch = window.values[row : row + 400, col : col + 400].astype(float)
        patch -= patch.mean()
        power = np.abs(np.fft.fft2(patch)) ** 2
        correlation = np.fft.fftshift(np.fft.ifft2(power).real) / power.mean()
        away = np.hypot(*np.mgrid[-200:200, -200:200]) * 20.0
        assert correlation[(away > 300.0) & (away < 2000.0)].max() < 0.3


def test_an_orthophoto_is_no_elevation() -> None:
    orthophoto, elevation = find_terrain("pine_mountain")
    with pytest.raises(InputError, match=r"3 bands.*swapped"):
        Terrain.open(elevation, orthophoto, "ellipsoidal")
