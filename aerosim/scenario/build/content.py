"""What a flight is made from, as a digest: two scenarios of the same digest are flown alike.

It is taken from the plan that was made, not from the keys that it was made from: terrain, camera and end lap
decide where the lines lie, and nothing else of a flight.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from aerosim.flight.plan import FlightPlan
from aerosim.flight.replay.replay import Replay
from aerosim.scenario.build.flight import aircraft_folder
from aerosim.scenario.build.route import Route
from aerosim.scenario.scenario import Scenario


def content_flown(scenario: Scenario, route: Route) -> str:
    """Digest of what JSBSim flies: plan, air, pilot, and the aircraft with the bytes of its files."""
    flight, folder = scenario.flight, aircraft_folder(scenario)
    files = {file.relative_to(folder).as_posix(): file for file in sorted(folder.rglob("*")) if file.is_file()}
    return digest({
        "plan": _plan(route.plan),
        "pilot": flight.pilot,
        "crew": flight.navigator.model_dump() if flight.pilot == "navigator" else None,
        "fuel": scenario.aircraft.fuel_kg,
        "aircraft": {"name": folder.name, **{name: file.read_bytes() for name, file in files.items()}},
        **_around(scenario, route),
    })  # fmt: skip


def content_replayed(scenario: Scenario, route: Route, replay: Replay) -> str:
    """Digest of what is flown again: the smooth path and attitude, their lines, and the air."""
    lines = [[*each.line.start, *each.line.end, each.run_in, each.start, each.end] for each in replay.lines]
    return digest({
        "plan": _plan(route.plan),
        "replay": [replay.path, replay.attitude, lines, replay.begin, replay.end, replay.alpha],
        **_around(scenario, route),
    })  # fmt: skip


def _around(scenario: Scenario, route: Route) -> dict[str, Any]:
    return {
        "seed": scenario.seed,
        "rate": scenario.aircraft.step_rate_hz,
        "air": scenario.air.model_dump(),
        "ground": route.ground,
    }


def _plan(plan: FlightPlan) -> list[Any]:
    lines = [[*line.start, *line.end] for line in plan.lines]
    return [lines, plan.height, plan.airspeed, plan.run_in_s, plan.bank_max]


def digest(value: Any) -> str:
    """SHA-256 of a value made of numbers, words, arrays, splines, mappings, sequences and dataclasses of them.

    Raises TypeError for anything else, which might look the same and be another.
    """
    out = hashlib.sha256()
    _feed(out, value)
    return out.hexdigest()


def _feed(out: Any, value: Any) -> None:
    if isinstance(value, np.ndarray) and value.dtype != object:
        out.update(f"array {value.dtype.str} {value.shape};".encode() + value.tobytes())
    elif isinstance(value, bytes):
        out.update(f"bytes {len(value)};".encode() + value)
    elif isinstance(value, BSpline):
        _feed(out, [value.t, value.c, value.k, bool(value.extrapolate), value.axis])
    elif isinstance(value, Mapping):
        _feed(out, [list(pair) for pair in value.items()])
    elif isinstance(value, (list, tuple)):
        out.update(f"list {len(value)};".encode())
        for each in value:
            _feed(out, each)
    elif is_dataclass(value):
        _feed(out, {field.name: getattr(value, field.name) for field in fields(value)})
    elif isinstance(value, (bool, int, str)) or value is None:
        out.update(f"{type(value).__name__} {value!r};".encode())
    elif isinstance(value, (float, np.floating)):
        out.update(f"number {float(value).hex()};".encode())
    else:
        raise TypeError(f"no digest of a {type(value).__name__}")
