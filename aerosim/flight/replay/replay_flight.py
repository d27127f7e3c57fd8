"""The replayed aircraft, step by step, with the interface of the flight that JSBSim flies."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from aerosim.flight.guidance import Phase
from aerosim.flight.interface import Air
from aerosim.flight.plan import FlightPlan
from aerosim.flight.replay.attitude import HALO, Attitude, body_rates, coordinated, gust_n, slope, with_given
from aerosim.flight.replay.replay import Replay
from aerosim.frames import Array, ecef_from_geodetic, wrap_pi
from aerosim.truth import AircraftState, AirState

BLOCK_S = 40.0
# An aircraft follows the wind's changes in seconds: its heading feels the mean of so long.
WIND_S = 2.0
_PHASES = (Phase.TURN, Phase.RUN_IN, Phase.LINE, Phase.DONE)


class _Block(NamedTuple):
    """Steps from number `first` on: table (n, 14) of states, and by step cross-track, line, next line, phase."""

    first: int
    table: Array
    across: list[float]
    line: list[int]
    next_line: list[int]
    phase: list[int]


class ReplayFlight:
    """A replay stepped at the scenario's rate, from the first run-in to the end of the last line.

    The path is that of the file, so gusts do not move it: they show in the air of the record and in the airspeed.
    The attitude feels the steady and the slow wind, averaged over two seconds.
    """

    def __init__(self, replay: Replay, air: Air, hold: int, step_rate: float) -> None:
        """air: its states follow each other every `hold` steps.  step_rate: Hz."""
        self.replay = replay
        self._air, self._hold, self._dt = air, hold, 1.0 / step_rate
        self._states: list[AirState] = []
        self._dropped = 0
        self._winds: list[Array] = []
        self._bin = max(1, round(WIND_S / (hold * self._dt)))
        self._size = hold * max(1, round(BLOCK_S / (hold * self._dt)))
        self._step = 0
        self._times = np.array([[each.run_in, each.start, each.end] for each in replay.lines]) - replay.begin
        self._normals = np.array([each.line.normal for each in replay.lines])
        self._offsets = np.array([each.line.offset for each in replay.lines])
        self._block = self._make(0)
        first = self._first_wind()
        self.plan: FlightPlan = replay.plan(first[0], first[1])

    def _first_wind(self) -> tuple[float, float]:
        return self._states[0].wind_north, self._states[0].wind_east

    def advance(self, steps: int) -> None:
        """Fly so many steps."""
        self._step += steps
        while self._step >= self._block.first + len(self._block.table):
            self._block = self._make(self._block.first + len(self._block.table))

    def state(self) -> AircraftState:
        """State of the aircraft now."""
        return AircraftState._make(self._block.table[self._step - self._block.first].tolist())

    @property
    def air(self) -> AirState:
        """The air that the aircraft is in now."""
        return self._states[self._step // self._hold - self._dropped]

    @property
    def line(self) -> int:
        """Number of the line being flown, -1 in run-ins and turns and after the last line."""
        return self._block.line[self._step - self._block.first]

    @property
    def next_line(self) -> int:
        """Number of the line being flown or approached."""
        return self._block.next_line[self._step - self._block.first]

    @property
    def phase(self) -> Phase:
        """Where in the flight the aircraft is."""
        return _PHASES[self._block.phase[self._step - self._block.first]]

    @property
    def cross_track(self) -> float:
        """Distance from the line being flown or approached, positive to its right, m."""
        return self._block.across[self._step - self._block.first]

    @property
    def done(self) -> bool:
        """Whether the last line's end has been passed."""
        return self.phase is Phase.DONE

    @property
    def steady(self) -> int:
        """Line and phase may change at any step."""
        return 0

    def sample(self) -> list[float]:
        """State and cross-track of now."""
        k = self._step - self._block.first
        return [*self._block.table[k].tolist(), self._block.across[k]]

    def states(self, samples: Array, first: int, next_line: NDArray[np.int64]) -> Array:
        """AircraftState and cross-track, (n, 15): the samples themselves."""
        return samples

    def _make(self, first: int) -> _Block:
        """The next block of steps."""
        steps = np.arange(first - 2 * HALO, first + self._size + 2 * HALO)
        self._meet_air(first)
        t = np.asarray(steps * self._dt, float)
        motion = self.replay.path.motion(self.replay.begin + t)
        vel_air = motion.vel_n - self._wind(t)
        inner = slice(HALO, -HALO)
        filled = coordinated(vel_air[inner], slope(vel_air, self._dt), self.replay.alpha)
        wide = with_given(filled, self.replay.attitude, self.replay.begin + t[inner])
        rate = Attitude(*(slope(angle, self._dt) for angle in wide))
        now = Attitude(*(angle[inner] for angle in wide))
        inside = slice(2 * HALO, -2 * HALO)
        lat, lon, height, vel_n = (values[inside] for values in motion)
        omega = body_rates(now, rate, lat, height, vel_n)
        table = np.column_stack([
            t[inside], lat, wrap_pi(lon), height, vel_n, now.roll, now.pitch, wrap_pi(now.heading), omega,
            self._airspeed(first, vel_n, now),
        ])  # fmt: skip
        return _Block(first, table, *self._place(t[inside], lat, lon, height))

    def _meet_air(self, first: int) -> None:
        """Air for a block and the time that its wind is averaged over; what lies behind is dropped."""
        behind = first // self._hold - self._dropped
        del self._states[:behind]
        self._dropped += behind
        bins = (first + self._size) // (self._hold * self._bin) + 4
        begin, path = self._dropped + len(self._states), self.replay.path
        index = np.arange(begin, bins * self._bin)
        t = np.minimum(self.replay.begin + index * self._hold * self._dt, path.last)
        lat, lon, height = path.place(t)
        for k, number in enumerate(index.tolist()):
            self._states.append(
                self._air.at(number, lambda k=k: (float(lat[k]), float(lon[k]), float(height[k])))  # type: ignore[misc]
            )
        while len(self._winds) < bins:
            start = len(self._winds) * self._bin - self._dropped
            self._winds.append(np.mean([state[:3] for state in self._states[start : start + self._bin]], axis=0))

    def _wind(self, t: Array) -> Array:
        """Smooth wind in n at times t, (n, 3), m/s: a cubic B-spline whose coefficients are the means."""
        length = self._bin * self._hold * self._dt
        first = max(0, int(t[0] / length) - 3)
        last = min(len(self._winds), int(t[-1] / length) + 4)
        means = [self._winds[0]] * 3 + self._winds if first == 0 else self._winds[first - 1 :]
        begin = first - 3 if first == 0 else first - 1
        means = means[: last - begin]
        knots = (np.arange(len(means) + 4) + begin + 0.5 - 2.0) * length
        return np.asarray(BSpline(knots, np.array(means), 3)(t))

    def _airspeed(self, first: int, vel_n: Array, now: Attitude) -> Array:
        """True airspeed, gusts included, (n,), m/s."""
        start = first // self._hold - self._dropped
        held = np.array(self._states[start : start + self._size // self._hold])
        air = np.repeat(held, self._hold, axis=0)
        through = vel_n - air[:, :3]
        if air[:, 3:6].any():
            through = through - gust_n(now, air[:, 3:6])
        return np.asarray(np.sqrt((through**2).sum(axis=1)))

    def _place(
        self, t: Array, lat: Array, lon: Array, height: Array
    ) -> tuple[list[float], list[int], list[int], list[int]]:
        """Cross-track, line, next line and phase of each step."""
        # A step counts as past a moment from half a microsecond before it on.
        now = t + 5e-7
        run_in, start, end = self._times.T
        next_line = np.minimum(np.searchsorted(end, now, side="right"), len(end) - 1)
        on_line = (now >= start[next_line]) & (now < end[next_line])
        phase = np.where(on_line, 2, np.where((now >= run_in[next_line]) & (now < start[next_line]), 1, 0))
        phase[now >= end[-1]] = 3
        pos_e = ecef_from_geodetic(lat, lon, height)
        across = (pos_e * self._normals[next_line]).sum(axis=1) - self._offsets[next_line]
        line = np.where(on_line, next_line, -1)
        return across.tolist(), line.tolist(), next_line.tolist(), phase.tolist()
