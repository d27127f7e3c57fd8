"""The frame camera's shutter: when a photo is taken, and the pose in the middle of its exposure."""

from __future__ import annotations

from typing import NamedTuple

from aerosim.sensing.mount import Mount
from aerosim.signals import CameraCommand
from aerosim.truth import AircraftState, Shot


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

    def step(self, t: float, line: int, command: CameraCommand) -> bool:
        """Count the present step (from t, s) towards the next photo; says whether one is exposed in it.

        line: survey line, -1 for none.  The interval may change at any time: its share of each step counts.
        """
        if line != self._line:
            self._line, self._elapsed = line, 1.0
        if line >= 0:
            if self._elapsed >= 1.0:
                # what the step went beyond the interval counts for the next one
                over = self._elapsed - 1.0 if self._elapsed < 1.0 + self._dt / command.interval else 0.0
                middle = t - over * command.interval + self._lag
                self._pending.append(_Pending(middle, line, command.interval, command.fmc_rate))
                self._elapsed = over
            self._elapsed += self._dt / command.interval
        return len(self._pending) > 0 and self._pending[0].t < t + self._dt

    def expose(self, aircraft: AircraftState, mount: Mount) -> Shot:
        """The photo that is due in this step, its pose carried on to the middle of the exposure."""
        due = self._pending.pop(0)
        pose = mount.pose(aircraft, due.t - aircraft.t)
        return Shot(pose, due.line, due.interval, due.fmc_rate)
