"""Steady level flight: Newton's method on the six accelerations of a running model."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from aerosim.errors import InputError
from aerosim.frames import Array


class Trim(NamedTuple):
    """Steady level flight.  Attitude and surfaces in rad, powers at the shaft in W, thrust in N.

    elevator + trailing edge down, aileron + rolls left, rudder + yaws left.  sideslip: + air from the right.
    thrust: of engines that push by a force of their own; 0 where the propeller is in the aerodynamics.  lift:
    coefficient across the air's path.  iterations: of Newton's method.
    """

    roll: float
    pitch: float
    heading: float
    alpha: float
    sideslip: float
    elevator: float
    aileron: float
    rudder: float
    power: float
    power_available: float
    thrust: float
    lift: float
    iterations: int


def first_guess(weight: float, airspeed: float, lift: float) -> tuple[Array, Array]:
    """A guess of any aircraft's trim, and how large its parts are about.

    weight: N; airspeed: m/s; lift: coefficient.  Both (7,): pitch, elevator, power, roll, aileron, rudder,
    sideslip, rad and W.  They take a lift-to-drag ratio of ten and a lift slope of 5.5 per rad.
    """
    power = weight * airspeed / 9.0
    return (
        np.array([lift / 5.5 - 0.06, 0.0, power, 0.0, 0.0, 0.0, 0.0]),
        np.array([0.1, 0.1, 0.5 * power, 0.1, 0.1, 0.1, 0.1]),
    )


def solve(
    residual: Callable[[Array], Array], start: Array, scale: Array, *, tolerance: float = 1e-9, most: int = 20
) -> tuple[Array, int]:
    """Root of a smooth function of as many values as unknowns.

    residual: (n,) to (n,); it is called with the root last.  start, scale: (n,), first guess and size of the
    unknowns.  tolerance: of each residual.  Returns the root and the number of iterations.
    Raises InputError when there is none near the first guess.
    """
    x, r = start, residual(start)
    for iteration in range(most):
        if np.abs(r).max() < tolerance:
            return x, iteration
        step = 1e-4 * scale
        jacobian = np.column_stack([(residual(x + d) - residual(x - d)) / 2e-4 for d in np.diag(step)])
        if not np.isfinite(jacobian).all() or np.linalg.matrix_rank(jacobian) < len(x):
            break
        # A step of more than half a unit leaves the range in which the guess says anything.
        move = -np.linalg.solve(jacobian, r)
        x = x + scale * move * min(1.0, 0.5 / np.abs(move).max())
        r = residual(x)
    raise InputError("no steady level flight found at this height and airspeed")
