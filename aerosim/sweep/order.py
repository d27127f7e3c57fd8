"""In which order runs are flown, so that one flight serves all that share it and nobody waits for another's."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

from aerosim.sweep.spec import Point, SweepSpec

GROUP = 64  # flights that are in use at the same time: some 0.6 GB of the folder of flights
FLOWN = ("terrain", "air", "aircraft", "flight")  # sections
OF_AREA = ("frame_camera", "control.end_lap_pct")  # they space the lines over an area


def may_influence_flight(key: str, area: bool) -> bool:
    """Whether a dotted key may change a flight.  area: whether lines are laid over an area."""
    if key.partition(".")[0] in FLOWN:
        return True
    return area and any(f"{key}.".startswith(f"{name}.") or name.startswith(f"{key}.") for name in OF_AREA)


def flight_order(spec: SweepSpec, workers: int = 1) -> tuple[Iterator[tuple[int, Point]], bool]:
    """Runs (seed, point) in the order in which they are flown, and whether any two share a flight.

    Points of one seed that agree in every key that may influence a flight share it (`Flights` knows better).  Of
    a group of flights the first run of each comes first, then the second of each.  Where a seed has fewer flights
    than there are `workers`, groups reach over several seeds: processes that fly side by side are then at
    different flights.  A rule for stopping may so be held up by as many seeds.
    """
    area = spec.scenario.flight.area is not None or any(
        key == "flight" or f"{key}.".startswith("flight.area.") for key in spec.vary
    )
    names = [key for key in spec.vary if may_influence_flight(key, area)]
    alike: dict[str, list[Point]] = {}
    for point in spec.points:
        alike.setdefault(json.dumps([point.values.get(name) for name in names]), []).append(point)
    if len(alike) == len(spec.points):
        return spec.runs(), False
    return _runs(list(alike.values()), spec.seeds, workers), True


def _runs(flights: list[list[Point]], seeds: int, workers: int) -> Iterator[tuple[int, Point]]:
    together = -(-min(workers, GROUP) // len(flights))
    blocks = max(1, seeds // max(1, together))
    for block in range(blocks):
        of_block = range(block * seeds // blocks + 1, (block + 1) * seeds // blocks + 1)
        for start in range(0, len(flights), GROUP):
            for points in _in_turn(flights[start : start + GROUP]):
                yield from ((seed, point) for seed in of_block for point in points)


def _in_turn(flights: Sequence[Sequence[Point]]) -> list[list[Point]]:
    """First points of all flights, second points of all that have two, ..."""
    rounds = max(len(points) for points in flights)
    return [[points[turn] for points in flights if turn < len(points)] for turn in range(rounds)]
