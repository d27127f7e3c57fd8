"""Ground speeds and vertical rates that have nothing to do with the positions: most often another unit."""

from __future__ import annotations

import numpy as np

from aerosim.errors import InputError
from aerosim.flight.replay.trajectory_file import FOOT, KNOT, Table
from aerosim.frames import Array

GAP = 30.0  # s; what happens across a longer one is not the mean of its ends
MOVING = 20.0  # m/s
LEAST_S = 60.0  # of moving, for a verdict
# Of three real flights the way by ground speeds is 0.998 to 1.004 of that by positions.
SPEED_AGREES = (0.85, 1.18)
WINDOW_S, CLIMBED = 60.0, 60.0  # a minute in which at least so many metres were climbed or sunk
LEAST_WINDOWS = 3
# Of two real flights the medians are 1.04 and 1.22; barometric and geometric rates differ by some per cent.
CLIMB_AGREES = (0.4, 2.5)
NEAR = 1.12  # how near a ratio is to a unit's to be called that
_SPEED_UNITS = ((KNOT, "m/s"), (1.0 / KNOT, "kt"), (3.6, "km/h"), (3.6 * KNOT, "km/h"))
_CLIMB_UNITS = ((FOOT / 60.0, "m/s"), (60.0 / FOOT, "ft/min"), (1.0 / FOOT, "ft/s"))


def check_velocity(way: Array, rise: Array, dt: Array, speed: Array, climb: Array, table: Table) -> None:
    """Raise InputError for speeds or rates that contradict the positions.

    way, rise, dt: from point to point, (n-1,), m, m, s.  speed, climb: of the points, (n,), m/s, NaN where the
    file has none.  table: names of the columns and of the file.
    """
    told, moving = (speed[1:] + speed[:-1]) / 2.0, (way / dt > MOVING) & (dt <= GAP)
    moving &= np.isfinite(told)
    if dt[moving].sum() >= LEAST_S:
        ratio = float((told * dt)[moving].sum() / way[moving].sum())
        if not SPEED_AGREES[0] < ratio < SPEED_AGREES[1]:
            there = way[moving].sum() / dt[moving].sum()
            raise _refusal(table, "groundspeed", ratio, ratio * there, there, _SPEED_UNITS)
    windows = _climbs(rise, dt, (climb[1:] + climb[:-1]) / 2.0, np.append(0.0, np.cumsum(dt)[:-1]))
    if len(windows) >= LEAST_WINDOWS:
        ratio = float(np.median(windows[:, 0] / windows[:, 1]))
        if not CLIMB_AGREES[0] < ratio < CLIMB_AGREES[1]:
            there = float(np.median(np.abs(windows[:, 1]))) / WINDOW_S
            raise _refusal(table, "vertical_rate", ratio, ratio * there, there, _CLIMB_UNITS)


def _climbs(rise: Array, dt: Array, told: Array, t: Array) -> Array:
    """Climb by the rates and by the heights, (k, 2), m, of each minute in which enough is climbed."""
    known, number = np.isfinite(told) & (dt <= GAP), np.floor(t / WINDOW_S).astype(int)
    if not known.any():
        return np.zeros((0, 2))
    both = np.column_stack([
        np.bincount(number[known], weights=values[known]) for values in (told * dt, rise)
    ])  # fmt: skip
    return np.asarray(both[np.abs(both[:, 1]) >= CLIMBED])


def _refusal(
    table: Table, quantity: str, ratio: float, told: float, there: float, units: tuple[tuple[float, str], ...]
) -> InputError:
    name = table.names[quantity]
    likely = [unit for factor, unit in units if 1.0 / NEAR < ratio / factor < NEAR and not _says(name, unit)]
    hint = f": are its numbers in {likely[0]}?" if likely else ""
    if ratio < 0.0:
        hint = ": is it positive downwards?"
    return InputError(
        f"{name} is {told:.3g} m/s where the positions make {there:.3g} m/s, {ratio:.3g} times as much{hint}",
        where=table.source,
        allowed="the velocity of the positions, climbs positive",
    )


def _says(name: str, unit: str) -> bool:
    """Whether a column's name has this unit already."""
    return name.endswith({"m/s": "_m_s", "kt": "_kt", "ft/min": "_ftpmin"}.get(unit, " "))
