"""Makes the terrain that ships: real relief, and an orthophoto made on top of it.  See README.md here."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import drainage
import landscape
import numpy as np
import roads
from numpy.typing import NDArray
from scipy import ndimage

Array = NDArray[np.float64]
CRS = "EPSG:32616"
# West, south, east, north, m.  The relief's own bounds are the wider ones, where water is gathered.
AREA = (731_800.0, 4_039_500.0, 761_300.0, 4_052_500.0)
BASIN = (731_700.0, 4_037_800.0, 761_400.0, 4_068_300.0)
PHOTO_PIXEL, HEIGHT_CELL, BASIN_CELL = 5.0, 25.0, 50.0
POSTS_PER_DEGREE = 1200.0


class Relief:
    """SRTM as it comes with matplotlib: 3 arc-seconds, EGM96 heights in whole metres."""

    def __init__(self) -> None:
        from matplotlib.cbook import get_sample_data
        from pyproj import Transformer

        with np.load(str(get_sample_data("jacksboro_fault_dem.npz", asfileobj=False))) as data:
            self._height = data["elevation"].astype(float)
            self._west, self._north = float(data["xmin"]), float(data["ymin"])
        self._to_geographic = Transformer.from_crs(CRS, "EPSG:4326", always_xy=True)

    def require(self, lon: Array, lat: Array) -> None:
        """Ends the program if points (deg) lie outside of the relief."""
        row, col = (self._north - lat) * POSTS_PER_DEGREE - 0.5, (lon - self._west) * POSTS_PER_DEGREE - 0.5
        for place, size in ((row, self._height.shape[0]), (col, self._height.shape[1])):
            if place.min() < 0 or place.max() > size - 1:
                raise SystemExit(f"the area leaves the relief: {place.min():.2f} to {place.max():.2f} of {size}")

    def heights(self, area: tuple[float, float, float, float], cell: float) -> tuple[Array, Array, Array]:
        """EGM96 heights at the centres of an area's cells, cubic, and their longitude and latitude (deg).

        Beyond the relief's rim (of which the basin has slivers) the heights of the rim.
        """
        west, south, east, north = area
        e, n = np.meshgrid(np.arange(west + cell / 2, east, cell), np.arange(north - cell / 2, south, -cell))
        lon, lat = self._to_geographic.transform(e, n)
        # The file's bounds are outer edges of its cells.
        row, col = (self._north - lat) * POSTS_PER_DEGREE - 0.5, (lon - self._west) * POSTS_PER_DEGREE - 0.5
        height = ndimage.map_coordinates(self._height, [row, col], order=3, mode="nearest")
        return height, lon, lat


def undulation(grid: Path | None, lon: Array, lat: Array) -> Array:
    """EGM96 undulation, m, from a folder with the geoid's grid, or an installed one."""
    from pyproj import Transformer, datadir

    if grid is not None:
        datadir.append_data_dir(str(grid))
    geoid = Transformer.from_crs(
        "EPSG:4326+5773", "EPSG:4979", always_xy=True, only_best=True, allow_ballpark=False
    )
    found: Array = geoid.transform(lon, lat, np.zeros(lon.shape), errcheck=True)[2]
    return found


def make_land(relief: Relief) -> landscape.Land:
    """Everything the picture is painted from."""
    basin, _, _ = relief.heights(BASIN, BASIN_CELL)
    smooth = ndimage.gaussian_filter(basin, 0.8)
    order, target = drainage.flow_order(smooth)
    area = drainage.accumulate(order, target)
    above = _above_channel(smooth, order, target, area)
    wide = (AREA[0] - 100, AREA[1] - 100, AREA[2] + 100, AREA[3] + 100)
    coarse = ndimage.gaussian_filter(relief.heights(wide, HEIGHT_CELL)[0], 0.9)
    shape = int((AREA[3] - AREA[1]) / PHOTO_PIXEL), int((AREA[2] - AREA[0]) / PHOTO_PIXEL)
    height = _refine(coarse, shape, (wide[0], wide[3]), HEIGHT_CELL)
    hand = _refine(ndimage.gaussian_filter(above, 1.0), shape, (BASIN[0], BASIN[3]), BASIN_CELL)
    lines = drainage.channels(order, target, area, basin.shape[1], 16.0)
    slope = np.hypot(*np.gradient(smooth, BASIN_CELL))
    streams = [(_to_photo(p), _stream_width(p, a, slope)) for p, a in lines]
    ways, tracks, houses = _settle(smooth, above)
    return landscape.Land(PHOTO_PIXEL, height, hand, _bend(streams), ways, tracks, _powerlines(), houses)


def _stream_width(points: Array, area: Array, slope: Array) -> Array:
    """Width of the water, m; 0 for rills on flat ground, whose course the filled basins invent."""
    row, col = points.astype(int).T
    width = np.clip(1.1 * (area * BASIN_CELL**2 / 1e6) ** 0.62, 1.2, 42.0)
    return np.where((area < 300.0) & (slope[row, col] < 0.06), 0.0, width)


def _above_channel(height: Array, order: NDArray[np.int64], target: NDArray[np.int64], area: Array) -> Array:
    """Height of each cell above the channel that it drains to."""
    base, flat = height.ravel().copy(), height.ravel()
    for cell in order:
        if target[cell] >= 0 and area[cell] < 160.0:
            base[cell] = base[target[cell]]
    return np.maximum(flat - base, 0.0).reshape(height.shape)


def _refine(
    coarse: Array, shape: tuple[int, int], corner: tuple[float, float], cell: float
) -> NDArray[np.float32]:
    """A coarse grid at the orthophoto's pixels, cubic.  corner: west, north of the coarse grid, m."""
    row = (corner[1] - (AREA[3] - (np.arange(shape[0]) + 0.5) * PHOTO_PIXEL)) / cell - 0.5
    col = (AREA[0] + (np.arange(shape[1]) + 0.5) * PHOTO_PIXEL - corner[0]) / cell - 0.5
    place = np.meshgrid(row, col, indexing="ij")
    return np.asarray(
        ndimage.map_coordinates(coarse.astype(np.float32), place, order=3, mode="nearest"), np.float32
    )


def _to_photo(points: Array) -> Array:
    """Row and column of the basin's grid as those of the orthophoto."""
    east = BASIN[0] + (points[:, 1] + 0.5) * BASIN_CELL
    north = BASIN[3] - (points[:, 0] + 0.5) * BASIN_CELL
    return np.column_stack([(AREA[3] - north) / PHOTO_PIXEL - 0.5, (east - AREA[0]) / PHOTO_PIXEL - 0.5])


def _bend(lines: list[landscape.Line]) -> list[landscape.Line]:
    """Lines finer, and a little crooked, as water is."""
    rng = np.random.default_rng(3)
    found = []
    for points, width in lines:
        if len(points) < 3:
            found.append((points, width))
            continue
        place = np.linspace(0, len(points) - 1, 6 * len(points))
        fine = np.stack([np.interp(place, np.arange(len(points)), points[:, k]) for k in range(2)], axis=-1)
        wide = np.interp(place, np.arange(len(points)), width)
        aside = ndimage.gaussian_filter1d(rng.standard_normal(fine.shape), 6.0, axis=0) * 9.0
        found.append((fine + aside * np.minimum(1.0, 0.4 + wide[:, None] / 12.0), wide))
    return found


def _settle(height: Array, above: Array) -> tuple[list[landscape.Line], list[landscape.Line], Array]:
    """Roads between places in the valleys, tracks to remote spots, houses along the roads."""
    rng = np.random.default_rng(4)
    wet = 1.0 + 1.5 * np.exp(-above / 2.0) + 0.25 * np.abs(rng.standard_normal(height.shape))
    graph = roads.cost_graph(height, BASIN_CELL, wet)
    cols = height.shape[1]
    slope = np.hypot(*np.gradient(ndimage.gaussian_filter(height, 1.0), BASIN_CELL))
    top = int((BASIN[3] - AREA[3]) / BASIN_CELL)
    calm = np.flatnonzero((slope.ravel() < 0.05) & (above.ravel() < 60.0) & (np.arange(height.size) // cols > top))
    high = np.flatnonzero((slope.ravel() < 0.5) & (above.ravel() > 40.0) & (np.arange(height.size) // cols > top))
    main = roads.network(graph, cols, rng.choice(calm, 26, replace=False), 1.4)
    side = roads.network(graph, cols, np.r_[[_flat(main[0][0], cols)], rng.choice(calm, 70, replace=False)], 1.0)
    remote = roads.network(graph, cols, np.r_[[_flat(main[0][0], cols)], rng.choice(high, 60, replace=False)], 0.8)
    ways = [(_to_photo(p), np.full(len(p), 14.0)) for p in main] + [
        (_to_photo(p), np.full(len(p), 7.5)) for p in side
    ]
    tracks = [(_to_photo(p), np.full(len(p), 5.0)) for p in remote]
    return ways, tracks, _houses(rng, [w[0] for w in ways])


def _flat(point: Array, cols: int) -> int:
    return int(round(point[0]) * cols + round(point[1]))


def _houses(rng: np.random.Generator, lines: list[Array]) -> Array:
    """Houses beside the roads, crowded at their ends."""
    found = []
    for points in lines:
        for k, at in enumerate(points):
            near_end = np.exp(-min(k, len(points) - 1 - k) / 6.0)
            count = rng.poisson(0.35 + 3.0 * near_end)
            found.append(at + rng.normal(0.0, 7.0 + 12.0 * near_end, (count, 2)))
    return np.concatenate(found)


def _powerlines() -> list[landscape.Line]:
    """Two lines straight across the land, row and column."""
    corners = ([(300, -50), (760, 1900), (640, 4100), (1300, 5950)], [(-50, 5150), (1200, 4700), (2650, 4950)])
    return [(np.array(c, float), np.full(len(c), 38.0)) for c in corners]


def write(path: Path, bands: NDArray[Any], cell: float, tags: dict[str, str], **options: Any) -> None:
    """Writes a GeoTIFF of the area.  bands: (count, rows, cols)."""
    import rasterio

    transform = rasterio.transform.from_origin(AREA[0], AREA[3], cell, cell)
    count, rows, cols = bands.shape
    with rasterio.open(
        path, "w", driver="GTiff", crs=CRS, transform=transform, count=count, height=rows, width=cols,
        dtype=bands.dtype, tiled=True, blockxsize=256, blockysize=256, **options,
    ) as file:  # fmt: skip
        file.write(bands)
        file.update_tags(**tags)


def write_photo(path: Path, picture: NDArray[np.uint8], quality: int) -> None:
    """Writes the orthophoto with overviews."""
    import rasterio
    from rasterio.enums import Resampling

    tags = {"TIFFTAG_IMAGEDESCRIPTION": "Synthetic orthophoto on real relief (SRTM); see README.md"}
    write(path, np.moveaxis(picture, -1, 0), PHOTO_PIXEL, tags, compress="jpeg", photometric="ycbcr",
          interleave="pixel", jpeg_quality=quality)  # fmt: skip
    with (
        rasterio.Env(COMPRESS_OVERVIEW="JPEG", PHOTOMETRIC_OVERVIEW="YCBCR", JPEG_QUALITY_OVERVIEW=quality),
        rasterio.open(path, "r+") as file,
    ):
        file.build_overviews([2, 4, 8, 16], Resampling.average)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--geoid", type=Path, help="folder with egm96_15.gtx or us_nga_egm96_15.tif")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "pine_mountain", help="folder")
    parser.add_argument("--quality", type=int, default=80, help="of JPEG")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    relief = Relief()
    height, lon, lat = relief.heights(AREA, HEIGHT_CELL)
    relief.require(lon, lat)
    ellipsoidal = np.round(height + undulation(options.geoid, lon, lat), 1).astype(np.float32)
    tags = {
        "VERTICAL_DATUM": "ellipsoidal",
        "TIFFTAG_IMAGEDESCRIPTION": "SRTM, heights above the WGS 84 ellipsoid, m",
    }
    write(
        options.out / "elevation.tif",
        ellipsoidal[None],
        HEIGHT_CELL,
        tags,
        compress="deflate",
        predictor=3,
        zlevel=9,
    )
    write_photo(options.out / "orthophoto.tif", landscape.paint(make_land(relief)), options.quality)


if __name__ == "__main__":
    main()
