"""The navigator at the drift sight of a camera without tracking: he turns it by hand, in whole degrees."""

from __future__ import annotations

import logging
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from aerosim.crew import DEGREE, Looking, in_words, pause
from aerosim.signals import MotionEstimate
from aerosim.truth import AircraftState

journal = logging.getLogger("aerosim")

NAN, TURN = math.nan, 2.0 * math.pi
# In a bank the sight does not show the track; a gust's lasts less than a look.
LEVEL = math.radians(5.0)
# Another heading: another line, on which the last one's drift says nothing.
ANOTHER_LINE = math.radians(30.0)
FIRST_LOOK_S = 8.0
# The camera stands where it was told to.
STANDS = math.radians(0.5)


class Turned(NamedTuple):
    """A correction as spoken: t, s; whole degrees, positive clockwise seen from above."""

    t: float
    degrees: int


@dataclass(frozen=True)
class SightParameters(Looking):
    """How the navigator of a camera looks.

    He errs more than the one who directs the pilot (1 deg), who has the line's landmarks too, and a camera needs
    less time to settle than an aircraft.  vh_sigma: error of one reading of v/h, as a part of it; vh_weight: of a
    new one against what is set.
    """

    settle: float = 5.0
    track_sigma: float = 1.0 * DEGREE
    vh_sigma: float = 0.03
    vh_weight: float = 0.5


class DriftSight:
    """What a navigator tells the mount and the intervalometer: drift as the yaw that he ordered, v/h as set.

    He looks now and then, in level flight, sees the mean angle between the track and the camera's axis, and has
    the camera turned if it is worth a word.  He begins each line with the camera along the airframe.  At each look
    he also times the ground over a grid.  orders: all corrections spoken.
    """

    def __init__(self, parameters: SightParameters, period: float, rng: np.random.Generator) -> None:
        """period: between calls of `tell`, s.  rng: the navigator's own."""
        self.orders: list[Turned] = []
        self._p = parameters
        self._rng = rng
        self._follow = 1.0 - math.exp(-period / parameters.average)
        self._heading: float | None = None  # of the line
        self._ordered, self._spoken = 0.0, 0
        self._look_at = self._heard_at = math.inf
        self._seen = self._passing = self._vh = NAN
        self._looked = False

    def tell(self, aircraft: AircraftState, terrain_height: float, mount_yaw: float) -> MotionEstimate | None:
        """What he changes now, None if nothing.

        terrain_height: mean below, ellipsoidal, m.  mount_yaw: of the camera against the airframe, rad.  Drift
        and v/h are valid once he has looked, v/h NaN as long as there was no land below; he states no standard
        deviations.
        """
        a = aircraft
        if abs(a.roll) > LEVEL:
            self._seen = NAN  # what was seen in the bank says nothing
            return None
        if self._heading is None or abs(math.remainder(a.heading - self._heading, TURN)) > ANOTHER_LINE:
            return self._begin(a)
        if a.t >= self._heard_at:
            self._ordered += self._spoken * DEGREE
            self._heard_at, self._seen = math.inf, NAN
            return self._set(a.t)
        if abs(mount_yaw - self._ordered) > STANDS:
            self._seen = NAN  # nor what the sight shows while it turns
            return None
        track = math.atan2(a.v_east, a.v_north)
        crab = math.remainder(track - a.heading - mount_yaw, TURN)
        vh = math.hypot(a.v_north, a.v_east) / (a.height - terrain_height)
        if math.isnan(self._seen):
            self._seen, self._passing = crab, vh
        self._seen += self._follow * (crab - self._seen)
        if math.isnan(self._passing):  # there was no land below
            self._passing = vh
        elif not math.isnan(vh):
            self._passing += self._follow * (vh - self._passing)
        if a.t < self._look_at:
            return None
        self._look(a.t)
        return self._set(a.t)

    def _set(self, t: float) -> MotionEstimate:
        return MotionEstimate(t, self._ordered, self._vh, NAN, NAN, self._looked)

    def _begin(self, aircraft: AircraftState) -> MotionEstimate:
        """Another line: the camera goes back to the airframe's axis.  v/h is kept: it is known no better."""
        self._heading, self._ordered, self._seen = aircraft.heading, 0.0, NAN
        self._look_at, self._heard_at = aircraft.t + FIRST_LOOK_S, math.inf
        return self._set(aircraft.t)

    def _look(self, t: float) -> None:
        """He looks, times the ground, and speaks if there is enough to say."""
        p, rng = self._p, self._rng
        angle = self._seen + p.track_sigma * rng.standard_normal()
        read = self._passing * (1.0 + p.vh_sigma * rng.standard_normal())
        if math.isnan(self._vh):
            self._vh = read
        elif not math.isnan(read):
            self._vh += p.vh_weight * (read - self._vh)
        self._looked = True
        self._look_at = t + pause(p, rng)
        if degrees := in_words(angle, p):
            self.orders.append(Turned(t, degrees))
            journal.info("navigator at %.1f s: camera %+d deg", t, degrees)
            self._spoken, self._heard_at = degrees, t + p.reaction
            self._look_at += p.settle
