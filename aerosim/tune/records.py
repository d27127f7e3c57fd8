"""Flights that `tune` reads: run directories, and angular rates as CSV files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.estimation.tuning import Segment
from aerosim.record import open_run
from aerosim.tune.csvfile import columns

Array = NDArray[np.float64]
GAP = 1.5  # of the usual time between two rows: beyond it a new segment begins


class Geometry(NamedTuple):
    """Of the rows, px."""

    spacing: float
    focal: float
    pixels: int


class Flown(NamedTuple):
    """One record at one height.  height: above ground, m; vh: 1/s; angles in rad, in segments without gaps.

    lines: photo times (s) and end laps (share) of each line, empty if the record has none; wanted: preset end
    lap.  mode: control.mode of a run, empty for a CSV file.
    """

    source: str
    height: float
    vh: float
    rows: Geometry
    roll: list[Segment]
    pitch: list[Segment]
    drift: list[Segment]
    lines: list[tuple[Array, Array]]
    wanted: float
    mode: str


def of_run(path: Path) -> Flown:
    """A run directory: its survey lines.  Raises InputError."""
    run = open_run(path)
    scenario, rows = run.scenario, run.scenario.ccd_rows
    names = ("t_s", "line", "agl_m", "vh_true_per_s", "roll_deg", "pitch_deg", "drift_true_deg")
    tel = {name: run.telemetry[name].to_numpy(zero_copy_only=False) for name in names}
    numbers = [int(k) for k in np.unique(tel["line"]) if k >= 0]
    if not numbers:
        raise InputError("flew no survey line", where=str(path))
    here = {k: tel["line"] == k for k in numbers}
    on_line = tel["line"] >= 0

    def segments(name: str) -> list[Segment]:
        return [Segment(tel["t_s"][here[k]], np.radians(tel[name][here[k]])) for k in numbers]

    photos = run.photos
    at = photos["line"].to_numpy(zero_copy_only=False)
    t, lap = (photos[name].to_numpy(zero_copy_only=False).astype(float) for name in ("t_s", "end_lap_pct"))
    return Flown(
        source=str(path),
        height=float(tel["agl_m"][on_line].mean()),
        vh=float(tel["vh_true_per_s"][on_line].mean()),
        rows=Geometry(rows.spacing_px, rows.focal_px, rows.pixels_px),
        roll=segments("roll_deg"),
        pitch=segments("pitch_deg"),
        drift=segments("drift_true_deg"),
        lines=[series for k in numbers if (series := _series(t[at == k], lap[at == k] / 100.0)) is not None],
        wanted=scenario.control.end_lap_pct / 100.0,
        mode=scenario.control.mode,
    )


def _series(t: Array, lap: Array) -> tuple[Array, Array] | None:
    """The longest piece of a line whose end laps are all known, with the photo before it; None below two laps."""
    known = np.r_[False, np.isfinite(lap[1:]), False]
    begins, ends = (np.flatnonzero(np.diff(known.astype(int)) == way) for way in (1, -1))
    if not len(begins):
        return None
    longest = int(np.argmax(ends - begins))
    piece = slice(begins[longest], ends[longest] + 1)
    return (t[piece], lap[piece]) if ends[longest] - begins[longest] >= 2 else None


def of_rates(path: Path, height: float | None, speed: float | None, rows: Geometry) -> Flown:
    """Angular rates or angles of a flight as CSV: t_s, roll_deg or p_deg_s, and if there are pitch_deg or q_deg_s,
    drift_deg, height_agl_m, ground_speed_m_s.

    height (above ground, m), speed (m/s): used where the file has no such column.  Raises InputError.
    """
    table = columns(path, ("t_s",))
    if "roll_deg" not in table and "p_deg_s" not in table:
        raise InputError("has no column of roll", where=f"{path}:1", allowed="roll_deg or p_deg_s")
    t = table["t_s"]
    if len(t) < 2:
        raise InputError("has a single row", where=str(path), allowed="two and more")
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        raise InputError("t_s does not grow", where=f"{path}:{int(back[0]) + 3}")
    found = {"height_agl_m": height, "ground_speed_m_s": speed}
    for name, option in (("height_agl_m", "--height_agl_m"), ("ground_speed_m_s", "--ground_speed_m_s")):
        if name in table:
            found[name] = float(table[name].mean())
        elif found[name] is None:
            raise InputError(f"has no column {name}", where=f"{path}:1", allowed=f"the column, or {option}")
    above, moving = found["height_agl_m"] or 0.0, found["ground_speed_m_s"] or 0.0
    if above <= 0.0 or moving <= 0.0:
        raise InputError("height and ground speed are not positive", where=str(path))

    def segments(angle: str, rate: str = "") -> list[Segment]:
        if angle in table:
            return _split(t, np.radians(table[angle]))
        if rate not in table:
            return []
        return [Segment(each.t, _integrated(each)) for each in _split(t, np.radians(table[rate]))]

    roll, pitch = segments("roll_deg", "p_deg_s"), segments("pitch_deg", "q_deg_s")
    return Flown(str(path), above, moving / above, rows, roll, pitch, segments("drift_deg"), [], math.nan, "")


def _split(t: Array, x: Array) -> list[Segment]:
    steps = np.diff(t)
    cuts = np.flatnonzero(steps > GAP * np.median(steps)) + 1
    return [Segment(*part) for part in zip(np.split(t, cuts), np.split(x, cuts), strict=True) if len(part[0]) > 1]


def _integrated(rate: Segment) -> Array:
    steps = (rate.x[1:] + rate.x[:-1]) / 2.0 * np.diff(rate.t)
    return np.concatenate([[0.0], np.cumsum(steps)])
