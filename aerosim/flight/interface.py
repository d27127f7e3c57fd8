"""What a flight asks for, and what the loop asks of a flight, whatever moves it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from aerosim.flight.guidance import Phase
from aerosim.flight.plan import FlightPlan
from aerosim.frames import Array
from aerosim.truth import AircraftState, AirState, Where

LONGEST, SPARE_S = 1.5, 120.0


def patience(planned: float) -> float:
    """Time (s) after which a flight that was planned to take so long (s) does not find its lines any more."""
    return LONGEST * planned + SPARE_S


class Air(Protocol):
    """The air that a flight asks for, state after state."""

    def at(self, index: int, where: Where) -> AirState:
        """State number `index` at the place that `where` tells; asked in rising order."""


class Flight(Protocol):
    """What the loop steps.  air: felt now; line: being flown, or -1; next_line: flown or approached."""

    plan: FlightPlan

    def advance(self, steps: int) -> None:
        """Fly so many steps.  Raises RunFailure when the aircraft is lost."""

    def state(self) -> AircraftState:
        """State of the aircraft now."""

    @property
    def air(self) -> AirState:
        """The air that the aircraft feels now."""

    @property
    def line(self) -> int:
        """Number of the line being flown, or -1."""

    @property
    def next_line(self) -> int:
        """Number of the line being flown or approached."""

    @property
    def phase(self) -> Phase:
        """Where in the plan the aircraft is."""

    @property
    def cross_track(self) -> float:
        """Distance from the line being flown or approached, positive to its right, m."""

    @property
    def done(self) -> bool:
        """Whether the last line's end has been passed."""


class Recordable(Flight, Protocol):
    """A flight whose every step can be kept at little cost."""

    @property
    def steady(self) -> int:
        """Steps from now during which air, line and phase surely stay as they are."""

    def sample(self) -> Iterable[float]:
        """Numbers of now that `states` needs, as the flight has them, to be read at once."""

    def states(self, samples: Array, first: int, next_line: NDArray[np.int64]) -> Array:
        """AircraftState and cross-track, (n, 15), of samples (n, k) at steps `first` on, as told then bit for bit.

        next_line: (n,), as told then.
        """


class Sortie(NamedTuple):
    """What a flight is to be, before it is flown.

    rate: steps a second.  duration: planned, s.  content: makes a digest of everything that the flight is made
    from, but for the program, its libraries and the machine.
    """

    rate: float
    duration: float
    content: Callable[[], str]


class FlightSource(Protocol):
    """Where flights come from."""

    def __call__(self, sortie: Sortie, fly: Callable[[], Recordable]) -> Flight:
        """The flight of a sortie; fly: makes a new one.  Raises InputError if it cannot be flown."""


def fresh(sortie: Sortie, fly: Callable[[], Recordable]) -> Flight:
    """A new flight, flown while it is looked at."""
    return fly()
