"""One piece of a ray over the tiles and cells of a relief, compiled: crossings with the bilinear ground.

Tiles of 64 and 8 cells whose heights the ray stays above (or below) are passed in one step.  Within a cell the
height over the bilinear ground is a quadratic, so no crossing is stepped over, however short.
A piece is cubics in u, 0 to 1: c (3, 4), coefficients of column, row and height.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerosim.frames import Array
from aerosim.geolocation.compiled import kernel
from aerosim.geolocation.relief import BLOCK, EDGE, PER_BLOCK, SIDE, SUBTILE, TILE
from aerosim.rasterfile import Values

HIT, MISS, NODATA, OUTSIDE = 0, 1, 2, 3
# What a ray is over: not known yet, above or under known ground, a void, off the raster.
START, ABOVE, UNDER, VOID, OFF = 0, 1, 2, 3, 4
# Columns of a ray's floats and integers, kept while a block is fetched: where it is (m), its first hit (in u, then
# m); of the hit latitude, longitude (rad), height, distance (m), incidence (rad), point and direction (3,) in e.
AT, FOUND, LAT, LON, HEIGHT, DISTANCE, INCIDENCE, POINT, ARRIVING, REALS = 0, 1, 2, 3, 4, 5, 6, 7, 10, 13
MODE, CROSSINGS, STATUS, WANTED, WHOLE = 0, 1, 2, 3, 4
GOES_ON, ENDED, WANTS = 0, 1, 2
# A point this near to a cell's edge, in cells, belongs to the cell that the ray goes to.
NUDGE = 1e-3
LEAST_STEP = 1e-9


@kernel
def _value(c: Array, k: int, u: float) -> float:  # pragma: no cover - compiled
    return float(((c[k, 3] * u + c[k, 2]) * u + c[k, 1]) * u + c[k, 0])


@kernel
def _rate(c: Array, k: int, u: float) -> float:  # pragma: no cover - compiled
    return float((3.0 * c[k, 3] * u + 2.0 * c[k, 2]) * u + c[k, 1])


@kernel
def _leaves(c: Array, k: int, u: float, low: float, high: float) -> float:  # pragma: no cover - compiled
    """Parameter at which a coordinate leaves low to high, one Newton step over the straight guess."""
    rate = _rate(c, k, u)
    if rate == 0.0:
        return 2.0
    target = high if rate > 0.0 else low
    guess = u + (target - _value(c, k, u)) / rate
    if guess > 1.5:
        return 2.0
    there = _rate(c, k, guess)
    return guess - (_value(c, k, guess) - target) / there if there * rate > 0.0 else guess


@kernel
def _tile_end(
    c: Array, u: float, x: float, y: float, right: float, bottom: float, size: float
) -> float:  # pragma: no cover
    """Parameter at which the piece leaves the tile that begins at x, y, or the raster, or ends."""
    end = min(
        _leaves(c, 0, u, x, min(x + size, right)), _leaves(c, 1, u, y, min(y + size, bottom)), 1.0
    )  # fmt: skip
    return max(end, u + LEAST_STEP)


@kernel
def _passes(c: Array, u: float, end: float, low: float, high: float, mode: int) -> int:  # pragma: no cover
    """Mode after a tile of heights low to high if nothing can happen in it, else -1."""
    if high < low:
        return VOID
    h0, h1 = _value(c, 2, u), _value(c, 2, end)
    bow = (2.0 * abs(c[2, 2]) + 6.0 * abs(c[2, 3])) * (end - u) ** 2 / 8.0
    if min(h0, h1) - bow > high and mode != UNDER:
        return ABOVE
    if mode == UNDER and max(h0, h1) + bow < low:
        return UNDER
    return -1


@kernel
def _comes_in(c: Array, u: float, right: float, bottom: float) -> float:  # pragma: no cover - compiled
    """Parameter at which a piece that is off the raster comes over it, along chords; 1 if it does not."""
    chords = 16
    first = int(u * chords)
    for k in range(first, chords):
        u0, u1 = max(u, k / chords), (k + 1) / chords
        enter, leave = 0.0, 1.0
        for axis in range(2):
            a, last = _value(c, axis, u0), right if axis == 0 else bottom
            b = _value(c, axis, u1)
            if a == b:
                if not 0.0 <= a <= last:
                    leave = -1.0
                continue
            t0, t1 = (0.0 - a) / (b - a), (last - a) / (b - a)
            enter, leave = max(enter, min(t0, t1)), min(leave, max(t0, t1))
        if enter < leave:
            return min(max(u0 + enter * (u1 - u0), u + 1e-6), 1.0)
    return 1.0


@kernel
def _polish(
    c: Array, u: float, span: float, z00: float, gx: float, gy: float, twist: float, i: int, j: int
) -> float:  # pragma: no cover
    """Secant steps on the height over a cell, from a first guess u."""
    before, at = u, u
    f_before = 0.0
    for k in range(4):
        x, y = _value(c, 0, at) - j, _value(c, 1, at) - i
        f = _value(c, 2, at) - (z00 + gx * x + gy * y + twist * x * y)
        if k == 0:
            slope = _rate(c, 2, at) - (gx + twist * y) * _rate(c, 0, at) - (gy + twist * x) * _rate(c, 1, at)
        else:
            slope = (f - f_before) / (at - before) if at != before else 0.0
        if slope == 0.0 or abs(f) < 1e-7:
            break
        before, f_before = at, f
        at = min(max(at - f / slope, u - span), u + span)
    return at


@kernel
def _cells(
    c: Array,
    u: float,
    end: float,
    x: float,
    y: float,
    chord: tuple[float, float, float, float],
    posts: Values,
    first: int,
    bounds: tuple[int, int, int, int],
    reals: Array,
    whole: NDArray[np.int64],
) -> bool:  # pragma: no cover - compiled
    """Cell by cell to the end of a subtile; sets mode, crossings and the first hit, as a parameter of the piece.

    Column and row along the tile's chord (off by centimetres, which the hit is freed of), the height exact (after
    Amanatides and Woo 1987).  x, y: at u; chord: rates of column and row, and what they take for a cell.  posts:
    flat; first: place in it that the post of row 0, column 0 would have.  bounds: first and last row and column
    of cells. False if the ray is lost.
    """
    vx, vy, per_x, per_y = chord
    i = min(max(int(y + (NUDGE if vy >= 0.0 else -NUDGE)), bounds[0]), bounds[1])
    j = min(max(int(x + (NUDGE if vx >= 0.0 else -NUDGE)), bounds[2]), bounds[3])
    x0, y0 = x - j, y - i
    u_x = u + (1.0 - x0 if vx > 0.0 else x0) * per_x
    u_y = u + (1.0 - y0 if vy > 0.0 else y0) * per_y
    step_x, step_y = 1 if vx > 0.0 else -1, 1 if vy > 0.0 else -1
    a2, a3, a1, a0 = c[2, 2], c[2, 3], c[2, 1], c[2, 0]
    h0 = ((a3 * u + a2) * u + a1) * u + a0
    mode = whole[MODE]
    while True:
        across = u_x < u_y
        u1 = max(min(u_x if across else u_y, end), u)
        k = first + i * EDGE + j
        z00, z01 = float(posts[k]), float(posts[k + 1])
        z10, z11 = float(posts[k + EDGE]), float(posts[k + EDGE + 1])
        gx, gy, twist = z01 - z00, z10 - z00, z00 - z01 - z10 + z11
        x1, y1 = x0 + vx * (u1 - u), y0 + vy * (u1 - u)
        h1 = ((a3 * u1 + a2) * u1 + a1) * u1 + a0
        if abs(twist) < np.inf:
            f0 = h0 - (z00 + gx * x0 + (gy + twist * x0) * y0)
            f1 = h1 - (z00 + gx * x1 + (gy + twist * x1) * y1)
            bow = -twist * (x1 - x0) * (y1 - y0)
            if mode < ABOVE or mode > UNDER:
                mode = _settled(f0, mode, whole)
                if mode < 0:
                    return False
            t = _down(f0, f1, bow, mode == ABOVE)
            if t >= 0.0:
                whole[CROSSINGS] += 1
                if whole[CROSSINGS] == 1:
                    reals[FOUND] = _polish(c, u + t * (u1 - u), u1 - u, z00, gx, gy, twist, i, j)
            mode = UNDER if f1 < 0.0 else ABOVE
        else:
            mode = VOID
        u, h0, x0, y0 = u1, h1, x1, y1
        if across:
            j += step_x
            x0 = 0.0 if vx > 0.0 else 1.0
            u_x += per_x
        else:
            i += step_y
            y0 = 0.0 if vy > 0.0 else 1.0
            u_y += per_y
        if u1 >= end or i < bounds[0] or i > bounds[1] or j < bounds[2] or j > bounds[3]:
            whole[MODE] = mode
            return True


@kernel
def _settled(f0: float, mode: int, whole: NDArray[np.int64]) -> int:  # pragma: no cover - compiled
    """What a ray is over that comes onto known ground f0 m above it, out of the unknown; -1: it is lost."""
    if mode == START and f0 <= 0.0:
        whole[STATUS] = MISS
        return -1
    if f0 < 0.0 and whole[CROSSINGS] == 0:
        whole[STATUS] = NODATA if mode == VOID else OUTSIDE
        return -1
    return UNDER if f0 < 0.0 else ABOVE


@kernel
def _down(f0: float, f1: float, bow: float, above: bool) -> float:  # pragma: no cover - compiled
    """Where f0 (1 - t) + f1 t - bow t (1 - t) goes below zero within 0 to 1; -1: nowhere.

    above: it was above just before.  A quadratic comes down once at most.
    """
    if above and f0 < 0.0:
        return 0.0
    if (f0 < 0.0) == (f1 < 0.0) and abs(bow) <= max(abs(f0), abs(f1)):
        return -1.0
    b = f1 - f0 - bow
    square = b * b - 4.0 * bow * f0
    if square <= 0.0:
        return -1.0
    q = -0.5 * (b + (np.sqrt(square) if b >= 0.0 else -np.sqrt(square)))
    for k in range(2):
        if (k == 0 and bow == 0.0) or (k == 1 and q == 0.0):
            continue
        t = q / bow if k == 0 else f0 / q
        if 0.0 <= t <= 1.0 and b + 2.0 * bow * t < 0.0:
            return float(t)
    return 1.0 if above and f1 < 0.0 else -1.0


@kernel
def _tile(
    c: Array,
    u: float,
    end: float,
    ti: int,
    tj: int,
    slot: int,
    sure: bool,
    shape: tuple[int, int],
    posts: Values,
    subtiles: Values,
    reals: Array,
    whole: NDArray[np.int64],
) -> bool:  # pragma: no cover - compiled
    """Subtile by subtile along a chord to the end of a tile.  False if the ray is lost.

    sure: the ray ends in this tile, which has voids, so it is to be known what it is over at its end.
    """  # fmt: skip
    right, bottom = shape[1] - 1, shape[0] - 1
    row, col = ti // PER_BLOCK * BLOCK, tj // PER_BLOCK * BLOCK
    x, y = _value(c, 0, u), _value(c, 1, u)
    vx, vy = (_value(c, 0, end) - x) / (end - u), (_value(c, 1, end) - y) / (end - u)
    side = TILE // SUBTILE
    i = min(max(int((y + (NUDGE if vy >= 0.0 else -NUDGE)) / SUBTILE), ti * side), ti * side + side - 1)
    j = min(max(int((x + (NUDGE if vx >= 0.0 else -NUDGE)) / SUBTILE), tj * side), tj * side + side - 1)
    per_x, per_y = 1.0 / max(abs(vx), 1e-12), 1.0 / max(abs(vy), 1e-12)
    chord = (vx, vy, per_x, per_y)
    u_x = u + abs(SUBTILE * (j + 1 if vx > 0.0 else j) - x) * per_x
    u_y = u + abs(SUBTILE * (i + 1 if vy > 0.0 else i) - y) * per_y
    begin = u
    bend_2 = (2.0 * abs(c[2, 2]) + 6.0 * abs(c[2, 3])) / 8.0
    h0 = _value(c, 2, u)
    while True:
        across = u_x < u_y
        u1 = max(min(u_x if across else u_y, end), u)
        h1 = _value(c, 2, u1)
        bow = bend_2 * (u1 - u) * (u1 - u)
        low = subtiles[slot, 0, i - row // SUBTILE, j - col // SUBTILE]
        high = subtiles[slot, 1, i - row // SUBTILE, j - col // SUBTILE]
        mode = whole[MODE]
        if high < low:
            whole[MODE] = VOID
        elif not sure and mode != UNDER and min(h0, h1) - bow > high:
            whole[MODE] = ABOVE
        elif (sure or mode != UNDER or max(h0, h1) + bow >= low) and u1 > u:
            bounds = (
                i * SUBTILE, min(i * SUBTILE + SUBTILE, bottom) - 1,
                j * SUBTILE, min(j * SUBTILE + SUBTILE, right) - 1,
            )  # fmt: skip
            place = (slot * SIDE + i - row // SUBTILE) * SIDE + j - col // SUBTILE
            first = place * EDGE * EDGE - i * SUBTILE * EDGE - j * SUBTILE
            here = x + vx * (u - begin), y + vy * (u - begin)
            if not _cells(c, u, u1, here[0], here[1], chord, posts, first, bounds, reals, whole):
                return False
        u, h0 = u1, h1
        if u >= end:
            return True
        if across:
            j += 1 if vx > 0.0 else -1
            u_x += SUBTILE * per_x
            if j < tj * side or j >= tj * side + side:
                return True
        else:
            i += 1 if vy > 0.0 else -1
            u_y += SUBTILE * per_y
            if i < ti * side or i >= ti * side + side:
                return True


@kernel
def follow_piece(
    c: Array,
    u: float,
    last: bool,
    shape: tuple[int, int],
    tiles: Values,
    voids: NDArray[np.bool_],
    slots: NDArray[np.int32],
    posts: Values,
    subtiles: Values,
    reals: Array,
    whole: NDArray[np.int64],
) -> tuple[int, float]:  # pragma: no cover - compiled
    """Follow one piece from u on.  last: the ray ends with it; shape to subtiles: of Blocks.  What happened,
    and u."""  # fmt: skip
    right, bottom = shape[1] - 1, shape[0] - 1
    while u < 1.0:
        j = int(np.floor(_value(c, 0, u) + (NUDGE if _rate(c, 0, u) >= 0.0 else -NUDGE)))
        i = int(np.floor(_value(c, 1, u) + (NUDGE if _rate(c, 1, u) >= 0.0 else -NUDGE)))
        if i < 0 or j < 0 or i >= bottom or j >= right:
            if whole[CROSSINGS] > 0:
                return ENDED, u
            whole[MODE] = OFF
            u = _comes_in(c, u, right, bottom)
            continue
        ti, tj = i // TILE, j // TILE
        end = _tile_end(c, u, tj * TILE, ti * TILE, right, bottom, TILE)
        mode = _passes(c, u, end, tiles[0, ti, tj], tiles[1, ti, tj], whole[MODE])
        if mode >= 0 and not (last and end >= 1.0 and voids[ti, tj] and mode != VOID):
            whole[MODE] = mode
            u = end
            continue
        bi, bj = ti // PER_BLOCK, tj // PER_BLOCK
        slot = slots[bi, bj]
        if slot < 0:
            whole[WANTED] = bi * slots.shape[1] + bj
            return WANTS, u
        sure = last and end >= 1.0 and voids[ti, tj]
        if not _tile(c, u, end, ti, tj, slot, sure, shape, posts, subtiles, reals, whole):
            return ENDED, u
        u = end
    return GOES_ON, 1.0
