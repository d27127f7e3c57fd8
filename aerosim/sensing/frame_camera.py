"""The frame camera's shutter: when a photo is taken, and the pose in the middle of its exposure."""

from __future__ import annotations

import math
from typing import NamedTuple

from aerosim.sensing.mount import Mount
from aerosim.signals import CameraCommand
from aerosim.truth import AircraftState, Shot

FAR = 1 << 30  # steps
SMOOTH = 0.3  # of each change of the lead goes into its rate: readings are noisy


class ShutterParameters(NamedTuple):
    """exposure: s.  delay: from the trigger to the opening, s.  rest: shortest time between two triggers, s.

    fmc_limit: fastest forward-motion compensation, rad/s.
    """

    exposure: float
    delay: float
    rest: float = 0.0
    fmc_limit: float = math.inf


class _Pending(NamedTuple):
    t: float
    line: int
    interval: float
    fmc_rate: float


class FrameCamera:
    """Takes photos on survey lines, the first at a line's start, then each time the wanted interval has run."""

    def __init__(self, parameters: ShutterParameters, dt: float) -> None:
        """dt: step, s."""
        self._lag = parameters.delay + parameters.exposure / 2.0
        self._rest, self._ready = parameters.rest, -math.inf
        self._fmc_limit = parameters.fmc_limit
        self._dt = dt
        self._elapsed = 1.0
        self._lead = self._lead_shot = 0.0
        self._growth = self._left = self._left_growth = 0.0
        self._line = -1
        self._pending: list[_Pending] = []

    def step(self, t: float, line: int, command: CameraCommand, span: float | None = None) -> bool:
        """Count the time from t (s) to t + span, a step by default; says whether a photo is due in this step.

        line: survey line, -1 for none.  The interval may change at any time: its share of each span counts.  So
        does the command's lead: the base is taken between footprints, the next one as its exposure will find it.
        """
        span = self._dt if span is None else span
        if line != self._line:
            self._line, self._elapsed, self._lead_shot = line, 1.0, command.lead
        growth = self._growth + SMOOTH * ((command.lead - self._lead) / span - self._growth)
        left_growth = self._left_growth + SMOOTH * ((command.left - self._left) / span - self._left_growth)
        self._lead, self._growth, self._left, self._left_growth = command.lead, growth, command.left, left_growth
        if line >= 0:
            lead = command.lead + growth * self._lag
            rate = 1.0 / command.interval + growth
            done = self._elapsed + lead - self._lead_shot
            wait = max((1.0 - done) / rate, self._ready - t, 0.0) if rate > 0.0 else span
            while wait < span:
                fmc = min(command.fmc_rate, self._fmc_limit)
                self._pending.append(_Pending(t + wait + self._lag, line, command.interval, fmc))
                self._lead_shot = command.left + left_growth * (self._lag + wait)
                self._elapsed = -wait / command.interval
                self._ready = t + wait + self._rest
                wait += command.interval
            self._elapsed += span / command.interval
        return self.due(t)

    def due(self, t: float) -> bool:
        """Whether the middle of an exposure falls into the step from t, s."""
        return len(self._pending) > 0 and self._pending[0].t < t + self._dt

    def steps_to_next(self, t: float) -> int:
        """Steps from t (s) to the one in which the next known exposure falls."""
        return int((self._pending[0].t - t) / self._dt) if self._pending else FAR

    def expose(self, aircraft: AircraftState, mount: Mount) -> Shot:
        """The photo that is due in this step, its pose carried on to the middle of the exposure."""
        due = self._pending.pop(0)
        pose = mount.pose(aircraft, due.t - aircraft.t)
        return Shot(pose, due.line, due.interval, due.fmc_rate)
