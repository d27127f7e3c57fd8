"""Flies the plan: run-ins, lines, and turns that arrive on the next line in the wind."""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from aerosim.errors import InputError, RunFailure
from aerosim.flight.plan import FlightPlan, Line, wind_triangle
from aerosim.flight.steering import Kinematics, Law
from aerosim.flight.turns import ROLL_RATE, TURN, Turn, roll_lag
from aerosim.frames import GRAVITY

# Bank for each radian of heading on the straight part of a turn.
HEADING_GAIN = 1.5
# Heading left of the last arc at which the line itself is captured.
CAPTURE = math.radians(25.0)


class Phase(StrEnum):
    """Where in the plan the aircraft is."""

    RUN_IN = "run_in"
    LINE = "line"
    TURN = "turn"
    DONE = "done"


class _Part(StrEnum):
    """Part of a turn."""

    FIRST = "first"
    STRAIGHT = "straight"
    LAST = "last"


def _wrap(angle: float) -> float:
    return math.remainder(angle, TURN)


class Guidance:
    """Roll commands from position and velocity, called once a period (s).

    line: 0, 1, ... between a line's start and end, else -1.  next_line: the line flown or approached.
    """

    def __init__(self, plan: FlightPlan, period: float, law: Law, heading: float) -> None:
        """law: keeps to the lines; heading: of the nose on the first one, rad."""
        self.plan = plan
        self._law = law
        self.period = period
        self.phase = Phase.RUN_IN
        self.line = -1
        self.next_line = 0
        self.roll_command = 0.0
        self._lag = roll_lag(plan.bank_turn)
        self._rate = GRAVITY * math.tan(plan.bank_turn) / plan.airspeed
        self._take(plan.lines[0], heading)

    def _take(self, line: Line, heading: float) -> None:
        """Make a line the one that is flown or approached.  heading: of the nose on it in the wind, rad."""
        self._law.take(line, heading)
        start, end = line.end_points(self.plan.height)
        self._line = line
        self._normal = tuple(float(v) for v in line.normal)
        self._offset = line.offset
        self._forward = tuple(float(v) for v in line.forward_start)
        self._forward_end = tuple(float(v) for v in line.forward_end)
        self._along_start = float(line.forward_start @ start)
        self._along_end = float(line.forward_end @ end)

    def cross_track(self, x: float, y: float, z: float) -> float:
        """Distance from the line flown or approached, positive to its right, m.  x, y, z: in e, m."""
        a, b, c = self._normal
        return a * x + b * y + c * z - self._offset

    def update(self, at: Kinematics, heading: float, t: float, wind_north: float, wind_east: float) -> float:
        """Roll to command, rad.

        at: position (m), ground velocity (m/s) in e; heading: of the nose, rad; t: s; wind: where it goes to, m/s.
        """
        wanted = self._turn_step(at, wind_north, wind_east) if self.phase is Phase.TURN else None
        if wanted is None:
            wanted = self._law.bank(at, heading, t)
            self._progress(at, wind_north, wind_east)
        most = ROLL_RATE * self.period
        change = wanted - self.roll_command
        self.roll_command += most if change > most else -most if change < -most else change
        return self.roll_command

    def _progress(self, at: Kinematics, wind_north: float, wind_east: float) -> None:
        """Begin and end of lines."""
        x, y, z = at[:3]
        if self.phase is Phase.RUN_IN:
            a, b, c = self._forward
            if a * x + b * y + c * z >= self._along_start:
                self.phase, self.line = Phase.LINE, self.next_line
        elif self.phase is Phase.LINE:
            a, b, c = self._forward_end
            if a * x + b * y + c * z >= self._along_end:
                self.line = -1
                self._leave(at, wind_north, wind_east)

    def _leave(self, at: Kinematics, wind_north: float, wind_east: float) -> None:
        """End of a line: the flight is done, or the turn onto the next line begins."""
        if self.next_line + 1 == len(self.plan.lines):
            self.phase = Phase.DONE
            return
        self.phase = Phase.TURN
        self.next_line += 1
        self._begin_turn(at, self.plan.lines[self.next_line], (wind_north, wind_east))

    def _begin_turn(self, at: Kinematics, line: Line, wind: tuple[float, float]) -> None:
        try:
            self._turn: Turn = self.plan.turn(line, np.array(at[:3]), np.array(at[3:]), wind)
            heading, _ = wind_triangle(line.course, self.plan.airspeed, *wind)
        except InputError as refusal:
            raise RunFailure(f"line {self.next_line} cannot be reached: {refusal}") from refusal
        self._take(line, heading)
        self._part = _Part.FIRST
        self._left = self._turn.angle_first
        self._heading = self._air_heading(at, self._line.frame_wind(*wind))
        self._clock = 0.0

    def _air_heading(self, at: Kinematics, wind: tuple[float, float]) -> float:
        """Direction of flight through the air against the line's course, rad.  wind: in the line's frame."""
        _, _, _, vx, vy, vz = at
        a, b, c = self._normal
        d, e, f = self._forward
        return math.atan2(a * vx + b * vy + c * vz - wind[1], d * vx + e * vy + f * vz - wind[0])

    def _turn_step(self, at: Kinematics, wind_north: float, wind_east: float) -> float | None:
        """Bank in a turn, None when the line itself can be captured."""
        wind = self._line.frame_wind(wind_north, wind_east)
        heading = self._air_heading(at, wind)
        self._clock += self.period
        if self._part is not _Part.STRAIGHT:
            side = self._turn.first if self._part is _Part.FIRST else self._turn.last
            self._left -= side * _wrap(heading - self._heading)
        self._heading = heading
        if self._part is _Part.FIRST:
            return self._first_arc()
        if self._part is _Part.STRAIGHT:
            return self._straight(at, wind)
        return self._last_arc(at, wind)

    def _first_arc(self) -> float:
        if self._left > self._rate * self._lag:
            return self._turn.first * self.plan.bank_turn
        self._part, self._clock = _Part.STRAIGHT, -self._lag
        self._miss: float | None = None
        return 0.0

    def _straight(self, at: Kinematics, wind: tuple[float, float]) -> float | None:
        """Heading held until the last arc, begun now, would end on the line."""
        turn = self._turn
        left = math.fmod(turn.last * (turn.heading_end - self._heading) + 2.0 * TURN, TURN)
        miss, _ = self._miss_of(at, wind, left, self._lag)
        crossed = self._miss is not None and miss * self._miss <= 0.0
        self._miss = miss
        due = turn.straight_s - self._lag
        # On a straight part along the line the miss says nothing about when to turn.
        slack = 3.0 + 0.1 * turn.straight_s * abs(math.sin(turn.straight))
        if (crossed and self._clock > due - slack) or self._clock > due + slack:
            self._part, self._left, self._clock = _Part.LAST, left, 0.0
            return self._last_arc(at, wind)
        limit = self.plan.bank_turn
        bank = HEADING_GAIN * _wrap(turn.straight - self._heading)
        return limit if bank > limit else -limit if bank < -limit else bank

    def _miss_of(self, at: Kinematics, wind: tuple[float, float], left: float, lag: float) -> tuple[float, float]:
        """Where the last arc, flown at its planned bank, ends beside the line, and the share of it in the radius.

        left: heading still to turn, rad; lag: s before the turn takes hold.  Returns m and m for each m of radius.
        """
        _, _, _, vx, vy, vz = at
        a, b, c = self._normal
        across = self.cross_track(*at[:3]) + lag * (a * vx + b * vy + c * vz)
        sway = self._turn.last * (math.cos(self._heading) - math.cos(self._turn.heading_end))
        a_metre = sway + wind[1] * left / self.plan.airspeed
        return across + a_metre * self.plan.airspeed / self._rate, a_metre

    def _last_arc(self, at: Kinematics, wind: tuple[float, float]) -> float | None:
        """Bank of the arc that ends on the line, None at its end."""
        if self._left < CAPTURE:
            self.phase = Phase.RUN_IN
            return None
        lag = max(0.0, self._lag - 0.5 * self._clock)
        miss, a_metre = self._miss_of(at, wind, self._left, lag)
        nominal = self.plan.airspeed / self._rate
        radius = nominal
        if self._left < 0.9 * math.pi and abs(a_metre) > 1e-3:
            radius = nominal - miss / a_metre
        least = self.plan.airspeed**2 / (GRAVITY * math.tan(self.plan.bank_max))
        radius = min(max(radius, least), 2.5 * nominal)
        return self._turn.last * math.atan(self.plan.airspeed**2 / (GRAVITY * radius))
