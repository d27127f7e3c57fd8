"""What the heights of an elevation raster refer to, and the way from there to the ellipsoid."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.frames import Array, MapGrid
from aerosim.raster import Window
from aerosim.rasterfile import RasterFile, Values

if TYPE_CHECKING:
    from pyproj import CRS

KEY = "terrain.vertical_datum"
ALLOWED = "file, ellipsoidal, egm96, egm2008, {undulation_m: x}"
GEOIDS = {"egm96": "EPSG:5773", "egm2008": "EPSG:3855"}
# The undulation is evaluated this far apart and bilinear between: global grids have posts 4.6 km apart or more.
SPACING = 1000.0


@dataclass(frozen=True)
class VerticalDatum:
    """Way from a raster's heights to ellipsoidal ones.

    name: for reports.  constant: undulation, m, or None where the transformer (of pyproj) gives it.
    """

    name: str
    constant: float | None = None
    transformer: Any = None

    def undulation(self, lat: ArrayLike, lon: ArrayLike) -> Array:
        """Height of the datum's surface above the ellipsoid, m.  lat, lon: rad, same shape.

        Raises InputError where the geoid's grid ends.
        """
        lat, lon = np.broadcast_arrays(np.asarray(lat, float), np.asarray(lon, float))
        if self.constant is not None:
            return np.full(lat.shape, self.constant)
        height = np.asarray(self.transformer.transform(np.degrees(lon), np.degrees(lat), np.zeros(lat.shape))[2])
        if not np.isfinite(height).all():
            raise InputError(f"the geoid grid of {self.name} does not cover the terrain", key=KEY, allowed=ALLOWED)
        return height

    def to_ellipsoid(self, window: Window, grid: MapGrid) -> Values:
        """Ellipsoidal heights (rows, cols) of a window of this datum's heights, in a map grid."""
        if self.constant is not None:
            return window.values + np.float32(self.constant)
        rows, cols = window.values.shape
        x = np.linspace(0.0, max(cols - 1, 1), int(np.ceil(cols * window.dx / SPACING)) + 1)
        y = np.linspace(0.0, max(rows - 1, 1), int(np.ceil(rows * -window.dy / SPACING)) + 1)
        easting, northing = np.meshgrid(window.x0 + x * window.dx, window.y0 + y * window.dy)
        coarse = self.undulation(*grid.to_geodetic(easting, northing))
        across = np.stack([np.interp(np.arange(cols), x, line) for line in coarse])
        weight = np.arange(rows) / y[1] if len(y) > 1 else np.zeros(rows)
        first = np.minimum(weight.astype(int), len(y) - 2)
        part = (weight - first)[:, None].astype(np.float32)
        low, high = across[first].astype(np.float32), across[first + 1].astype(np.float32)
        return np.asarray(window.values + low + part * (high - low), np.float32)


def resolve(spec: str | float, elevation: RasterFile) -> VerticalDatum:
    """The datum that a scenario asks for and a file allows.

    spec: "file", "ellipsoidal", "egm96", "egm2008", or a constant undulation in m.
    Raises InputError: the file does not say, it says something else, or PROJ has no grid of that geoid here.
    """
    said = elevation.vertical
    if not isinstance(spec, str):
        if not -120.0 <= spec <= 120.0:
            raise InputError(f"an undulation of {spec} m is impossible", key=KEY, allowed="-120 to 120 m")
        if spec != 0.0:
            _refuse_ellipsoidal(said, elevation)
        return VerticalDatum(f"constant undulation {spec:g} m", constant=float(spec))
    if spec == "file":
        return _of_file(said, elevation)
    if spec == "ellipsoidal":
        if said is not None and not isinstance(said, str):
            raise InputError(f"{elevation.path} says that its heights are {said.name!r}", key=KEY, allowed=ALLOWED)
        return VerticalDatum("ellipsoidal", constant=0.0)
    if spec not in GEOIDS:
        raise InputError(f"unknown vertical datum {spec!r}", key=KEY, allowed=ALLOWED)
    _refuse_ellipsoidal(said, elevation)
    return geoid(GEOIDS[spec])


def _refuse_ellipsoidal(said: str | CRS | None, elevation: RasterFile) -> None:
    """Raise InputError for heights that a geoid would lift once more."""
    if isinstance(said, str):
        raise InputError(
            f"{elevation.path} says that its heights are ellipsoidal", key=KEY, allowed="file or ellipsoidal"
        )


def _of_file(said: str | CRS | None, elevation: RasterFile) -> VerticalDatum:
    if said is None:
        raise InputError(
            f"{elevation.path} does not say what its heights refer to",
            key=KEY,
            allowed="ellipsoidal, egm96, egm2008, {undulation_m: x}",
        )
    if isinstance(said, str):
        return VerticalDatum("ellipsoidal", constant=0.0)
    return geoid(said)


def geoid(vertical: str | CRS) -> VerticalDatum:
    """Datum of a vertical CRS, through a grid that PROJ really has here, never through its ballpark.

    PROJ looks in its own folders, PROJ_DATA and pyproj's user folder; no network is used.
    Raises InputError that names the grid and the ways out.
    """
    from pyproj import CRS
    from pyproj.crs import CompoundCRS
    from pyproj.transformer import TransformerGroup

    crs = CRS.from_user_input(vertical)
    source = CompoundCRS("WGS 84 + " + crs.name, ["EPSG:4326", crs])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        group = TransformerGroup(source, "EPSG:4979", always_xy=True, allow_ballpark=False)
    for transformer in group.transformers:
        if _has_grid(transformer):
            return VerticalDatum(crs.name, transformer=transformer)
    grids = [g.short_name for op in group.unavailable_operations[:1] for g in op.grids]
    needs = f" (it needs {' and '.join(grids)})" if grids else ""
    other = "egm2008" if "EGM96" in crs.name else "egm96"
    raise InputError(
        f"heights refer to {crs.name!r} and PROJ has no grid here to make them ellipsoidal{needs}",
        key=KEY,
        allowed=f"install the grid into {_user_folder()} or a folder of PROJ_DATA, name {other} if its grid "
        "is there, or give the undulation as {undulation_m: x}",
    )


def _has_grid(transformer: Any) -> bool:
    steps = transformer.operations or (transformer,)
    grids = [grid for step in steps for grid in getattr(step, "grids", ())]
    return bool(grids) and all(grid.available for grid in grids)


def _user_folder() -> str:
    """pyproj's folder for a user's grids, with the home folder unsaid."""
    from pathlib import Path

    import pyproj

    folder = Path(pyproj.datadir.get_user_data_dir())  # type: ignore[attr-defined]
    return f"~/{folder.relative_to(Path.home())}" if folder.is_relative_to(Path.home()) else str(folder)
