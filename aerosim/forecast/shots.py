"""The photos that a plan will take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.forecast.land import Land
from aerosim.frames import Array
from aerosim.raster import EARTH_RADIUS, sample


class Shots(NamedTuple):
    """Planned photos, level, in the order taken.

    place: (n, 2) east, north on the plane, m; heading: (n,), of the camera on the plane from north to east, rad;
    line: (n,), index; ground: (n,), height of the ground below, m, NaN if unknown.
    """

    place: Array
    heading: Array
    line: NDArray[np.int64]
    ground: Array


def planned(land: Land, counts: Sequence[int], bases: Sequence[float], crabs: Sequence[float]) -> Shots:
    """Photos of all lines.

    counts: photos of each line; bases: way between two at flying height, m; crabs: track less camera heading, rad.
    """
    place, heading, line = [], [], []
    for index, track in enumerate(land.tracks):
        along = np.arange(counts[index]) * bases[index] / (1.0 + land.height / EARTH_RADIUS)
        place.append(track.start + along[:, None] * track.ahead)
        heading.append(np.full(len(along), math.atan2(track.ahead[0], track.ahead[1]) - crabs[index]))
        line.append(np.full(len(along), index, np.int64))
    places = np.concatenate(place)
    ground = sample(land.relief, places[:, 0], places[:, 1])
    return Shots(places, np.concatenate(heading), np.concatenate(line), ground)


def corners(land: Land, shots: Shots) -> Array:
    """Footprints on the level of the ground below each photo: (n, 4, 2) east, north on the plane, m.

    Front left, front right, rear right, rear left.
    """
    known = shots.ground[np.isfinite(shots.ground)]
    ground = np.where(np.isfinite(shots.ground), shots.ground, known.mean() if len(known) else 0.0)
    size = (land.height - ground) / (1.0 + ground / EARTH_RADIUS)
    sin, cos = np.sin(shots.heading), np.cos(shots.heading)
    ahead, right = np.stack([sin, cos], axis=-1), np.stack([cos, -sin], axis=-1)
    along, across = 0.5 * land.lens_along * size[:, None], 0.5 * land.lens_across * size[:, None]
    signs = ((1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0))
    return np.asarray(
        shots.place[:, None] + np.stack([a * along * ahead + b * across * right for a, b in signs], axis=1)
    )
