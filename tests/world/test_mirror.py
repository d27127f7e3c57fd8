"""A mirrored strip: the land itself, then its picture in a mirror at its edge, heights and grey at one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rasterio
from affine import Affine

from aerosim.cli.app import call
from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.raster import sample
from aerosim.world import mirror
from aerosim.world.mirror import mirror_terrain
from aerosim.world.terrain import Terrain

EAST, NORTH = 740_000.0, 4_050_000.0  # of the orthophoto's north-western corner


def write(file: Path, bands: Array, pixel: float, west: float, north: float) -> Path:
    with rasterio.open(
        file, "w", driver="GTiff", crs="EPSG:32616", count=len(bands), height=bands.shape[1], width=bands.shape[2],
        dtype=bands.dtype, transform=Affine(pixel, 0, west, 0, -pixel, north),
    ) as raster:  # fmt: skip
        raster.write(bands)
    return file


def height(e: Array, n: Array) -> Array:
    return 300.0 + 0.05 * (e - EAST) + 0.02 * (n - NORTH)


@pytest.fixture(scope="module")
def land(tmp_path_factory: pytest.TempPathFactory) -> Terrain:
    """A picture of 3 x 2 km in pixels of 10 m, on a tilted plane in cells of 24 m that is larger."""
    folder = tmp_path_factory.mktemp("land")
    grey = np.random.default_rng(1).integers(1, 256, (3, 200, 300), dtype=np.uint8)
    e, n = np.meshgrid(EAST - 240.0 + 24.0 * (np.arange(150) + 0.5), NORTH + 240.0 - 24.0 * (np.arange(110) + 0.5))
    heights = height(e, n).astype(np.float32)[None]
    files = (
        write(folder / "o.tif", grey, 10.0, EAST, NORTH),
        write(folder / "e.tif", heights, 24.0, EAST - 240, NORTH + 240),
    )
    return Terrain.open(*files, 30.0)


@pytest.mark.parametrize("along", ["north", "east"])
def test_points_on_both_sides_of_an_edge_are_alike(land: Terrain, tmp_path: Path, along: str) -> None:
    strip = Terrain.open(*mirror_terrain(land, 7500.0, tmp_path / "strip", along), "file")
    east = along == "east"
    # the edge that is the mirror, and the length of the land: 3000 m of columns or 2000 m of rows
    edge, long = (EAST + 3000.0, 3000.0) if east else (NORTH, 2000.0)
    rng = np.random.default_rng(2)
    inwards = rng.uniform(30.0, long - 30.0, 200)
    aside = rng.uniform(30.0, 1900.0, 200)

    def at(view: Terrain, way: Array) -> tuple[Array, Array]:
        e, n = (way, NORTH - aside) if east else (EAST + aside, way)
        box = e.min() - 30, n.min() - 30, e.max() + 30, n.max() + 30
        return sample(view.elevation().covering(*box), e, n), sample(view.orthophoto().covering(*box), e, n)

    heights, grey = at(land, edge - inwards)
    for far in (edge - inwards, edge + inwards, edge + 2.0 * long - inwards):
        told = (far < edge - long + 7470.0) & (far > edge - long)  # what the strip has of it
        assert told.sum() > 50
        found = at(strip, far)
        # a plane is bilinear, but for cells of it at the edges, which the points keep away from
        assert found[0][told] == pytest.approx(heights[told], abs=2e-3)
        assert found[1][told] == pytest.approx(grey[told], abs=1e-2)
    e_min, n_min, e_max, n_max = strip.bounds
    assert (e_max - e_min if east else n_max - n_min) == pytest.approx(
        7500.0, abs=1.5 * 24.0 + 0.5
    )  # whole cells, centres
    assert (e_min if east else n_min) == pytest.approx(edge - long, abs=12.0)
    assert strip.vertical.name == "ellipsoidal"
    assert np.unique(heights).size > 100


def test_nothing_is_left_of_one_that_fails(land: Terrain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: object) -> None:
        raise OSError("no room")

    monkeypatch.setattr(mirror, "_finish", full)
    with pytest.raises(OSError, match="no room"):
        mirror_terrain(land, 7500.0, tmp_path / "strip")
    assert not list((tmp_path / "strip").iterdir())


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (("--length_m", "1999"), "--length_m: 1999 m is no length of a strip of land that is 2000 m long (more"),
        (("--length_m", "nan"), "--length_m: nan m is no length"),
        (("--length_m", "inf"), "--length_m: inf m is no length"),
        (("--length_m", "1e12"), "--length_m: a strip of 1000000000 km has too many pixels"),
        (("--length_m", "9000", "--along", "up"), "--along: 'up' is no way to go (north or east)"),
        (("--length_m", "9000", "--vertical-datum", "file"), "--vertical-datum: "),
        (("--length_m", "9000", "--out", "."), "orthophoto.tif: file exists (another --out)"),
    ],
)
def test_what_is_wrong_is_one_line(
    land: Terrain,
    tmp_path: Path,
    arguments: tuple[str, ...],
    line: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "orthophoto.tif").write_text("mine")
    files = str(land.orthophoto_file.path), str(land.elevation_file.path)
    assert call(["terrain", "mirror", *files, "--out", "new", "--vertical-datum", "30", *arguments]) == 2
    said = capsys.readouterr().err
    assert said.startswith(line)
    assert said.count("\n") == 1
    assert [each.name for each in tmp_path.iterdir()] == ["orthophoto.tif"]


def test_the_command_prints_both_files(land: Terrain, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = str(land.orthophoto_file.path), str(land.elevation_file.path)
    out = tmp_path / "strip"
    assert call(["terrain", "mirror", *files, "-o", str(out), "--length_m", "5000", "--vertical-datum", "30"]) == 0
    assert capsys.readouterr().out.split() == [str(out / "orthophoto.tif"), str(out / "elevation.tif")]


def test_too_much_land_is_refused(land: Terrain, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mirror, "PIECE_PIXELS", 10_000)
    with pytest.raises(InputError, match="million pixels are repeated"):
        mirror_terrain(land, 7500.0, tmp_path / "strip")
    assert not (tmp_path / "strip").exists()
