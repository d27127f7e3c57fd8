"""Thermals: updrafts at places, each with its ring of sink, single ones or a random field."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp
from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.world.local import LocalPlane

REACH = 4.0  # radii; beyond, a thermal moves less than 2e-6 of its strength
SPREAD = 0.5  # of the strengths and radii of a field, either side of their mean


class Thermal(NamedTuple):
    """One updraft at flying height: its centre at time 0 (rad), radius (m) and the updraft there (m/s)."""

    lat: float
    lon: float
    radius: float
    strength: float


class ThermalField(NamedTuple):
    """Updrafts strewn at random (Poisson): number per m^2, mean radius (m) and strength (m/s)."""

    density: float
    radius: float
    strength: float


class Thermals:
    """Given updrafts: up = strength (1 - s) exp(-s) with s = (r/radius)^2.

    Positive to the radius, sink outside, and no air moved on the whole: int (1 - s) exp(-s) ds = 0.  The profile
    is Gedeon's (1973, from memory).  Strength and radius are those of flying height, whatever the height.
    """

    def __init__(self, thermals: Sequence[Thermal], plane: LocalPlane) -> None:
        """plane: in which they stand, or drift.  Raises InputError for a radius that is not positive."""
        for index, thermal in enumerate(thermals):
            _check(thermal.radius, f"air.thermals.{index}.radius_m")
        self._plane = plane
        self._cores = np.array([(*plane.at(0.0, t.lat, t.lon), t.radius, t.strength) for t in thermals])

    def at(self, t: float, lat: float, lon: float, height: float) -> tuple[float, float, float]:
        """Velocity of the air in n, m/s, at a time (s) and place (rad; the height does not matter)."""
        return 0.0, 0.0, -_updraft(self._cores, *self._plane.at(t, lat, lon))


class ThermalCells:
    """A random field without end: the plane is divided into squares, each filled from its own seed when needed.

    So the field is the same wherever the aircraft comes first.  Strength and radius are even within SPREAD of
    their means.
    """

    def __init__(self, field: ThermalField, plane: LocalPlane, rng: np.random.Generator) -> None:
        """plane: in which they stand, or drift.  Raises InputError for a radius that is not positive."""
        _check(field.radius, "air.thermal_field.radius_m")
        self._field, self._plane = field, plane
        self._seed = int(rng.integers(2**63))
        # the eight neighbours of a square hold all that reaches into it; about one updraft each or more
        self._side = max(REACH * (1.0 + SPREAD) * field.radius, field.density**-0.5)
        self._near: tuple[int, int] | None = None
        self._cores = np.empty((0, 4))

    def at(self, t: float, lat: float, lon: float, height: float) -> tuple[float, float, float]:
        """Velocity of the air in n, m/s, at a time (s) and place (rad; the height does not matter)."""
        x, y = self._plane.at(t, lat, lon)
        near = int(x // self._side), int(y // self._side)
        if near != self._near:
            self._near = near
            around = [(near[0] + i, near[1] + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
            self._cores = np.vstack([self._cell(*each) for each in around])
        return 0.0, 0.0, -_updraft(self._cores, x, y)

    def _cell(self, i: int, j: int) -> Array:
        rng = np.random.default_rng([self._seed, i % 2**32, j % 2**32])
        count = rng.poisson(self._field.density * self._side**2)
        x, y, size, strength = rng.random((4, count))
        spread = 1.0 + SPREAD * (2.0 * np.array([size, strength]) - 1.0)
        return np.column_stack(
            [
                (i + x) * self._side,
                (j + y) * self._side,
                self._field.radius * spread[0],
                self._field.strength * spread[1],
            ]
        )


def _check(radius: float, key: str) -> None:
    if not radius > 0.0:
        raise InputError(f"a thermal of {radius:g} m radius", key=key, allowed="more than 0")


@njit(cache=True, nogil=True)
def _updraft(cores: Array, x: float, y: float) -> float:  # pragma: no cover - compiled
    up = 0.0
    for i in range(cores.shape[0]):
        dx, dy = x - cores[i, 0], y - cores[i, 1]
        s = (dx * dx + dy * dy) / (cores[i, 2] * cores[i, 2])
        if s < REACH * REACH:
            up += cores[i, 3] * (1.0 - s) * exp(-s)
    return up
