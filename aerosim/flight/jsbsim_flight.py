"""The flight that the loop steps: aircraft, guidance and the air that moves them."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin

from aerosim.flight.aircraft import Aircraft
from aerosim.flight.guidance import Guidance, Phase
from aerosim.flight.plan import FlightPlan, wind_triangle
from aerosim.truth import AircraftState, AirState

GUIDANCE_RATE_HZ = 20.0


class JsbsimFlight:
    """A plan flown by JSBSim.  It starts trimmed in the wind, at the run-in of line 0.

    Raises InputError for a plan that this aircraft cannot fly in this wind.
    """

    def __init__(
        self, aircraft: Aircraft, plan: FlightPlan, wind_n: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ) -> None:
        """wind_n: velocity of the air at the start, north, east, down, m/s."""
        self.aircraft = aircraft
        self.plan = plan
        for line in plan.lines:
            wind_triangle(line.course, plan.airspeed, wind_n[0], wind_n[1])
        first = plan.lines[0]
        distance = plan.run_in_distance(first, wind_n[0], wind_n[1])
        lat, lon = first.before_start(distance, plan.height)
        course = first.course_at(lat, lon)
        self.trim = aircraft.start(lat, lon, plan.height, course, plan.airspeed, wind_n)
        self._every = max(1, round(aircraft.step_rate / GUIDANCE_RATE_HZ))
        self._guidance = Guidance(plan, self._every * aircraft.step_period)
        self._guidance.roll_command = self.trim.roll
        self._until = 0
        self._mat_nb = _mat_nb(*aircraft.attitude())

    def step(self, air: AirState) -> None:
        """One step of the aircraft in this air, see `advance`."""
        self.advance((air,))

    def advance(self, air: Sequence[AirState]) -> None:
        """A step of the aircraft in each of these states of the air.  Raises RunFailure when it is lost.

        Gusts are turned from b to n by the attitude of the last guidance step, at most 50 ms old: at 4 deg/s of
        roll that misplaces 0.4 % of a gust.
        """
        while air:
            if self._until == 0:
                self._guide(air[0])
            now, air = air[: self._until], air[self._until :]
            self.aircraft.fly(now, self._mat_nb)
            self._until -= len(now)

    def _guide(self, air: AirState) -> None:
        aircraft = self.aircraft
        self._until = self._every
        aircraft.command_roll(self._guidance.update(aircraft.ecef(), air.wind_north, air.wind_east))
        self._mat_nb = _mat_nb(*aircraft.attitude())

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
        x, y, z = self.aircraft.ecef()[:3]
        return self._guidance.cross_track(x, y, z)

    @property
    def done(self) -> bool:
        """Whether the last line's end has been passed."""
        return self._guidance.phase is Phase.DONE


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
