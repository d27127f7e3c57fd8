"""The figures of summary.json that a report shows: what they are called, their unit, what they mean."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from aerosim.metrics.expect import value_at


class Figure(NamedTuple):
    """One number of the summary.  path: dotted; digits: decimals shown."""

    path: str
    name: str
    unit: str
    digits: int
    meaning: str


FIGURES = (
    Figure("flight.duration_s", "Duration", "s", 0, "whole flight: run-ins, lines and turns"),
    Figure("flight.lines", "Lines", "", 0, "survey lines flown"),
    Figure("flight.cross_track_rms_m", "Cross track, rms", "m", 2, "distance of the aircraft from its line"),
    Figure("flight.roll_rms_deg", "Roll, rms", "deg", 2, "bank on the lines"),
    Figure("flight.pitch_rms_deg", "Pitch, rms", "deg", 2, "pitch about its mean on the lines"),
    Figure(
        "flight.drift_mean_deg",
        "Drift, mean",
        "deg",
        2,
        "track less aircraft heading: what the wind does; mean of the lines' sizes",
    ),
    Figure(
        "crab.residual_rms_deg", "Crab, rms", "deg", 2, "track less camera heading: what the controller leaves"
    ),
    Figure("crab.residual_mean_deg", "Crab, mean", "deg", 2, "its constant part"),
    Figure("crab.residual_max_deg", "Crab, largest", "deg", 2, "its worst moment"),
    Figure("crab.estimate_error_rms_deg", "Crab estimate, rms error", "deg", 2, "estimated less true"),
    Figure("crab.settle_s", "Settling", "s", 1, "from the start of a line until crab stays small"),
    Figure("crab.strips", "Strips", "", 0, "strips of row I looked for in row II"),
    Figure("crab.accepted_pct", "Strips accepted", "%", 1, "recognised without doubt"),
    Figure("crab.bad_pct", "Strips bad", "%", 1, "of the accepted ones, more than 0.5 deg off"),
    Figure("crab.silent_max_s", "Silence, longest", "s", 1, "time on a line without an accepted strip"),
    Figure("crab.silent_end_s", "Silence at the end", "s", 1, "up to a line's end: a lock that was not regained"),
    Figure("vh.error_rms_pct", "v/h, rms error", "%", 2, "estimated less true, against the moment"),
    Figure("vh.error_mean_pct", "v/h, mean error", "%", 2, "its constant part"),
    Figure(
        "vh.strip_error_rms_pct", "v/h of strips, rms error", "%", 2, "each strip against its own time and ground"
    ),
    Figure("photos.count", "Photos", "", 0, "taken on the lines"),
    Figure("photos.end_lap_mean_pct", "End lap, mean", "%", 2, "of consecutive photos, on the mean ground"),
    Figure("photos.end_lap_error_rms_pct", "End lap, rms error", "%", 2, "against the wanted end lap"),
    Figure("photos.end_lap_min_pct", "End lap, least", "%", 2, "the worst pair"),
    Figure("photos.side_lap_min_pct", "Side lap, least", "%", 2, "of neighbouring lines"),
    Figure("photos.blur_rms_px", "Blur, rms", "px", 2, "image motion during the exposure, in picture pixels"),
    Figure(
        "photos.out_of_tolerance",
        "Photos out of tolerance",
        "",
        0,
        "verdict other than ok: end lap, tilt, crab or blur",
    ),
    Figure("speed.real_time_factor", "Speed", "x real time", 1, "flight time over computing time"),
)


def shown(figure: Figure, value: Any) -> str:
    """A value with its unit; a dash if it was not measured."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value:  # noqa: PLR0124
        return "–"
    return f"{value:.{figure.digits}f} {figure.unit}".strip()


def headline(summary: Mapping[str, Any]) -> list[tuple[Figure, str, str]]:
    """Each figure with its shown value and, where there is none, the reason why."""
    notes = summary.get("notes") or {}
    found = []
    for figure in FIGURES:
        value = shown(figure, value_at(summary, figure.path))
        reason = str(notes.get(figure.path) or "not measured") if value == "–" else ""
        found.append((figure, value, reason))
    return found
