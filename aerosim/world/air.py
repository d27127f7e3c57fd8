"""The air at the aircraft: states made block by block, with what depends on the place added when it is asked.

Not JSBSim's turbulence: that turns u and v into a frame that follows the wind's azimuth, so a crosswind changes
the roll that the same severity gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from aerosim.frames import Array
from aerosim.truth import AirState, Where

AIR_RATE_HZ = 40.0
"""Wanted rate of the air; a flight holds a state for round(step rate / this) steps."""
BLOCK = 512


class Source(Protocol):
    """Something that gives columns of a component of the air, step after step."""

    def draw(self, steps: int) -> Array:
        """The next (steps, k) values."""


class PlaceWind(Protocol):
    """A component of the air that depends on the place."""

    def at(self, t: float, lat: float, lon: float, height: float) -> tuple[float, float, float]:
        """Velocity of the air in n, m/s.  t: s after the start; lat, lon: rad; height: ellipsoidal, m."""


class TimeWind(Protocol):
    """A component of the air that is given over time."""

    def at(self, t: Array) -> Array:
        """Velocity of the air in n, (n, 3), m/s, at times (n,), s after the start."""


class Air:
    """The air along the flight, one state an air step.

    Without a component that depends on the place a state is taken from a list; with one, the aircraft's place is
    asked for, once a step.
    """

    def __init__(
        self,
        dt: float,
        steady: tuple[float, float, float] = (0.0, 0.0, 0.0),
        *,
        slow: Sequence[Source] = (),
        turbulence: Sequence[Source] = (),
        times: Sequence[TimeWind] = (),
        places: Sequence[PlaceWind] = (),
    ) -> None:
        """dt: air step, s.  steady: wind in n, m/s.  slow: sources of north and east wind.  turbulence: sources
        whose columns are, in this order, u, v, r, w, q, p.  times, places: winds by time and by place."""
        self.dt = dt
        self._steady = steady
        self._slow = slow
        self._turbulence = turbulence
        self._times = times
        self._places = places
        self._first = 0
        self._count = 0
        # numbers, not states: many objects alive at a time make work for the garbage collector
        self._flat: list[float] = []
        self._placed = bytearray()
        self._extend()

    def at(self, index: int, where: Where) -> AirState:
        """State of the air at air step `index`, held until the next.

        Steps rise; one of the current block may be asked for again and is the same.  where: gives the aircraft's
        latitude, longitude (rad) and ellipsoidal height (m); it is called only if something depends on them.
        Raises IndexError for a step behind the current block.
        """
        k = index - self._first
        if k >= self._count:
            self._run_to(index)
            k = index - self._first
        if k < 0:
            raise IndexError(f"the air of step {index} is gone")
        if self._places and not self._placed[k]:
            self._place(k, where())
        return AirState._make(self._flat[9 * k : 9 * k + 9])

    def _run_to(self, index: int) -> None:
        while index >= self._first + self._count:
            self._extend()

    def _place(self, k: int, place: tuple[float, float, float]) -> None:
        lat, lon, height = place
        t = (self._first + k) * self.dt
        for component in self._places:
            for axis, more in enumerate(component.at(t, lat, lon, height), start=9 * k):
                self._flat[axis] += more
        self._placed[k] = 1

    def _extend(self) -> None:
        self._first += self._count
        table = np.zeros((BLOCK, 9))
        table[:, :3] = self._steady
        for column, source in enumerate(self._slow):
            table[:, column] += source.draw(BLOCK)[:, 0]
        for given in self._times:
            table[:, :3] += given.at(self.dt * np.arange(self._first, self._first + BLOCK, dtype=float))
        if self._turbulence:
            u, v, r, w, q, p = np.hstack([source.draw(BLOCK) for source in self._turbulence]).T
            table[:, 3:] = np.column_stack([u, v, w, p, q, r])
        self._flat = table.ravel().tolist()
        self._count = BLOCK
        self._placed = bytearray(BLOCK)
