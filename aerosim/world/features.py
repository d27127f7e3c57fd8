"""Land that is hard for the rows, painted into synthetic land: a lake, ploughed rows or stripes, a lattice."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.frames import Array, MapGrid
from aerosim.world.texture import GREY

KINDS = ("lake", "rows", "lattice")
WATER = 70.0  # grey
MIDDLE, SWING = 130.0, 60.0  # grey of a pattern
LAND = 112.0  # mean grey of the land around


@dataclass(frozen=True)
class Feature:
    """A square of special land, its sides along the map grid.  SI, rad.

    kind: lake: no contrast; rows: stripes, as of ploughed fields; lattice: two crossed sets of them.
    width: of the square; None: all of the land.  period: of the pattern.  course: along which the stripes run,
    from true north.  rest: share of the land's own contrast that is left over the pattern, 0 to 1.  centre:
    latitude, longitude; None: the middle of the flight.
    """

    kind: str
    width: float | None = None
    period: float = 68.0
    course: float = 0.0
    rest: float = 0.1
    centre: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"no feature {self.kind!r}", key="--feature", allowed=", ".join(KINDS))
        if self.width is not None and not 10.0 <= self.width <= 1e6:
            raise InputError(f"width of {self.width:g} m", key="--feature", allowed="10 to 1000000 m")
        if not 1.0 <= self.period <= 1e5:
            raise InputError(f"period of {self.period:g} m", key="--feature", allowed="1 to 100000 m")
        if not 0.0 <= self.rest <= 1.0:
            raise InputError(f"rest of {100.0 * self.rest:g} %", key="--feature", allowed="0 to 100 %")


class Placed(NamedTuple):
    """A feature on a map grid.  middle: easting, northing, m; along: unit vector of its stripes on the grid."""

    feature: Feature
    middle: Array
    along: Array


def placed(feature: Feature, grid: MapGrid, middle: tuple[float, float]) -> Placed:
    """A feature on a map grid.  middle: latitude and longitude (rad) where it lies if it says nothing itself."""
    lat, lon = feature.centre or middle
    step = 1e-5  # rad, 64 m
    places = np.array([
        grid.from_geodetic(lat, lon),
        grid.from_geodetic(
            lat + step * math.cos(feature.course), lon + step * math.sin(feature.course) / math.cos(lat)
        ),
    ]).reshape(2, 2)  # fmt: skip
    along = places[1] - places[0]
    return Placed(feature, places[0], along / np.hypot(*along))


def paint(grey: NDArray[np.uint8], west: float, north: float, pixel: float, features: tuple[Placed, ...]) -> None:
    """Paint features over grey values (rows, cols) whose upper left corner lies at west, north (m); in place."""
    x = west + (np.arange(grey.shape[1]) + 0.5) * pixel
    y = (north - (np.arange(grey.shape[0]) + 0.5) * pixel)[:, None]
    for feature, middle, along in features:
        e, n = x - middle[0], y - middle[1]
        half = math.inf if feature.width is None else 0.5 * feature.width
        inside = (np.abs(e) <= half) & (np.abs(n) <= half)
        if inside.any():
            value = _grey(feature, e, n, along, grey)
            grey[inside] = np.clip(np.rint(value[inside]), *GREY).astype(np.uint8)


def _grey(feature: Feature, e: Array, n: Array, along: Array, land: NDArray[np.uint8]) -> Array:
    """Grey values of a feature, (rows, cols).  e, n: m from its middle, (cols,) and (rows, 1)."""
    if feature.kind == "lake":
        return np.full(land.shape, WATER)
    wave = 2.0 * math.pi / feature.period
    pattern = np.sin(wave * (along[1] * e - along[0] * n))
    if feature.kind == "lattice":
        pattern = pattern * np.sin(wave * (along[0] * e + along[1] * n))
    return np.asarray(MIDDLE + SWING * (1.0 - feature.rest) * pattern + feature.rest * (land - LAND))
