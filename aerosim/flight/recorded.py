"""A flight flown once and looked at many times: recording it, and the recording as a flight.

Nothing of the camera reaches the pilot: the navigator looks through his own sight.  So one flown trajectory
serves all devices, estimators and controllers.
"""

from __future__ import annotations

import math
from array import array
from bisect import bisect_right
from struct import Struct

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import RunFailure
from aerosim.flight.guidance import Phase
from aerosim.flight.interface import Recordable, Sortie, patience
from aerosim.flight.recording import STATE_WIDTH, Block, Recording, pack
from aerosim.frames import Array
from aerosim.truth import AircraftState, AirState

BLOCK = 8192  # steps at least
# The loop looks at least each 10 s, the longest period of rows, whether the flight is done, and how late it is.
TAIL_S = 11.0
LATE_S = 30.0
_PHASES = (Phase.RUN_IN, Phase.LINE, Phase.TURN, Phase.DONE)
_ROW = Struct(f"={STATE_WIDTH}d")


def record(flight: Recordable, sortie: Sortie) -> Recording:
    """Fly a flight that has not moved yet to its end and keep every step, whatever a camera may ask for.

    Kept are the seconds after the last line in which a loop may still look, or all until the flight fails, or
    until no loop has patience with it any more.
    """
    tape, advance, sample = _Tape(flight), flight.advance, flight.sample
    end = math.ceil((patience(sortie.duration) + LATE_S) * sortie.rate)
    tail, over, failure = math.ceil(TAIL_S * sortie.rate), False, ""
    tape.event()
    try:
        while tape.step < end:
            advance(1)
            tape.event()
            for _ in range(flight.steady):
                advance(1)
                tape.keep(sample())
            if flight.done and not over:
                end, over = min(end, tape.step + tail), True
    except RunFailure as reason:
        failure = str(reason)
    tape.flush()
    return Recording(flight.plan, tuple(tape.blocks), failure)


class _Tape:
    """The steps of a flight as they are flown.  keep(sample): of a step in which only the state has changed."""

    def __init__(self, flight: Recordable) -> None:
        self.blocks: list[Block] = []
        self._flight = flight
        self._width = len(list(flight.sample()))
        self._first = 0
        self._samples = array("d")
        self.keep = self._samples.extend
        self._events: list[list[float]] = []
        self._air: AirState | None = None
        self._mark = (0, 0, Phase.DONE)

    @property
    def step(self) -> int:
        """The last one kept, -1 for none."""
        return self._first + len(self._samples) // self._width - 1

    def event(self) -> None:
        """Keep this step, in which air, line or phase may have changed."""
        flight, step = self._flight, self.step + 1
        if step - self._first >= BLOCK:
            self.flush()
        self.keep(flight.sample())
        air, mark = flight.air, (flight.line, flight.next_line, flight.phase)
        if air is not self._air or mark != self._mark or not self._events:
            self._air, self._mark = air, mark
            self._events.append([step - self._first, *air, *mark[:2], _PHASES.index(mark[2])])

    def flush(self) -> None:
        """Pack the steps since the last block."""
        samples, events = np.array(self._samples).reshape(-1, self._width), np.array(self._events)
        steps = len(samples)
        next_line = events[_events_of(events, steps), 11].astype(np.int64)
        states = self._flight.states(samples, self._first, next_line)
        self.blocks.append(Block(self._first, steps, len(events), pack(states), pack(events)))
        self._first += steps
        del self._samples[:]
        self._events = []


def _events_of(events: Array, count: int) -> NDArray[np.int64]:
    """Which event holds at each step of a block, (count,)."""
    starts = events[:, 0].astype(np.int64)
    return np.repeat(np.arange(len(events)), np.diff(starts, append=count))


class RecordedFlight:
    """A recording with the interface of the flight that it is of."""

    def __init__(self, recording: Recording) -> None:
        self.plan = recording.plan
        self._recording = recording
        self._starts = [block.first for block in recording.blocks]
        self._open(0)
        self._at = 0

    def _open(self, number: int) -> None:
        block = self._recording.blocks[number]
        states, events = block.unpacked()
        holds = _events_of(events, block.steps)
        self._first, self._count = block.first, block.steps
        self._states, self._across = states.data.cast("B"), states[:, 14]
        self._airs, self._holds = events[:, 1:10], holds
        marks = events[holds, 10:].astype(np.int64).T
        self._line: list[int] = marks[0].tolist()
        self._next_line: list[int] = marks[1].tolist()
        self._phase: list[int] = marks[2].tolist()

    def advance(self, steps: int) -> None:
        """Fly so many steps.  Raises RunFailure when the aircraft was lost."""
        self._at += steps
        if self._at >= self._count:
            self._go_on()

    def _go_on(self) -> None:
        step, recording = self._first + self._at, self._recording
        if step > recording.last:
            if recording.failure:
                raise RunFailure(recording.failure)
            raise RuntimeError(f"step {step} of a flight that was recorded to step {recording.last}")
        self._open(bisect_right(self._starts, step) - 1)
        self._at = step - self._first

    def state(self) -> AircraftState:
        """State of the aircraft now."""
        return AircraftState._make(_ROW.unpack_from(self._states, _ROW.size * self._at)[:-1])

    @property
    def air(self) -> AirState:
        """The air that the aircraft feels now."""
        return AirState._make(self._airs[self._holds[self._at]].tolist())

    @property
    def line(self) -> int:
        """Number of the line being flown, -1 in run-ins and turns and after the last line."""
        return self._line[self._at]

    @property
    def next_line(self) -> int:
        """Number of the line being flown or approached."""
        return self._next_line[self._at]

    @property
    def phase(self) -> Phase:
        """Where in the plan the aircraft is."""
        return _PHASES[self._phase[self._at]]

    @property
    def cross_track(self) -> float:
        """Distance from the line being flown or approached, positive to its right, m."""
        return float(self._across[self._at])

    @property
    def done(self) -> bool:
        """Whether the last line's end has been passed."""
        return self.phase is Phase.DONE
