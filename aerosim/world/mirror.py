"""A long strip of land out of a short one: orthophoto and elevation repeated, every second time mirrored.

Real land is seldom photographed far enough for a line with statistics on it.  Mirrored at its edges it has no
seams, and its contrast and relief are the real ones.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.frames import MapGrid
from aerosim.raster import sample
from aerosim.rasterfile import CACHE_BYTES, DATUM_TAG, RasterFile
from aerosim.world.terrain import Terrain

TILE = 512  # px
PIECE_PIXELS = 60_000_000  # of the land that is repeated: it is held in memory
STRIP_PIXELS = 600_000_000
WAYS = ("north", "east")


class _Strip(NamedTuple):
    """A raster that repeats: its piece (bands, rows, cols), west and north edge (m), cell (m), lines in all."""

    piece: NDArray[Any]
    west: float
    north: float
    cell: tuple[float, float]
    lines: int


def mirror_terrain(
    terrain: Terrain,
    length: float,
    out: Path,
    along: str = "north",
    progress: Callable[[float, float], None] | None = None,
) -> tuple[Path, Path]:
    """Write orthophoto.tif and elevation.tif (ellipsoidal heights) of a mirrored strip into a folder.

    terrain: what both files cover is repeated.  length: of the strip, m, from the southern (western) edge on.
    along: north or east.  progress: told tiles done and tiles in all.  Returns both files, in the terrain's grid.
    Raises InputError: shorter than the land, too large, files there already, a way that is none.
    """
    if along not in WAYS:
        raise InputError(f"{along!r} is no way to go", key="--along", allowed=" or ".join(WAYS))
    files = out / "orthophoto.tif", out / "elevation.tif"
    for file in files:
        if file.exists():
            raise InputError("file exists", where=str(file), allowed="another --out")
    photo = _photo(terrain, length, along)
    heights = _heights(terrain, photo, length, along)
    out.mkdir(parents=True, exist_ok=True)
    parts = [file.with_name(f".{file.name}.part") for file in files]
    try:
        _write(parts[1], terrain.grid, heights, along, None, predictor=3)
        _write(parts[0], terrain.grid, photo, along, progress, predictor=2, nodata=0)
        _finish(parts)
        for part, file in zip(parts, files, strict=True):
            part.replace(file)
    finally:
        for part in parts:
            part.unlink(missing_ok=True)
    return files


def _photo(terrain: Terrain, length: float, along: str) -> _Strip:
    """The orthophoto where both files are, 1 to 255 in each band, 0 where it has nothing."""
    file = terrain.orthophoto_file
    e_min, n_min, e_max, n_max = terrain.bounds
    pixel = file.native_resolution(terrain.grid.crs)
    if (e_max - e_min) * (n_max - n_min) > PIECE_PIXELS * pixel**2:
        problem = f"{(e_max - e_min) * (n_max - n_min) / pixel**2 / 1e6:.0f} million pixels are repeated"
        raise InputError(problem, where=str(file.path), allowed=f"up to {PIECE_PIXELS / 1e6:.0f} million")
    bands = []
    for band, weight in _bands(terrain, file).items():
        cells = file.read(terrain.grid.crs, terrain.bounds, 0.0, {band: weight})
        rows, cols = cells.values.shape
        e, n = cells.x0 + np.arange(cols) * cells.dx, cells.y0 + np.arange(rows) * cells.dy
        here = np.ix_(_within(n, n_min, n_max), _within(e, e_min, e_max))
        grey = cells.values[here]
        bands.append(np.where(np.isfinite(grey), np.clip(np.rint(grey), 1, 255), 0).astype(np.uint8))
    west, north = e[here[1].ravel()[0]] - cells.dx / 2.0, n[here[0].ravel()[0]] - cells.dy / 2.0
    strip = _strip(np.stack(bands), (west, north), (cells.dx, -cells.dy), length, along)
    if strip.piece[0].size / _size(strip, along) * strip.lines > STRIP_PIXELS:
        raise InputError(
            f"a strip of {length / 1e3:.0f} km has too many pixels",
            key="--length_m",
            allowed=f"up to {STRIP_PIXELS / 1e6:.0f} million",
        )
    return strip


def _bands(terrain: Terrain, file: RasterFile) -> dict[int, float]:
    """Bands that are kept and what makes 0 to 255 of each."""
    weights = file.colour_weights()
    return {band: terrain.orthophoto_weights()[band] / weights[band] for band in weights}


def _within(centres: NDArray[Any], low: float, high: float) -> NDArray[np.int64]:
    """Places of the centres from low to high, m; a millimetre beyond counts."""
    return np.flatnonzero((centres > low - 1e-3) & (centres < high + 1e-3))


def _size(strip: _Strip, along: str) -> int:
    """Lines of the piece that follow one another along the strip."""
    return int(strip.piece.shape[1 if along == "north" else 2])


def _strip(
    piece: NDArray[Any], corner: tuple[float, float], cell: tuple[float, float], length: float, along: str
) -> _Strip:
    """corner: west and north edge of the piece, m; the strip's own northern edge lies where it ends."""
    step, count = cell[1 if along == "north" else 0], piece.shape[1 if along == "north" else 2]
    if not count * step <= length < np.inf:
        problem = f"{length:g} m is no length of a strip of land that is {count * step:.0f} m long"
        raise InputError(problem, key="--length_m", allowed="more than that")
    lines = round(length / step)
    north = corner[1] + ((lines - count) * step if along == "north" else 0.0)
    return _Strip(piece, corner[0], north, cell, lines)


def _heights(terrain: Terrain, photo: _Strip, length: float, along: str) -> _Strip:
    """Heights over the orthophoto's piece, in cells of which a whole number fits: mirrored at the same lines."""
    rows, cols = photo.piece.shape[1:]
    native = terrain.elevation_file.native_resolution(terrain.grid.crs)
    wide, high = cols * photo.cell[0], rows * photo.cell[1]
    nx, ny = (max(2, int(np.ceil(side / native))) for side in (wide, high))
    dx, dy = wide / nx, high / ny
    step, count = photo.cell[1], rows
    top = photo.north - (photo.lines - count) * step if along == "north" else photo.north
    east = photo.west + (np.arange(nx) + 0.5) * dx
    north = top - (np.arange(ny) + 0.5) * dy
    window = terrain.elevation().covering(east[0], north[-1], east[-1], north[0])
    heights = sample(window, *np.meshgrid(east, north)).astype(np.float32)
    return _strip(heights[None], (photo.west, top), (dx, dy), length, along)


def _write(
    file: Path,
    grid: MapGrid,
    strip: _Strip,
    along: str,
    progress: Callable[[float, float], None] | None,
    **options: Any,
) -> None:
    import rasterio
    from affine import Affine
    from rasterio.windows import Window

    bands, rows, cols = strip.piece.shape
    rows, cols = (strip.lines, cols) if along == "north" else (rows, strip.lines)
    place = Affine(strip.cell[0], 0.0, strip.west, 0.0, -strip.cell[1], strip.north)
    with (
        rasterio.Env(GDAL_CACHEMAX=CACHE_BYTES),
        rasterio.open(
            file, "w", driver="GTiff", crs=grid.crs.to_wkt(), transform=place, count=bands, height=rows,
            width=cols, dtype=strip.piece.dtype, compress="deflate", tiled=True, blockxsize=TILE, blockysize=TILE,
            bigtiff="if_safer", **options,
        ) as raster,
    ):  # fmt: skip
        tiles = [(row, col) for row in range(0, rows, TILE) for col in range(0, cols, TILE)]
        for done, (row, col) in enumerate(tiles):
            high, wide = min(TILE, rows - row), min(TILE, cols - col)
            raster.write(_tile(strip, along, row, col, high, wide), window=Window(col, row, wide, high))
            if progress is not None:
                progress(done + 1, len(tiles))


def _tile(strip: _Strip, along: str, row: int, col: int, high: int, wide: int) -> NDArray[Any]:
    """A part of the strip: lines counted from the piece's southern (western) edge, there and back."""
    size = _size(strip, along)
    if along == "north":
        at = strip.lines - 1 - np.arange(row, row + high)  # from the south
        return strip.piece[:, size - 1 - _folded(at, size), col : col + wide]
    return strip.piece[:, row : row + high, _folded(np.arange(col, col + wide), size)]


def _folded(at: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Places in a piece of a line's number in the strip: 0, 1, 2, 2, 1, 0, 0, 1, ... for a size of 3."""
    turn = at % (2 * size)
    return np.where(turn < size, turn, 2 * size - 1 - turn)


def _finish(parts: list[Path]) -> None:
    """Overviews of the orthophoto; what the heights refer to."""
    import rasterio
    from rasterio.enums import Resampling

    with (
        rasterio.Env(GDAL_CACHEMAX=CACHE_BYTES, COMPRESS_OVERVIEW="DEFLATE"),
        rasterio.open(parts[0], "r+") as photo,
    ):
        sizes = [2**k for k in range(1, 8) if max(photo.height, photo.width) >> k >= 128]
        if sizes:
            photo.build_overviews(sizes, Resampling.average)
    with rasterio.open(parts[1], "r+") as heights:
        heights.update_tags(**{DATUM_TAG: "ELLIPSOIDAL"})
