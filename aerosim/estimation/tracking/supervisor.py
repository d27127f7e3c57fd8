"""Keeps lock and regains it: what is believed of the strips as a whole."""

from __future__ import annotations

from collections import deque
from enum import StrEnum

KEPT_S = 3.0  # over which the share of accepted strips is taken
WIDEN_BELOW = 0.6
SILENT_S = 5.0  # without an accepted strip the estimate is held
AGREE = 3  # strips that have to agree before one is believed
AGREE_WITHIN_S = 6.0


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
        self, t: float, track: float, log_vh: float, within: tuple[float, float]
    ) -> tuple[float, float] | None:
        """A strip that fits no belief yet: once AGREE of them agree (rad, log), their median is what they say."""
        self._found.append((t, track, log_vh))
        while self._found[0][0] < t - AGREE_WITHIN_S:
            self._found.popleft()
        near = [f for f in self._found if abs(f[1] - track) < within[0] and abs(f[2] - log_vh) < within[1]]
        if len(near) < AGREE:
            return None
        self._found.clear()
        self.state, self._last = State.LOCKED, t
        tracks, speeds = sorted(f[1] for f in near), sorted(f[2] for f in near)
        return tracks[len(near) // 2], speeds[len(near) // 2]
