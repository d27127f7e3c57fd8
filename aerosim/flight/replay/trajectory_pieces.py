"""A trajectory cut at its gaps and stops, and carried to another place on Earth."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from aerosim.errors import InputError
from aerosim.flight.replay.trajectory import SLOWEST, Trajectory
from aerosim.frames import WGS84_A, Array, ecef_from_geodetic, geodetic_from_ecef, mat_ne, wrap_pi

AGREES = (0.7, 1.4)  # mean speed across a gap against the speed beside it
DETOUR = 1.5  # speed to and from a wild point against the speed around it
SHORT_GAP = 30.0  # s; below it stale stamps look like a speed that disagrees


def flown_pieces(found: Trajectory, gap_max: float) -> tuple[list[Trajectory], list[str]]:
    """Pieces without long gaps and without parts on the ground, in order of time, and what was cut and why.

    gap_max: s.  A gap counts as long too if it is above 30 s and what lies beside it does not agree with it.
    """
    found, aside = _without_wild(found)
    way, dt = found.legs()
    speed = np.hypot(*way.T) / dt
    calm = _calm(speed)
    beside = (np.concatenate([[calm[0]], calm[:-1]]) + np.concatenate([calm[1:], [calm[-1]]])) / 2.0
    ratio = speed / np.maximum(beside, 1.0)
    usual = 3.0 * float(np.median(dt))
    disagrees = (dt > max(SHORT_GAP, usual)) & ((ratio < AGREES[0]) | (ratio > AGREES[1]))
    gap, slow = (dt > gap_max) | disagrees, calm < SLOWEST
    edges = np.flatnonzero(np.concatenate([[True], gap | slow, [True]]))
    pieces = [found.part(slice(a, b)) for a, b in pairwise(edges) if b - a >= 8]
    notes = aside + [
        f"gap of {dt[i]:.0f} s before {found.source}:{found.lines[i + 1]}"
        + ("" if dt[i] > gap_max else " that does not fit the speed beside it")
        for i in np.flatnonzero(gap & ~slow)
    ]
    if slow.any():
        notes.append(f"{float(dt[slow].sum()):.0f} s on the ground or slower than {SLOWEST:g} m/s are left out")
    if not pieces:
        raise InputError("nothing of it is flown", where=found.source, allowed=f"{SLOWEST:g} m/s and more")
    return pieces, notes


def _calm(speed: Array) -> Array:
    """The median of five legs: one stale stamp is no stop."""
    padded = np.pad(speed, 2, mode="edge")
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=-1))


def _without_wild(found: Trajectory) -> tuple[Trajectory, list[str]]:
    """Points left out to which and from which the way is too long, when it is not from neighbour to neighbour."""
    way, dt = found.legs()
    speed = np.hypot(*way.T) / dt
    calm = np.maximum(_calm(speed), SLOWEST)
    there, back = speed[:-1] / calm[:-1], speed[1:] / calm[1:]
    past = np.hypot(*(way[1:] + way[:-1]).T) / (dt[1:] + dt[:-1]) / (0.5 * (calm[1:] + calm[:-1]))
    step = 2.0 * WGS84_A * max(found.steps.get("latitude", 0.0), found.steps.get("longitude", 0.0))
    wild = (
        (there > DETOUR)
        & (back > DETOUR)
        & (past < AGREES[1])
        & (np.minimum(speed[1:] * dt[1:], speed[:-1] * dt[:-1]) > step)
    )
    if not wild.any():
        return found, []
    first = int(np.argmax(wild)) + 1
    note = (
        f"{int(wild.sum())} points far aside of their neighbours left out, "
        f"the first at {found.source}:{found.lines[first]}"
    )
    return found.part(np.concatenate([[True], ~wild, [True]])), [note]


def moved(found: Trajectory, anchor: tuple[float, float], to: tuple[float, float]) -> Trajectory:
    """The path carried to another place on Earth as a rigid body: same shape, azimuths at the anchor kept.

    anchor, to: latitude and longitude, rad.  The tangent frame at one becomes that at the other; each point keeps
    its ellipsoidal height (the Earth falls off a little differently there).
    """
    pos_e = ecef_from_geodetic(found.lat, found.lon, found.height)
    old, new = mat_ne(*anchor), mat_ne(*to)
    turn = new.T @ old
    origin, target = (ecef_from_geodetic(*place, 0.0) for place in (anchor, to))
    lat, lon, _ = geodetic_from_ecef(target + (pos_e - origin) @ turn.T)

    def carried(azimuth: Array | None) -> Array | None:
        if azimuth is None:
            return None
        known = np.isfinite(azimuth)
        at = np.where(known, azimuth, 0.0)
        east = np.stack([-np.sin(found.lon), np.cos(found.lon), np.zeros(len(found))], axis=-1)
        north = np.cross(_up(found.lat, found.lon), east)
        way_e = (np.cos(at)[:, None] * north + np.sin(at)[:, None] * east) @ turn.T
        east = np.stack([-np.sin(lon), np.cos(lon), np.zeros(len(lon))], axis=-1)
        north = np.cross(_up(lat, lon), east)
        there = np.arctan2((way_e * east).sum(axis=-1), (way_e * north).sum(axis=-1))
        return np.where(known, azimuth + wrap_pi(there - at), np.nan)

    track = carried(found.track)
    assert track is not None
    return replace(found, lat=lat, lon=np.unwrap(lon), track=track, heading=carried(found.heading))


def _up(lat: Array, lon: Array) -> Array:
    return np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1)
