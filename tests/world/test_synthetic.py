"""Synthetic land: as asked for, the same each time, opened by the terrain that flights use."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest
import rasterio

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.raster import sample
from aerosim.world import synthetic
from aerosim.world.synthetic import Ground, make_terrain
from aerosim.world.terrain import Terrain
from aerosim.world.texture import relief, texture

LINE = (np.radians([45.0, 45.0]), np.radians([9.0, 9.15]))


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return make_terrain([LINE], 3000.0, Ground(200.0, 30.0, 8.0, 50.0), tmp_path_factory.mktemp("land"))


def test_a_flight_can_be_made_over_it(files: tuple[Path, Path]) -> None:
    terrain = Terrain.open(*files, "file")
    info = terrain.info()
    assert info["vertical_datum"] == "ellipsoidal"
    assert info["crs"] == "WGS 84 / UTM zone 32N"
    # a line of 11.8 km and 3 km around it
    east, north = terrain.grid.from_geodetic(*LINE)
    assert terrain.shortfall(east - [2900.0, -2900.0], north) == pytest.approx(0.0)
    assert terrain.shortfall(east, north + 2900.0) == pytest.approx(0.0)
    assert terrain.shortfall(east, north + 3100.0).min() > 0.0
    # where is 200 m: over 18 x 6 km lie few hills of 6 km, so their mean is known to their deviation/sqrt(5)
    heights = terrain.mean_height(east, north, 2000.0)
    assert heights.mean == pytest.approx(200.0, abs=2.0 * 30.0 / np.sqrt(5.0))
    assert heights.missing == 0.0
    # contrast that rows of 22.6 m see: tens of grey levels
    assert info["strip_contrast_min_grey"] > 12.0


def test_no_pixel_inside_is_taken_for_no_data(files: tuple[Path, Path]) -> None:
    """0 means no data, and JPEG is not exact: nothing comes near it."""
    with rasterio.open(files[0]) as photo:
        grey = photo.read(1)
        assert photo.nodata == 0
        assert photo.overviews(1)
    assert grey[: grey.shape[0] // 2].min() > 10


def spectrum(values: Array, pixel: float) -> tuple[Array, Array]:
    """Wavelengths (m) and variance in each octave about them, of the rows of an image."""
    power = (np.abs(np.fft.rfft(values - values.mean(), axis=1)) ** 2).mean(axis=0) / values.shape[1] ** 2 * 2.0
    waves = values.shape[1] * pixel / np.arange(1, len(power))
    edges = 22.5 * 2.0 ** np.arange(7)
    return edges[:-1], np.array([power[1:][(waves >= a) & (waves < 2.0 * a)].sum() for a in edges[:-1]])


def test_there_is_contrast_at_all_lengths_that_rows_see() -> None:
    grey = texture(512, 1024, 4e5, 5e6, 5.0, 45.2, 723.0, 1).astype(float)
    waves, variance = spectrum(grey, 5.0)
    assert waves == pytest.approx([22.5, 45.0, 90.0, 180.0, 360.0, 720.0])
    deviation = np.sqrt(variance)
    # the rows' noise is 1.5 grey levels; no octave is hidden by it, nor by another octave
    assert deviation[1:5].min() > 5.0
    assert deviation[1:5].min() / deviation[1:5].max() > 0.4
    assert 18.0 < grey.std() < 40.0


def test_pieces_fit_and_seeds_differ() -> None:
    whole = texture(64, 96, 4e5, 5e6, 5.0, 45.2, 723.0, 7)
    part = texture(32, 48, 4e5 + 48 * 5.0, 5e6 - 32 * 5.0, 5.0, 45.2, 723.0, 7)
    assert (whole[32:, 48:] == part).all()
    other = texture(64, 96, 4e5, 5e6, 5.0, 45.2, 723.0, 8)
    assert abs(np.corrcoef(whole.ravel(), other.ravel())[0, 1]) < 0.5


def test_the_relief_is_gentle_and_as_high_as_asked_for() -> None:
    heights = relief(400, 400, 4e5, 5e6, 250.0, 1)  # 100 km: 270 hills
    assert heights.std() == pytest.approx(1.0, rel=0.15)
    assert abs(heights.mean()) < 0.2
    fine = relief(64, 64, 4e5, 5e6, 25.0, 1)
    # 30 m of it: slopes below 10 %
    assert np.abs(np.gradient(30.0 * fine, 25.0)).max() < 0.10


def test_the_same_land_twice(tmp_path: Path) -> None:
    made = [make_terrain([LINE], 200.0, Ground(pixel=10.0), tmp_path / name) for name in "ab"]
    digests = [[hashlib.sha256(file.read_bytes()).hexdigest() for file in pair] for pair in made]
    assert digests[0] == digests[1]


def test_land_far_from_the_way_takes_no_space(tmp_path: Path) -> None:
    slanted = (np.radians([45.0, 45.2]), np.radians([9.0, 9.2]))  # a corridor across 16 x 22 km
    told: list[tuple[float, float]] = []
    photo, _ = make_terrain(
        [slanted], 1000.0, Ground(pixel=5.0), tmp_path, lambda done, total: told.append((done, total))
    )
    with rasterio.open(photo) as file:
        tiles = -(-file.width // 512) * -(-file.height // 512)
        assert told[-1] == (len(told), len(told))
        assert len(told) < 0.5 * tiles
        corner = file.read(1, window=((0, 100), (0, 100)))  # north-west: 10 km off
        assert (corner == 0).all()
    terrain = Terrain.open(photo, tmp_path / "elevation.tif", "file")
    grey = terrain.orthophoto(10.0)
    for share in (0.0, 0.5, 1.0):
        lat, lon = (np.array([a + share * (b - a)]) for a, b in slanted)
        east, north = (float(v[0]) for v in terrain.grid.from_geodetic(lat, lon))
        window = grey.covering(east - 900, north - 900, east + 900, north + 900)
        e, n = np.meshgrid(east + np.linspace(-900, 900, 50), north + np.linspace(-900, 900, 50))
        assert np.isfinite(sample(window, e.ravel(), n.ravel())).all()


def test_what_cannot_be_made_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="million pixels of 1 m"):
        make_terrain([LINE], 20_000.0, Ground(pixel=1.0), tmp_path / "big")
    assert not (tmp_path / "big").exists()
    with pytest.raises(InputError, match="has no UTM zone"):
        make_terrain([(np.radians([86.0]), np.radians([9.0]))], 1000.0, Ground(), tmp_path / "pole")
    for wrong in ({"pixel": 0.0}, {"relief": -1.0}, {"height": 1e5}, {"seed": -1}):
        with pytest.raises(InputError):
            Ground(**wrong)
    with pytest.raises(InputError, match="margin"):
        make_terrain([LINE], -1.0, Ground(), tmp_path / "small")

    # whatever stops it leaves no half file behind
    def stop(*args: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_terrain([LINE], 200.0, Ground(pixel=10.0), tmp_path / "stopped", stop)
    assert list((tmp_path / "stopped").iterdir()) == []
    make_terrain([LINE], 200.0, Ground(pixel=10.0), tmp_path / "once")
    with pytest.raises(InputError, match="file exists"):
        make_terrain([LINE], 200.0, Ground(pixel=10.0), tmp_path / "once")


def test_south_and_across_the_date_line(tmp_path: Path) -> None:
    way = (np.radians([-17.0, -17.0]), np.radians([179.98, -179.98]))
    photo, _ = make_terrain([way], 500.0, Ground(pixel=10.0), tmp_path)
    with rasterio.open(photo) as file:
        assert file.width * 10.0 == pytest.approx(4260.0 + 1000.0, rel=0.02)  # not around the Earth
        assert file.crs.to_epsg() in (32701, 32760)


def test_limits_are_those_of_the_messages() -> None:
    assert synthetic.MOST_PIXELS == 600_000_000
