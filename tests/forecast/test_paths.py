"""Ways drawn on the map of a plan: they join, and take the time and the bank that were planned."""

from __future__ import annotations

import math

import numpy as np
import pytest
from planned import place

from aerosim.flight.plan import FlightPlan, Line
from aerosim.flight.turns import turn_radius
from aerosim.forecast import paths
from aerosim.tangent import TangentPlane

SPEED = 70.0


def plan(spacing: float) -> FlightPlan:
    lines = [
        Line(place(-6e3, 0.0), place(6e3, 0.0)),
        Line(place(6e3, spacing), place(-6e3, spacing)),
        Line(place(-6e3, 2 * spacing), place(6e3, 2 * spacing)),
    ]
    return FlightPlan(lines, 3000.0, SPEED, run_in_s=40.0)


@pytest.mark.parametrize("wind", [(0.0, 0.0), (9.0, -4.0), (-3.0, 12.0)])
@pytest.mark.parametrize("spacing", [900.0, -2500.0, 4500.0])
def test_turns_join_line_and_run_in(spacing: float, wind: tuple[float, float]) -> None:
    flight, plane = plan(spacing), TangentPlane(*place(0.0, 0.0))
    flown = flight.forecast(*wind)
    ways, run_ins = paths.turns(flight, wind, plane), paths.run_ins(flight, wind, plane)
    radius = turn_radius(SPEED, flight.bank_turn)
    for k, way in enumerate(ways):
        assert way[0] == pytest.approx(plane.to_plane(flight.lines[k].end), abs=1e-3)
        assert way[-1] == pytest.approx(run_ins[k + 1][0], abs=1e-3)
        steps = np.diff(way, axis=0) / (flown.turn_s[k] / (len(way) - 1))
        through_air = steps - np.array([wind[1], wind[0]])
        # the aircraft's own speed all along; what is spread over the turn to close it is a few m/s at most
        assert np.hypot(*through_air.T) == pytest.approx(SPEED, rel=0.06)
        turned = np.abs(np.diff(np.unwrap(np.arctan2(*through_air.T))))
        seconds = flown.turn_s[k] / (len(way) - 1)
        assert turned.max() / seconds < 1.12 * SPEED / radius
    for run_in, line in zip(run_ins, flight.lines, strict=True):
        assert run_in[1] == pytest.approx(plane.to_plane(line.start), abs=1e-3)
        heading = math.remainder(math.atan2(*(run_in[1] - run_in[0])) - line.course, 2.0 * math.pi)
        assert abs(heading) < 2e-3
