"""What keeps the aircraft on a run-in and its line: the pilot who tracks it from position and velocity."""

from __future__ import annotations

import math
from typing import Protocol

from aerosim.flight.plan import FlightPlan, Line
from aerosim.frames import EARTH_RATE, GRAVITY

Kinematics = tuple[float, float, float, float, float, float]

# Bank for each metre off the line, each m/s across it, each metre second: well damped, 64 s long, so that it
# neither chases gusts of seconds nor rolls the camera for them.
OFFSET_GAIN = 1.0e-3
RATE_GAIN = 0.0164
INTEGRAL_GAIN = 1.6e-5
INTEGRAL_BAND = 5.0
# Rate of closing towards the line, as a part of the airspeed, at most.
CLOSING = 0.5


class Law(Protocol):
    """A pilot's way to keep to a line, called once a guidance period."""

    def take(self, line: Line, heading: float) -> None:
        """Make a line the one that is flown or approached.  heading: of the nose on it in the wind, rad."""

    def bank(self, at: Kinematics, heading: float, t: float) -> float:
        """Bank wanted, rad.  at: position (m), ground velocity (m/s) in e; heading: of the nose, rad; t: s."""


class Tracking:
    """Bank from the distance off the line and its rate, as an autopilot with satellite navigation has them."""

    def __init__(self, plan: FlightPlan, period: float) -> None:
        """period: of the guidance, s."""
        self._most = CLOSING * plan.airspeed * RATE_GAIN
        self._limit = plan.bank_max
        self._airspeed = plan.airspeed
        self._integral_gain = INTEGRAL_GAIN * period

    def take(self, line: Line, heading: float) -> None:
        """Make a line the one that is flown or approached.  heading: of no use here."""
        self._normal = tuple(float(v) for v in line.normal)
        self._offset = line.offset
        self._integral = 0.0
        # Bank against the Coriolis acceleration, which pushes to the right on the northern half.
        self._level = -2.0 * EARTH_RATE * math.sin(line.start[0]) * self._airspeed / GRAVITY

    def bank(self, at: Kinematics, heading: float, t: float) -> float:
        """Bank wanted, rad.  at: position (m), ground velocity (m/s) in e."""
        x, y, z, vx, vy, vz = at
        a, b, c = self._normal
        across = a * x + b * y + c * z - self._offset
        rate = a * vx + b * vy + c * vz
        if -INTEGRAL_BAND < across < INTEGRAL_BAND:
            self._integral += self._integral_gain * across
        most, limit = self._most, self._limit
        closing = OFFSET_GAIN * across
        closing = most if closing > most else -most if closing < -most else closing
        bank = self._level - closing - RATE_GAIN * rate - self._integral
        return limit if bank > limit else -limit if bank < -limit else bank
