"""The flown path that a scenario replays."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from pathlib import Path

import numpy as np

from aerosim.flight.plan import Line
from aerosim.flight.replay.replay import Replay, ReplayParameters, prepare
from aerosim.scenario import replay as section
from aerosim.scenario.build.air import mean_wind
from aerosim.scenario.build.placing import at
from aerosim.scenario.build.route import Route, given_lines, ground_under
from aerosim.scenario.scenario import Scenario
from aerosim.world.terrain import Terrain


def replayed(scenario: Scenario, terrain: Terrain) -> tuple[Replay, Route]:
    """The path that a scenario flies again, and the route that it makes.  Raises InputError."""
    wanted, (lines, _, _) = scenario.flight.replay, given_lines(scenario)
    assert wanted is not None
    with at(scenario, "flight.replay"):
        replay = replay_of(wanted, scenario.flight.run_in_s, lines, terrain)
        plan = replay.plan()
        under = [ground_under(scenario, terrain, line) for line in plan.lines]
    ground = float(np.average([each.mean for each in under], weights=[line.length for line in plan.lines]))
    wind = mean_wind(scenario, plan, ground)
    names = tuple(str(index) for index in range(len(plan.lines)))
    return replay, Route(replay.plan(wind[0], wind[1]), ground, names)


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
