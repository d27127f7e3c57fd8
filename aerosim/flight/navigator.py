"""The pilot who flies a heading, corrected by word of mouth: the crew of a camera without tracking."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from aerosim.crew import DEGREE, Looking, in_words, pause
from aerosim.flight.plan import FlightPlan, Line
from aerosim.flight.steering import Kinematics

journal = logging.getLogger("aerosim")

# Bank for each radian of heading: a correction is flown within 15 s, and gusts that yaw the nose roll little.
HEADING_GAIN = 1.2
# The pilot's bank for a spoken correction, at most; rolling out of a turn he has the turn's.
CORRECTION_BANK = math.radians(6.0)
ROLLING_OUT = math.radians(8.0)
# On the heading: the navigator begins to look.
ON_HEADING = math.radians(2.0)
FIRST_LOOK_S = 8.0
# Steepest track towards the line.
CLOSING_MAX = math.radians(10.0)


class Order(NamedTuple):
    """A correction as spoken: t, s; whole degrees, positive to the right."""

    t: float
    degrees: int


@dataclass(frozen=True)
class NavigatorParameters(Looking):
    """How a crew flies by word of mouth.  Angles in rad, times in s, distances in m.

    offset_sigma: error of a look in the distance from the line.  closing: distance ahead at which the line is to
    be met again.  hold_sigma, hold_time: wander of the heading that the pilot holds.
    """

    offset_sigma: float = 25.0
    closing: float = 4000.0
    hold_sigma: float = 0.5 * DEGREE
    hold_time: float = 20.0


class Navigator:
    """Law of a pilot who holds a heading and a navigator who now and then corrects it, imperfectly.

    orders: all corrections spoken, run-ins included.  ordered: heading that the pilot has to hold, rad.
    """

    def __init__(
        self, plan: FlightPlan, period: float, parameters: NavigatorParameters, rng: np.random.Generator
    ) -> None:
        """period: of the guidance, s.  rng: the crew's own."""
        self.orders: list[Order] = []
        self.ordered = 0.0
        self._plan = plan
        self._p = parameters
        self._rng = rng
        self._period = period
        self._keep = math.exp(-period / parameters.hold_time)
        self._kick = parameters.hold_sigma * math.sqrt(1.0 - self._keep**2)
        self._hold = parameters.hold_sigma * rng.standard_normal()
        self._follow = 1.0 - math.exp(-period / parameters.average)

    def take(self, line: Line, heading: float) -> None:
        """Pilot and navigator turn to a line: the planned heading, in whole degrees, is what the pilot holds."""
        self._normal = tuple(float(v) for v in line.normal)
        self._offset = line.offset
        self._forward = tuple(float(v) for v in line.forward_start)
        self.ordered = round(heading / DEGREE) * DEGREE
        self._track: float | None = None
        self._look_at = math.inf
        self._heard_at = math.inf
        self._spoken = 0

    def bank(self, at: Kinematics, heading: float, t: float) -> float:
        """Bank of the pilot's hand, rad.  at: position (m), ground velocity (m/s) in e; heading: rad; t: s."""
        self._hold = self._keep * self._hold + self._kick * self._rng.standard_normal()
        x, y, z, vx, vy, vz = at
        a, b, c = self._normal
        d, e, f = self._forward
        track = math.atan2(a * vx + b * vy + c * vz, d * vx + e * vy + f * vz)
        self._track = track if self._track is None else self._track + self._follow * (track - self._track)
        if t >= self._heard_at:
            self.ordered += self._spoken * DEGREE
            self._heard_at = math.inf
        error = math.remainder(self.ordered + self._hold - heading, 2.0 * math.pi)
        if self._look_at == math.inf and abs(error) < ON_HEADING:
            # What the sight showed while turning says nothing.
            self._track, self._look_at = track, t + FIRST_LOOK_S
        if t >= self._look_at:
            self._look(self._track, a * x + b * y + c * z - self._offset, t)
        limit = CORRECTION_BANK if abs(error) < ROLLING_OUT else self._plan.bank_turn
        return min(max(HEADING_GAIN * error, -limit), limit)

    def _look(self, track: float, across: float, t: float) -> None:
        """The navigator looks through the sight, and speaks if there is enough to say."""
        p = self._p
        seen = track + p.track_sigma * self._rng.standard_normal()
        offset = across + p.offset_sigma * self._rng.standard_normal()
        closing = min(max(offset / p.closing, -CLOSING_MAX), CLOSING_MAX)
        degrees = in_words(-(seen + closing), p)
        self._look_at = t + pause(p, self._rng)
        if degrees:
            self.orders.append(Order(t, degrees))
            journal.info("navigator at %.1f s: %+d deg", t, degrees)
            self._spoken, self._heard_at = degrees, t + p.reaction
            self._look_at += p.settle
