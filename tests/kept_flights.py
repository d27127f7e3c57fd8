"""Flights made up for the tests of recording and keeping: any state at any step, and nothing to compute."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from aerosim.errors import RunFailure
from aerosim.flight.guidance import Phase
from aerosim.flight.interface import Flight, Recordable, Sortie
from aerosim.flight.plan import FlightPlan, Line
from aerosim.flight.recorded import RecordedFlight, record
from aerosim.flight.recording import Recording, from_bytes, to_bytes
from aerosim.truth import AircraftState, AirState

PLAN = FlightPlan([Line((0.6, -1.4), (0.6, -1.398)), Line((0.601, -1.398), (0.601, -1.4))], 2500.0, 70.0)


class MadeUp:
    """States of random bits; air, line and phase change at steps of their own.  lost: step not reached."""

    def __init__(self, seed: int, steps: int, lost: int | None = None, done: int | None = None) -> None:
        rng = np.random.default_rng(seed)
        self.table = rng.integers(-(2**63), 2**63 - 1, (steps, 15)).view(np.float64)
        self.airs = [AirState(*rng.standard_normal(9).tolist()) for _ in range(steps // 7 + 1)]
        self.marks = rng.integers(-1, 3, (steps // 50 + 1, 3)).tolist()
        self.plan, self.step, self.lost, self.end = PLAN, 0, lost, done

    def advance(self, steps: int) -> None:
        if self.lost is not None and self.step + steps >= self.lost:
            raise RunFailure(f"aircraft lost at step {self.lost}")
        self.step += steps

    def state(self) -> AircraftState:
        return AircraftState._make(self.table[self.step, :14].tolist())

    @property
    def air(self) -> AirState:
        return self.airs[self.step // 7]

    @property
    def line(self) -> int:
        return int(self.marks[self.step // 50][0])

    @property
    def next_line(self) -> int:
        return int(self.marks[self.step // 50][1])

    @property
    def phase(self) -> Phase:
        return Phase.DONE if self.done else list(Phase)[self.marks[self.step // 50][2] % 3]

    @property
    def cross_track(self) -> float:
        return float(self.table[self.step, 14])

    @property
    def done(self) -> bool:
        return self.end is not None and self.step >= self.end

    @property
    def steady(self) -> int:
        return 0

    def sample(self) -> list[float]:
        return self.table[self.step].tolist()  # type: ignore[no-any-return]

    def states(self, samples: Any, first: int, next_line: Any) -> Any:
        return samples


class Memory:
    """A source that flies each flight once and keeps its bytes.  flown: how many."""

    def __init__(self) -> None:
        self.kept: dict[str, bytes] = {}
        self.flown = 0

    def __call__(self, sortie: Sortie, fly: Callable[[], Recordable]) -> Flight:
        key = sortie.content()
        if key not in self.kept:
            self.flown += 1
            self.kept[key] = to_bytes(record(fly(), sortie))
        return RecordedFlight(from_bytes(self.kept[key]))

    def only(self) -> Recording:
        (data,) = self.kept.values()
        return from_bytes(data)


def sortie(name: str, duration: float = 1.0, rate: float = 120.0) -> Sortie:
    return Sortie(rate, duration, lambda: name)


def fly_one(folder: str, name: str, seed: int, pause: float) -> tuple[int, list[float]]:
    """What a process of its own does: ask a folder for a flight.  Returns how many it flew, and a state."""
    from pathlib import Path

    from aerosim.sweep.flights import Flights

    flights = Flights(Path(folder))

    def fly() -> MadeUp:
        time.sleep(pause)
        return MadeUp(seed, 40_000)

    found = flights(sortie(name), fly)
    return flights.flown, list(found.state())
