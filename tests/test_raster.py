"""Rasters: reading in windows, values between cells, rays that meet the ground, bad files."""

import time
from pathlib import Path

import numpy as np
import psutil
import pytest
import rasterio
from affine import Affine
from pyproj import CRS, Transformer
from scipy import ndimage

from aerosim import frames
from aerosim.errors import InputError, RunFailure
from aerosim.raster import EARTH_RADIUS, Window, WindowedRaster, intersect, sample
from aerosim.rasterfile import MAX_CHECKED_BLOCKS, RasterFile

UTM = CRS("EPSG:32616")
EAST, NORTH = 740_000.0, 4_050_000.0
GREY = {1: 1.0}


def write(path: Path, values, transform=None, crs="EPSG:32616", tags=None, overviews=(), **options):
    """A GeoTIFF of (rows, cols) or (bands, rows, cols), 10 m cells with the corner at EAST, NORTH by default."""
    bands = np.atleast_3d(values) if np.ndim(values) == 3 else np.asarray(values)[None]
    transform = transform or Affine(10.0, 0.0, EAST, 0.0, -10.0, NORTH)
    count, rows, cols = bands.shape
    with rasterio.open(
        path, "w", driver="GTiff", crs=crs, transform=transform, count=count, height=rows, width=cols,
        dtype=bands.dtype, **options,
    ) as file:  # fmt: skip
        file.write(bands)
        file.update_tags(**(tags or {}))
        if overviews:
            file.build_overviews(overviews, rasterio.enums.Resampling.average)
    return path


def texture(rows=300, cols=400, seed=1):
    noise = np.random.default_rng(seed).standard_normal((rows, cols))
    return (200.0 * ndimage.gaussian_filter(noise, 3.0) + 100.0).astype(np.float32)


@pytest.fixture
def file(tmp_path):
    return RasterFile(write(tmp_path / "a.tif", texture()))


class TestSample:
    def test_is_scipys_bilinear(self):
        values = texture(40, 50)
        window = Window.of(values, 1000.0, 9000.0, 5.0, -4.0)
        e, n = np.random.default_rng(2).uniform((1000, 9000 - 39 * 4), (1000 + 49 * 5, 9000), (500, 2)).T
        place = [(9000.0 - n) / 4.0, (e - 1000.0) / 5.0]
        expected = ndimage.map_coordinates(values.astype(float), place, order=1)
        # float32 cells of about 100 differ from float64 sums by their rounding, 1e-5.
        assert sample(window, e, n) == pytest.approx(expected, abs=1e-4)

    def test_reaches_the_outermost_centres_and_no_further(self):
        window = Window.of(texture(4, 5), 0.0, 0.0, 1.0, -1.0)
        at_corner = sample(window, [0.0, 4.0, 0.0, 4.0], [0.0, 0.0, -3.0, -3.0])
        assert at_corner == pytest.approx(window.values[[0, 0, -1, -1], [0, -1, 0, -1]])
        beyond = sample(window, [-0.01, 4.01, 2.0, 2.0], [-1.0, -1.0, 0.01, -3.01])
        assert np.isnan(beyond).all()
        assert window.bounds == (0.0, -3.0, 4.0, 0.0)

    def test_missing_cells_spoil_their_surroundings_only(self):
        values = np.ones((5, 5), np.float32)
        values[2, 2] = np.nan
        found = sample(Window.of(values, 0.0, 0.0, 1.0, -1.0), [1.5, 3.5, 0.5], [-1.5, -3.5, -0.5])
        assert np.isnan(found).tolist() == [True, False, False]

    def test_keeps_the_shape(self):
        window = Window.of(texture(9, 9), 0.0, 0.0, 1.0, -1.0)
        assert sample(window, np.full((2, 3), 4.0), -2.0).shape == (2, 3)


class TestIntersect:
    def flat(self, height=500.0, half=300):
        values = np.full((2 * half, 2 * half), height, np.float32)
        return Window.of(values, -half * 25.0, half * 25.0, 25.0, -25.0)

    def test_level_ground_is_a_sphere_in_closed_form(self):
        tangent = np.array([0.0, 0.2, 0.5, 1.0, 1.7])
        rays = np.column_stack([0.6 * tangent, 0.8 * tangent, -np.ones(5)]) * 3.0
        found = intersect(self.flat(), (0.0, 0.0, 3500.0), rays)
        # The line and the sphere of the ground: t from the quadratic, the arc on the ellipsoid from the angle.
        high, low = EARTH_RADIUS + 3500.0, EARTH_RADIUS + 500.0
        up = -1.0 / np.hypot(1.0, tangent)
        # Differences of squares of 6e6 m keep 1e-3 m only; as products they keep all.
        c = (high - low) * (high + low)
        t = c / (-high * up + np.sqrt((high * up) ** 2 - c))
        arc = EARTH_RADIUS * np.arctan2(t * np.sqrt(1.0 - up**2), high + t * up)
        # The kernel's series leaves out terms of the fourth order in distance over radius: 1e-3 m at 5 km.
        assert np.hypot(found[:, 0], found[:, 1]) == pytest.approx(arc, abs=2e-3)
        assert found[:, 2] == pytest.approx(500.0, abs=1e-4)
        assert found[1:, 0] / found[1:, 1] == pytest.approx(0.75)

    def test_is_right_to_centimetres_on_the_ellipsoid_in_a_real_grid(self):
        grid = frames.MapGrid(UTM)
        lat, lon = np.radians([36.53, -84.25])
        e_north, e_east, n_north, n_east = grid.local(lat, lon)(lat, lon)[2:]
        e0, n0 = (float(v) for v in grid.from_geodetic(lat, lon))
        flat = self.flat()._replace(x0=e0 - 7500.0, y0=n0 + 7500.0)
        rays = np.array(
            [[0.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 1.0, -1.0], [-0.7, 0.7, -1.0], [0.6, -0.8, -1.0]]
        )
        found = intersect(flat, (e0, n0, 3500.0), rays, [[e_east, e_north], [n_east, n_north]])
        mat_en = frames.mat_ne(lat, lon).T
        start = frames.ecef_from_geodetic(lat, lon, 3500.0)
        for ray, point in zip(rays, found, strict=True):
            ray_e = mat_en @ (ray[[1, 0, 2]] * [1.0, 1.0, -1.0]) / np.linalg.norm(ray)
            short, long = 0.0, 9000.0
            for _ in range(60):
                t = (short + long) / 2.0
                at = frames.geodetic_from_ecef(start + t * ray_e)
                short, long = (t, long) if at[2] > 500.0 else (short, t)
            e, n = grid.from_geodetic(at[0], at[1])
            # 3 km off: the grid's scale and the bend of its straight lines change by 2.5 cm each.
            assert np.hypot(point[0] - e, point[1] - n) < 0.05

    def test_finds_what_a_brute_search_finds_first(self):
        rng = np.random.default_rng(3)
        relief = 400.0 * ndimage.gaussian_filter(rng.standard_normal((240, 240)), 4.0) / 0.07 * 0.2
        window = Window.of(relief, 0.0, 0.0, 25.0, -25.0)
        origin = np.array([3000.0, -3000.0, 900.0])
        rays = rng.uniform((-1, -1, -0.8), (1, 1, -0.15), (120, 3))
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        found = intersect(window, origin, rays)
        steps = np.arange(0.0, 5000.0, 0.5)
        hits = 0
        for ray, point in zip(rays, found, strict=True):
            level = steps * np.hypot(*ray[:2])
            height = origin[2] + steps * ray[2] + level**2 / (2.0 * EARTH_RADIUS)
            e, n = origin[0] + steps * ray[0], origin[1] + steps * ray[1]
            ground = ndimage.map_coordinates(
                window.values.astype(float), [n / -25.0, e / 25.0], order=1, cval=np.nan
            )
            below = np.flatnonzero(height <= ground)
            if np.isnan(point).any():
                assert not len(below) or np.isnan(ground[: below[0]]).any()
                continue
            hits += 1
            # Half a metre of search, and 0.4 m by which the map is smaller than ground 900 m up at 3 km.
            assert np.linalg.norm(point - (e[below[0]], n[below[0]], height[below[0]])) < 1.0
            assert point[2] == pytest.approx(sample(window, point[0], point[1]), abs=1e-4)
        assert hits > 80

    def test_a_wall_hides_the_ground_behind(self):
        values = np.zeros((200, 200), np.float32)
        values[:, 120] = 300.0
        window = Window.of(values, 0.0, 0.0, 10.0, -10.0)
        point = intersect(window, (1000.0, -1000.0, 200.0), [1.0, 0.0, -0.2])[0]
        # The wall's near side rises from 1190 m to 300 m at 1200 m; the ray comes with 162 m.
        assert point[0] == pytest.approx(1195.4, abs=0.1)

    def test_directions_are_turned_into_the_grid(self):
        window = Window.of(texture(200, 200, seed=5), 0.0, 0.0, 25.0, -25.0)
        turn = np.array([[np.cos(0.4), -np.sin(0.4)], [np.sin(0.4), np.cos(0.4)]])
        rays = np.random.default_rng(6).uniform((-1, -1, -1), (1, 1, -0.3), (50, 3))
        turned = np.column_stack([rays[:, :2] @ turn.T, rays[:, 2]])
        origin = (2500.0, -2500.0, 1500.0)
        assert intersect(window, origin, rays, turn) == pytest.approx(
            intersect(window, origin, turned), abs=1e-3, nan_ok=True
        )

    def test_ground_that_was_entered_unseen_is_missing(self):
        values = np.zeros((100, 200), np.float32)
        values[:, 50:80] = 500.0
        rays = [[1.0, 0.0, -0.05]]
        inside = Window.of(values, 0.0, 0.0, 10.0, -10.0)
        assert np.isnan(intersect(inside, (600.0, -500.0, 60.0), rays)).all()
        # A metre under its falling flank, where one step leads into the open.
        assert np.isnan(intersect(inside, (796.0, -500.0, 199.0), rays)).all()
        # The near side of the block is unknown: the ray is under ground where ground is known again.
        values[:, 40:60] = np.nan
        assert np.isnan(intersect(Window.of(values, 0.0, 0.0, 10.0, -10.0), (100.0, -500.0, 80.0), rays)).all()
        # Across a hole in flat ground the ray is above ground at both sides, and goes on.
        values[:, 60:] = 0.0
        beyond = intersect(Window.of(values, 0.0, 0.0, 10.0, -10.0), (100.0, -500.0, 60.0), rays)
        assert beyond[0, 0] == pytest.approx(100.0 + 60.0 / 0.05, abs=3.0)

    def test_missing_values(self):
        values = np.zeros((100, 100), np.float32)
        values[40:60, 70:80] = np.nan
        window = Window.of(values, 0.0, 0.0, 10.0, -10.0)
        rays = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [2.6, 0.0, -1.0], [9.0, 0.0, -1.0], [0.0, 0.0, -1.0]]
        found = intersect(window, (500.0, -500.0, 100.0), rays)
        assert np.isnan(found).all(axis=1).tolist() == [True, True, True, True, False]
        assert np.isnan(intersect(window, (500.0, -500.0, -1.0), rays)).all()


class TestCovering:
    def test_cells_are_the_files(self, file):
        window = WindowedRaster(file, UTM, 10.0).covering(EAST + 500, NORTH - 900, EAST + 900, NORTH - 500)
        assert (window.dx, window.dy) == (10.0, -10.0)
        centre = sample(window, EAST + 10 * 77 + 5.0, NORTH - 10 * 61 - 5.0)
        assert float(centre) == pytest.approx(float(texture()[61, 77]))

    def test_cells_are_means_of_blocks(self, file):
        window = WindowedRaster(file, UTM, 45.0).covering(EAST + 500, NORTH - 900, EAST + 900, NORTH - 500)
        blocks = texture()[:300, :400].reshape(75, 4, 100, 4).mean(axis=(1, 3))
        assert window.dx == 40.0
        row, col = 20, 15
        value = sample(window, EAST + 40 * (col + 0.5), NORTH - 40 * (row + 0.5))
        assert float(value) == pytest.approx(blocks[row, col], abs=1e-3)

    def test_outside_is_missing(self, file):
        window = WindowedRaster(file, UTM, 10.0).covering(EAST - 500, NORTH - 900, EAST + 900, NORTH + 500)
        assert np.isnan(sample(window, EAST - 100.0, NORTH - 100.0))
        assert np.isfinite(sample(window, EAST + 5.0, NORTH - 5.0))
        assert np.isnan(sample(window, EAST + 5.0, NORTH - 4.9))

    def test_reads_only_when_the_area_leaves_the_window(self, file, monkeypatch):
        reads = []
        read = RasterFile.read
        monkeypatch.setattr(RasterFile, "read", lambda self, *a: reads.append(a) or read(self, *a))
        raster = WindowedRaster(file, UTM, 10.0, size=64)
        seen = {}
        for e in np.arange(EAST + 100.0, EAST + 3500.0, 20.0):
            window = raster.covering(e, NORTH - 1000.0, e + 100.0, NORTH - 900.0)
            assert window.values.size < 70 * 70
            seen[e] = float(sample(window, e + 50.0, NORTH - 950.0))
        # A window is 640 m and re-centred on an area of 100 m: a new one every 270 m at the earliest.
        assert len(reads) <= 3400 / 270 + 1
        whole = WindowedRaster(file, UTM, 10.0).covering(EAST, NORTH - 3000.0, EAST + 4000.0, NORTH)
        assert list(seen.values()) == [float(sample(whole, e + 50.0, NORTH - 950.0)) for e in seen]

    def test_refuses_an_area_too_large_to_hold(self, file):
        with pytest.raises(InputError, match="too large to be read at once"):
            WindowedRaster(file, UTM, 10.0, size=64).covering(EAST, NORTH - 3000.0, EAST + 4000.0, NORTH)
        with pytest.raises(RunFailure, match="not a number"):
            WindowedRaster(file, UTM, 10.0).covering(np.nan, NORTH, EAST, NORTH)

    def test_is_cheap_when_nothing_changes(self, file):
        raster = WindowedRaster(file, UTM, 10.0)
        area = (EAST + 500.0, NORTH - 900.0, EAST + 900.0, NORTH - 500.0)
        assert raster.covering(*area) is raster.covering(*area)

    def test_a_file_that_breaks_during_the_run_ends_the_run(self, tmp_path):
        path = write(tmp_path / "a.tif", texture(2000, 400), tiled=True, compress="deflate")
        raster = WindowedRaster(RasterFile(path), UTM, 10.0, size=64)
        path.write_bytes(path.read_bytes()[:200_000])
        with pytest.raises(RunFailure, match="damaged or truncated"):
            raster.covering(EAST + 100, NORTH - 19_000, EAST + 200, NORTH - 18_900)


class TestOtherGrids:
    def plane(self, e, n):
        return 100.0 + 0.02 * (e - EAST) - 0.03 * (n - NORTH)

    def check(self, path, tolerance, resolution=10.0):
        file = RasterFile(path)
        e, n = (
            np.random.default_rng(4).uniform((EAST + 800, NORTH - 2000), (EAST + 1800, NORTH - 1000), (200, 2)).T
        )
        window = WindowedRaster(file, UTM, resolution).covering(e.min(), n.min(), e.max(), n.max())
        assert sample(window, e, n) == pytest.approx(self.plane(e, n), abs=tolerance)
        return file

    def test_geographic_raster(self, tmp_path):
        to_map = Transformer.from_crs("EPSG:4326", UTM, always_xy=True)
        lon0, lat0 = to_map.transform(EAST - 500.0, NORTH + 500.0, direction="INVERSE")
        step = 1e-4
        lon, lat = np.meshgrid(lon0 + (np.arange(400) + 0.5) * step, lat0 - (np.arange(400) + 0.5) * step)
        values = self.plane(*to_map.transform(lon, lat)).astype(np.float32)
        path = write(tmp_path / "g.tif", values, Affine(step, 0, lon0, 0, -step, lat0), "EPSG:4326")
        # GDAL's approximate transformer is allowed an eighth of a pixel, 1.2 m on a slope of 0.036.
        file = self.check(path, 0.05)
        assert file.native_resolution(UTM) == pytest.approx(np.sqrt(8.95 * 11.1), rel=0.01)

    def test_rotated_raster(self, tmp_path):
        c, s = 10.0 * np.cos(0.35), 10.0 * np.sin(0.35)
        turn = Affine(c, -s, EAST - 500, -s, -c, NORTH + 200)
        cols, rows = np.meshgrid(np.arange(500) + 0.5, np.arange(500) + 0.5)
        e, n = turn.a * cols + turn.b * rows + turn.c, turn.d * cols + turn.e * rows + turn.f
        path = write(tmp_path / "r.tif", self.plane(e, n).astype(np.float32), turn)
        self.check(path, 0.05)

    def test_rows_from_the_south(self, tmp_path):
        e, n = np.meshgrid(EAST + 10 * (np.arange(400) + 0.5), NORTH - 4000 + 10 * (np.arange(400) + 0.5))
        up = Affine(10.0, 0.0, EAST, 0.0, 10.0, NORTH - 4000.0)
        self.check(write(tmp_path / "s.tif", self.plane(e, n).astype(np.float32), up), 0.05)

    @pytest.mark.parametrize("kind", ["uint8", "int16", "float32", "nodata", "alpha"])
    def test_outside_of_a_warped_raster_is_missing(self, tmp_path, kind):
        values = np.full((400, 400), 90, "uint8" if kind in ("nodata", "alpha") else kind)
        options = {"nodata": 0} if kind == "nodata" else {}
        if kind == "alpha":
            values, options = np.stack([values, np.full_like(values, 255)]), {"alpha": "yes"}
            values[1, :, 200:] = 0
        file = RasterFile(write(tmp_path / "w.tif", values, **options))
        other = CRS("EPSG:32617")
        e, n = Transformer.from_crs(UTM, other, always_xy=True).transform(EAST + 2000.0, NORTH - 2000.0)
        for resolution in (10.0, 60.0):
            cells = file.read(other, (e - 3000, n - 3000, e + 3000, n + 3000), resolution, GREY)
            known = np.isfinite(cells.values)
            # 4000 x 4000 m of raster in cells of the other grid; its scale differs by less than 1 %.
            assert known.sum() * cells.dx**2 == pytest.approx(8e6 if kind == "alpha" else 16e6, rel=0.06)
            assert (cells.values[known] == 90.0).all()

    def test_vrt(self, tmp_path):
        e, n = np.meshgrid(EAST + 10 * (np.arange(400) + 0.5), NORTH - 10 * (np.arange(400) + 0.5))
        write(tmp_path / "v.tif", self.plane(e, n).astype(np.float32))
        (tmp_path / "v.vrt").write_text(
            '<VRTDataset rasterXSize="400" rasterYSize="400"><SRS>EPSG:32616</SRS>'
            f"<GeoTransform>{EAST}, 10, 0, {NORTH}, 0, -10</GeoTransform>"
            '<VRTRasterBand dataType="Float32" band="1"><SimpleSource>'
            '<SourceFilename relativeToVRT="1">v.tif</SourceFilename><SourceBand>1</SourceBand>'
            "</SimpleSource></VRTRasterBand></VRTDataset>"
        )
        self.check(tmp_path / "v.vrt", 1e-3)


class TestValues:
    def values_of(self, path, weights=None):
        file = RasterFile(path)
        area = (EAST + 5.0, NORTH - 35.0, EAST + 35.0, NORTH - 5.0)
        return file.read(UTM, area, 10.0, weights or file.colour_weights()).values

    def test_nodata_is_missing(self, tmp_path):
        values = np.full((4, 4), 7, np.int16)
        values[1, 2] = -32768
        found = self.values_of(write(tmp_path / "n.tif", values, nodata=-32768))
        assert np.argwhere(np.isnan(found)).tolist() == [[1, 2]]
        assert found[0, 0] == 7.0

    def test_nodata_is_left_out_of_means_and_of_warps(self, tmp_path):
        values = np.full((400, 400), 7.0, np.float32)
        values[:, 100:] = -9999.0
        file = RasterFile(write(tmp_path / "n.tif", values, nodata=-9999.0))
        for crs in (UTM, CRS("EPSG:32617")):
            e, n = Transformer.from_crs(UTM, crs, always_xy=True).transform(EAST + 1000.0, NORTH - 2000.0)
            found = file.read(crs, (e - 200, n - 200, e + 200, n + 200), 40.0, GREY).values
            assert np.nanmin(found) == np.nanmax(found) == 7.0
            assert 0.3 < np.isnan(found).mean() < 0.7

    def test_alpha_is_a_mask(self, tmp_path):
        bands = np.full((4, 4, 4), 90, np.uint8)
        bands[3] = 255
        bands[3, 0, 0] = 0
        path = write(tmp_path / "a.tif", bands, photometric="RGB", alpha="yes")
        found = self.values_of(path)
        assert np.isnan(found[0, 0])
        assert found[1, 1] == pytest.approx(90.0)

    def test_grey_is_luma(self, tmp_path):
        bands = np.zeros((3, 4, 4), np.uint8)
        bands[:, 0, 0] = (200, 100, 50)
        assert self.values_of(write(tmp_path / "c.tif", bands))[0, 0] == pytest.approx(124.2, abs=0.05)

    def test_scale_and_offset_of_a_band(self, tmp_path):
        path = write(tmp_path / "o.tif", np.full((4, 4), 1000, np.uint16))
        with rasterio.open(path, "r+") as data:
            data.scales, data.offsets = (0.1,), (-20.0,)
        assert self.values_of(path)[0, 0] == pytest.approx(80.0)

    def test_feet_become_metres(self, tmp_path):
        path = write(tmp_path / "f.tif", np.full((4, 4), 1000.0, np.float32), crs="EPSG:26916+6360")
        assert np.nanmean(self.values_of(path)) == pytest.approx(1000.0 * 1200.0 / 3937.0, rel=1e-6)


class TestBadFiles:
    def refused(self, path, match):
        with pytest.raises(InputError, match=match) as caught:
            RasterFile(path)
        assert "\n" not in str(caught.value)

    def test_no_file(self, tmp_path):
        self.refused(tmp_path / "none.tif", "does not exist")
        self.refused(tmp_path, "does not exist")

    @pytest.mark.parametrize("content", [b"", b"name: x\n", b"II*\x00\x08\x00\x00\x00", bytes(range(256)) * 9])
    def test_no_raster(self, tmp_path, content):
        (tmp_path / "t.tif").write_bytes(content)
        self.refused(tmp_path / "t.tif", "cannot be read as a raster")

    @pytest.mark.parametrize("part", [0.3, 0.6, 0.99])
    @pytest.mark.parametrize("kind", ["tiles", "strips", "overviews"])
    def test_truncated(self, tmp_path, part, kind):
        options = {"tiled": True, "blockxsize": 64, "blockysize": 64} if kind != "strips" else {}
        overviews = (2, 4) if kind == "overviews" else ()
        path = write(tmp_path / "t.tif", texture(), compress="deflate", overviews=overviews, **options)
        assert RasterFile(path).width == 400
        content = path.read_bytes()
        path.write_bytes(content[: int(part * len(content))])
        self.refused(path, "truncated|cannot be read as a raster")

    def test_no_crs(self, tmp_path):
        self.refused(write(tmp_path / "c.tif", texture(), crs=None), "has no CRS")

    @pytest.mark.filterwarnings("ignore::rasterio.errors.NotGeoreferencedWarning")
    def test_no_georeference(self, tmp_path):
        self.refused(
            write(tmp_path / "c.tif", texture(), transform=Affine.identity()), "no position or pixel size"
        )

    def test_neither_map_nor_globe(self, tmp_path):
        local = 'LOCAL_CS["site",UNIT["metre",1]]'
        self.refused(write(tmp_path / "c.tif", texture(), crs=local), "neither|no CRS|not understood")

    def test_palette_and_complex(self, tmp_path):
        path = write(tmp_path / "p.tif", np.zeros((8, 8), np.uint8), photometric="palette")
        self.refused(path, "palette")
        self.refused(write(tmp_path / "z.tif", np.zeros((8, 8), np.complex64)), "complex")


def test_twelve_gigabytes_are_opened_and_read_in_little_memory_and_time(tmp_path):
    side, pixel = 110_000, 0.5
    path = tmp_path / "huge.tif"
    with rasterio.open(
        path, "w", driver="GTiff", crs="EPSG:32616", transform=Affine(pixel, 0, EAST, 0, -pixel, NORTH), count=1,
        width=side, height=side, dtype="uint8", tiled=True, blockxsize=512, blockysize=512, SPARSE_OK=True,
        BIGTIFF="YES",
    ) as data:  # fmt: skip
        data.write(np.full((2048, 2048), 77, np.uint8), 1, window=((51200, 53248), (51200, 53248)))
    assert (side / 512) ** 2 > MAX_CHECKED_BLOCKS
    before, start = psutil.Process().memory_info().rss, time.perf_counter()
    raster = WindowedRaster(RasterFile(path), UTM, 10.0)
    e, n = EAST + 52_224 * pixel, NORTH - 52_224 * pixel
    window = raster.covering(e - 400, n - 400, e + 400, n + 400)
    assert float(sample(window, e, n)) == 77.0
    assert window.values.size <= 2060**2
    # Window, block cache (64 MB) and what GDAL holds of one read; the file would be 12 GB.
    assert psutil.Process().memory_info().rss - before < 300e6
    assert time.perf_counter() - start < 30.0
