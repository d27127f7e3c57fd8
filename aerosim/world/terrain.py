"""The ground: an orthophoto and an elevation raster on one map grid, heights made ellipsoidal."""

from __future__ import annotations

from difflib import get_close_matches
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerosim import assets, datum
from aerosim.errors import InputError
from aerosim.frames import Array, MapGrid
from aerosim.raster import WINDOW, Window, WindowedRaster, sample
from aerosim.rasterfile import RasterFile

if TYPE_CHECKING:
    from pyproj import CRS

# A grid whose scale is further off (Web Mercator away from the equator) is no map to measure in.
MAX_SCALE_ERROR = 0.01


class GroundHeights(NamedTuple):
    """Ellipsoidal heights of a piece of ground, m; missing: share of it without data, 0 to 1."""

    mean: float
    low: float
    high: float
    missing: float


class Terrain:
    """Orthophoto and elevation, read in windows.  grid: the working map grid g of everything below."""

    def __init__(
        self,
        orthophoto: RasterFile,
        elevation: RasterFile,
        vertical: datum.VerticalDatum,
        relief_factor: float = 1.0,
    ) -> None:
        """relief_factor: heights above their mean are multiplied by it; 0: flat land at the mean.

        Raises InputError when the two do not overlap.
        """
        self.orthophoto_file, self.elevation_file, self.vertical = orthophoto, elevation, vertical
        self.relief_factor = relief_factor
        self.grid = working_grid(orthophoto)
        self._corridors: WindowedRaster | None = None
        self._levels = _white_level(orthophoto, self.grid.crs)
        self._outlines = [file.outline(self.grid.crs) for file in (orthophoto, elevation)]
        bounds = [(o.min(axis=0), o.max(axis=0)) for o in self._outlines]
        low = np.maximum(bounds[0][0], bounds[1][0])
        high = np.minimum(bounds[0][1], bounds[1][1])
        if (high <= low).any():
            raise InputError(
                f"orthophoto {orthophoto.path} and elevation {elevation.path} do not overlap", key="terrain.source"
            )
        self.bounds = (float(low[0]), float(low[1]), float(high[0]), float(high[1]))

    @classmethod
    def open(
        cls, orthophoto: Path, elevation: Path, vertical_datum: str | float, relief_factor: float = 1.0
    ) -> Terrain:
        """Terrain of two files.  vertical_datum: as `datum.resolve`; relief_factor: as of the class.

        Raises InputError: a bad raster, no way to ellipsoidal heights, files that do not overlap.
        """
        heights = RasterFile(elevation)
        if heights.count != 1:
            raise InputError(
                f"elevation {elevation} has {heights.count} bands, heights have one",
                key="terrain.source",
                allowed="orthophoto first, elevation second: are the two swapped?",
            )
        return cls(RasterFile(orthophoto), heights, datum.resolve(vertical_datum, heights), relief_factor)

    def elevation(self, resolution_m: float = 0.0, size: int = WINDOW) -> WindowedRaster:
        """Ellipsoidal heights, m; 0: as fine as the file.  size: cells along a side of its window."""
        return WindowedRaster(self.elevation_file, self.grid.crs, resolution_m, convert=self._heights, size=size)

    def _heights(self, window: Window) -> NDArray[np.float32]:
        """Ellipsoidal heights of a window of the file's, the relief made higher or lower."""
        heights = self.vertical.to_ellipsoid(window, self.grid)
        if self.relief_factor == 1.0:
            return heights
        mean = np.float32(self._mean)
        return np.asarray(mean + np.float32(self.relief_factor) * (heights - mean), np.float32)

    @cached_property
    def _mean(self) -> float:
        """Mean height of the whole elevation file above the ellipsoid, m.  Raises InputError if it is empty."""
        outline = self.elevation_file.outline(self.grid.crs)
        (e_min, n_min), (e_max, n_max) = outline.min(axis=0), outline.max(axis=0)
        native = self.elevation_file.native_resolution(self.grid.crs)
        resolution = max(native, max(e_max - e_min, n_max - n_min) / 1000.0)
        cells = self.elevation_file.read(self.grid.crs, (e_min, n_min, e_max, n_max), resolution, {1: 1.0})
        heights = self.vertical.to_ellipsoid(Window(*cells), self.grid)
        if not np.isfinite(heights).any():
            raise InputError(f"elevation {self.elevation_file.path} is empty", key="terrain.source")
        return float(np.nanmean(heights, dtype=np.float64))

    def orthophoto(self, resolution_m: float = 0.0) -> WindowedRaster:
        """Grey values from 0 to 255: luma of ITU-R BT.601; other types than uint8 scaled to that range."""
        weights = self.orthophoto_weights()
        return WindowedRaster(self.orthophoto_file, self.grid.crs, resolution_m, weights=weights)

    def orthophoto_weights(self) -> dict[int, float]:
        """Weights of the orthophoto's bands that make grey from 0 to 255."""
        return {b: w * 255.0 / self._levels for b, w in self.orthophoto_file.colour_weights().items()}

    def picture(
        self, max_px: int = 2048, bounds: tuple[float, float, float, float] | None = None
    ) -> tuple[NDArray[np.uint8], Window]:
        """Colour overview.  bounds: e_min, n_min, e_max, n_max (m), the whole terrain by default.

        Returns (rows, cols, 3), and a window of its grey with the place of each pixel's centre.
        """
        bounds = bounds or self.bounds
        # Cells are whole multiples of the file's pixel, rounded down: ask for enough to stay below the bound.
        resolution = max(bounds[2] - bounds[0], bounds[3] - bounds[1]) / max_px
        native = self.orthophoto_file.native_resolution(self.grid.crs)
        resolution = native * np.ceil(resolution / native)
        bands = list(self.orthophoto_file.colour_weights())
        bands = bands * 3 if len(bands) == 1 else bands
        weight = 255.0 / self._levels
        layers = [self.orthophoto_file.read(self.grid.crs, bounds, resolution, {band: weight}) for band in bands]
        colour = np.nan_to_num(np.stack([layer.values for layer in layers], axis=-1))
        grey = colour @ np.array([0.299, 0.587, 0.114], np.float32)
        return np.clip(colour + 0.5, 0, 255).astype(np.uint8), Window.of(grey, *layers[0][1:])

    def mean_height(self, easting: ArrayLike, northing: ArrayLike, half_width: float) -> GroundHeights:
        """Ellipsoidal heights of a corridor along a line.

        easting, northing: (n >= 2,) corners, m.  half_width: m to either side.
        Raises InputError if there is no elevation at all.
        """
        corners = np.column_stack([np.asarray(easting, float), np.asarray(northing, float)])
        resolution, window = self._overview(corners, half_width)
        e, n = _corridor(corners, half_width, 2.0 * resolution)
        heights = sample(window, e, n)
        known = heights[np.isfinite(heights)]
        if not len(known):
            raise InputError("there is no elevation under the line", key="terrain.source")
        return GroundHeights(
            float(known.mean()), float(known.min()), float(known.max()), 1.0 - len(known) / heights.size
        )

    def heights(self, easting: ArrayLike, northing: ArrayLike) -> Array:
        """Ellipsoidal heights of the ground at points (n,), m; NaN where there are none.

        Means of cells of up to 1/2000 of the points' spread.
        """
        points = np.column_stack([np.asarray(easting, float), np.asarray(northing, float)])
        return sample(self._overview(points, 0.0)[1], *points.T)

    def _overview(self, points: Array, beyond: float) -> tuple[float, Window]:
        """Cell (m) and heights of the land that holds points (n, 2) and so much (m) around them."""
        low, high = points.min(axis=0) - beyond, points.max(axis=0) + beyond
        resolution = max(float((high - low).max()) / 2000.0, self.elevation_file.native_resolution(self.grid.crs))
        if self._corridors is None or self._corridors.resolution_m != resolution:
            self._corridors = self.elevation(resolution)  # kept: a block has a hundred lines over the same land
        return resolution, self._corridors.covering(low[0], low[1], high[0], high[1])

    def shortfall(self, easting: ArrayLike, northing: ArrayLike) -> Array:
        """How far points (n,), m, lie outside of the rasters' outline, m; 0 inside."""
        points = np.column_stack(
            [np.atleast_1d(np.asarray(easting, float)), np.atleast_1d(np.asarray(northing, float))]
        )
        beyond = np.stack([_outside(outline, points) for outline in self._outlines]).max(axis=0)
        return np.asarray(np.maximum(0.0, beyond))

    def contains(self, easting: ArrayLike, northing: ArrayLike) -> bool:
        """Whether all points (n,), m, lie within both rasters' outline."""
        return bool((self.shortfall(easting, northing) <= 0.0).all())

    def info(self, row_pixel_m: float = 22.6) -> dict[str, Any]:
        """Facts for `aerosim terrain info`: row_pixel_m: pixel of a CCD row on the ground."""
        from aerosim.world.survey import survey

        return survey(self, row_pixel_m)


def working_grid(orthophoto: RasterFile) -> MapGrid:
    """The orthophoto's grid if it is one in metres and nearly true to scale, else the UTM zone of its middle."""
    from pyproj import Proj

    middle = np.array([orthophoto.width / 2.0]), np.array([orthophoto.height / 2.0])
    lon, lat = (float(angle[0]) for angle in orthophoto.place("EPSG:4326", *middle))
    if not (np.isfinite(lat) and abs(lat) <= 84.0):
        raise InputError(f"raster {orthophoto.path} lies where no UTM zone is", allowed="latitudes within 84 deg")
    crs = orthophoto.horizontal
    if crs.is_projected and all(axis.unit_conversion_factor == 1.0 for axis in crs.axis_info):
        factors = Proj(crs).get_factors(lon, lat)
        scales = np.array([factors.meridional_scale, factors.parallel_scale])
        if (np.abs(scales - 1.0) < MAX_SCALE_ERROR).all():
            return MapGrid(crs)
    zone = int((lon + 180.0) // 6.0) % 60 + 1
    return MapGrid(f"EPSG:{32600 + zone if lat >= 0.0 else 32700 + zone}")


def find_terrain(name: str) -> tuple[Path, Path]:
    """Orthophoto and elevation of a terrain that ships.  Raises InputError with the nearest names."""
    root = assets.folder("terrain")
    names = sorted(p.parent.name for p in root.glob("*/orthophoto.tif"))
    if name not in names:
        near = get_close_matches(name, names, 1)
        hint = (
            f"did you mean {near[0]}?" if near else f"shipped: {', '.join(names)}, or {{orthophoto:, elevation:}}"
        )
        raise InputError(f"no terrain {name!r} ships", key="terrain.source", allowed=hint)
    return root / name / "orthophoto.tif", root / name / "elevation.tif"


def _white_level(file: RasterFile, crs: CRS) -> float:
    """Value shown as white: 255 of uint8, else the 99.9th percentile of an overview."""
    if file.dtype == "uint8":
        return 255.0
    outline = file.outline(crs)
    low, high = outline.min(axis=0), outline.max(axis=0)
    resolution = float((high - low).max()) / 512.0
    cells = file.read(crs, (low[0], low[1], high[0], high[1]), resolution, file.colour_weights())
    known = cells.values[np.isfinite(cells.values)]
    level = float(np.percentile(known, 99.9)) if len(known) else 0.0
    if level <= 0.0:
        raise InputError(f"orthophoto {file.path} is empty or black")
    return level


def _corridor(corners: Array, half_width: float, step: float) -> tuple[Array, Array]:
    """Points of a regular grid along and across the legs.  Returns easting, northing, (n,), m."""
    aside = np.linspace(-half_width, half_width, 2 * int(np.ceil(half_width / step)) + 1)
    found = []
    for start, end in pairwise(corners):
        length = float(np.hypot(*(end - start)))
        along = np.linspace(0.0, length, int(np.ceil(length / step)) + 1)
        ahead = (end - start) / max(length, 1e-9)
        right = np.array([ahead[1], -ahead[0]])
        found.append((start + along[:, None, None] * ahead + aside[None, :, None] * right).reshape(-1, 2))
    points = np.concatenate(found)
    return points[:, 0], points[:, 1]


def _outside(outline: Array, points: Array) -> Array:
    """Distance of points (n, 2) beyond the farthest side of a convex outline (4, 2), m; negative inside."""
    ahead = np.roll(outline, -1, axis=0) - outline
    turn = np.sign(ahead[0, 0] * ahead[1, 1] - ahead[0, 1] * ahead[1, 0])
    outward = turn * np.column_stack([ahead[:, 1], -ahead[:, 0]]) / np.hypot(*ahead.T)[:, None]
    return np.asarray(((points[:, None, :] - outline) * outward).sum(axis=-1).max(axis=1))
