"""Natural motions of an aircraft: linearised about its trim, read from the running model."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from aerosim.flight.aircraft import Aircraft
from aerosim.flight.trim import Trim
from aerosim.frames import Array

STATES = ("u", "v", "w", "p", "q", "r", "roll", "pitch")
LONGITUDINAL = (0, 2, 4, 7)
LATERAL = (1, 3, 5, 6)
_STEP = np.array([0.01, 0.01, 0.01, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4])


class Modes(NamedTuple):
    """Natural frequencies (rad/s), damping ratios, time constants (s; negative: unstable)."""

    short_period: float
    short_period_damping: float
    phugoid: float
    phugoid_damping: float
    dutch_roll: float
    dutch_roll_damping: float
    roll_s: float
    spiral_s: float


def linearise(aircraft: Aircraft, trim: Trim, airspeed: float) -> Array:
    """Jacobian of the eight states u, v, w, p, q, r, roll, pitch at a trim in still air, controls fixed.

    Central differences.  airspeed: m/s.  Returns (8, 8), SI.  The aircraft cannot fly on afterwards.
    """
    level, v = airspeed * math.cos(trim.sideslip), airspeed * math.sin(trim.sideslip)
    u, w = level * math.cos(trim.alpha), level * math.sin(trim.alpha)
    x = np.array([u, v, w, 0.0, 0.0, 0.0, trim.roll, trim.pitch])
    columns = [
        (aircraft.derivatives(x + d) - aircraft.derivatives(x - d)) / (2.0 * d.sum()) for d in np.diag(_STEP)
    ]
    return np.column_stack(columns)


def modes(jacobian: Array) -> Modes:
    """Modes of a Jacobian from `linearise`.  The two sides are taken apart, as the books do."""
    pitching = np.linalg.eigvals(jacobian[np.ix_(LONGITUDINAL, LONGITUDINAL)])
    fast, slow = (sorted(pitching[pitching.imag > 0.0], key=abs)[i] for i in (-1, 0))
    rolling = np.linalg.eigvals(jacobian[np.ix_(LATERAL, LATERAL)])
    dutch = rolling[rolling.imag > 0.0][0]
    spiral, roll = sorted(rolling[rolling.imag == 0.0].real, key=abs)
    return Modes(
        *(abs(fast), -fast.real / abs(fast), abs(slow), -slow.real / abs(slow)),
        *(abs(dutch), -dutch.real / abs(dutch), -1.0 / roll, -1.0 / spiral),
    )
