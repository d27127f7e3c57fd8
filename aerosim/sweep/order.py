"""In which order points are flown, so that one flight serves all that share it."""

from __future__ import annotations

from collections.abc import Sequence

from aerosim.scenario import variants
from aerosim.sweep.flights import flown_alike
from aerosim.sweep.spec import Point, SweepSpec

GROUP = 64  # flights that are in use at the same time: some 0.6 GB of the folder of flights


def flight_order(spec: SweepSpec) -> tuple[list[Point], bool]:
    """Points in the order in which they are flown with each seed, and whether any two share a flight.

    Flights are taken in groups.  Of a group the first point of each flight comes first, then the second of each:
    processes that fly side by side are then at different flights, and none waits for another's.
    """
    alike: dict[str, list[Point]] = {}
    scenarios = variants(spec.scenario, (spec.overrides(point) for point in spec.points))
    for point, scenario in zip(spec.points, scenarios, strict=True):
        alike.setdefault(flown_alike(scenario), []).append(point)
    if len(alike) == len(spec.points):
        return spec.points, False
    flights = list(alike.values())
    groups = [flights[start : start + GROUP] for start in range(0, len(flights), GROUP)]
    return [point for group in groups for point in _in_turn(group)], True


def _in_turn(flights: Sequence[Sequence[Point]]) -> list[Point]:
    rounds = max(len(points) for points in flights)
    return [points[turn] for turn in range(rounds) for points in flights if turn < len(points)]
