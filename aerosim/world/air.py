"""The air at the aircraft: steady wind, slow wind and continuous turbulence, one generator each.

Not JSBSim's turbulence: that turns u and v into a frame that follows the wind's azimuth, so a crosswind changes
the roll that the same severity gives.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from aerosim.frames import Array
from aerosim.truth import AirState, Where
from aerosim.world.dryden import dryden_processes
from aerosim.world.process import GaussProcess

AIR_RATE_HZ = 40.0
BLOCK = 512  # short, so that few objects are alive at a time


class Source(Protocol):
    """Something that gives columns of a component of the air, step after step."""

    def draw(self, steps: int) -> Array:
        """The next (steps, k) values."""


def wind_n(speed: float, from_azimuth: float) -> tuple[float, float, float]:
    """Velocity of the air in n (m/s) of a wind that comes FROM an azimuth (rad, clockwise from north)."""
    return -speed * float(np.cos(from_azimuth)), -speed * float(np.sin(from_azimuth)), 0.0


def slow_wind_process(sigma: float, time_constant: float, dt: float, rng: np.random.Generator) -> GaussProcess:
    """One component of the slow wind: first-order Gauss-Markov.  m/s, s; it starts in its stationary state."""
    return GaussProcess([[-1.0 / time_constant]], [[sigma * np.sqrt(2.0 / time_constant)]], [[1.0]], dt, rng)


class Air:
    """The air along the flight, one state a step, made block by block so that a run of any length fits."""

    def __init__(
        self, steady: tuple[float, float, float], slow: Sequence[Source], gusts: Sequence[Source]
    ) -> None:
        """steady: wind in n, m/s.  slow: sources of north and east wind, or none.  gusts: sources whose
        columns are, in this order, u, v, r, w, q, p; or none."""
        self._steady = steady
        self._slow = slow
        self._gusts = gusts
        self._first = 0
        self._states: list[AirState] = []
        self._extend()

    def at(self, index: int, where: Where) -> AirState:
        """State number `index`; IndexError for one behind the current block.  where: not asked, see `Where`."""
        while index >= self._first + len(self._states):
            self._extend()
        if index < self._first:
            raise IndexError(f"state {index} of the air is gone")
        return self._states[index - self._first]

    def _extend(self) -> None:
        self._first += len(self._states)
        table = np.zeros((BLOCK, 9))
        table[:, :3] = self._steady
        for column, source in enumerate(self._slow):
            table[:, column] += source.draw(BLOCK)[:, 0]
        if self._gusts:
            u, v, r, w, q, p = np.hstack([source.draw(BLOCK) for source in self._gusts]).T
            table[:, 3:] = np.column_stack([u, v, w, p, q, r])
        self._states = [AirState._make(row) for row in table.tolist()]


def make_air(
    steady: tuple[float, float, float],
    slow_sigma: float,
    slow_time_constant: float,
    gust_sigma: float,
    gust_length: float,
    airspeed: float,
    span: float,
    dt: float,
    rng_of: RngOf,
) -> Air:
    """Air of a scenario.  rng_of: generator by component name.  SI; span: wing span for the rate gusts."""
    slow: list[Source] = []
    gusts: list[Source] = []
    if slow_sigma > 0.0:
        slow = [
            slow_wind_process(slow_sigma, slow_time_constant, dt, rng_of(f"air.slow_wind.{axis}"))
            for axis in ("north", "east")
        ]
    if gust_sigma > 0.0:
        gusts = list(dryden_processes(gust_sigma, gust_length, airspeed, span, dt, rng_of))
    return Air(steady, slow, gusts)


class RngOf(Protocol):
    """Generator of a component by its name."""

    def __call__(self, name: str, /) -> np.random.Generator:
        """The component's generator."""
