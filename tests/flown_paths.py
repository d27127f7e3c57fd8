"""Flown paths in closed form, and files of them as trajectories come."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from aerosim.frames import Array, ecef_from_geodetic, geodetic_from_ecef, mat_ne
from aerosim.truth import AirState, Where

PLACE = (math.radians(47.0), math.radians(11.0))


class Track(NamedTuple):
    """Times, geodetic places (rad, m), velocity over ground in n."""

    t: Array
    lat: Array
    lon: Array
    height: Array
    vel_n: Array


def on_plane(t: Array, north: Array, east: Array, up: Array, place: tuple[float, float] = PLACE) -> Track:
    """A path drawn on the tangent plane at a place, its velocity by fine differences of the ECEF position."""
    mat = mat_ne(*place)
    pos_e = ecef_from_geodetic(*place, 0.0) + np.stack([north, east, -up], axis=-1) @ mat
    vel_e = np.gradient(pos_e, t, axis=0, edge_order=2)
    lat, lon, height = geodetic_from_ecef(pos_e)
    vel_n = np.stack([mat_ne(a, b) @ v for a, b, v in zip(lat, lon, vel_e, strict=True)])
    return Track(t, lat, lon, height, vel_n)


def race_track(rate: float = 100.0, speed: float = 60.0, leg: float = 6000.0, radius: float = 1200.0) -> Track:
    """North for a leg, half a circle to the right, back south: rolled into at once.  rate: points a second."""
    s = np.arange(0.0, 2.0 * leg + math.pi * radius, speed / rate)
    turn = np.clip((s - leg) / radius, 0.0, math.pi)
    north = np.minimum(s, leg) + radius * np.sin(turn) - np.maximum(s - leg - math.pi * radius, 0.0)
    return on_plane(s / speed, north, radius * (1.0 - np.cos(turn)), np.full_like(s, 1500.0))


def write_csv(path: Path, columns: dict[str, Array], formats: dict[str, str] | None = None) -> Path:
    """A CSV file of columns, 12 digits or as `formats` says."""
    formats = formats or {}
    lines = [",".join(columns)]
    lines += [
        ",".join(format(value, formats.get(name, ".12g")) for name, value in zip(columns, row, strict=True))
        for row in zip(*columns.values(), strict=True)
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def columns_of(track: Track, every: int = 1) -> dict[str, Array]:
    """The columns that every trajectory has."""
    part = slice(None, None, every)
    return {
        "t_s": track.t[part],
        "latitude_deg": np.degrees(track.lat[part]),
        "longitude_deg": np.degrees(track.lon[part]),
        "height_m": track.height[part],
    }


class SteadyAir:
    """The same air everywhere, and whether it was asked in rising order."""

    def __init__(
        self, north: float = 0.0, east: float = 0.0, gust: tuple[float, float, float] = (0, 0, 0)
    ) -> None:
        self.state = AirState(north, east, 0.0, *map(float, gust), 0.0, 0.0, 0.0)
        self.asked: list[int] = []

    def at(self, index: int, where: Where) -> AirState:
        self.asked.append(index)
        return self.state
