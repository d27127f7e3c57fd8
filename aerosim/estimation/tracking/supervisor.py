"""Keeps lock and regains it: what is believed of the strips as a whole."""

from __future__ import annotations

import math
from collections import deque
from enum import StrEnum

KEPT_S = 3.0  # over which the share of accepted strips is taken
WIDEN_BELOW = 0.6
SILENT_S = 5.0  # without an accepted strip the estimate is held
AGREE, AGREE_ANEW = 3, 5  # strips that have to agree before one is believed, and against what is believed
AGREE_WITHIN_S, AGREE_OVER_S = 6.0, 0.75  # neighbours see the same ground, and err alike
MAJORITY = 0.6  # of all that were found meanwhile
# what a track and the logarithm of v/h can have become while nothing was accepted; for so long this is sure
BOUNDS, BOUNDS_S = (math.radians(16.0), math.log(1.25)), 60.0


class State(StrEnum):
    """What the tracker does."""

    SEEKING = "seeking"
    LOCKED = "locked"
    HELD = "held"


class Supervisor:
    """Counts accepted strips, and says when to widen, to hold and to start anew."""

    def __init__(self) -> None:
        """Nothing is known yet."""
        self.state = State.SEEKING
        self._decided: deque[tuple[float, bool]] = deque()
        self._last = -1e9
        self._found: deque[tuple[float, float, float]] = deque()

    def strip(self, t: float, accepted: bool) -> None:
        """A strip was decided at time t, s."""
        self._decided.append((t, accepted))
        while self._decided[0][0] < t - KEPT_S:
            self._decided.popleft()
        if accepted:
            self._last = t
            if self.state is State.HELD:
                self.state = State.LOCKED

    def watch(self, t: float) -> None:
        """Time goes by."""
        if self.state is State.LOCKED and t - self._last > SILENT_S:
            self.state = State.HELD

    @property
    def doubtful(self) -> bool:
        """Too few strips are accepted: look in wider windows."""
        decided = self._decided
        return len(decided) >= 3 and sum(ok for _, ok in decided) < WIDEN_BELOW * len(decided)

    def found(
        self,
        t: float,
        track: float,
        log_vh: float,
        within: tuple[float, float],
        belief: tuple[float, float] | None = None,
    ) -> tuple[float, float] | None:
        """A strip that fits no belief yet: once enough of them agree (rad, log), their median is what they say.

        Enough are AGREE, or AGREE_ANEW against a belief, over at least AGREE_OVER_S and a MAJORITY.  belief: what
        was believed last (rad, log); a strip further from it than BOUNDS is no strip, unless all is long ago.
        """
        if belief is not None and t - self._last < BOUNDS_S:
            off = abs(track - belief[0]) / BOUNDS[0], abs(log_vh - belief[1]) / BOUNDS[1]
            if max(off) > 1.0:
                return None
        self._found.append((t, track, log_vh))
        while self._found[0][0] < t - AGREE_WITHIN_S:
            self._found.popleft()
        near = [f for f in self._found if abs(f[1] - track) < within[0] and abs(f[2] - log_vh) < within[1]]
        least = max(AGREE if belief is None else AGREE_ANEW, MAJORITY * len(self._found))
        if len(near) < least or t - near[0][0] < AGREE_OVER_S:
            return None
        self._found.clear()
        self.state, self._last = State.LOCKED, t
        tracks, speeds = sorted(f[1] for f in near), sorted(f[2] for f in near)
        return tracks[len(near) // 2], speeds[len(near) // 2]
