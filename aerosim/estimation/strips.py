"""Recognition of strips: row I is kept, row II is compared with it until the same ground comes by."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.estimation.mad import Trough, centred, correlate, judge, padded, refine
from aerosim.signals import Grey, MountReading, Reason, RowExposure, StripMatch

NEVER = np.iinfo(np.int64).max // 2  # first exposure of an empty slot
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
        self._number1 = np.full(slots, NEVER)
        self._open: dict[int, _Open] = {}
        self._stamps = np.zeros((self._last + 2, 2))
        self._strips = 0
        self._next = 0

    def opens(self, number: int) -> bool:
        """Whether an exposure of this number begins a strip: the moment to find the exposure time anew."""
        return not self._open if self._par.period is None else number >= self._next

    def begin_line(self, exposure_number: int) -> None:
        """Forget the strips in flight and start again at this exposure."""
        self._open.clear()
        self._number1[:] = NEVER
        self._next = exposure_number

    def add(self, exposure: RowExposure, mount: MountReading) -> list[StripMatch]:
        """Take one exposure of both rows; returns the strips that it decided."""
        number = exposure.number
        if exposure.missing:
            return self._lose(exposure)
        self._stamps[number % len(self._stamps)] = exposure.t, mount.yaw
        decided: list[StripMatch] = []
        if self._open:
            steps = number - self._number1 - self._first
            if correlate(
                self._scaled(exposure.row2, exposure.exposure, 0),
                self._rows1, steps, self._settle, self._surfaces, self._least, self._least_step, self._ready,
            ):  # fmt: skip
                decided = self._decide(exposure, steps)
        if self.opens(number):
            self._begin(exposure, mount)
        return decided

    def end_line(self, t: float) -> list[StripMatch]:
        """Give up the strips in flight when the rows are switched off at time t (s): reason timeout."""
        nothing = Trough(np.nan, np.nan, np.nan, Reason.TIMEOUT)
        return [self._close(slot, nothing, 0, t) for slot in sorted(self._open)]

    def _lose(self, exposure: RowExposure) -> list[StripMatch]:
        """No ground below the rows: strips that look for theirs now are lost, none is begun."""
        steps = exposure.number - self._number1 - self._first
        nothing = Trough(np.nan, np.nan, np.nan, Reason.OUTSIDE_TERRAIN)
        return [self._close(slot, nothing, 0, exposure.t) for slot in sorted(self._open) if steps[slot] >= 0]

    def _scaled(self, row: Grey, exposure: float, max_shift: int) -> Grey:
        """Grey values as if exposed for 10 ms, and without their mean if so wanted."""
        grey = row * np.float32(0.01 / exposure)
        return centred(grey, max_shift) if self._par.mean_subtracted else grey

    def _begin(self, exposure: RowExposure, mount: MountReading) -> None:
        par = self._par
        slot = int(np.argmax(self._number1 == NEVER))
        row1 = padded(exposure.row1, par.max_shift) if par.padded else exposure.row1
        self._rows1[slot] = self._scaled(row1, exposure.exposure, par.max_shift)
        self._number1[slot] = exposure.number
        self._open[slot] = _Open(self._strips, exposure.number, exposure.t, mount.yaw)
        self._strips += 1
        self._next = exposure.number + (par.period or 0)

    def _decide(self, exposure: RowExposure, steps: NDArray[np.int64]) -> list[StripMatch]:
        decided = []
        for slot in np.flatnonzero(self._ready).tolist():
            seen = int(steps[slot]) + 1
            complete = seen == self._surfaces.shape[1]
            trough = judge(self._surfaces[slot, :seen], self._steps_per_px, complete)
            if complete or trough.reason is Reason.ACCEPTED:
                if self._par.subpixel:
                    trough = refine(self._surfaces[slot, :seen], trough, self._steps_per_px)
                decided.append(self._close(slot, trough, seen, exposure.t))
        return decided

    def _close(self, slot: int, trough: Trough, seen: int, t: float) -> StripMatch:
        strip = self._open.pop(slot)
        self._number1[slot] = NEVER
        n = self._first + trough.step
        t_row2, yaw2 = (np.nan, np.nan) if np.isnan(n) else self._stamp(strip.number1 + n)
        return StripMatch(
            strip.strip, strip.number1, strip.t_row1, t_row2, t, n, trough.mu, trough.value,
            strip.yaw1, yaw2, trough.reason, self._first, self._surfaces[slot, :seen].copy(),
        )  # fmt: skip

    def _stamp(self, number: float) -> tuple[float, float]:
        """Time and mount yaw at an exposure number, between two exposures by interpolation."""
        below = int(number)
        a, b = (self._stamps[(below + i) % len(self._stamps)] for i in (0, 1))
        t, yaw = a + (number - below) * (b - a)
        return float(t), float(yaw)
