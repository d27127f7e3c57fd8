"""Vertical datum: against the EGM96 grid, and refused where there is no grid."""

from pathlib import Path

import numpy as np
import pyproj
import pytest
import rasterio
from affine import Affine

from aerosim import datum
from aerosim.errors import InputError
from aerosim.frames import MapGrid
from aerosim.raster import Window
from aerosim.rasterfile import RasterFile
from aerosim.world.terrain import Terrain

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="the folder of real data is absent")
REAL = (DATA / "real_terrain/orthophoto_5m.tif", DATA / "real_terrain/elevation_24m_egm2008.tif")


@pytest.fixture
def no_grids(monkeypatch, tmp_path):
    """PROJ as a wheel brings it, whatever this machine has installed."""
    before = pyproj.datadir.get_data_dir()
    inside = Path(pyproj.__file__).parent / "proj_dir" / "share" / "proj"
    pyproj.datadir.set_data_dir(str(inside) if inside.is_dir() else before)
    yield
    pyproj.datadir.set_data_dir(before)


@pytest.fixture
def egm96(no_grids):
    """The same with the EGM96 grid beside it."""
    pyproj.datadir.append_data_dir(str(DATA))


def elevation(path, crs, tags=None, value=300.0):
    values = np.full((1, 40, 40), value, np.float32)
    with rasterio.open(
        path, "w", driver="GTiff", crs=crs, transform=Affine(25.0, 0, 740_000, 0, -25.0, 4_050_000), count=1,
        width=40, height=40, dtype="float32",
    ) as file:  # fmt: skip
        file.write(values)
        file.update_tags(**(tags or {}))
    return RasterFile(path)


@needs_data
@pytest.mark.parametrize(("lat", "lon", "height"), [(33.980849, 107.523239, -35.183), (51.0, 13.0, 44.492)])
def test_egm96_undulation(egm96, lat, lon, height):
    found = datum.geoid("EPSG:5773").undulation(np.radians([lat]), np.radians([lon]))
    assert found[0] == pytest.approx(height, abs=1e-3)


@needs_data
def test_real_terrain_is_refused_without_its_grid(egm96):
    for spec in ("file", "egm2008"):
        with pytest.raises(InputError) as caught:
            Terrain.open(*REAL, spec)
        line = str(caught.value)
        assert "EGM2008" in line
        assert "us_nga_egm08_25.tif" in line
        assert "undulation_m" in line
        assert "PROJ_DATA" in line
        assert "egm96" in line
        assert "\n" not in line
    with pytest.raises(InputError, match="says that its heights are 'EGM2008 height'"):
        Terrain.open(*REAL, "ellipsoidal")


@needs_data
@pytest.mark.parametrize(("spec", "tolerance"), [("egm96", 0.15), (28.26, 1e-4)])
def test_real_terrain_rises_by_the_undulation(egm96, spec, tolerance):
    terrain = Terrain.open(*REAL, spec)
    centre = (np.array(terrain.bounds[:2]) + terrain.bounds[2:]) / 2.0
    area = (*(centre - 300.0), *(centre + 300.0))
    window = terrain.elevation().covering(*area)
    with rasterio.open(REAL[1]) as file:
        row, col = file.index(*centre)
        x, y = file.xy(row, col)
        raw = float(file.read(1)[row, col])
    ours = window.values[round((y - window.y0) / window.dy), round((x - window.x0) / window.dx)]
    # 28.26 m in the middle of the folder's note; EGM96 itself leans by 0.1 m over these 10 km.
    assert ours - raw == pytest.approx(28.26, abs=tolerance)


@needs_data
def test_undulation_over_a_window_is_the_transformers_everywhere(egm96):
    grid = MapGrid("EPSG:32616")
    window = Window.of(np.zeros((700, 1001), np.float32), 740_000.0, 4_050_000.0, 25.0, -25.0)
    vertical = datum.geoid("EPSG:5773")
    found = vertical.to_ellipsoid(window, grid)
    rng = np.random.default_rng(1)
    row, col = np.r_[0, 699, 0, rng.integers(0, 700, 200)], np.r_[0, 1000, 1000, rng.integers(0, 1001, 200)]
    lat, lon = grid.to_geodetic(740_000.0 + 25.0 * col, 4_050_000.0 - 25.0 * row)
    # The geoid's 15-minute grid has a kink at each of its posts, cut over less than 1 km: millimetres.
    assert found[row, col] == pytest.approx(vertical.undulation(lat, lon), abs=0.005)
    assert np.ptp(found) > 0.2


def test_without_a_grid_nothing_is_guessed(no_grids):
    for vertical in ("EPSG:5773", "EPSG:3855", "EPSG:5703"):
        with pytest.raises(InputError, match="no grid here") as caught:
            datum.geoid(vertical)
        assert caught.value.key == "terrain.vertical_datum"


def test_network_stays_off(no_grids):
    assert not pyproj.network.is_network_enabled()


class TestResolve:
    def test_file_says_ellipsoidal_by_tag(self, tmp_path):
        file = elevation(tmp_path / "e.tif", "EPSG:32616", {"VERTICAL_DATUM": "ellipsoidal"})
        assert datum.resolve("file", file).undulation(0.6, -1.4) == 0.0
        assert datum.resolve("ellipsoidal", file).undulation(0.6, -1.4) == 0.0
        assert datum.resolve(0.0, file).constant == 0.0
        for spec in ("egm96", 40.0, -31.5):
            with pytest.raises(InputError, match="says that its heights are ellipsoidal"):
                datum.resolve(spec, file)

    def test_file_says_ellipsoidal_by_three_dimensions(self, tmp_path):
        crs = pyproj.CRS("EPSG:32616").to_3d().to_wkt()
        file = elevation(tmp_path / "e.tif", rasterio.crs.CRS.from_wkt(crs))
        assert file.vertical == "ellipsoidal"
        assert datum.resolve("file", file).constant == 0.0

    def test_file_does_not_say(self, tmp_path):
        file = elevation(tmp_path / "e.tif", "EPSG:32616")
        with pytest.raises(InputError, match="does not say what its heights refer to") as caught:
            datum.resolve("file", file)
        assert "ellipsoidal, egm96, egm2008" in caught.value.allowed
        assert datum.resolve("ellipsoidal", file).constant == 0.0
        assert datum.resolve(-31.5, file).constant == -31.5

    def test_file_says_a_geoid(self, tmp_path, no_grids):
        file = elevation(tmp_path / "e.tif", "EPSG:32616+5773")
        with pytest.raises(InputError, match="'EGM96 height' and PROJ has no grid"):
            datum.resolve("file", file)
        with pytest.raises(InputError, match="says that its heights are 'EGM96 height'"):
            datum.resolve("ellipsoidal", file)
        tagged = elevation(tmp_path / "t.tif", "EPSG:32616", {"VERTICAL_DATUM": "EGM2008"})
        with pytest.raises(InputError, match="'EGM2008 height' and PROJ has no grid"):
            datum.resolve("file", tagged)

    @pytest.mark.parametrize("spec", ["geoid", 500.0, float("nan")])
    def test_nonsense(self, tmp_path, spec):
        with pytest.raises(InputError, match=r"unknown vertical datum|impossible"):
            datum.resolve(spec, elevation(tmp_path / "e.tif", "EPSG:32616"))
