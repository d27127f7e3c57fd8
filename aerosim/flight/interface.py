"""What a flight asks for, and what the loop asks of a flight, whatever moves it."""

from __future__ import annotations

from typing import Protocol

from aerosim.flight.guidance import Phase
from aerosim.flight.plan import FlightPlan
from aerosim.truth import AircraftState, AirState, Where


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
