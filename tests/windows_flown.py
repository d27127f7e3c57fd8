"""Pieces of land overflown by the real rows and their recogniser: how many strips are accepted and right."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerosim.estimation.strips import StripParameters, StripRecogniser
from aerosim.frames import Array, LocalMap, mat_from_attitude
from aerosim.sensing.ccd_rows import CcdRows, RowParameters
from aerosim.signals import MountReading, Reason, StripMatch
from aerosim.truth import CameraPose
from aerosim.world.ground import GroundView
from aerosim.world.terrain import Terrain

SPEED = 69.44
FOCAL, SPACING, PIXELS, SHIFT = 132.6, 39.7, 96, 7
SEARCH = (0.6, 1.6)
RIGHT_DEG = 0.5
RADIUS = 6.37e6


class Piece(NamedTuple):
    """A piece of land.  lat, lon: its middle, rad; course: rad; ground: mean height there, m."""

    lat: float
    lon: float
    course: float
    ground: float


class Way(NamedTuple):
    """How it is overflown.

    agl: m; noise: of the rows, grey; level: the relief is taken away; strips, step: number of strips and way
    between them, m; period: between exposures, s; jitter: roll, pitch, yaw rms, deg.
    """

    agl: float = 3000.0
    noise: float = 1.5
    level: bool = False
    strips: int = 10
    step: float = 40.0
    period: float = 0.05
    jitter: float = 0.03

    @property
    def along(self) -> Array:
        """Where the strips lie, (strips,), m from the middle of the piece."""
        return self.step * (np.arange(self.strips) - 0.5 * (self.strips - 1))


def pieces(terrain: Terrain, count: int, agl: float, seed: int) -> list[Piece]:
    """Places and courses at random, with all that the rows see of them on the terrain."""
    rng = np.random.default_rng(seed)
    room = agl / FOCAL * (0.5 * PIXELS + SHIFT + 1.8 * SPACING) + 300.0
    west, south, east, north = terrain.bounds
    low, high = np.array([west, south]) + room, np.array([east, north]) - room
    places = low + rng.uniform(size=(count, 2)) * (high - low)
    lat, lon = terrain.grid.to_geodetic(places[:, 0], places[:, 1])
    ground = [terrain.mean_height([e - 50.0, e + 50.0], [n, n], 0.35 * agl).mean for e, n in places]
    courses = rng.uniform(0.0, 2.0 * np.pi, count)
    return [Piece(*map(float, each)) for each in zip(lat, lon, courses, ground, strict=True)]


def view_of(terrain: Terrain, over: list[Piece], agl: float) -> tuple[GroundView, LocalMap]:
    """The land as the rows meet it, and the map grid around it."""
    local = terrain.grid.local(*np.array([each[:2] for each in over]).T)
    return GroundView(terrain, local, agl / FOCAL), local


def share_locked(piece: Piece, view: GroundView, way: Way, seed: int) -> float:
    """Share of the strips over a piece that are accepted and right within 0.5 deg."""
    rng = np.random.default_rng(seed)
    # up to a pixel of shift
    drift = float(np.arctan(rng.uniform(-1.0, 1.0) / SPACING))
    planned = SPACING / (FOCAL * way.period * SPEED / way.agl)
    every = max(1, round(way.step / SPEED / way.period))
    rows = CcdRows(
        RowParameters(PIXELS, SHIFT, SPACING, FOCAL, 1.0, 1.0, None, way.noise, 0.0, 8),
        piece.ground,
        np.random.default_rng(seed + 1),
    )
    matcher = StripRecogniser(
        StripParameters(PIXELS, SHIFT, SPACING, planned, SEARCH, every, True, True, padded=False)
    )
    last = (way.strips - 1) * every
    attitude = np.radians(way.jitter) * _wander(rng, last + int(np.ceil(SEARCH[1] * planned)) + 2, way.period)
    good = 0
    for k, angles in enumerate(attitude):
        # row I, which looks ahead, passes the middle of the piece in the middle of the strips
        along = (k - 0.5 * last) * SPEED * way.period - 0.5 * SPACING / FOCAL * way.agl
        pose = _pose(piece, along, k * way.period, way.agl, angles, drift)
        spot = view.around(pose.lat, pose.lon, rows.reach(pose.height))
        if way.level:
            spot = spot._replace(relief=np.full_like(spot.relief, piece.ground))
        opens = matcher.opens() and k <= last
        if opens:
            rows.new_cycle()
        for match in matcher.add(rows.expose(pose, spot, opens), MountReading(pose.t, 0.0)):
            right = abs(_off(match, drift, attitude)) < np.radians(RIGHT_DEG)
            good += match.strip < way.strips and match.reason is Reason.ACCEPTED and right
    return good / way.strips


def _pose(piece: Piece, along: float, t: float, agl: float, angles: Array, drift: float) -> CameraPose:
    """Straight and level over the piece; the camera points `drift` to the left of the track, and shakes."""
    lat = piece.lat + along * np.cos(piece.course) / RADIUS
    lon = piece.lon + along * np.sin(piece.course) / (RADIUS * np.cos(piece.lat))
    velocity = SPEED * np.array([np.cos(piece.course), np.sin(piece.course), 0.0])
    roll, pitch, yaw = (float(each) for each in angles)
    mat = mat_from_attitude(piece.course - drift + yaw, pitch, roll)
    return CameraPose(t, float(lat), float(lon), piece.ground + agl, velocity, mat, np.zeros(3))


def _off(match: StripMatch, drift: float, attitude: Array) -> float:
    """How far a strip's angle is off, rad; roll and yaw at both its ends are known."""
    if not np.isfinite(match.n):
        return np.nan
    first, second = attitude[match.number1], attitude[min(round(match.number1 + match.n), len(attitude) - 1)]
    # d tan(drift) + f (roll 1 - roll 2), the latter averaged over the row: 4.4 % more
    expected = SPACING * np.tan(drift - 0.5 * (first[2] + second[2])) + 1.044 * FOCAL * (first[0] - second[0])
    return float((match.mu - expected) / SPACING)


def _wander(rng: np.random.Generator, count: int, period: float) -> Array:
    """Three processes of unit variance with a correlation time of a second, (count, 3)."""
    keep = np.exp(-period / 1.0)
    steps = rng.standard_normal((count, 3)) * np.sqrt(1.0 - keep * keep)
    steps[0] /= np.sqrt(1.0 - keep * keep)
    for k in range(1, count):
        steps[k] += keep * steps[k - 1]
    return steps
