"""One georeferenced raster file: opened, checked, read in bounded pieces, never whole."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.frames import Array

if TYPE_CHECKING:
    from affine import Affine
    from pyproj import CRS

Values = NDArray[np.float32]

# A wheel's GDAL would take 5 % of the machine for its block cache.
CACHE_BYTES = 24_000_000
# Source pixels along a side that one read may touch where no overview is coarse enough.
MAX_SOURCE_SIDE = 8192
# Blocks looked at when a file is opened; of a larger one an even choice.
MAX_CHECKED_BLOCKS = 20_000
DATUM_TAG = "VERTICAL_DATUM"
DATUM_TAGS = {"ELLIPSOIDAL": "ellipsoidal", "EGM96": "EPSG:5773", "EGM2008": "EPSG:3855"}


class Cells(NamedTuple):
    """Piece of a raster in the working grid: values (rows, cols), NaN where there are none.

    x0, y0: easting and northing of the centre of value (0, 0), m; dx > 0, dy < 0: from centre to centre.
    """

    values: Values
    x0: float
    y0: float
    dx: float
    dy: float


def gdal_env() -> Any:
    """The context in which GDAL is called: small block cache, its messages to the log."""
    import rasterio

    return rasterio.Env(GDAL_CACHEMAX=CACHE_BYTES)


class RasterFile:
    """A raster file that GDAL reads, checked when opened.

    path; crs: pyproj CRS as written; horizontal: its two-dimensional part; vertical: "ellipsoidal", a vertical
    CRS or None where the file does not say; z_factor: metres per unit of the values; transform, width, height,
    count, dtype, nodata, bounds (left, bottom, right, top in the file's own CRS).
    """

    def __init__(self, path: Path | str) -> None:
        """path: file.  Raises InputError: missing, unreadable, truncated, without CRS or georeference."""
        self.path = Path(path)
        if not self.path.is_file():
            raise InputError(f"raster {self.path} does not exist")
        self._data = self._open(self.path)
        data = self._data
        self.transform: Affine = data.transform
        self.width, self.height, self.count = int(data.width), int(data.height), int(data.count)
        self.dtype, self.nodata = str(data.dtypes[0]), data.nodata
        t, w, h = self.transform, self.width, self.height
        x = [t.c, t.c + t.a * w, t.c + t.b * h, t.c + t.a * w + t.b * h]
        y = [t.f, t.f + t.d * w, t.f + t.e * h, t.f + t.d * w + t.e * h]
        self.bounds = (min(x), min(y), max(x), max(y))
        self._check_kind()
        self._check_complete()
        self.crs, self.horizontal = self._reference()
        self.vertical, self.z_factor = self._vertical()

    @staticmethod
    def _open(path: Path, **options: Any) -> Any:
        import rasterio
        from rasterio.errors import NotGeoreferencedWarning, RasterioError

        try:
            with gdal_env(), warnings.catch_warnings():
                warnings.simplefilter("ignore", NotGeoreferencedWarning)
                return rasterio.open(path, **options)
        except RasterioError as error:
            raise InputError(f"{path} cannot be read as a raster ({error})") from error

    def _check_kind(self) -> None:
        if self._data.crs is None:
            raise InputError(f"raster {self.path} has no CRS", allowed="a georeferenced file, such as a GeoTIFF")
        if self.transform.is_identity or self.transform.is_degenerate:
            raise InputError(f"raster {self.path} has a CRS but no position or pixel size")
        if "complex" in self.dtype:
            raise InputError(f"raster {self.path} holds complex numbers")
        if self._data.colorinterp[0].name == "palette":
            raise InputError(f"raster {self.path} holds palette indices", allowed="grey or RGB bands")

    def _check_complete(self) -> None:
        """A TIFF cut short opens without a murmur: see that its blocks lie within the file."""
        if self._data.driver != "GTiff":
            return
        levels = [(1, {}), *((f, {"ovr": i}) for i, f in enumerate(self._data.overviews(1)))]
        size, (rows, cols) = self.path.stat().st_size, self._data.block_shapes[0]
        for factor, level in levels:
            down, across = -(-self.height // (rows * factor)), -(-self.width // (cols * factor))
            step = max(1, down * across // MAX_CHECKED_BLOCKS)
            for index in {*range(0, down * across, step), down * across - 1}:
                name = f"{index % across}_{index // across}"
                offset = self._data.get_tag_item(f"BLOCK_OFFSET_{name}", "TIFF", bidx=1, **level)
                length = self._data.get_tag_item(f"BLOCK_SIZE_{name}", "TIFF", bidx=1, **level)
                if offset and length and int(offset) + int(length) > size:
                    raise InputError(f"raster {self.path} is truncated: it ends before its pixels do")

    def _reference(self) -> tuple[CRS, CRS]:
        from pyproj import CRS
        from pyproj.exceptions import CRSError

        try:
            crs = CRS.from_wkt(self._data.crs.to_wkt(version="WKT2_2019"))
            horizontal = crs.sub_crs_list[0] if crs.is_compound else crs.to_2d()
        except CRSError as error:
            raise InputError(f"the CRS of raster {self.path} is not understood ({error})") from error
        if not (horizontal.is_projected or horizontal.is_geographic):
            raise InputError(f"the CRS of raster {self.path} is neither a map's nor geographic")
        return crs, horizontal

    def _vertical(self) -> tuple[str | CRS | None, float]:
        from pyproj import CRS

        tag = str(self._data.tags().get(DATUM_TAG, "")).upper()
        if self.crs.is_compound:
            vertical = self.crs.sub_crs_list[1]
            return vertical, float(vertical.axis_info[0].unit_conversion_factor)
        unit = (self._data.units[0] or "m").lower()
        if unit not in ("m", "metre", "meter", "metres", "meters"):
            raise InputError(f"raster {self.path} has values in {unit!r}", allowed="metres")
        if tag in DATUM_TAGS:
            found = DATUM_TAGS[tag]
            return (found if found == "ellipsoidal" else CRS.from_user_input(found)), 1.0
        return ("ellipsoidal" if len(self.crs.axis_info) == 3 else None), 1.0

    def native_resolution(self, crs: CRS) -> float:
        """Pixel size in metres of the projected crs, at the middle: the geometric mean of both sides."""
        col, row = self.width / 2.0, self.height / 2.0
        e, n = self.place(crs, np.array([col, col + 1, col]), np.array([row, row, row + 1]))
        return float(np.sqrt(np.hypot(e[1] - e[0], n[1] - n[0]) * np.hypot(e[2] - e[0], n[2] - n[0])))

    def outline(self, crs: CRS) -> Array:
        """Corners through the centres of the outermost pixels, in crs, going round.  Returns (4, 2), m."""
        w, h = self.width - 0.5, self.height - 0.5
        return np.column_stack(self.place(crs, np.array([0.5, 0.5, w, w]), np.array([0.5, h, h, 0.5])))

    def place(self, crs: CRS | str, col: Array, row: Array) -> tuple[Array, Array]:
        """Where pixel corners lie in crs (x before y).  col, row: (n,), the file's corner is (0, 0)."""
        from pyproj import Transformer

        t = self.transform
        x, y = t.a * col + t.b * row + t.c, t.d * col + t.e * row + t.f
        found: tuple[Array, Array] = Transformer.from_crs(self.horizontal, crs, always_xy=True).transform(x, y)
        return found

    def _is_aligned(self, crs: CRS) -> bool:
        t = self.transform
        north_up = t.b == 0.0 and t.d == 0.0 and t.a > 0.0 and t.e < 0.0
        return bool(north_up and self.horizontal.equals(crs, ignore_axis_order=True))

    def cell_size(self, crs: CRS, resolution: float) -> float:
        """Size (m) of the cells that `read` gives for a wanted resolution (m)."""
        native = self.native_resolution(crs)
        if self._is_aligned(crs):
            return self._factor(resolution) * native
        # Twice as fine as the file: bilinear between the warped cells is then bilinear between its own.
        return max(resolution, native / 2.0)

    def _factor(self, resolution: float) -> int:
        return max(1, int(resolution / max(self.transform.a, -self.transform.e) * (1.0 + 1e-9)))

    def max_side(self, crs: CRS, resolution: float) -> float:
        """Longest side (m) that one read at that resolution (m) should have, lest it read too many pixels."""
        native = self.native_resolution(crs)
        coarsest = max(self._data.overviews(1), default=1)
        return MAX_SOURCE_SIDE * native * coarsest

    def colour_weights(self) -> dict[int, float]:
        """Bands and weights that make grey: one band, or the luma of ITU-R BT.601 of red, green and blue."""
        names = [c.name for c in self._data.colorinterp]
        colour = [b for b, name in enumerate(names, 1) if name != "alpha"]
        if len(colour) < 3:
            return {colour[0]: 1.0}
        named = [names.index(c) + 1 if c in names else 0 for c in ("red", "green", "blue")]
        bands = named if all(named) else colour[:3]
        return dict(zip(bands, (0.299, 0.587, 0.114), strict=True))

    def read(
        self,
        crs: CRS,
        bounds: tuple[float, float, float, float],
        resolution: float,
        weights: dict[int, float],
    ) -> Cells:
        """Weighted sum of bands over an area, averaged to about the resolution, never finer than the file.

        crs: projected, m.  bounds: e_min, n_min, e_max, n_max, m; the cells' centres enclose it.
        weights: of bands numbered from 1.  Raises InputError if the file cannot be read there.
        """
        from rasterio.errors import RasterioError

        try:
            with gdal_env():
                if self._is_aligned(crs):
                    return self._read_aligned(bounds, resolution, weights)
                return self._read_warped(crs, bounds, resolution, weights)
        except RasterioError as error:
            raise InputError(f"raster {self.path} cannot be read: damaged or truncated ({error})") from error

    def read_own(self, row: int, col: int, rows: int, cols: int) -> Values:
        """Values of the first band in the file's own grid, metres.

        row, col: of the first cell; NaN where there is none, also outside of the file.  Returns (rows, cols).
        Raises InputError if the file cannot be read there.
        """
        from rasterio.errors import RasterioError
        from rasterio.windows import Window as Piece

        values = np.full((rows, cols), np.nan, np.float32)
        r0, r1 = max(row, 0), min(row + rows, self.height)
        c0, c1 = max(col, 0), min(col + cols, self.width)
        if r1 > r0 and c1 > c0:
            piece = Piece(c0, r0, c1 - c0, r1 - r0)
            try:
                with gdal_env():
                    found = self._bands(self._data, {1: 1.0}, (r1 - r0, c1 - c0), window=piece)
            except RasterioError as error:
                raise InputError(f"raster {self.path} cannot be read: damaged or truncated ({error})") from error
            values[r0 - row : r1 - row, c0 - col : c1 - col] = found
        return values

    def _read_aligned(self, bounds: tuple[float, ...], resolution: float, weights: dict[int, float]) -> Cells:
        """Cells are blocks of k by k pixels counted from the corner, so that every read gives the same ones."""
        from rasterio.windows import Window as Piece

        t, k = self.transform, self._factor(resolution)
        dx, dy = k * t.a, k * t.e
        col, last_col = int(np.floor((bounds[0] - t.c) / dx - 0.5)), int(np.ceil((bounds[2] - t.c) / dx - 0.5))
        row, last_row = int(np.floor((bounds[3] - t.f) / dy - 0.5)), int(np.ceil((bounds[1] - t.f) / dy - 0.5))
        values = np.full((last_row - row + 1, last_col - col + 1), np.nan, np.float32)
        c0, c1 = max(col, 0), min(last_col + 1, self.width // k)
        r0, r1 = max(row, 0), min(last_row + 1, self.height // k)
        if c1 > c0 and r1 > r0:
            piece = Piece(c0 * k, r0 * k, (c1 - c0) * k, (r1 - r0) * k)
            target = values[r0 - row : r1 - row, c0 - col : c1 - col]
            target[:] = self._bands(self._data, weights, (r1 - r0, c1 - c0), window=piece)
        return Cells(values, t.c + (col + 0.5) * dx, t.f + (row + 0.5) * dy, dx, dy)

    def _read_warped(
        self, crs: CRS, bounds: tuple[float, ...], resolution: float, weights: dict[int, float]
    ) -> Cells:
        """Through GDAL's warper, from the coarsest overview that is fine enough."""
        import rasterio.crs as rasterio_crs
        from affine import Affine
        from rasterio.vrt import WarpedVRT
        from rasterio.warp import Resampling

        native, size = self.native_resolution(crs), self.cell_size(crs, resolution)
        west, north = np.floor(bounds[0] / size) - 1, np.ceil(bounds[3] / size) + 1
        cols, rows = (int(np.ceil(s / size)) + 3 for s in (bounds[2] - bounds[0], bounds[3] - bounds[1]))
        fitting = [i for i, f in enumerate(self._data.overviews(1)) if f * native <= size]
        source = self._open(self.path, OVERVIEW_LEVEL=fitting[-1]) if fitting else self._data
        options = {
            "src_crs": rasterio_crs.CRS.from_wkt(self.horizontal.to_wkt()),
            "crs": rasterio_crs.CRS.from_wkt(crs.to_wkt()),
            "transform": Affine(size, 0.0, west * size, 0.0, -size, north * size),
            "resampling": Resampling.average if size > 1.5 * native else Resampling.bilinear,
            "nodata": np.nan,
            "dtype": "float32",
        }
        with WarpedVRT(source, width=cols, height=rows, **options) as warped:
            values = self._bands(warped, weights, (rows, cols))
        if source is not self._data:
            source.close()
        return Cells(values, (west + 0.5) * size, (north - 0.5) * size, size, -size)

    def _bands(self, data: Any, weights: dict[int, float], shape: tuple[int, int], **where: Any) -> Values:
        from rasterio.warp import Resampling

        total = np.zeros(shape, np.float32)
        for band, weight in weights.items():
            read = data.read(
                band, out_shape=shape, resampling=Resampling.average, masked=True, out_dtype="float32", **where
            )
            scale, offset = self._data.scales[band - 1], self._data.offsets[band - 1]
            total += np.float32(weight * self.z_factor) * (
                read.filled(np.nan) * np.float32(scale) + np.float32(offset)
            )
        return total
