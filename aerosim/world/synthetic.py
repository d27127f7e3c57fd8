"""Synthetic terrain for flights anywhere: an orthophoto with contrast at every length that matters, and a relief.

Made from the map coordinates and a seed alone, tile by tile, so that neighbouring files fit and a second call
gives the same ground.  It looks like no particular land; it has what correlating rows of pixels need.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from aerosim.errors import InputError
from aerosim.frames import Array, MapGrid
from aerosim.rasterfile import CACHE_BYTES, DATUM_TAG
from aerosim.world.features import Feature, Placed, paint, placed
from aerosim.world.texture import relief, texture

TILE = 512  # px
MOST_PIXELS = 600_000_000  # of tiles that are written: about 250 MB as JPEG
MOST_SIDE = 200_000  # px
QUALITY = 85
# Shortest and longest wavelength with contrast, in pixels of a row (45 m and 720 m from 3000 m).
WAVES = (2.0, 32.0)

Progress = Callable[[float, float], None]


@dataclass(frozen=True)
class Ground:
    """What the land is like.  SI.

    height: mean, above the ellipsoid; relief: standard deviation of the heights; pixel: of the orthophoto; cell:
    of the elevation model; detail: a pixel of the rows on the ground, which sets the lengths of the contrast;
    features: painted into the picture, the later ones over the earlier.
    """

    height: float = 0.0
    relief: float = 0.0
    pixel: float = 5.0
    cell: float = 25.0
    detail: float = 22.6
    seed: int = 1
    features: tuple[Feature, ...] = ()

    def __post_init__(self) -> None:
        if not 0.1 <= self.pixel <= 100.0:
            raise InputError(f"pixel of {self.pixel:g} m", key="--pixel_m", allowed="0.1 to 100 m")
        if not -500.0 <= self.height <= 9000.0:
            raise InputError(f"ground at {self.height:g} m", key="--height_m", allowed="-500 to 9000 m")
        if not 0.0 <= self.relief <= 500.0:
            raise InputError(f"relief of {self.relief:g} m", key="--relief_m", allowed="0 to 500 m")
        if not 0 <= self.seed < 2**31:
            raise InputError(f"seed {self.seed}", key="--seed", allowed="0 to 2147483647")


class _Frame(NamedTuple):
    """A raster's grid: west, north edge (m), size (px), pixel (m)."""

    west: float
    north: float
    rows: int
    cols: int
    pixel: float


def make_terrain(
    ways: Sequence[tuple[Array, Array]], margin: float, ground: Ground, out: Path, progress: Progress | None = None
) -> tuple[Path, Path]:
    """Write orthophoto.tif and elevation.tif around some ways into a new or empty folder.

    ways: latitudes and longitudes (n,), rad, of each; margin: land to either side, m; progress: told tiles done
    and tiles in all.  Returns both files.  Tiles of the orthophoto farther off hold no data and take no space.
    Raises InputError: too large, too far north or south, files there already.
    """
    if not 10.0 <= margin <= 100_000.0:
        raise InputError(f"margin of {margin:g} m", key="--margin_m", allowed="10 to 100000 m")
    files = out / "orthophoto.tif", out / "elevation.tif"
    for file in files:
        if file.exists():
            raise InputError("file exists", where=str(file), allowed="another --out")
    grid = _utm(ways)
    lines = [np.column_stack(grid.from_geodetic(lat, lon)) for lat, lon in ways]
    frame = _frame(lines, margin, ground.pixel)
    tiles = list(_tiles(frame, lines, margin))
    features = tuple(placed(feature, grid, _middle(ways)) for feature in ground.features)
    if len(tiles) * TILE**2 > MOST_PIXELS:
        raise InputError(
            f"an orthophoto of {len(tiles) * TILE**2 / 1e6:.0f} million pixels of {ground.pixel:g} m",
            key="--pixel_m",
            allowed=f"up to {MOST_PIXELS / 1e6:.0f} million: larger pixels, a smaller margin, fewer lines",
        )
    out.mkdir(parents=True, exist_ok=True)
    made: list[Path] = []
    try:
        made.append(files[1])
        _write_elevation(files[1], grid, _frame(lines, margin, ground.cell), ground)
        made.append(files[0])
        _write_photo(files[0], grid, frame, tiles, ground, features, progress)
    except BaseException:
        for file in made:
            file.unlink(missing_ok=True)
        raise
    return files


def _utm(ways: Sequence[tuple[Array, Array]]) -> MapGrid:
    """The UTM zone of the middle of the ways."""
    lat = np.concatenate([way[0] for way in ways])
    middle_lat, middle_lon = np.degrees(_middle(ways))
    if not np.abs(np.degrees(lat)).max() <= 84.0:
        raise InputError(f"latitude {np.degrees(lat).max():.1f} deg has no UTM zone", allowed="within 84 deg")
    zone = int((middle_lon + 180.0) // 6.0) % 60 + 1
    return MapGrid(f"EPSG:{32600 + zone if middle_lat >= 0.0 else 32700 + zone}")


def _middle(ways: Sequence[tuple[Array, Array]]) -> tuple[float, float]:
    """Latitude and longitude of the middle of the ways, rad."""
    lat = np.concatenate([way[0] for way in ways])
    lon = np.unwrap(np.concatenate([way[1] for way in ways]))
    return float(lat.min() + lat.max()) / 2.0, float(lon.min() + lon.max()) / 2.0


def _frame(lines: Sequence[Array], margin: float, pixel: float) -> _Frame:
    """Grid of whole pixels around the lines."""
    points = np.concatenate(lines)
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    west, north = np.floor(low[0] / pixel) * pixel, np.ceil(high[1] / pixel) * pixel
    cols, rows = int(np.ceil((high[0] - west) / pixel)), int(np.ceil((north - low[1]) / pixel))
    if max(rows, cols) > MOST_SIDE:
        raise InputError(
            f"terrain of {cols * pixel / 1e3:.0f} x {rows * pixel / 1e3:.0f} km with pixels of {pixel:g} m",
            key="--pixel_m",
            allowed=f"up to {MOST_SIDE} pixels a side",
        )
    return _Frame(float(west), float(north), rows, cols, pixel)


def _tiles(frame: _Frame, lines: Sequence[Array], margin: float) -> Iterator[tuple[int, int]]:
    """Row and column of the tiles that lie within the margin of a line."""
    from scipy.spatial import cKDTree

    side = TILE * frame.pixel
    points = np.concatenate([_dense(line, side / 4.0) for line in lines])
    rows, cols = np.meshgrid(np.arange(0, frame.rows, TILE), np.arange(0, frame.cols, TILE), indexing="ij")
    centre = np.column_stack([
        frame.west + (cols.ravel() + TILE / 2.0) * frame.pixel,
        frame.north - (rows.ravel() + TILE / 2.0) * frame.pixel,
    ])  # fmt: skip
    near = cKDTree(points).query(centre)[0] <= margin + side * (np.sqrt(0.5) + 0.125)
    yield from zip(rows.ravel()[near].tolist(), cols.ravel()[near].tolist(), strict=True)


def _dense(line: Array, step: float) -> Array:
    """Points along a line (n, 2), not farther apart than a step, m."""
    if len(line) < 2:
        return line
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    at = np.append(np.arange(0.0, way[-1], step), way[-1])
    return np.column_stack([np.interp(at, way, line[:, k]) for k in range(2)])


def _create(file: Path, grid: MapGrid, frame: _Frame, **options: Any) -> Any:
    import rasterio
    from affine import Affine

    transform = Affine(frame.pixel, 0.0, frame.west, 0.0, -frame.pixel, frame.north)
    return rasterio.open(
        file, "w", driver="GTiff", crs=grid.crs.to_wkt(), transform=transform, count=1, height=frame.rows,
        width=frame.cols, tiled=True, blockxsize=TILE, blockysize=TILE, bigtiff="if_safer", **options,
    )  # fmt: skip


def _write_photo(
    file: Path, grid: MapGrid, frame: _Frame, tiles: Sequence[tuple[int, int]], ground: Ground,
    features: tuple[Placed, ...], progress: Progress | None,
) -> None:  # fmt: skip
    import rasterio
    from rasterio.enums import Resampling
    from rasterio.windows import Window

    low, high = WAVES[0] * ground.detail, WAVES[1] * ground.detail
    with rasterio.Env(GDAL_CACHEMAX=CACHE_BYTES):
        with _create(
            file, grid, frame, dtype="uint8", nodata=0, compress="jpeg", jpeg_quality=QUALITY, sparse_ok=True
        ) as photo:
            for done, (row, col) in enumerate(tiles):
                rows, cols = min(TILE, frame.rows - row), min(TILE, frame.cols - col)
                west, north = frame.west + col * frame.pixel, frame.north - row * frame.pixel
                grey = texture(rows, cols, west, north, frame.pixel, low, high, ground.seed)
                paint(grey, west, north, frame.pixel, features)
                photo.write(grey, 1, window=Window(col, row, cols, rows))
                if progress is not None:
                    progress(done + 1, len(tiles))
            photo.update_tags(TIFFTAG_IMAGEDESCRIPTION=f"Synthetic orthophoto, seed {ground.seed}")
        with (
            rasterio.Env(COMPRESS_OVERVIEW="JPEG", JPEG_QUALITY_OVERVIEW=QUALITY, SPARSE_OK_OVERVIEW="ON"),
            rasterio.open(file, "r+") as photo,
        ):
            photo.build_overviews(
                [2**k for k in range(1, 8) if max(frame.rows, frame.cols) >> k >= 128], Resampling.average
            )


def _write_elevation(file: Path, grid: MapGrid, frame: _Frame, ground: Ground) -> None:
    from rasterio.windows import Window

    options = {"compress": "deflate", "predictor": 3, "dtype": "float32"}
    with _create(file, grid, frame, **options) as heights:
        for row in range(0, frame.rows, TILE):
            for col in range(0, frame.cols, TILE):
                rows, cols = min(TILE, frame.rows - row), min(TILE, frame.cols - col)
                west, north = frame.west + col * frame.pixel, frame.north - row * frame.pixel
                tile = relief(rows, cols, west, north, frame.pixel, ground.seed)
                heights.write(
                    (ground.height + ground.relief * tile).astype(np.float32),
                    1,
                    window=Window(col, row, cols, rows),
                )
        heights.update_tags(**{DATUM_TAG: "ELLIPSOIDAL"})
