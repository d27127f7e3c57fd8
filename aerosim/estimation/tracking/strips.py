"""Strips in flight: kept, looked for in windows around their prediction, measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from aerosim.estimation.mad import Trough
from aerosim.estimation.tracking.edges import beside, edges
from aerosim.estimation.tracking.fine import REACH_PX
from aerosim.estimation.tracking.geometry import MOUNT, TIME, YAW, ahead, between, mismatch, passed
from aerosim.estimation.tracking.health import Health, mended
from aerosim.estimation.tracking.look import Looked, View, Where, look
from aerosim.estimation.tracking.rays import Rays
from aerosim.frames import Array
from aerosim.signals import Grey, Reason, RowExposure, StripMatch

Counts = NDArray[np.int64]

REFERENCE_S = 0.01  # grey values are taken as if exposed for so long
PLANNED_BY = 1.12  # times the planned n: the first look for a strip of which nothing is known
SEEK_EVERY = 4  # strips


@dataclass(frozen=True)
class StripSetup:
    """Rows, and how strips are taken.

    pixels, max_shift, spacing_px, focal_px: of the rows, px.  period: between exposures, s.  level: pitch of the
    mount against the airframe, rad.  planned_n: exposures; search: parts of it.  every: exposures between strips.
    rays: of the rows, as they are believed.
    """

    pixels: int
    max_shift: int
    spacing_px: float
    focal_px: float
    period: float
    level: float
    planned_n: float
    search: tuple[float, float]
    every: int
    rays: Rays


class Window(NamedTuple):
    """along: px of ground motion to either side of the prediction; half: shifts to either side.

    soon: px behind the prediction after which a first look is taken, along: none.  slant: rad, by which the camera
    may have turned more or less than is known; 0: not looked for.  tolerance: see `Where`.
    """

    along: float
    half: int
    soon: float
    slant: float = 0.0
    tolerance: float = 0.0


class Found(NamedTuple):
    """A strip that was looked for.  first, second: rows of the attitude ring at both exposures, None: refused."""

    match: StripMatch
    first: Array | None = None
    second: Array | None = None


class Strips:
    """Rings of row II and of the attitude, and the strips of row I that wait."""

    def __init__(self, setup: StripSetup) -> None:
        """Room for as many strips as can be in flight is made at once."""
        s = self._setup = setup
        self._first, self._last = max(1, int(s.search[0] * s.planned_n)), math.ceil(s.search[1] * s.planned_n)
        self._steps_per_px = s.planned_n / s.spacing_px
        self._apart = s.rays.apart
        self._bow = s.rays.bow * self._steps_per_px
        bent = math.ceil(np.abs(self._bow).max())
        self._behind = int(REACH_PX * self._steps_per_px) + 3 + bent  # exposures that the fit wants behind it
        ring = 1 << math.ceil(math.log2(self._last + 8 * s.every + 64 + 2 * bent))
        self._rows2 = np.zeros((ring, s.pixels), np.float32)
        self.ring = np.zeros((ring, 7))
        slots = self._last // s.every + 4
        self._rows1 = np.zeros((slots, s.pixels + 2 * s.max_shift), np.float32)
        self._edges2 = np.zeros_like(self._rows2)
        self._number1 = np.full(slots, -1, np.int64)
        self._id = np.zeros(slots, np.int64)
        self._looked = np.zeros(slots, np.bool_)
        self._late = np.zeros(slots, np.bool_)  # the first look found nothing: the next is the last
        # first and last exposure within the window, that nearest to the prediction and its shift
        self._begin = np.full(slots, -1, np.int64)
        self._end = np.full(slots, -1, np.int64)
        self._near = np.full(slots, np.inf)
        self._centre = np.zeros(slots)
        self._seen, self._miss = np.zeros((slots, 2)), np.zeros((slots, 2))
        self._health = Health(s.pixels)
        self._weights = np.ones(s.pixels, np.float32)
        self._health1 = Health(s.pixels + 2 * s.max_shift)
        self._weights1 = np.ones(s.pixels + 2 * s.max_shift, np.float32)
        self._half, self._slant, self._tolerance = s.max_shift, 0.0, 0.0
        self._strips = self._wait = 0
        self.t = math.nan

    def opens(self) -> bool:
        """Whether the next exposure begins a strip."""
        return self._wait == 0

    def give_up(self, t: float) -> list[StripMatch]:
        """All strips in flight are given up."""
        self._wait = 0
        waiting = np.flatnonzero(self._number1 >= 0).tolist()
        return [self._lost(slot, t, Reason.TIMEOUT) for slot in waiting]

    def _lost(self, slot: int, t: float, reason: Reason) -> StripMatch:
        nothing = np.zeros((0, 2 * self._setup.max_shift + 1), np.float32)
        return self._match(slot, Trough(np.nan, np.nan, np.nan, reason), 0, nothing, t)

    def keep(self, exposure: RowExposure, attitude: tuple[float, ...]) -> None:
        """Take an exposure into the rings; row I too if a strip begins."""
        s, number = self._setup, exposure.number
        at = number % len(self.ring)
        self.t = exposure.t
        self.ring[at] = attitude
        scale = REFERENCE_S / exposure.exposure
        self._rows2[at] = exposure.row2 * scale
        edges(self._rows2[at], self._weights, self._edges2[at])
        if self._wait > 0:
            self._wait -= 1
            return
        self._wait = s.every - 1
        if exposure.missing:
            return
        self._weights = self._health(self._rows2[at])
        slot = int(np.argmin(self._number1))  # -1: empty
        if self._number1[slot] >= 0:
            return
        self._rows1[slot] = exposure.row1 * scale
        self._weights1 = self._health1(self._rows1[slot])
        self._seen[slot] = ahead(self.ring[at], self._apart, s.focal_px, s.level)
        self._number1[slot], self._id[slot] = number, self._strips
        self._begin[slot] = self._end[slot] = -1
        self._near[slot], self._looked[slot], self._late[slot] = np.inf, False, False
        self._strips += 1

    def closed_unknown(self, number: int) -> list[int]:
        """Strips whose turn it is while nothing is known: a look soon after the planned n, one at the end."""
        age = number - self._number1
        soon, end = int(PLANNED_BY * self._setup.planned_n), self._last
        waits = self._number1 >= 0
        ready = waits & (((age == soon) & (self._id % SEEK_EVERY == 0)) | (age >= end))
        out = np.flatnonzero(ready).tolist()
        for slot in out:
            self._begin[slot], self._end[slot] = self._number1[slot] + self._first, number - self._behind
            self._centre[slot] = 0.0
        self._half, self._slant, self._tolerance = 2 * self._setup.max_shift, 0.0, 0.0
        return out

    def closed(self, number: int, track: float, speed: float, window: Window) -> list[int]:
        """Strips whose window is over.  track, speed: see `mismatch`."""
        s = self._setup
        self._half, self._slant, self._tolerance = window.half, window.slant, window.tolerance
        self._late |= window.soon >= window.along
        count = _follow(
            self.ring, number, self._number1, self._seen, track, speed, self._apart, s.focal_px, s.level,
            window.along, window.soon, self._late, s.pixels, self._behind / self._steps_per_px,
            self._first, self._last, self._begin, self._end, self._near, self._centre, self._miss, self._looked,
        )  # fmt: skip
        return np.flatnonzero(self._looked & (self._number1 >= 0)).tolist() if count else []

    def recognise(self, slot: int, exposure: RowExposure, final: bool) -> Found | None:
        """Look for a strip in its window.

        None: not found yet, its window is still open (`final` False and the last exposure not reached).
        """
        number, t = exposure.number, exposure.t
        begin, end = int(self._begin[slot]), int(self._end[slot])
        complete = final or number - self._number1[slot] >= self._last
        last_look = complete and (not final or bool(self._late[slot]))
        if not last_look:  # what the fit wants behind a minimum has been seen
            end = min(end, number - self._behind)
        if final and not last_look and end - begin < 2:
            self._late[slot] = True
            return None
        if not self._worth(slot, final):
            return Found(self._lost(slot, t, Reason.BORDER_N if final else Reason.SKIPPED))
        slants = (0.0,) if self._slant == 0.0 else (-self._slant, 0.0, self._slant)
        where = Where(begin, end, self._shift(slot), self._half, slants, complete, self._tolerance)
        looked = self._look(slot, where, last_look)
        if not last_look and not looked.accepted:
            self._late[slot] = final
            if not final:  # should the track be known by then, its window is another
                self._begin[slot] = self._end[slot] = -1
            return None
        if not looked.accepted:
            return Found(self._match(slot, looked.trough, begin, looked.found, t))
        return self._measured(slot, looked.trough, begin, looked.found, t)

    def _look(self, slot: int, where: Where, last: bool) -> Looked:
        """Look at grey values, and at edges if these leave a doubt: moving shadows make troughs of their own.

        last: the strip will not be looked for again.
        """

        def turn(number: int) -> float:
            return self._turn(slot, number)

        def crab(number: int, mu: float) -> float:
            return math.tan(self._reading(slot, number, mu)[1])

        row1 = mended(self._rows1[slot], self._weights1)
        views = View(row1, self._rows2, self._weights1, self._weights)
        grey = look(views, where, turn, crab, self._steps_per_px, self._bow)
        if grey.clean or not math.isfinite(grey.trough.value) or not (grey.accepted or last):
            return grey
        sharp = np.empty_like(row1)
        edges(row1, self._weights1, sharp)
        views = View(sharp, self._edges2, beside(self._weights1), beside(self._weights), edges=True)
        edged = look(views, where, turn, crab, self._steps_per_px, self._bow)
        return edged if edged.accepted or grey.accepted else grey

    def _worth(self, slot: int, final: bool) -> bool:
        """Whether a strip has a window; while nothing is known, only some are worth their long search."""
        if not final and self._id[slot] % SEEK_EVERY:
            return False
        return bool(self._begin[slot] >= 0 and self._end[slot] - self._begin[slot] >= 2)

    def _shift(self, slot: int) -> int:
        """Shift that a strip is looked for around, px."""
        most = 2 * self._setup.max_shift  # half of the pixels still face each other
        return min(max(round(float(self._centre[slot])), -most), most)

    def _turn(self, slot: int, number: int) -> float:
        """Turn of the camera since the strip's row I, rad."""
        a, b = self.ring[self._number1[slot] % len(self.ring)], self.ring[number % len(self.ring)]
        return float(b[YAW] + b[MOUNT] - a[YAW] - a[MOUNT])

    def _reading(self, slot: int, number: float, mu: float) -> tuple[float, float, float, Array, Array]:
        """Track (rad), its angle against the rows' axis (rad), v/h (1/s) and both rows of the attitude ring."""
        s = self._setup
        first = self.ring[self._number1[slot] % len(self.ring)].copy()
        second = between(self.ring, number)
        north, east = passed(first, second, mu, s.level, *s.rays, s.focal_px)
        track = math.atan2(east, north)
        axis = (first[YAW] + first[MOUNT] + second[YAW] + second[MOUNT]) / 2.0
        vh = math.hypot(north, east) / (second[TIME] - first[TIME])
        return track, math.remainder(track - axis, 2.0 * math.pi), vh, first, second

    def _measured(self, slot: int, trough: Trough, begin: int, found: Grey, t: float) -> Found:
        track, angle, vh, first, second = self._reading(slot, begin + trough.step, trough.mu)
        match = self._match(slot, trough, begin, found, t)
        return Found(match._replace(track=track, angle=angle, vh=vh), first, second)

    def _match(self, slot: int, trough: Trough, begin: int, found: Grey, t: float) -> StripMatch:
        number1 = int(self._number1[slot])
        self._number1[slot] = -1
        n = begin + trough.step - number1
        first = self.ring[number1 % len(self.ring)]
        second = between(self.ring, number1 + n) if math.isfinite(n) else np.full(7, np.nan)
        return StripMatch(
            int(self._id[slot]), number1, float(first[TIME]), float(second[TIME]), t, float(n), float(trough.mu),
            float(trough.value), float(first[MOUNT]), float(second[MOUNT]), trough.reason, begin - number1, found,
            centre=self._shift(slot),
        )  # fmt: skip


@njit(cache=True)
def _follow(
    ring: Array,
    number: int,
    number1: Counts,
    seen: Array,
    track: float,
    speed: float,
    spacing: float,
    focal: float,
    level: float,
    along: float,
    soon: float,
    late: NDArray[np.bool_],
    pixels: int,
    settle: float,
    first: int,
    last: int,
    begin: Counts,
    end: Counts,
    near: Array,
    centre: Array,
    miss: Array,
    over: NDArray[np.bool_],
) -> int:  # pragma: no cover - compiled
    """Note which exposures lie within each strip's window; marks those that are to be looked at, counts them."""
    mismatch(ring, number, number1, seen, track, speed, spacing, focal, level, miss)
    now = ring[number % ring.shape[0]]
    count = 0
    for s in range(number1.shape[0]):
        over[s] = False
        if number1[s] < 0:
            continue
        age = number - number1[s]
        if abs(miss[s, 0]) <= along and first <= age <= last:
            if begin[s] < 0:
                begin[s] = number
            end[s] = number
            if abs(miss[s, 0]) < near[s]:
                near[s], centre[s] = abs(miss[s, 0]), miss[s, 1]
        then = ring[number1[s] % ring.shape[0]]
        turn = abs(now[YAW] + now[MOUNT] - then[YAW] - then[MOUNT])
        until = along if late[s] else soon
        if miss[s, 0] < -(until + settle + turn * pixels / 2.0) or age > last + 32:
            over[s] = True
            count += 1
    return count
