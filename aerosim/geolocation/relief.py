"""An elevation model larger than memory: blocks in its own grid, least and greatest heights of tiles.

The raster is read once when opened, block by block, for the least and greatest height of every tile of 64 cells;
after that a block is read when a ray comes so near to its ground that these do not decide.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerosim import datum
from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.geolocation.compiled import entry
from aerosim.geolocation.gridmap import GridMap, applied
from aerosim.rasterfile import RasterFile, Values

if TYPE_CHECKING:
    from affine import Affine
    from pyproj import CRS

BLOCK = 512  # cells along a side of a block
TILE, SUBTILE = 64, 8
PER_BLOCK = BLOCK // TILE
SIDE, EDGE = BLOCK // SUBTILE, SUBTILE + 1  # subtiles along a block, posts along a subtile
BYTES = 4 * SIDE**2 * (EDGE**2 + 2)
MEMORY = 256_000_000
# The highest ground and the deepest trench, with room.
POSSIBLE = (-12_000.0, 10_000.0)


class Source(Protocol):
    """What a relief reads from."""

    def read_own(self, row: int, col: int, rows: int, cols: int) -> Values:
        """Heights, m, NaN where there are none."""


class _Held(NamedTuple):
    """An array as a source."""

    values: Values

    def read_own(self, row: int, col: int, rows: int, cols: int) -> Values:
        out = np.full((rows, cols), np.nan, np.float32)
        piece = self.values[max(row, 0) : row + rows, max(col, 0) : col + cols]
        out[: piece.shape[0], : piece.shape[1]] = piece
        return out


class Blocks(NamedTuple):
    """What the march reads.

    shape: rows, columns of posts.  low, high: m.  tiles: (2, n, m) least and greatest height of each 64 cells,
    inf and -inf where there is none; voids: (n, m) where cells are missing.  slots: (n, m) where a block is held,
    -1: nowhere.  posts: (slots, 64, 64, 9, 9) heights, m, by
    subtile with those on its edges, so that a ray stays in few lines of memory; subtiles: (slots, 2, 64, 64) of
    each 8 cells.
    """

    shape: tuple[int, int]
    low: float
    high: float
    tiles: Values
    voids: NDArray[np.bool_]
    slots: NDArray[np.int32]
    posts: Values
    subtiles: Values


class Relief:
    """Ellipsoidal heights of a raster, bilinear between the centres of its cells, in its own grid.

    grid: latitude and longitude to cells; blocks: what is held now; low, high: of all heights, m; datum: what the
    heights referred to.
    """

    def __init__(
        self,
        source: Source,
        crs: CRS,
        transform: Affine,
        shape: tuple[int, int],
        vertical: datum.VerticalDatum,
        memory: float = MEMORY,
    ) -> None:
        """crs: horizontal.  transform: of cell corners.  shape: rows, columns.  memory: bytes for blocks.

        Raises InputError: less than two cells a side, no heights, heights that no ground has, no map.
        """
        if min(shape) < 2:
            raise InputError(f"an elevation of {shape[0]} x {shape[1]} cells", allowed="2 or more each way")
        self._source, self._transform, self.shape, self.datum = source, transform, shape, vertical
        self.grid = GridMap.of(crs, transform, shape[1], shape[0])
        self._undulation = vertical if vertical.constant is None else None
        self._to_geodetic = _inverse(crs) if self._undulation else None
        down, across = (-(-(n - 1) // BLOCK) for n in shape)
        held = int(min(down * across, max(2, memory // BYTES)))
        self._owner = np.full(held, -1)
        self._used = np.zeros(held, np.int64)
        self._clock = 0
        self.blocks = Blocks(
            (int(shape[0]), int(shape[1])), np.inf, -np.inf,
            np.empty((2, down * PER_BLOCK, across * PER_BLOCK), np.float32),
            np.ones((down * PER_BLOCK, across * PER_BLOCK), np.bool_),
            np.full((down, across), -1, np.int32),
            np.empty((held, SIDE, SIDE, EDGE, EDGE), np.float32),
            np.empty((held, 2, SIDE, SIDE), np.float32),
        )  # fmt: skip
        for index in range(down * across):
            self._load(index)
        low, high = float(self.blocks.tiles[0].min()), float(self.blocks.tiles[1].max())
        if low > high:
            raise InputError("the elevation holds no height at all")
        if low < POSSIBLE[0] or high > POSSIBLE[1]:
            raise InputError(
                f"the elevation has heights from {low:.0f} to {high:.0f} m: a value for missing ground that the "
                "file does not name, or not metres",
                allowed=f"{POSSIBLE[0]:.0f} to {POSSIBLE[1]:.0f} m",
            )
        self.low, self.high = low, high
        self.blocks = self.blocks._replace(low=low, high=high)

    @classmethod
    def open(cls, path: Path | str, vertical_datum: str | float = "file", memory: float = MEMORY) -> Relief:
        """Relief of a file.  vertical_datum: "file", "ellipsoidal", "egm96", "egm2008", or an undulation, m.

        Raises InputError, with the file: no raster, several bands, heights whose datum is not known or whose geoid
        has no grid here.
        """
        file = RasterFile(path)
        if file.count != 1:
            raise InputError(f"elevation {path} has {file.count} bands", allowed="one, of heights")
        try:
            vertical = datum.resolve(vertical_datum, file)
        except InputError as error:
            raise InputError(error.problem, key="vertical_datum", allowed=error.allowed) from error
        try:
            return cls(file, file.horizontal, file.transform, (file.height, file.width), vertical, memory)
        except InputError as error:
            raise error.at(where=str(path)) from error

    @classmethod
    def of(cls, values: ArrayLike, transform: Affine, crs: CRS | str, memory: float = MEMORY) -> Relief:
        """Relief of an array of ellipsoidal heights (rows, columns), m, NaN for missing ones."""
        from pyproj import CRS

        heights = np.asarray(values, np.float32)
        vertical = datum.VerticalDatum("ellipsoidal", constant=0.0)
        return cls(_Held(heights), CRS.from_user_input(crs), transform, heights.shape, vertical, memory)

    def load(self, wanted: ArrayLike) -> None:
        """Hold blocks, the first ones if not all have room.  wanted: flat numbers in blocks.slots."""
        for index in np.asarray(wanted)[: len(self._owner)]:
            if self.blocks.slots.flat[index] < 0:
                self._load(int(index))
            self._used[self.blocks.slots.flat[index]] = self._clock
        self._clock += 1

    def _load(self, index: int) -> None:
        slot = int(np.argmin(self._used + np.where(self._owner < 0, -1, 0)))
        if self._owner[slot] >= 0:
            self.blocks.slots.flat[self._owner[slot]] = -1
        row, col = divmod(index, self.blocks.slots.shape[1])
        posts = self._source.read_own(row * BLOCK, col * BLOCK, BLOCK + 1, BLOCK + 1)
        i, j = row * PER_BLOCK, col * PER_BLOCK
        heights = self._ellipsoidal(posts, row * BLOCK, col * BLOCK)
        _pyramid(
            heights, self.blocks.posts[slot], self.blocks.subtiles[slot],
            self.blocks.tiles[:, i : i + PER_BLOCK, j : j + PER_BLOCK],
            self.blocks.voids[i : i + PER_BLOCK, j : j + PER_BLOCK],
        )  # fmt: skip
        self._owner[slot] = index
        self.blocks.slots.flat[index] = slot
        self._clock += 1
        self._used[slot] = self._clock

    def _ellipsoidal(self, posts: Values, row: int, col: int) -> Values:
        """A block of the source's heights above the ellipsoid."""
        if self._undulation is None:
            return posts + np.float32(self.datum.constant or 0.0)
        last = min(self.shape[0] - row, BLOCK + 1) - 1, min(self.shape[1] - col, BLOCK + 1) - 1
        y, x = (np.linspace(0.0, max(n, 1), _nodes(n, self._cell)) for n in last)
        place = applied(self._transform, *np.meshgrid(col + x + 0.5, row + y + 0.5))
        lon, lat = self._to_geodetic.transform(*place)  # type: ignore[union-attr]
        coarse = self._undulation.undulation(np.radians(lat), np.radians(lon))
        across = np.stack([np.interp(np.arange(BLOCK + 1), x, line) for line in coarse])
        down = np.arange(BLOCK + 1) / (y[1] - y[0])
        first = np.minimum(down.astype(int), len(y) - 2)
        part = np.clip(down - first, 0.0, 1.0)[:, None]
        lift = across[first] * (1.0 - part) + across[first + 1] * part
        return np.asarray(posts + lift, np.float32)

    @property
    def _cell(self) -> float:
        """Size of a cell, m, roughly."""
        t = self._transform
        size = max(abs(t.a) + abs(t.b), abs(t.d) + abs(t.e))
        return float(size * 111_320.0 if self.grid.geographic else size)

    def heights(self, lat: ArrayLike, lon: ArrayLike) -> Array:
        """Heights of the ground, m; NaN where it is not known.  lat, lon: rad, same shape."""
        x, y = self.grid.cells(np.asarray(lat, float), np.asarray(lon, float))
        out = np.full(x.shape, np.nan)
        inside = (x >= 0.0) & (x <= self.shape[1] - 1) & (y >= 0.0) & (y <= self.shape[0] - 1)
        where = np.full(x.shape, -1)
        i = np.minimum(y[inside].astype(int), self.shape[0] - 2) // BLOCK
        where[inside] = i * self.blocks.slots.shape[1] + (
            np.minimum(x[inside].astype(int), self.shape[1] - 2) // BLOCK
        )
        for index in np.unique(where[inside]):
            self.load([index])
            here = where == index
            row, col = divmod(int(index), self.blocks.slots.shape[1])
            posts = self.blocks.posts[self.blocks.slots.flat[index]]
            out[here] = _bilinear(posts, x[here] - col * BLOCK, y[here] - row * BLOCK)
        return out


def _inverse(crs: CRS) -> Any:
    from pyproj import Transformer

    return Transformer.from_crs(crs, "EPSG:4326", always_xy=True)


def _nodes(cells: int, size: float) -> int:
    """Nodes along a side at which the undulation is evaluated: a kilometre apart or a cell."""
    return max(2, min(cells, int(np.ceil(cells * size / datum.SPACING))) + 1)


def _bilinear(posts: Values, x: Array, y: Array) -> Array:
    """Heights within a block.  posts: (64, 64, 9, 9); x, y: (n,) cells from its first post."""
    (si, i), (sj, j) = (divmod(np.minimum(v.astype(int), BLOCK - 1), SUBTILE) for v in (y, x))
    x, y = x - SUBTILE * sj - j, y - SUBTILE * si - i
    top = posts[si, sj, i, j] * (1.0 - x) + posts[si, sj, i, j + 1] * x
    bottom = posts[si, sj, i + 1, j] * (1.0 - x) + posts[si, sj, i + 1, j + 1] * x
    return np.asarray(top * (1.0 - y) + bottom * y, float)


@entry
def _pyramid(
    block: Values, posts: Values, subtiles: Values, tiles: Values, voids: NDArray[np.bool_]
) -> None:  # pragma: no cover - compiled
    """Posts by subtile; least and greatest height of each tile with those on its edges, missing ones left out."""
    tiles[0] = np.inf
    tiles[1] = -np.inf
    voids[:] = False
    ratio = TILE // SUBTILE
    for i in range(SIDE):
        for j in range(SIDE):
            low, high, missing = np.float32(np.inf), np.float32(-np.inf), False
            for r in range(SUBTILE * i, SUBTILE * i + SUBTILE + 1):
                for c in range(SUBTILE * j, SUBTILE * j + SUBTILE + 1):
                    value = block[r, c]
                    posts[i, j, r - SUBTILE * i, c - SUBTILE * j] = value
                    if value == value:  # noqa: PLR0124  (not NaN)
                        low, high = min(low, value), max(high, value)
                    else:
                        missing = True
            subtiles[0, i, j], subtiles[1, i, j] = low, high
            tiles[0, i // ratio, j // ratio] = min(tiles[0, i // ratio, j // ratio], low)
            tiles[1, i // ratio, j // ratio] = max(tiles[1, i // ratio, j // ratio], high)
            voids[i // ratio, j // ratio] |= missing
