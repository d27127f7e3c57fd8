"""Made land and scenarios for the tests of the planner, in UTM zone 16 north of 36 deg."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rasterio
from rasterio.transform import from_origin

from aerosim.flight.block import Ground
from aerosim.frames import Array, MapGrid, ecef_from_geodetic, geodetic_from_ecef, mat_ne
from aerosim.projection import Camera
from aerosim.world.terrain import Terrain

MIDDLE = np.radians([36.52, -87.0])
EAST, NORTH = 500_000.0, 4_041_800.0  # of the middle, nearly
CAMERA = Camera.of_frame(0.152, (0.230, 0.230), 12e-6)
Heights = Callable[[Array, Array], Array]


def write_land(
    folder: Path, heights: Heights, *, half_east: float = 30e3, half_north: float = 12e3, cell: float = 50.0
) -> Terrain:
    """Terrain files photo.tif and heights.tif.  heights: of easting and northing from the middle, m."""
    cols, rows = round(2 * half_east / cell), round(2 * half_north / cell)
    x = -half_east + cell * (np.arange(cols) + 0.5)
    y = half_north - cell * (np.arange(rows) + 0.5)
    ground = np.broadcast_to(heights(*np.meshgrid(x, y)), (rows, cols)).astype(np.float32)
    grey = np.random.default_rng(1).integers(50, 200, ground.shape).astype(np.uint8)
    place = from_origin(EAST - half_east, NORTH + half_north, cell, cell)
    for name, values in (("heights", ground), ("photo", grey)):
        profile: dict[str, Any] = {"driver": "GTiff", "count": 1, "dtype": values.dtype, "crs": "EPSG:32616"}
        with rasterio.open(
            folder / f"{name}.tif", "w", width=cols, height=rows, transform=place, **profile
        ) as file:
            file.write(values, 1)
    return Terrain.open(folder / "photo.tif", folder / "heights.tif", "ellipsoidal")


def ground_of(terrain: Terrain) -> Ground:
    return Ground(terrain.grid, terrain.elevation, terrain.elevation_file.native_resolution(terrain.grid.crs))


def place(east: float, north: float) -> tuple[float, float]:
    """Latitude and longitude (rad) of a point east and north of the middle, m, by the tangent plane."""
    level = np.array([north, east, 0.0]) @ mat_ne(*MIDDLE)
    lat, lon, _ = geodetic_from_ecef(ecef_from_geodetic(*MIDDLE, 0.0) + level)
    return float(lat), float(lon)


def rectangle(east: float, north: float, turned_deg: float = 0.0) -> Array:
    """Corners (4, 2), rad, of a rectangle around the middle, m, turned clockwise."""
    s, c = np.sin(np.radians(turned_deg)), np.cos(np.radians(turned_deg))
    corners = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
    turned = [(c * a * east + s * b * north, -s * a * east + c * b * north) for a, b in corners]
    return np.array([place(*each) for each in turned])


def utm() -> MapGrid:
    return MapGrid("EPSG:32616")
