"""Recognition of strips in whole numbers, one at a time: the instrument of 1988 to the bit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerosim.estimation.fixed_point import Bytes, Sums, least, mad_sums, padded_bytes
from aerosim.estimation.mad import NEAR_PX, Trough
from aerosim.estimation.strips import SETTLE_PX, StripParameters
from aerosim.signals import MountReading, Reason, RowExposure, StripMatch


class _Open(NamedTuple):
    """The strip that waits to be recognised."""

    strip: int
    number1: int
    t_row1: float
    yaw1: float
    row1: Bytes


def judge_sums(surface: Sums, near: int, complete: bool) -> Trough:
    """Find the least sum and say whether it is a trough, by the rules of `mad.judge` in whole numbers.

    surface: (steps, 2 j + 1), not divided by u, which falls out of all ratios.  near: exposures within which a
    second trough does not count.  Products stay below 2^32 for windows of up to 480 exposures, and are taken in
    64 bits here.  The value is still a sum.
    """
    step, k = least(surface)
    shifts, value = surface.shape[1], int(surface[step, k])
    steps, columns = np.ogrid[: len(surface), :shifts]
    far = surface[(abs(steps - step) > near) | (abs(columns - k) > NEAR_PX)]
    total, second = int(surface.sum(dtype=np.int64)), int(far.min()) if far.size else None
    reason = Reason.ACCEPTED
    if k in (0, shifts - 1):
        reason = Reason.BORDER_MU
    elif step == 0 or (complete and step == len(surface) - 1):
        reason = Reason.BORDER_N
    elif (5 * total < 9 * value * surface.size) if complete else (2 * total < 5 * value * surface.size):
        reason = Reason.DEGENERATE
    elif second is not None and 4 * second < 5 * value:  # 1.25
        reason = Reason.AMBIGUOUS
    return Trough(float(step), float(k - shifts // 2), float(value), reason)


class IntegerRecogniser:
    """Keeps one row of row I and compares row II with it, exposure by exposure."""

    def __init__(self, parameters: StripParameters) -> None:
        """parameters: with period None, not subpixel, at most 128 pixels; the rows come in 8 bits."""
        par = self._par = parameters
        self._first = max(1, int(par.search[0] * par.planned_n))
        self._last = int(np.ceil(par.search[1] * par.planned_n))
        per_px = par.planned_n / par.spacing_px
        self._settle, self._near = int(np.ceil(SETTLE_PX * per_px)), int(NEAR_PX * per_px)
        self._surface = np.zeros((self._last - self._first + 1, 2 * par.max_shift + 1), np.uint16)
        self._stamps = np.zeros((self._last + 2, 2))
        self._open: _Open | None = None
        self._step, self._least, self._least_step, self._strips = 0, 0, 0, 0

    def opens(self) -> bool:
        """Whether the next exposure begins a strip: the moment to find the exposure time anew."""
        return self._open is None

    def switch(self, t: float) -> list[StripMatch]:
        """The rows are switched on or off at time t (s): a strip in flight is given up, with reason timeout."""
        nothing = Trough(np.nan, np.nan, np.nan, Reason.TIMEOUT)
        return [] if self._open is None else [self._close(self._open, nothing, 0, t)]

    def add(self, exposure: RowExposure, mount: MountReading) -> list[StripMatch]:
        """Take one exposure of both rows; returns the strip that it decided, if it did."""
        strip = self._open
        self._stamps[exposure.number % len(self._stamps)] = exposure.t, mount.yaw
        if strip is None:
            if not exposure.missing:
                self._begin(exposure, mount)
            return []
        self._step += 1
        if self._step < 0:
            return []
        if exposure.missing:
            return [self._close(strip, Trough(np.nan, np.nan, np.nan, Reason.OUTSIDE_TERRAIN), 0, exposure.t)]
        return self._compare(strip, exposure)

    def _begin(self, exposure: RowExposure, mount: MountReading) -> None:
        row1 = exposure.row1.astype(np.uint8)
        if self._par.padded:
            row1 = padded_bytes(row1, self._par.max_shift)
        self._open = _Open(self._strips, exposure.number, exposure.t, mount.yaw, row1)
        self._step = -self._first
        self._strips += 1

    def _compare(self, strip: _Open, exposure: RowExposure) -> list[StripMatch]:
        sums = mad_sums(strip.row1, exposure.row2.astype(np.uint8), self._par.mean_subtracted)
        self._surface[self._step] = sums
        lowest = int(sums.min())
        if self._step == 0 or lowest < self._least:
            self._least, self._least_step = lowest, self._step
        seen = self._step + 1
        complete = seen == len(self._surface)
        if not complete and self._step - self._least_step != self._settle:
            return []
        trough = judge_sums(self._surface[:seen], self._near, complete)
        if not complete and trough.reason is not Reason.ACCEPTED:
            return []
        return [self._close(strip, trough, seen, exposure.t)]

    def _close(self, strip: _Open, trough: Trough, seen: int, t: float) -> StripMatch:
        """The strip as it is recorded: sums are divided by u here, behind the instrument."""
        self._open = None
        n = self._first + trough.step
        t_row2, yaw2 = (np.nan, np.nan)
        if not np.isnan(n):
            t_row2, yaw2 = self._stamps[(strip.number1 + int(n)) % len(self._stamps)].tolist()
        surface = (self._surface[:seen] / np.float32(self._par.pixels)).astype(np.float32)
        return StripMatch(
            strip.strip, strip.number1, strip.t_row1, t_row2, t, n, trough.mu, trough.value / self._par.pixels,
            strip.yaw1, yaw2, trough.reason, self._first, surface,
        )  # fmt: skip
