"""A trajectory file flown again: what the loop steps instead of JSBSim."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from aerosim.errors import InputError
from aerosim.flight.plan import FlightPlan, Forecast, Line
from aerosim.flight.replay.attitude import GivenAttitude
from aerosim.flight.replay.flown_lines import FlownLine, Steady, find_lines, match_lines
from aerosim.flight.replay.smooth_path import Scatter, SmoothPath, scatter_of, smooth_path
from aerosim.flight.replay.trajectory import Trajectory, Undulation, read_trajectory
from aerosim.flight.replay.trajectory_pieces import flown_pieces, moved
from aerosim.frames import Array

journal = logging.getLogger("aerosim")


@dataclass(frozen=True)
class ReplayParameters:
    """How a file is replayed.  SI, rad.

    first, last: part of the file's time, None for all.  move_to: latitude, longitude of the first line's start.
    height_offset: added to the heights.  gap_max: longest gap that is bridged.  course: deviation allowed on a
    straight part; shortest: length that makes it a line; run_in: longest straight flight before a line.
    within: distance at which a given line counts as flown.  alpha: angle of attack where the file has no pitch.
    """

    first: float | None = None
    last: float | None = None
    move_to: tuple[float, float] | None = None
    height_offset: float = 0.0
    gap_max: float = 120.0
    course: float = math.radians(3.0)
    shortest: float = 4000.0
    run_in: float = 60.0
    within: float = 300.0
    alpha: float = 0.0


@dataclass(frozen=True)
class Replay:
    """A flight ready to be flown again.

    points: of the file, one piece, carried to where it is flown; begin, end: time of the path that is flown, s:
    from the first run-in to the end of the last line.
    """

    points: Trajectory
    path: SmoothPath
    attitude: GivenAttitude
    lines: tuple[FlownLine, ...]
    begin: float
    end: float
    alpha: float
    notes: tuple[str, ...] = field(default=())

    @property
    def duration(self) -> float:
        """Of the flight, s."""
        return self.end - self.begin

    def _on_lines(self) -> Array:
        """Each second on the lines, s."""
        return np.concatenate([np.arange(line.start, line.end, 1.0) for line in self.lines])

    @property
    def height(self) -> float:
        """Mean height on the lines, ellipsoidal, m."""
        return float(self.path.place(self._on_lines())[2].mean())

    @property
    def ground_speed(self) -> float:
        """Mean on the lines, m/s."""
        return float(np.hypot(*self.path.motion(self._on_lines()).vel_n[:, :2].T).mean())

    def airspeed(self, wind_north: float = 0.0, wind_east: float = 0.0) -> float:
        """Mean true airspeed on the lines in a steady wind (m/s, where it goes to), m/s."""
        vel = self.path.motion(self._on_lines()).vel_n
        return float(np.linalg.norm(vel - np.array([wind_north, wind_east, 0.0]), axis=1).mean())

    def plan(self, wind_north: float = 0.0, wind_east: float = 0.0) -> FlightPlan:
        """What a plan of this flight would have said: its lines, mean height and airspeed in a steady wind."""
        run_in = max(line.start - line.run_in for line in self.lines)
        lines = [line.line for line in self.lines]
        return FlightPlan(lines, self.height, self.airspeed(wind_north, wind_east), run_in)

    def forecast(self, wind_north: float = 0.0, wind_east: float = 0.0) -> Forecast:
        """What the flight takes; drift: track less the azimuth of the motion through a steady wind (m/s)."""
        line_s, drift, speed = [], [], []
        for each in self.lines:
            north, east = self.path.motion(np.arange(each.start, each.end, 1.0)).vel_n[:, :2].mean(axis=0)
            track, nose = math.atan2(east, north), math.atan2(east - wind_east, north - wind_north)
            line_s.append(each.end - each.start)
            drift.append(math.remainder(track - nose, 2.0 * math.pi))
            speed.append(math.hypot(north, east))
        turns = tuple(late.run_in - early.end for early, late in pairwise(self.lines))
        return Forecast(self.duration, tuple(line_s), turns, tuple(drift), tuple(speed))

    @property
    def level_pitch(self) -> float:
        """Mean pitch on the first line as given, else the angle of attack, rad: what a static mount takes out."""
        if self.attitude.pitch is None:
            return self.alpha
        first = self.lines[0]
        return float(np.mean(self.attitude.pitch(np.arange(first.start, first.end, 1.0))))


def prepare(
    file: Path, parameters: ReplayParameters, lines: Sequence[Line] = (), undulation: Undulation | None = None
) -> Replay:
    """Read a trajectory file, smooth it and find its lines.

    lines: planned ones that it flies, in their order; none: its straight parts.  undulation: of the geoid (m) at
    lat, lon (rad), for orthometric heights.
    Raises InputError for whatever is wrong with the file or cannot be replayed, with file and line.
    """
    par = parameters
    points = read_trajectory(file, height_offset=par.height_offset, undulation=undulation)
    # One piece may hold too few points to know what they are worth.
    scatter = scatter_of(points)
    points, notes = _piece(points, par)
    if par.move_to is not None:
        points = _carried(points, par, scatter)
    path = smooth_path(points, scatter)
    steady = Steady(par.course, par.shortest, par.run_in)
    found = match_lines(path, lines, par.run_in, par.within) if lines else find_lines(path, steady)
    notes.append(
        f"{len(found)} lines; points lie {scatter.across:.2g} m aside of the path, {scatter.height:.2g} m "
        f"above or below it, and {scatter.stamp:.2g} s before or behind"
    )
    for note in notes:
        journal.info("%s: %s", file, note)
    return Replay(
        points, path, GivenAttitude.of(points), tuple(found), found[0].run_in, found[-1].end, par.alpha,
        (*points.notes, *notes),
    )  # fmt: skip


def _piece(points: Trajectory, par: ReplayParameters) -> tuple[Trajectory, list[str]]:
    """The part of the file that is replayed: what was asked for, else the longest without a long gap."""
    asked = par.first is not None or par.last is not None
    first = -math.inf if par.first is None else par.first
    last = math.inf if par.last is None else par.last
    inside = (points.t >= first) & (points.t <= last)
    if inside.sum() < 8:
        raise InputError(
            f"{int(inside.sum())} points of {points.source} from {first:g} to {last:g} s",
            allowed=f"8 and more, of {points.t[0]:.10g} to {points.t[-1]:.10g} s",
        )
    pieces, notes = flown_pieces(points.part(inside), par.gap_max)
    if len(pieces) == 1:
        return pieces[0], notes
    spans = ", ".join(f"{piece.t[0]:.10g} to {piece.t[-1]:.10g} s" for piece in pieces)
    if asked:
        raise InputError(
            f"from {first:g} to {last:g} s the flight is broken ({notes[0]})",
            allowed=f"a longer replay.gap_max_s, or one of {spans}",
        )
    longest = max(pieces, key=lambda piece: piece.t[-1] - piece.t[0])
    journal.warning(
        "%s: the flight is broken; %.10g to %.10g s is replayed, of %s",
        points.source, longest.t[0], longest.t[-1], spans,
    )  # fmt: skip
    return longest, notes


def _carried(points: Trajectory, par: ReplayParameters, scatter: Scatter) -> Trajectory:
    """The path with the start of its first straight part where it is wanted."""
    assert par.move_to is not None
    if abs(par.move_to[0]) > math.radians(85.0):
        raise InputError(f"latitude {math.degrees(par.move_to[0]):g} deg to move to", allowed="-85 to 85 deg")
    first = find_lines(smooth_path(points, scatter), Steady(par.course, par.shortest, par.run_in))[0]
    return moved(points, first.line.start, par.move_to)
