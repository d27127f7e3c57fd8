"""Survey lines in a flown path: those that were planned, or its straight and level parts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.flight.plan import Line
from aerosim.flight.replay.smooth_path import Motion, SmoothPath
from aerosim.frames import Array, ecef_from_geodetic, wrap_pi

LOOK = 10  # s to either side, for the rate of turn and of climb
TURN_RATE = math.radians(0.25)  # 1/s
# Wings level: at the ends of a straight part the bank of the turn must be gone, for rows that are switched on.
GLANCE, LEVEL_RATE, NEAR_END = 3, math.radians(0.4), 30  # s, 1/s, s
CLIMB = 1.5  # m/s
SAME_COURSE = math.radians(20.0)
RUN_IN_SHARE = 0.25  # of a straight part, at most, is run-in


class FlownLine(NamedTuple):
    """A line in the path.  Times of the path, s: where its run-in, the line and its end begin."""

    line: Line
    run_in: float
    start: float
    end: float


class Steady(NamedTuple):
    """What counts as a line.  course: deviation from its mean course, rad; shortest: m; run_in: s."""

    course: float
    shortest: float
    run_in: float


class _Seconds(NamedTuple):
    """The path each second."""

    t: Array
    motion: Motion
    course: Array

    @classmethod
    def of(cls, path: SmoothPath) -> _Seconds:
        t = np.append(np.arange(path.first, path.last - 1e-6, 1.0), path.last)
        motion = path.motion(t)
        course = np.unwrap(np.arctan2(motion.vel_n[:, 1], motion.vel_n[:, 0]))
        return cls(t, motion, course)


def find_lines(path: SmoothPath, steady: Steady) -> list[FlownLine]:
    """Straight and level parts of a path, in order of time.

    Raises InputError when there is none.
    """
    seconds = _Seconds.of(path)
    if len(seconds.t) < 3 * LOOK:
        raise InputError(f"a flight of {len(seconds.t)} s has no line")
    found, longest = [], 0.0
    for run in _runs(_straight(seconds)):
        first, last = _level(seconds.course, *_core(seconds.course, *run, steady.course))
        run_in = min(steady.run_in, RUN_IN_SHARE * (last - first))
        start, end = float(seconds.t[first]) + run_in, float(seconds.t[last])
        length = float(np.hypot(*seconds.motion.vel_n[first + round(run_in) : last, :2].T).sum())
        longest = max(longest, length)
        if length >= steady.shortest:
            found.append(FlownLine(_line(path, start, end), start - run_in, start, end))
    if not found:
        raise InputError(
            f"no straight and level part of {steady.shortest:.0f} m (the longest has {longest:.0f} m)",
            allowed="lines of the scenario, or a shorter replay.line_min_m",
        )
    return found


def _straight(seconds: _Seconds) -> NDArray[np.bool_]:
    climb = -seconds.motion.vel_n[:, 2]
    straight = np.zeros(len(seconds.t), bool)
    turn = np.abs(seconds.course[2 * LOOK :] - seconds.course[: -2 * LOOK]) / (2.0 * LOOK)
    height = seconds.motion.height
    rate = np.abs(height[2 * LOOK :] - height[: -2 * LOOK]) / (2.0 * LOOK)
    straight[LOOK:-LOOK] = (turn < TURN_RATE) & (rate < CLIMB) & (np.abs(climb[LOOK:-LOOK]) < 4.0 * CLIMB)
    return straight


def _runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each run of true values."""
    change = np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8))
    return list(
        zip(np.flatnonzero(change == 1).tolist(), (np.flatnonzero(change == -1) - 1).tolist(), strict=True)
    )


def _core(course: Array, first: int, last: int, most: float) -> tuple[int, int]:
    """The longest part of a run whose course stays near the run's median."""
    inside = np.abs(course[first : last + 1] - np.median(course[first : last + 1])) <= most
    a, b = max(_runs(inside), key=lambda run: run[1] - run[0], default=(0, 0))
    return first + a, first + b


def _level(course: Array, first: int, last: int) -> tuple[int, int]:
    """A part without what is still turning near its ends."""
    at = np.arange(first, last + 1)
    before, after = np.maximum(at - GLANCE, 0), np.minimum(at + GLANCE, len(course) - 1)
    turning = np.abs(course[after] - course[before]) > LEVEL_RATE * (after - before)
    begin = turning[: min(NEAR_END, len(at) // 3)]
    end = turning[len(at) - len(begin) :]
    skip = len(begin) - int(np.argmax(begin[::-1])) if begin.any() else 0
    cut = len(end) - int(np.argmax(end)) if end.any() else 0
    return first + skip, last - cut


def _line(path: SmoothPath, start: float, end: float) -> Line:
    lat, lon, _ = path.place(np.array([start, end]))
    return Line((float(lat[0]), float(lon[0])), (float(lat[1]), float(lon[1])))


def match_lines(path: SmoothPath, lines: Sequence[Line], run_in: float, within: float) -> list[FlownLine]:
    """Where a path flies given lines, each after the one before.

    run_in: longest straight flight before each, s.  within: how far aside, m.
    Raises InputError for a line that the path does not fly, with its number.
    """
    seconds = _Seconds.of(path)
    pos_e = ecef_from_geodetic(*seconds.motion[:3])
    found: list[FlownLine] = []
    for number, line in enumerate(lines):
        after = found[-1].end if found else path.first
        times = _passage(seconds, pos_e, line, after, within)
        if isinstance(times, str):
            raise InputError(
                f"line {number} is not flown in the trajectory ({times})", key=f"flight.lines.{number}"
            )
        start, end = times
        found.append(FlownLine(line, _run_in(seconds, line, start, max(start - run_in, after)), start, end))
    return found


def _passage(
    seconds: _Seconds, pos_e: Array, line: Line, after: float, within: float
) -> tuple[float, float] | str:
    """Times at which start and end are passed; else what is nearest to it."""
    across = pos_e @ line.normal - line.offset
    height = float(np.median(seconds.motion.height))
    start, end = line.end_points(height)
    along = (pos_e - start) @ line.forward_start
    beyond = (pos_e - end) @ line.forward_end
    near = (np.abs(across) <= within) & (along > -5e5) & (beyond < 5e5)
    entering = np.flatnonzero((along[:-1] < 0.0) & (along[1:] >= 0.0) & near[1:] & (seconds.t[1:] > after))
    leaving = np.flatnonzero((beyond[:-1] < 0.0) & (beyond[1:] >= 0.0) & near[1:])
    starts = [(int(i) + 1, _crossing(seconds.t, along, int(i))) for i in entering]
    ends = [(int(i), _crossing(seconds.t, beyond, int(i))) for i in leaving]
    # A record that was switched on or off with the line itself.
    if 0.0 <= along[0] <= within and after <= seconds.t[0]:
        starts.insert(0, (0, float(seconds.t[0])))
    if -within <= beyond[-1] < 0.0:
        ends.append((len(along) - 1, float(seconds.t[-1])))
    for first, start_time in starts:
        last, end_time = next((end for end in ends if end[0] > first), (-1, 0.0))
        if last > 0 and near[first : last + 1].all():
            return start_time, end_time
    inside = (along >= 0.0) & (beyond <= 0.0) & (seconds.t > after)
    if not inside.any():
        return "it does not come by" if after == seconds.t[0] else "it does not come by after the line before"
    least = float(np.abs(across[inside]).min())
    return f"it comes as near as {least:.0f} m; {within:.0f} m all along are asked for"


def _crossing(t: Array, value: Array, index: int) -> float:
    return float(t[index] + (t[index + 1] - t[index]) * -value[index] / (value[index + 1] - value[index]))


def _run_in(seconds: _Seconds, line: Line, start: float, earliest: float) -> float:
    """Begin of the straight flight before a line, s."""
    before = (seconds.t < start) & (seconds.t >= earliest)
    turned = np.abs(wrap_pi(seconds.course[before] - line.course)) > SAME_COURSE
    if not before.any():
        return start
    if turned.any():
        return float(seconds.t[before][np.flatnonzero(turned)[-1]] + 1.0)
    return max(earliest, float(seconds.t[before][0]))
