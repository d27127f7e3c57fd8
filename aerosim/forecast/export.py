"""A plan as features for map files: lines, photo centres, footprints, area."""

from __future__ import annotations

from typing import Any

import numpy as np

from aerosim.forecast.check import Outlook
from aerosim.forecast.shots import corners
from aerosim.formats.features import Feature, Property
from aerosim.frames import Array

# of each line, what a crew or a GIS wants to see beside it
SHOWN = (
    "course_deg", "length_m", "duration_s", "drift_deg", "ground_speed_m_s", "photos", "photo_interval_s",
    "photo_base_m", "end_lap_pct", "gsd_min_m", "gsd_max_m",
    "strips_accepted_pct",
)  # fmt: skip


def lines(found: Outlook) -> list[Feature]:
    """The lines in the order flown, with their figures."""
    features = []
    for index, line in enumerate(found.plan.lines):
        figures: dict[str, Any] = found.figures["lines"][index]
        properties: dict[str, Property] = {"telemetry_line": index, "height_m": round(found.plan.height, 2)}
        properties |= {key: _short(figures[key]) for key in SHOWN}
        features.append(Feature("line", (line.start, line.end), found.names[index], found.plan.height, properties))
    return features


def everything(found: Outlook) -> list[Feature]:
    """Lines, photo centres, footprints on the level of the ground below, and the counted area."""
    features, shots = lines(found), found.shots
    centres, outlines = _geodetic(found, shots.place), _geodetic(found, corners(found.land, shots))
    for number, line in enumerate(shots.line):
        properties: dict[str, Property] = {"line": found.names[line], "photo": number}
        name = f"photo {number}"
        features.append(Feature("photo", (_point(centres[number]),), name, found.plan.height, properties))
        ring = tuple(_point(corner) for corner in outlines[number])
        features.append(Feature("footprint", ring, name, None, properties))
    if found.ring is not None:
        ring = tuple(_point(corner) for corner in _geodetic(found, found.ring))
        features.append(Feature("area", ring, "area", None, {}))
    return features


def _geodetic(found: Outlook, places: Array) -> Array:
    return found.land.plane.to_geodetic(places)


def _point(place: Array) -> tuple[float, float]:
    return float(place[0]), float(place[1])


def _short(value: Any) -> Property:
    return round(value, 4) if isinstance(value, float) and np.isfinite(value) else value
