"""Rays to the relief, compiled: from its highest to its lowest height, in pieces.

On a piece of 16 km at most, column, row and height are cubics through four exact points: off by a centimetre in
the worst case, by less than a millimetre at 74 deg off-nadir.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerosim.frames import Array
from aerosim.geolocation.cells import (
    ABOVE,
    ARRIVING,
    AT,
    CROSSINGS,
    DISTANCE,
    ENDED,
    FOUND,
    HEIGHT,
    HIT,
    INCIDENCE,
    LAT,
    LON,
    MISS,
    MODE,
    NODATA,
    OFF,
    OUTSIDE,
    POINT,
    START,
    STATUS,
    VOID,
    WANTED,
    WANTS,
    follow_piece,
)
from aerosim.geolocation.compiled import entry, kernel
from aerosim.geolocation.gridmap import GridMap, cell_of
from aerosim.geolocation.ray import NODES, bend, come_to, dropped, geodetic, passes, start, up_at
from aerosim.geolocation.relief import Blocks
from aerosim.rasterfile import Values

LONGEST_PIECE = 16_000.0
# Heights between the nodes of a ray are off by less than this, m.
SLACK = 4.0


@kernel
def _place(
    linear: Array,
    lattice: Array,
    box: Array,
    middle: float,
    pos: Array,
    los: Array,
    down: Array,
    nodes: Array,
    count: int,
    s: float,
    p: Array,
    k: int,
) -> float:  # pragma: no cover
    """Column, row and height of a ray's point at s into p[:, k]; returns the cosine of its latitude."""
    drop, _slope = dropped(nodes, count, s)
    x = pos[0] + s * los[0] + drop * down[0]
    y = pos[1] + s * los[1] + drop * down[1]
    z = pos[2] + s * los[2] + drop * down[2]
    sine, cosine, p[2, k] = geodetic(x, y, z)
    p[0, k], p[1, k] = cell_of(linear, lattice, box, middle, np.arctan(sine / cosine), np.arctan2(y, x))
    return cosine


@kernel
def _fill(
    pos: Array, los: Array, down: Array, nodes: Array, count: int, s: float, reals: Array
) -> None:  # pragma: no cover - compiled
    """What is to be known of a ray at s into its state."""
    reals[FOUND] = s
    drop, slope = dropped(nodes, count, s)
    x = pos[0] + s * los[0] + drop * down[0]
    y = pos[1] + s * los[1] + drop * down[1]
    z = pos[2] + s * los[2] + drop * down[2]
    dx, dy, dz = los[0] + slope * down[0], los[1] + slope * down[1], los[2] + slope * down[2]
    sine, cosine, reals[HEIGHT] = geodetic(x, y, z)
    ux, uy, uz = up_at(x, y, sine, cosine)
    length = np.sqrt(dx * dx + dy * dy + dz * dz)
    reals[LAT], reals[LON] = np.arctan(sine / cosine), np.arctan2(y, x)
    reals[DISTANCE] = np.sqrt(s * s + drop * drop)
    reals[INCIDENCE] = np.arccos(min(max(-(dx * ux + dy * uy + dz * uz) / length, -1.0), 1.0))
    reals[POINT], reals[POINT + 1], reals[POINT + 2] = x, y, z
    reals[ARRIVING], reals[ARRIVING + 1], reals[ARRIVING + 2] = dx / length, dy / length, dz / length


@kernel
def _cubics(p: Array, c: Array) -> None:  # pragma: no cover - compiled
    """Coefficients of cubics through values at 0, 1/3, 2/3, 1."""
    for k in range(3):
        a, b, d, e = p[k, 0], p[k, 1], p[k, 2], p[k, 3]
        c[k, 0] = a
        c[k, 1] = -5.5 * a + 9.0 * b - 4.5 * d + e
        c[k, 2] = 9.0 * a - 22.5 * b + 18.0 * d - 4.5 * e
        c[k, 3] = -4.5 * a + 13.5 * b - 13.5 * d + 4.5 * e


@kernel
def _longest(geographic: bool, cosine: float) -> float:  # pragma: no cover - compiled
    """Length of a piece, m: shorter beside a pole, where longitude runs away along a straight line."""
    to_pole = 6.37e6 * max(cosine, 1e-7)
    if not geographic or to_pole > 1e6:
        return LONGEST_PIECE
    return float(min(LONGEST_PIECE, np.sqrt(np.sqrt(0.08 * to_pole * to_pole * to_pole))))


@kernel
def _span(
    pos: Array, los: Array, down: Array, table: Array, low: float, high: float, nodes: Array
) -> tuple[int, float, float]:  # pragma: no cover
    """Nodes of a ray, and where it is between high and low for the first time; no nodes: never."""
    height, rise, radius = start(pos, los, down)
    low, high = low - SLACK, high + SLACK
    count = bend(height, rise, radius, table, low - 50.0, high + 50.0, nodes)
    if count < 2:
        return 0, 0.0, 0.0
    begin, node = 0.0, 0
    if height > high:
        begin, node = passes(nodes, count, high, 0, True)
        if node < 0:
            return 0, 0.0, 0.0
    end, at = passes(nodes, count, low, node, True)
    rises, up = passes(nodes, count, high, node, False)
    if up >= 0 and rises > begin and (at < 0 or rises < end):
        end = rises
    elif at < 0:
        end = nodes[0, count - 1]
    return count, begin, end


@kernel
def _unmet(mode: int) -> int:  # pragma: no cover - compiled
    """Status of a ray that met no ground, by what it was over at the end."""
    return NODATA if mode == VOID else OUTSIDE if mode == OFF else MISS


@kernel
def _next_piece(
    linear: Array,
    lattice: Array,
    box: Array,
    middle: float,
    pos: Array,
    los: Array,
    down: Array,
    nodes: Array,
    count: int,
    s: float,
    end: float,
    p: Array,
    c: Array,
) -> float:  # pragma: no cover - compiled
    """Coefficients of the piece that begins at s; its length, m, negative off the grid."""
    cosine = _place(linear, lattice, box, middle, pos, los, down, nodes, count, s, p, 0)
    length = min(end - s, _longest(linear.size > 0, cosine))
    for k in range(1, 4):
        _place(linear, lattice, box, middle, pos, los, down, nodes, count, s + length * k / 3.0, p, k)
    if not abs(p[0, 0] + p[0, 1] + p[0, 2] + p[0, 3]) < np.inf:
        return -length
    if linear.size > 0:  # longitude counted on from the first point
        turn = abs(2.0 * np.pi * linear[0, 0])
        for k in range(1, 4):
            if p[0, k] - p[0, 0] > 0.5 * turn:
                p[0, k] -= turn
            elif p[0, k] - p[0, 0] < -0.5 * turn:
                p[0, k] += turn
    _cubics(p, c)
    return length


@kernel
def _one(
    pos: Array,
    los: Array,
    table: Array,
    shape: tuple[int, int],
    low: float,
    high: float,
    tiles: Values,
    voids: NDArray[np.bool_],
    slots: NDArray[np.int32],
    posts: Values,
    subtiles: Values,
    linear: Array,
    lattice: Array,
    box: Array,
    middle: float,
    down: Array,
    nodes: Array,
    p: Array,
    c: Array,
    reals: Array,
    whole: NDArray[np.int64],
) -> None:  # pragma: no cover - compiled
    """Follow one ray from where it is to its end or to a block that is not here."""  # fmt: skip
    whole[WANTED] = -1
    count, begin, end = _span(pos, los, down, table, low, high, nodes)
    if count == 0:
        whole[STATUS] = MISS
        return
    if reals[AT] < begin:
        reals[AT] = begin
        whole[MODE] = ABOVE if begin > 0.0 else START
    s = reals[AT]
    while s < end:
        length = _next_piece(linear, lattice, box, middle, pos, los, down, nodes, count, s, end, p, c)
        if length < 0.0:
            if whole[CROSSINGS] > 0:
                break
            whole[MODE] = OFF
            s -= length
            continue
        happened, u = follow_piece(
            c, 0.0, s + length >= end, shape, tiles, voids, slots, posts, subtiles, reals, whole
        )
        if whole[CROSSINGS] > 0 and whole[STATUS] != HIT:
            whole[STATUS] = HIT
            _fill(pos, los, down, nodes, count, s + reals[FOUND] * length, reals)
        if happened == WANTS:
            reals[AT] = s + u * length
            return
        if happened == ENDED:
            break
        s += length
    if whole[STATUS] < 0:
        whole[STATUS] = _unmet(whole[MODE])


@entry
def follow(
    pos: Array,
    los: Array,
    which: NDArray[np.int64],
    table: Array,
    blocks: Blocks,
    grid: GridMap,
    reals: Array,
    whole: NDArray[np.int64],
) -> None:  # pragma: no cover - compiled
    """Follow rays until each has its status or a block that it wants.

    pos, los: (n, 3).  which: rows to follow.  table: of the atmosphere.  reals, whole: their state.
    """  # fmt: skip
    # taken out once: in a loop each look into a tuple counts references
    shape, low, high, tiles, voids, slots, posts, subtiles = blocks
    linear, lattice, box, middle, _geographic = grid
    flat = posts.reshape(-1)
    down, nodes, p, c = np.empty(3), np.empty((4, NODES)), np.empty((3, 4)), np.empty((3, 4))
    for k in which:
        _one(
            pos[k], los[k], table, shape, low, high, tiles, voids, slots, flat, subtiles,
            linear, lattice, box, middle, down, nodes, p, c, reals[k], whole[k],
        )  # fmt: skip


@entry
def at_height(
    pos: Array, los: Array, table: Array, height: Array, reals: Array, whole: NDArray[np.int64]
) -> None:  # pragma: no cover - compiled
    """Rays down to ellipsoidal heights (n,), m.  Fills the state as `follow` does."""
    down, nodes = np.empty(3), np.empty((4, NODES))
    for k in range(len(pos)):
        h, rise, radius = start(pos[k], los[k], down)
        count = bend(h, rise, radius, table, height[k] - 50.0, max(height[k], h) + 50.0, nodes)
        whole[k, STATUS] = MISS
        if count >= 2:
            s, node = come_to(pos[k], los[k], down, nodes, count, height[k], 0, True)
            if node >= 0:
                whole[k, STATUS], whole[k, CROSSINGS] = HIT, 1
                _fill(pos[k], los[k], down, nodes, count, s, reals[k])
