"""The flown path that a scenario replays."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, hypot, radians
from pathlib import Path

import numpy as np

from aerosim.errors import InputError
from aerosim.flight.plan import Line
from aerosim.flight.replay.replay import Replay, ReplayParameters, prepare
from aerosim.scenario import replay as section
from aerosim.scenario.build.air import mean_wind
from aerosim.scenario.build.placing import at
from aerosim.scenario.build.route import CLEARANCE, Route, given_lines, ground_under
from aerosim.scenario.checks import WIND_SHARE
from aerosim.scenario.scenario import Scenario
from aerosim.world.terrain import GroundHeights, Terrain


def replayed(scenario: Scenario, terrain: Terrain) -> tuple[Replay, Route]:
    """The path that a scenario flies again, and the route that it makes.  Raises InputError."""
    wanted, (lines, _, _) = scenario.flight.replay, given_lines(scenario)
    assert wanted is not None
    with at(scenario, "flight.replay"):
        replay = replay_of(wanted, scenario.flight.run_in_s, lines, terrain)
        plan = replay.plan()
        under = [ground_under(scenario, terrain, line) for line in plan.lines]
        _check_lines(replay, under, _offset(wanted))
        _check_between(replay, terrain)
    ground = float(np.average([each.mean for each in under], weights=[line.length for line in plan.lines]))
    north, east, _ = mean_wind(scenario, plan, ground)
    plan = replay.plan(north, east)
    with at(scenario, "air.wind"):
        if hypot(north, east) > WIND_SHARE * plan.airspeed:
            raise InputError(
                f"{hypot(north, east):.1f} m/s of wind make an airspeed of {plan.airspeed:.1f} m/s of the "
                f"{replay.ground_speed:.1f} m/s over ground that the file has",
                allowed=f"up to {100.0 * WIND_SHARE:.0f} % of the airspeed",
            )
    names = tuple(str(index) for index in range(len(plan.lines)))
    return replay, Route(plan, ground, names)


def _offset(wanted: str | section.Replay) -> float:
    return 0.0 if isinstance(wanted, str) else wanted.height_offset_m


def _check_lines(replay: Replay, under: Sequence[GroundHeights], offset: float) -> None:
    """Raise InputError for a line that comes too near to the highest ground under it.  offset: added before, m."""
    for number, (line, ground) in enumerate(zip(replay.lines, under, strict=True)):
        t = np.append(np.arange(line.start, line.end, 1.0), line.end)
        height = replay.path.place(t)[2]
        least = int(np.argmin(height))
        clear = float(height[least]) - ground.high
        if clear < CLEARANCE:
            raise InputError(
                f"line {number} is {height[least]:.0f} m above the ellipsoid at {t[least]:.0f} s, {_over(clear)} "
                f"the highest ground under it ({ground.high:.0f} m)",
                allowed=f"{CLEARANCE:.0f} m above it and more: height_offset_m from "
                f"{ceil(offset + CLEARANCE - clear)} on, another part (from_s, to_s), "
                "or heights of another datum (orthometric_height_m in the file, terrain.vertical_datum)",
                where=replay.points.source,
            )


def _check_between(replay: Replay, terrain: Terrain) -> None:
    """Raise InputError for a path that goes through the land anywhere."""
    t = np.append(np.arange(replay.begin, replay.end, 1.0), replay.end)
    lat, lon, height = replay.path.place(t)
    clear = height - terrain.heights(*terrain.grid.from_geodetic(lat, lon))
    if (clear <= 0.0).any():
        least = int(np.nanargmin(clear))
        raise InputError(
            f"the path is {height[least]:.0f} m above the ellipsoid at {t[least]:.0f} s, {_over(clear[least])} "
            "the ground",
            allowed="a path above the land: height_offset_m, or another part (from_s, to_s)",
            where=replay.points.source,
        )


def _over(clear: float) -> str:
    return f"{abs(clear):.0f} m {'above' if clear > 0.0 else 'below'}"


def replay_of(
    wanted: str | section.Replay, run_in: float, lines: Sequence[Line], terrain: Terrain | None
) -> Replay:
    """The replay of `flight.replay`, its file name resolved.

    run_in: longest straight flight before a line, s.  lines: planned ones that it flies, or none: its straight
    parts.  terrain: its vertical datum is that of orthometric heights.  Raises InputError.
    """
    part = section.Replay(file=wanted) if isinstance(wanted, str) else wanted
    to = part.move_to_deg
    parameters = ReplayParameters(
        first=part.from_s,
        last=part.to_s,
        move_to=None if to is None else (radians(to[0]), radians(to[1])),
        height_offset=part.height_offset_m,
        gap_max=part.gap_max_s,
        course=radians(part.steady_deg),
        shortest=part.line_min_m,
        run_in=run_in,
        within=part.pass_within_m,
        alpha=radians(part.angle_of_attack_deg),
    )
    undulation = None if terrain is None else terrain.vertical.undulation
    return prepare(Path(part.file), parameters, lines, undulation)
