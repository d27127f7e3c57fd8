"""A flown path as it was received: points in time, read and checked."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.flight.replay.contradiction import check_velocity
from aerosim.flight.replay.trajectory_file import HEIGHTS, KINDS, NEEDED, Table, read_table
from aerosim.frames import WGS84_A, Array, wrap_pi

journal = logging.getLogger("aerosim")

MAX_SPEED = 400.0  # m/s; what no survey aircraft flies
MAX_CLIMB = 150.0  # m/s
MAX_ACCELERATION = 100.0  # m/s^2, ten g
FEW = 5  # changes of a column, of which nobody can tell a quantisation
SLOWEST = 20.0  # m/s over ground; below it the aircraft stands, taxies or is no aeroplane
Undulation = Callable[[Array, Array], Array]


@dataclass(frozen=True)
class Trajectory:
    """Points of a flown path, SI and rad, (n,) each.

    t: s; lat, lon: geodetic, lon without jumps; height: ellipsoidal, m.  speed, track, climb: velocity over ground
    as the file has it, NaN where it does not; track clockwise from north.  roll, pitch, heading: given attitude,
    or None.  lines: of the file.  steps: quantity -> quantisation found in the file, SI.
    pressure: whether the height is one of the standard atmosphere.
    """

    source: str
    t: Array
    lat: Array
    lon: Array
    height: Array
    speed: Array
    track: Array
    climb: Array
    roll: Array | None
    pitch: Array | None
    heading: Array | None
    lines: NDArray[np.int64]
    steps: dict[str, float]
    pressure: bool = False
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.t)

    def part(self, keep: slice | NDArray[np.bool_]) -> Trajectory:
        """Some of the points."""

        def cut(values: Array | None) -> Array | None:
            return None if values is None else values[keep]

        return replace(
            self,
            t=self.t[keep],
            lat=self.lat[keep],
            lon=self.lon[keep],
            height=self.height[keep],
            speed=self.speed[keep],
            track=self.track[keep],
            climb=self.climb[keep],
            roll=cut(self.roll),
            pitch=cut(self.pitch),
            heading=cut(self.heading),
            lines=self.lines[keep],
        )

    def legs(self) -> tuple[Array, Array]:
        """Way from point to point, (n-1, 2) north and east, m, and its time, (n-1,), s."""
        middle = (self.lat[1:] + self.lat[:-1]) / 2.0
        north = np.diff(self.lat) * WGS84_A
        east = np.diff(self.lon) * WGS84_A * np.cos(middle)
        return np.column_stack([north, east]), np.diff(self.t)


def read_trajectory(
    path: Path, *, height_offset: float = 0.0, undulation: Undulation | None = None, key: str = ""
) -> Trajectory:
    """Read and check a trajectory file.

    height_offset: added to the file's heights, m.  undulation: of the geoid (m) at lat, lon (rad), for orthometric
    heights.  Barometric altitudes are taken as heights above the ellipsoid, with the offset: nothing is known of
    the day's pressure.  key: scenario key, for errors.
    Raises InputError with file and line, see `read_table` and `check`.
    """
    try:
        table = read_table(Path(path))
        found = _from_table(table, height_offset, undulation)
        found = check(found, table.place)
        way, dt = found.legs()
        check_velocity(np.hypot(*way.T), np.diff(found.height), dt, found.speed, found.climb, table)
    except InputError as error:
        raise error.at(key=key) from error
    for note in found.notes:
        journal.info("%s: %s", found.source, note)
    return found


def _from_table(table: Table, height_offset: float, undulation: Undulation | None) -> Trajectory:
    column, nothing = table.columns, np.full(len(table.lines), np.nan)
    kind = next(name for name in HEIGHTS if name in column)
    height, lat, lon = column[kind] + height_offset, column["latitude"], np.unwrap(column["longitude"])
    notes = list(table.notes)
    if kind == "orthometric_height":
        if undulation is None:
            raise InputError(
                f"heights of {table.names[kind]} refer to a geoid, and none is given",
                where=table.source,
                allowed="a terrain with a vertical datum, or height_m (ellipsoidal)",
            )
        height = height + undulation(lat, lon)
    if kind == "barometric_altitude":
        notes.append(
            f"{table.names[kind]}: pressure altitude of the standard atmosphere taken as ellipsoidal height, "
            f"{height_offset:+g} m"
        )
    steps = {
        name: step_of(values / _unit(table, name), name in NEEDED) * _unit(table, name)
        for name, values in column.items()
    }
    given = {name: _run_on(column[name]) for name in ("roll", "heading") if name in column}
    return Trajectory(
        source=table.source,
        t=column["time"],
        lat=lat,
        lon=lon,
        height=height,
        speed=column.get("groundspeed", nothing),
        track=column.get("track", nothing),
        climb=column.get("vertical_rate", nothing),
        roll=given.get("roll"),
        pitch=column.get("pitch"),
        heading=given.get("heading"),
        lines=table.lines,
        steps={**steps, "height": steps[kind]},
        pressure=kind == "barometric_altitude",
        notes=tuple(notes),
    )


def _run_on(angle: Array) -> Array:
    """Angles (n,) that run on over the full turn; NaN stays."""
    found, known = angle.copy(), np.isfinite(angle)
    found[known] = np.unwrap(angle[known])
    return found


def _unit(table: Table, quantity: str) -> float:
    return KINDS[table.names[quantity]].factor


def step_of(values: Array, decimal: bool = False, share: float = 0.8) -> float:
    """Quantisation of a column: the largest step of which most changes are whole multiples; 0 if none is seen.

    values: (n,), in the unit of the file, NaN where missing.  decimal: only powers of ten, for columns that move
    on all the time (an even period is no quantisation).  share: of the changes that must be multiples.
    """
    values = values[np.isfinite(values)]
    change = np.abs(np.diff(values))
    change = change[change > 1e-9 * max(1.0, float(np.abs(values).max(initial=0.0)))]
    if not len(change):
        return 0.0
    rounded, count = np.unique(np.round(change, 9), return_counts=True)
    often = np.sort(rounded[np.argsort(-count, kind="stable")[:20]])[::-1]
    for step in (*(() if decimal or len(change) < FEW else often), *(10.0**-k for k in range(9))):
        ratio = change / step
        if np.mean((ratio > 0.99) & (np.abs(ratio - np.round(ratio)) < 0.01)) >= share:
            return float(step)
    return 0.0


def check(found: Trajectory, place: Callable[[int], str]) -> Trajectory:
    """Trajectory with equal rows dropped.  place: of a row, for messages.

    Raises InputError: time running backwards, two positions at one time, jumps, latitude and longitude swapped,
    or too few points.
    """
    back = np.diff(found.t) < 0.0
    if back.any():
        index = int(np.argmax(back)) + 1
        raise InputError(
            f"time runs backwards: {found.t[index]:.10g} s after {found.t[index - 1]:.10g} s", where=place(index)
        )
    same = np.diff(found.t) == 0.0
    if same.any():
        moved = same & ~(
            np.isclose(np.diff(found.lat), 0.0, atol=1e-12)
            & np.isclose(np.diff(found.lon), 0.0, atol=1e-12)
            & np.isclose(np.diff(found.height), 0.0, atol=1e-6)
        )
        if moved.any():
            index = int(np.argmax(moved)) + 1
            raise InputError(f"two positions at {found.t[index]:.10g} s", where=place(index))
        first = int(np.argmax(same)) + 1
        note = f"{int(same.sum())} repeated rows dropped, the first at {place(first)}"
        kept = np.concatenate([[True], ~same])
        numbers = np.flatnonzero(kept)
        found = replace(found.part(kept), notes=(*found.notes, note))
        return check(found, lambda index: place(int(numbers[index])))
    if len(found) < 4:
        raise InputError(f"a trajectory of {len(found)} different times", where=found.source, allowed="4 and more")
    _check_jumps(found, place)
    _check_track(found)
    return found


def _check_jumps(found: Trajectory, place: Callable[[int], str]) -> None:
    way, dt = found.legs()
    step = WGS84_A * max(found.steps.get("latitude", 0.0), found.steps.get("longitude", 0.0))
    rise, rise_step = np.diff(found.height), found.steps.get("height", 0.0)
    length = np.hypot(*way.T)
    fast = (length - 2.0 * step) / dt > MAX_SPEED
    if fast.any():
        index = int(np.argmax(fast))
        raise InputError(
            f"jump of {length[index]:.0f} m in {dt[index]:g} s, {length[index] / dt[index]:.0f} m/s",
            where=place(index + 1),
            allowed=f"up to {MAX_SPEED:g} m/s",
        )
    steep = (np.abs(rise) - 2.0 * rise_step) / dt > MAX_CLIMB
    if steep.any():
        index = int(np.argmax(steep))
        raise InputError(
            f"jump of {rise[index]:+.0f} m in height in {dt[index]:g} s",
            where=place(index + 1),
            allowed=f"up to {MAX_CLIMB:g} m/s",
        )
    velocity = way / dt[:, None]
    apart = (dt[1:] + dt[:-1]) / 2.0
    sharp = np.hypot(*np.diff(velocity, axis=0).T) / apart - 4.0 * step / np.minimum(dt[1:], dt[:-1]) / apart
    if (sharp > MAX_ACCELERATION).any():
        index = int(np.argmax(sharp > MAX_ACCELERATION))
        raise InputError(
            f"jump: the velocity changes by {np.hypot(*(velocity[index + 1] - velocity[index])):.0f} m/s "
            f"in {apart[index]:g} s",
            where=place(index + 1),
            allowed=f"up to {MAX_ACCELERATION:g} m/s2",
        )


def _check_track(found: Trajectory) -> None:
    """Tracks that have nothing to do with the positions: these are swapped, or mirrored."""
    way, dt = found.legs()
    track = found.track[:-1]
    moving = (np.hypot(*way.T) / dt > SLOWEST) & np.isfinite(track)
    if moving.sum() < 20:
        return
    off = np.abs(wrap_pi(np.arctan2(way[moving, 1], way[moving, 0]) - track[moving]))
    if np.median(off) > math.radians(60.0):
        raise InputError(
            f"positions run {np.degrees(np.median(off)):.0f} deg off the track column",
            where=found.source,
            allowed="latitude and longitude not swapped, west and south negative",
        )
