"""The way over ground of run-ins and turns, for the map of a plan."""

from __future__ import annotations

import numpy as np

from aerosim.flight.plan import FlightPlan, Line, wind_triangle
from aerosim.flight.turns import Turn, roll_lag
from aerosim.frames import Array
from aerosim.tangent import TangentPlane

STEP_S = 2.0


def run_ins(plan: FlightPlan, wind: tuple[float, float], plane: TangentPlane) -> list[Array]:
    """Begin and end of each run-in, (2, 2) east, north on the plane, m.  wind: north, east, m/s."""
    found = []
    for line in plan.lines:
        begin = line.before_start(plan.run_in_distance(line, *wind), plan.height)
        found.append(plane.to_plane([begin, line.start]))
    return found


def turns(plan: FlightPlan, wind: tuple[float, float], plane: TangentPlane) -> list[Array]:
    """Way from each line's end to the next run-in, (n, 2) east, north on the plane, m.  wind: north, east, m/s."""
    found = []
    for line, following in zip(plan.lines[:-1], plan.lines[1:], strict=True):
        _, speed = wind_triangle(line.course_end, plan.airspeed, *wind)
        turn = plan.turn(following, line.end_points(plan.height)[1], speed * line.forward_end, wind)
        found.append(_on_plane(plan, line, following, turn, wind, plane))
    return found


def _on_plane(
    plan: FlightPlan, line: Line, following: Line, turn: Turn, wind: tuple[float, float], plane: TangentPlane
) -> Array:
    """A turn drawn between the two places that it joins; what is left of it at its end is spread over it."""
    way = _flown(plan, line, following, turn, following.frame_wind(*wind))
    start, end = plane.to_plane([following.start, following.end])
    ahead = (end - start) / np.hypot(*(end - start))
    placed = way @ np.array([ahead, [ahead[1], -ahead[0]]])
    leave = plane.to_plane(line.end)
    arrive = plane.to_plane(following.before_start(plan.run_in_distance(following, *wind), plan.height))
    placed = placed + leave - placed[0]
    return np.asarray(placed + np.linspace(0.0, 1.0, len(placed))[:, None] * (arrive - placed[-1]))


def _flown(plan: FlightPlan, line: Line, following: Line, turn: Turn, wind: tuple[float, float]) -> Array:
    """A turn over ground in the frame of the line that it leads to (x along, y right), (n, 2), m."""
    rate = (turn.angle_first + turn.angle_last) / max(
        turn.duration - turn.straight_s - 2.0 * roll_lag(plan.bank_turn), 1e-6
    )
    lag = roll_lag(plan.bank_turn)
    first, last = turn.angle_first / rate, turn.angle_last / rate
    begin = turn.straight - turn.first * turn.angle_first
    times = np.linspace(0.0, turn.duration, max(int(turn.duration / STEP_S), 8))
    turned = np.clip(times - lag, 0.0, first) * turn.first * rate
    turned = turned + np.clip(times - lag - first - turn.straight_s, 0.0, last) * turn.last * rate
    heading = begin + turned
    velocity = plan.airspeed * np.stack([np.cos(heading), np.sin(heading)], axis=-1) + np.array(wind)
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(times)[:, None]
    return np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
