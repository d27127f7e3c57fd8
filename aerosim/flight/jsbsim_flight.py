"""The flight that the loop steps: aircraft, guidance and the air that moves them."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin

import numpy as np
from numpy.typing import NDArray

from aerosim.flight.aircraft import Aircraft
from aerosim.flight.guidance import Guidance, Phase
from aerosim.flight.interface import Air
from aerosim.flight.plan import FlightPlan, wind_triangle
from aerosim.flight.steering import Law, Tracking
from aerosim.frames import Array
from aerosim.truth import AircraftState

GUIDANCE_EVERY = 4  # states of the air: 10 Hz; rolling takes seconds, and every call costs half a step of JSBSim


class JsbsimFlight:
    """A plan flown by JSBSim.  It starts trimmed in the wind, at the run-in of line 0.

    air: what the aircraft feels now.  Raises InputError for a plan that this aircraft cannot fly in this wind.
    """

    def __init__(
        self,
        aircraft: Aircraft,
        plan: FlightPlan,
        air: Air,
        hold: int,
        pilot: Callable[[FlightPlan, float], Law] = Tracking,
    ) -> None:
        """air: its states follow each other every `hold` steps.  pilot: makes its law, for a period (s)."""
        self.aircraft = aircraft
        self.sample = aircraft.sample
        self.plan = plan
        self._air = air
        self._hold = hold
        first = plan.lines[0]
        lat, lon = first.start
        self.air = air.at(0, lambda: (lat, lon, plan.height))
        wind_n = self.air[:3]
        for line in plan.lines:
            wind_triangle(line.course, plan.airspeed, wind_n[0], wind_n[1])
        distance = plan.run_in_distance(first, wind_n[0], wind_n[1])
        lat, lon = first.before_start(distance, plan.height)
        course = first.course_at(lat, lon)
        self.trim = aircraft.start(lat, lon, plan.height, course, plan.airspeed, wind_n)
        period = GUIDANCE_EVERY * hold * aircraft.step_period
        self._guidance = Guidance(plan, period, pilot(plan, period), self.trim.heading)
        self._guidance.roll_command = self.trim.roll
        self._where = aircraft.place
        self._index = 0
        self._left = 0

    def advance(self, steps: int) -> None:
        """Fly so many steps.  Raises RunFailure when the aircraft is lost.

        Gusts are turned from b to n by the attitude of the last guidance step, at most 0.1 s old: at 4 deg/s of
        roll that misplaces 0.7 % of a gust.
        """
        left, advance = self._left, self.aircraft.advance
        while steps > left:
            if left:
                advance(left)
                steps -= left
            self._meet_air()
            left = self._hold
        advance(steps)
        self._left = left - steps

    def _meet_air(self) -> None:
        """The next state of the air, and every fourth time the guidance's next word."""
        aircraft = self.aircraft
        self.air = air = self._air.at(self._index, self._where)
        if self._index % GUIDANCE_EVERY == 0:
            attitude, t = aircraft.attitude(), aircraft.steps * aircraft.step_period
            self._mat_nb = _mat_nb(*attitude)
            roll = self._guidance.update(aircraft.ecef(), attitude[2], t, air.wind_north, air.wind_east)
            aircraft.command_roll(roll)
        aircraft.feel(air, self._mat_nb)
        self._index += 1

    def state(self) -> AircraftState:
        """State of the aircraft now."""
        return self.aircraft.state()

    @property
    def line(self) -> int:
        """Number of the line being flown, -1 in run-ins and turns and after the last line."""
        return self._guidance.line

    @property
    def next_line(self) -> int:
        """Number of the line being flown or approached."""
        return self._guidance.next_line

    @property
    def phase(self) -> Phase:
        """Where in the plan the aircraft is."""
        return self._guidance.phase

    @property
    def cross_track(self) -> float:
        """Distance from the line being flown or approached, positive to its right, m."""
        return self._guidance.cross_track(*self.aircraft.place_e())

    @property
    def done(self) -> bool:
        """Whether the last line's end has been passed."""
        return self._guidance.phase is Phase.DONE

    @property
    def steady(self) -> int:
        """Steps until the air is met again."""
        return self._left

    def states(self, samples: Array, first: int, next_line: NDArray[np.int64]) -> Array:
        """AircraftState and cross-track, (n, 15), of samples (n, 16) at steps `first` on; next_line: (n,)."""
        states, pos_e = self.aircraft.states(samples, first)
        lines = self.plan.lines
        a, b, c = np.array([line.normal for line in lines])[next_line].T
        x, y, z = pos_e.T
        # in the order in which the guidance adds
        across = a * x + b * y + c * z - np.array([line.offset for line in lines])[next_line]
        return np.column_stack([states, across])


def _mat_nb(roll: float, pitch: float, heading: float) -> tuple[float, ...]:
    """mat_nb = Rz(heading) Ry(pitch) Rx(roll), row by row; plain floats, since it is used one number at a time."""
    sr, cr, sp, cp, sh, ch = sin(roll), cos(roll), sin(pitch), cos(pitch), sin(heading), cos(heading)
    return (
        ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr,
        sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr,
        -sp, cp * sr, cp * cr,
    )  # fmt: skip


def bare_loop(aircraft: Aircraft, steps: int) -> None:
    """JSBSim alone with the model's own autopilot, in steady wind: what the loop's time is compared with."""
    run = aircraft.bare_step
    for _ in range(steps):
        run()
