"""Recognition of strips: row I is kept, row II is compared with it until the same ground comes by."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerosim.estimation.mad import Trough, correlate, judge, padded, prepared, refine
from aerosim.signals import MountReading, Reason, RowExposure, StripMatch

NEVER = -(2**62)  # step of an empty slot: it does not come up
TAKEN_S = 0.01  # grey values are taken as if exposed for so long
SETTLE_PX = 2.0  # the trough must have been left behind by so many pixels of ground motion


class StripParameters(NamedTuple):
    """How strips are taken and looked for.

    period: exposures between strips; None: one at a time (the paper).  planned_n: exposures between the rows
    at the planned v/h.  search: window of n as shares of planned_n.  spacing_px: between the rows.
    padded: the extension of row I shows nothing (the paper) instead of ground.
    """

    pixels: int
    max_shift: int
    spacing_px: float
    planned_n: float
    search: tuple[float, float]
    period: int | None
    mean_subtracted: bool
    subpixel: bool
    padded: bool


class _Open(NamedTuple):
    """A strip that waits to be recognised."""

    strip: int
    number1: int
    t_row1: float
    yaw1: float


class StripRecogniser:
    """Keeps rows of row I and follows each through its window of exposures of row II."""

    def __init__(self, parameters: StripParameters) -> None:
        """Slots for as many strips as can be in flight are made at once."""
        par = self._par = parameters
        self._first = max(1, int(par.search[0] * par.planned_n))
        self._last = int(np.ceil(par.search[1] * par.planned_n))
        self._steps_per_px = par.planned_n / par.spacing_px
        self._settle = int(np.ceil(SETTLE_PX * self._steps_per_px))
        slots = 1 if par.period is None else self._last // par.period + 2
        self._rows1 = np.zeros((slots, par.pixels + 2 * par.max_shift), np.float32)
        self._surfaces = np.zeros((slots, self._last - self._first + 1, 2 * par.max_shift + 1), np.float32)
        self._least = np.zeros(slots, np.float32)
        self._least_step = np.zeros(slots, np.int64)
        self._ready = np.zeros(slots, np.bool_)
        self._steps = np.full(slots, NEVER)
        self._open: dict[int, _Open] = {}
        self._stamps = [(0.0, 0.0)] * (self._last + 2)  # time and mount yaw, by exposure number
        self._strips = 0
        self._wait = 0

    def opens(self) -> bool:
        """Whether the next exposure begins a strip: the moment to find the exposure time anew."""
        return not self._open if self._par.period is None else self._wait == 0

    def switch(self, t: float) -> list[StripMatch]:
        """The rows are switched on or off at time t (s): strips in flight are given up, with reason timeout."""
        nothing = Trough(np.nan, np.nan, np.nan, Reason.TIMEOUT)
        self._wait = 0
        return [self._close(slot, nothing, 0, t) for slot in sorted(self._open)]

    def add(self, exposure: RowExposure, mount: MountReading) -> list[StripMatch]:
        """Take one exposure of both rows; returns the strips that it decided."""
        opens = self.opens()
        self._stamps[exposure.number % len(self._stamps)] = exposure.t, mount.yaw
        decided: list[StripMatch] = []
        if self._open:
            # two calls: compiled into one, sums would depend on whether it was just compiled or had been kept
            row2 = prepared(exposure.row2, 0, TAKEN_S / exposure.exposure, self._par.mean_subtracted)
            ready = correlate(
                row2, self._rows1, self._steps, self._settle, self._surfaces, self._least, self._least_step,
                self._ready,
            )  # fmt: skip
            if exposure.missing:
                decided = self._lose(exposure.t)
            elif ready:
                decided = self._decide(exposure.t)
        if opens and not exposure.missing:
            self._begin(exposure, mount)
        elif self._wait > 0:
            self._wait -= 1
        return decided

    def _begin(self, exposure: RowExposure, mount: MountReading) -> None:
        par = self._par
        slot = next(i for i in range(len(self._rows1)) if i not in self._open)
        row1 = padded(exposure.row1, par.max_shift) if par.padded else exposure.row1
        self._rows1[slot] = prepared(row1, par.max_shift, TAKEN_S / exposure.exposure, par.mean_subtracted)
        self._steps[slot] = -self._first
        self._open[slot] = _Open(self._strips, exposure.number, exposure.t, mount.yaw)
        self._strips += 1
        self._wait = (par.period or 1) - 1

    def _lose(self, t: float) -> list[StripMatch]:
        """There was no ground below the rows: strips that look for theirs now are lost."""
        nothing = Trough(np.nan, np.nan, np.nan, Reason.OUTSIDE_TERRAIN)
        return [self._close(slot, nothing, 0, t) for slot in sorted(self._open) if self._steps[slot] >= 0]

    def _decide(self, t: float) -> list[StripMatch]:
        decided = []
        for slot in np.flatnonzero(self._ready).tolist():
            seen = int(self._steps[slot]) + 1
            complete = seen == self._surfaces.shape[1]
            trough = judge(self._surfaces[slot, :seen], self._steps_per_px, complete)
            if complete or trough.reason is Reason.ACCEPTED:
                if self._par.subpixel:
                    trough = refine(self._surfaces[slot, :seen], trough, self._steps_per_px)
                decided.append(self._close(slot, trough, seen, t))
        return decided

    def _close(self, slot: int, trough: Trough, seen: int, t: float) -> StripMatch:
        strip = self._open.pop(slot)
        self._steps[slot] = NEVER
        n = self._first + trough.step
        t_row2, yaw2 = (np.nan, np.nan) if np.isnan(n) else self._stamp(strip.number1 + n)
        return StripMatch(
            strip.strip, strip.number1, strip.t_row1, t_row2, t, n, trough.mu, trough.value,
            strip.yaw1, yaw2, trough.reason, self._first, self._surfaces[slot, :seen].copy(),
        )  # fmt: skip

    def _stamp(self, number: float) -> tuple[float, float]:
        """Time and mount yaw at an exposure number, between two exposures by interpolation."""
        below = int(number)
        (t, yaw), (t_next, yaw_next) = (self._stamps[(below + i) % len(self._stamps)] for i in (0, 1))
        return t + (number - below) * (t_next - t), yaw + (number - below) * (yaw_next - yaw)
