"""Turns in the wind: the shortest arc - straight - arc through moving air onto a line."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from aerosim.errors import InputError
from aerosim.frames import GRAVITY, Array

ROLL_RATE = math.radians(5.0)
# Time by which the roll follows its command under an autopilot.
ROLL_RESPONSE = 0.6
TURN = 2.0 * math.pi


def turn_radius(airspeed: float, bank: float) -> float:
    """Radius of a steady turn through the air, m.  airspeed: m/s, bank: rad."""
    return airspeed**2 / (GRAVITY * math.tan(bank))


def roll_lag(bank: float) -> float:
    """Time by which a turn rolled into at the usual rate lags one that banks at once, s."""
    return bank / (2.0 * ROLL_RATE) + ROLL_RESPONSE


# Between the divergence of a base turn and the first turn of a 45/180 procedure turn (ICAO Doc 8168).
TEARDROP_LEAD = math.radians(45.0)
TURN_BACK = math.radians(90.0)


class Shape(StrEnum):
    """What the trade calls a turn.

    race_track: both arcs to the same side.  Else the lesser arc leads out to the other side, and the greater one
    turns back: teardrop with less than 45 deg of lead, procedure from there on.  s_turn: none turns back by more
    than 90 deg, as between lines in the same direction.
    """

    RACE_TRACK = "race_track"
    PROCEDURE = "procedure"
    TEARDROP = "teardrop"
    S_TURN = "s_turn"


class Turn(NamedTuple):
    """A turn onto a line, in the line's frame (x along it, y to its right), through the air.

    first, last: +1 right, -1 left.  angle_first, angle_last: of the arcs, rad.  straight: heading between them
    against the line's course, rad.  straight_s: its duration.  heading_end: against the course, on the line.
    duration: s, roll-in and roll-out included.
    """

    first: int
    angle_first: float
    straight: float
    straight_s: float
    last: int
    angle_last: float
    heading_end: float
    duration: float

    @property
    def shape(self) -> Shape:
        """Name of the turn, see Shape."""
        if self.first == self.last:
            return Shape.RACE_TRACK
        lead, back = sorted((self.angle_first, self.angle_last))
        if back <= TURN_BACK:
            return Shape.S_TURN
        return Shape.TEARDROP if lead < TEARDROP_LEAD else Shape.PROCEDURE


class _Word(NamedTuple):
    """Arc, straight, arc for each flying time: angles (rad), heading and length (m) of the straight, (n,)."""

    first: Array
    straight: Array
    length: Array
    last: Array


def _word(
    turns: tuple[int, int], start: Array, heading: float, target: Array, heading_end: float, radius: float
) -> _Word:
    """One Dubins word to moving targets; NaN where there is none.  start: (2,), target: (n, 2), m, through air.

    Dubins (1957); with the target drifting against the wind, McGee & Hedrick (2007).
    """
    first, last = turns
    centre = start + first * radius * np.array([-math.sin(heading), math.cos(heading)])
    centre_end = target + last * radius * np.array([-math.sin(heading_end), math.cos(heading_end)])
    between = centre_end - centre
    azimuth = np.arctan2(between[:, 1], between[:, 0])
    distance = np.hypot(between[:, 0], between[:, 1])
    if first == last:
        length, straight = distance, azimuth
    else:
        gap = distance**2 - 4.0 * radius**2
        length = np.sqrt(np.where(gap >= 0.0, gap, np.nan))
        straight = azimuth + first * np.arctan2(2.0 * radius, length)
    return _Word(
        np.mod(first * (straight - heading), TURN), straight, length, np.mod(last * (heading_end - straight), TURN)
    )


def plan_turn(
    position: tuple[float, float],
    heading: float,
    airspeed: float,
    wind: tuple[float, float],
    radius: float,
    bank: float,
) -> Turn:
    """Quickest turn that ends at the origin, on the line, its nose into the wind.

    position: m, heading: through the air, rad, wind: m/s, all in the line's frame (x along, y right).
    airspeed: m/s, radius: of the arcs, m, bank: in them, rad.
    Raises InputError for a wind that is not below the airspeed.
    """
    if math.hypot(*wind) >= airspeed:
        raise InputError(f"wind of {math.hypot(*wind):.3g} m/s in a turn", allowed=f"below {airspeed:.4g} m/s")
    lag = roll_lag(bank)
    heading_end = -math.asin(wind[1] / airspeed)
    drift = np.array(wind)
    forward = airspeed * np.array([math.cos(heading), math.sin(heading)])
    start = np.array(position) + lag * (forward + drift)
    end = np.array([-lag * (airspeed * math.cos(heading_end) + wind[0]), 0.0])
    far = float(np.hypot(*(end - start))) + 8.0 * math.pi * radius
    times = np.arange(0.0, far / (airspeed - math.hypot(*wind)) + 2.0, 1.0)
    best: tuple[float, tuple[int, int], int] | None = None
    for turns in ((1, 1), (-1, -1), (1, -1), (-1, 1)):
        for loops in range(3):
            found = _arrival(turns, loops, start, heading, end, heading_end, radius, airspeed, drift, times)
            if found is not None and (best is None or found < best[0] - 1e-6):
                best = (found, turns, loops)
    if best is None:
        raise InputError("no turn onto the next line found in this wind")
    flying, turns, loops = best
    word = _word(turns, start, heading, (end - drift * flying)[None], heading_end, radius)
    first = float(word.first[0]) + TURN * loops
    return Turn(
        turns[0],
        first,
        float(word.straight[0]),
        float(word.length[0]) / airspeed,
        turns[1],
        float(word.last[0]),
        heading_end,
        flying + 2.0 * lag,
    )


def _arrival(
    turns: tuple[int, int],
    loops: int,
    start: Array,
    heading: float,
    end: Array,
    heading_end: float,
    radius: float,
    airspeed: float,
    drift: Array,
    times: Array,
) -> float | None:
    """First time at which aircraft and target meet on a word with so many extra circles, s, if they do."""

    def late(at: Array) -> Array:
        word = _word(turns, start, heading, end - drift * at[:, None], heading_end, radius)
        arcs = word.first + word.last + TURN * loops
        return np.asarray((radius * arcs + word.length) / airspeed - at)

    ahead = late(times)
    # Where an arc closes to a whole circle the length jumps: no meeting there.
    jump = 0.5 * TURN * radius / airspeed
    with np.errstate(invalid="ignore"):
        meets = (ahead[:-1] >= 0.0) & (ahead[1:] < 0.0) & (ahead[:-1] - ahead[1:] < jump)
    if not meets.any():
        return None
    low = float(times[int(np.argmax(meets))])
    high = low + float(times[1] - times[0])
    for _ in range(3):
        grid = np.linspace(low, high, 65)
        inside = late(grid)
        index = int(np.argmax(inside < 0.0))
        low, high = float(grid[max(index - 1, 0)]), float(grid[index])
    return (low + high) / 2.0
