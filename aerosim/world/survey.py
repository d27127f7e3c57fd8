"""What a terrain is like: facts for `aerosim terrain info`, contrast as the CCD rows see it among them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.frames import Array

if TYPE_CHECKING:
    from aerosim.raster import Window
    from aerosim.world.terrain import Terrain

# A strip of ground as a row keeps it, more or less: across and along the track, m.
STRIP = (2000.0, 300.0)
# Strips looked at along each direction, at most; the rest of a large terrain is left out.
MAX_STRIPS = 40


def survey(terrain: Terrain, row_pixel_m: float) -> dict[str, Any]:
    """Size, CRS, datum, pixel sizes, heights, contrast and missing share.  row_pixel_m: m on the ground."""
    crs, photo, ground = terrain.grid.crs, terrain.orthophoto_file, terrain.elevation_file
    e_min, n_min, e_max, n_max = terrain.bounds
    coarse = terrain.elevation(max(ground.native_resolution(crs), max(e_max - e_min, n_max - n_min) / 2000.0))
    heights = _within(coarse.covering(*terrain.bounds), terrain.bounds)
    lat, lon = terrain.grid.to_geodetic((e_min + e_max) / 2.0, (n_min + n_max) / 2.0)
    contrast = strip_contrast(terrain, row_pixel_m)
    return {
        "orthophoto": str(photo.path),
        "elevation": str(ground.path),
        "crs": crs.name,
        "vertical_datum": terrain.vertical.name,
        "undulation_m": round(float(terrain.vertical.undulation(lat, lon)), 3),
        "centre_deg": [round(float(np.degrees(lat)), 5), round(float(np.degrees(lon)), 5)],
        "extent_east_m": round(e_max - e_min, 1),
        "extent_north_m": round(n_max - n_min, 1),
        "orthophoto_pixel_m": round(photo.native_resolution(crs), 3),
        "orthophoto_size_px": [photo.height, photo.width],
        "orthophoto_bands": photo.count,
        "elevation_cell_m": round(ground.native_resolution(crs), 3),
        "elevation_size_px": [ground.height, ground.width],
        "height_min_m": round(float(np.nanmin(heights)), 1),
        "height_mean_m": round(float(np.nanmean(heights)), 1),
        "height_max_m": round(float(np.nanmax(heights)), 1),
        "elevation_missing_pct": round(100.0 * float(np.isnan(heights).mean()), 3),
        "row_pixel_m": row_pixel_m,
        "strips": len(contrast),
        "strip_contrast_median_grey": round(float(np.median(contrast)), 2),
        "strip_contrast_p05_grey": round(float(np.percentile(contrast, 5)), 2),
        "strip_contrast_min_grey": round(float(contrast.min()), 2),
    }


def strip_contrast(terrain: Terrain, row_pixel_m: float) -> Array:
    """Standard deviation of grey in strips of 2000 m by 300 m, averaged to row pixels.

    Strips lie north-south and east-west, side by side or, on a large terrain, spread.  Returns (n,), grey
    levels, strips with missing data left out.  Raises InputError if there is none.
    """
    found = [
        *_contrast(terrain, row_pixel_m, STRIP[0], STRIP[1]),
        *_contrast(terrain, row_pixel_m, STRIP[1], STRIP[0]),
    ]
    if not found:
        raise InputError("the terrain is smaller than a strip of 2000 x 300 m", key="terrain.source")
    return np.array(found)


def _contrast(terrain: Terrain, pixel: float, wide: float, high: float) -> list[float]:
    e_min, n_min, e_max, n_max = terrain.bounds
    file, weights = terrain.orthophoto_file, terrain.orthophoto_weights()
    found = []
    for e in _starts(e_min, e_max, wide):
        for n in _starts(n_min, n_max, high):
            cells = file.read(terrain.grid.crs, (e, n, e + wide, n + high), pixel / 4.0, weights)
            blocks = _block_means(cells.values, max(1, round(pixel / cells.dx)))
            if np.isfinite(blocks).all():
                found.append(float(blocks.std()))
    return found


def _block_means(values: NDArray[np.float32], side: int) -> Array:
    """Means of side x side values; what is left over at the edges is dropped."""
    rows, cols = values.shape[0] // side, values.shape[1] // side
    cut = values[: rows * side, : cols * side].astype(float)
    means: Array = cut.reshape(rows, side, cols, side).mean(axis=(1, 3))
    return means


def _starts(low: float, high: float, size: float) -> Array:
    """Where strips of a size begin between two bounds."""
    count = int((high - low) // size)
    return np.linspace(low, high - size, min(count, MAX_STRIPS)) if count else np.empty(0)


def _within(window: Window, bounds: tuple[float, float, float, float]) -> NDArray[np.float32]:
    """Values of a window whose centres lie within bounds.  Raises InputError if none of them is known."""
    rows, cols = window.values.shape
    e, n = window.x0 + np.arange(cols) * window.dx, window.y0 + np.arange(rows) * window.dy
    inside = window.values[np.ix_((n >= bounds[1]) & (n <= bounds[3]), (e >= bounds[0]) & (e <= bounds[2]))]
    if not np.isfinite(inside).any():
        raise InputError("there is no elevation under the orthophoto", key="terrain.source")
    return inside
