"""In which order, and which way, the lines of a block are flown."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal, get_args

import numpy as np

from aerosim.errors import InputError
from aerosim.flight.plan import Line

Order = Literal["sequential", "race_track", "shortest"]
ORDERS: tuple[str, ...] = get_args(Order)
# track, part of it, whether it is flown forward
Leg = tuple[int, int, bool]


def race_track(number: int, leap: int) -> list[int]:
    """Tracks 0 to number - 1 so that each turn leaps about so many: out on one half of a group, back on the other.

    Groups of 2 leap - 1 tracks: 0, leap, 1, leap + 1, ..., leap - 1.  The last group is smaller, its leaps too.
    """
    found: list[int] = []
    while len(found) < number:
        first, left = len(found), number - len(found)
        # a group that would leave a few lines behind takes them in
        size = left if left < 2 * (2 * leap - 1) and left <= 3 * leap else min(2 * leap - 1, left)
        half = (size + 1) // 2
        group = [first + half * (k % 2) + k // 2 for k in range(size)]
        found += group
    return found


def flown(
    parts: Sequence[int],
    spacing: Sequence[float],
    order: Order,
    turn_diameter: float,
    line: Callable[[int, int, bool], Line],
    duration: Callable[[Sequence[Line]], float] | None,
) -> list[Leg]:
    """Legs in the order flown, there and back in turn.

    parts: number of parts of each track; spacing: between neighbouring tracks, m; turn_diameter: m; line: makes
    the line of a leg; duration: of a flight along lines, s, for order `shortest`, which tries the sequential one
    and race tracks of several widths, then the quickest of them from either side and end.
    """
    if order not in ORDERS:
        raise InputError(f"order {order!r} is not known", allowed=", ".join(ORDERS))
    number = len(parts)
    least = 1 + math.ceil(turn_diameter / float(np.mean(spacing))) if number > 1 else 1
    if order == "sequential":
        return _legs(range(number), parts, True)
    if order == "race_track":
        return _legs(race_track(number, least), parts, True)
    if duration is None:
        raise InputError("order 'shortest' without a way to tell the duration of a flight")
    fly = duration

    def takes(legs: list[Leg]) -> float:
        return fly([line(*leg) for leg in legs])

    leaps = sorted({1, *(max(1, min(least + more, (number + 1) // 2)) for more in (-1, 0, 1))})
    plain = [race_track(number, leap) if leap > 1 else list(range(number)) for leap in leaps]
    best = min(plain, key=lambda tracks: takes(_legs(tracks, parts, True)))
    sides = (best, [number - 1 - track for track in best])
    return min((_legs(tracks, parts, forward) for tracks in sides for forward in (True, False)), key=takes)


def _legs(tracks: Sequence[int], parts: Sequence[int], forward: bool) -> list[Leg]:
    legs: list[Leg] = []
    for track in tracks:
        inside = range(parts[track])
        legs += [(track, part, forward) for part in (inside if forward else reversed(inside))]
        forward = not forward
    return legs
