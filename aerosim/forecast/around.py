"""Where land is wanted: around a trajectory, around lines or an area, around a point."""

from __future__ import annotations

import csv
from math import radians
from pathlib import Path
from typing import NamedTuple

import numpy as np

from aerosim.errors import InputError
from aerosim.frames import Array

KEY = "--around"
EVERY_S = 5.0


class Around(NamedTuple):
    """Ways over the land: latitudes and longitudes (n,), rad, of each.

    height: of the flight along them, ellipsoidal, m, where it is known.
    """

    ways: list[tuple[Array, Array]]
    height: float | None


def around(text: str) -> Around:
    """Ways of a trajectory file, of a file with lines or areas, or the one point "latitude,longitude" in deg.

    Raises InputError.
    """
    path = Path(text)
    if not path.exists():
        return Around([_point(text)], None)
    if path.suffix.lower() in (".parquet", ".pq") or (path.suffix.lower() == ".csv" and _has_time(path)):
        return _trajectory(path)
    from aerosim.formats.files import read

    ways = []
    for feature in read(path):
        points = np.array([*feature.points, *(feature.points[:1] if feature.kind == "area" else ())])
        ways.append((points[:, 0], points[:, 1]))
    return Around(ways, None)


def _point(text: str) -> tuple[Array, Array]:
    try:
        lat, lon = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(
            f"no file {text!r}", key=KEY, allowed="a trajectory, a file of lines, or latitude,longitude"
        ) from None
    if not (abs(lat) <= 84.0 and abs(lon) <= 360.0):
        raise InputError(f"latitude {lat:g}, longitude {lon:g}", key=KEY, allowed="latitude -84 to 84")
    return np.array([radians(lat)]), np.array([radians(lon)])


def _has_time(path: Path) -> bool:
    """Whether a CSV file is a trajectory: it says when."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            names = next(csv.reader(stream), [])
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError("is no text file", where=str(path)) from error
    return any(name.strip() in ("t_s", "time_utc") for name in names)


def _trajectory(path: Path) -> Around:
    from aerosim.flight.replay.smooth_path import smooth_path
    from aerosim.flight.replay.trajectory import read_trajectory
    from aerosim.flight.replay.trajectory_pieces import flown_pieces

    points = read_trajectory(path, undulation=lambda lat, lon: np.zeros_like(lat))
    pieces, _ = flown_pieces(points, gap_max=120.0)
    ways = []
    for piece in pieces:
        at = np.append(np.arange(piece.t[0], piece.t[-1], EVERY_S), piece.t[-1])
        lat, lon, _ = smooth_path(piece).place(at)
        ways.append((lat, lon))
    return Around(ways, float(np.median(np.concatenate([piece.height for piece in pieces]))))
