"""The frame camera's shutter: when a photo is taken, and the pose in the middle of its exposure."""

from __future__ import annotations

from typing import NamedTuple

from aerosim.sensing.mount import Mount
from aerosim.signals import CameraCommand
from aerosim.truth import AircraftState, Shot

FAR = 1 << 30  # steps


class ShutterParameters(NamedTuple):
    """exposure: s.  delay: from the trigger to the opening, s."""

    exposure: float
    delay: float


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
        self._dt = dt
        self._elapsed = 1.0
        self._line = -1
        self._pending: list[_Pending] = []

    def step(self, t: float, line: int, command: CameraCommand, span: float | None = None) -> bool:
        """Count the time from t (s) to t + span, a step by default; says whether a photo is due in this step.

        line: survey line, -1 for none.  The interval may change at any time: its share of each span counts.
        """
        span = self._dt if span is None else span
        if line != self._line:
            self._line, self._elapsed = line, 1.0
        if line >= 0:
            wait = (1.0 - self._elapsed) * command.interval
            while wait < span:
                self._pending.append(_Pending(t + wait + self._lag, line, command.interval, command.fmc_rate))
                wait += command.interval
            self._elapsed = 1.0 - (wait - span) / command.interval
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
