"""What a CCD row sees and reads: rays to the relief, footprint, smear, motion and converter, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.signals import Grey

EARTH_RADIUS = 6_371_000.0
STEPS = 12
LEVEL = 0.5  # m; the height found is then carried into the ray once more, which leaves centimetres
FURTHEST = 0.75  # px; samples of the blur lie no further apart
FAST = {"contract", "nsz", "arcp"}


@njit(inline="always")
def _between(values: Grey, row: float, col: float) -> float:  # pragma: no cover - compiled
    """Bilinear value at a fractional row and column, NaN outside."""
    if not (row >= 0.0 and col >= 0.0 and row < values.shape[0] - 1 and col < values.shape[1] - 1):
        return np.nan
    # without a sign no index has to be looked at for counting from the end
    i, j = np.uint64(row), np.uint64(col)
    p, q = i + np.uint64(1), j + np.uint64(1)
    a, b = row - np.int64(i), col - np.int64(j)
    upper = values[i, j] + b * (values[i, q] - values[i, j])
    lower = values[p, j] + b * (values[p, q] - values[p, j])
    return float(upper + a * (lower - upper))


@njit(cache=True)
def _light(
    shade: Grey, place: tuple[float, ...], least: float, north: float, east: float
) -> float:  # pragma: no cover - compiled
    """Light on a point of the ground, from `least` to 1: bilinear in a window that repeats itself without end."""
    rows, cols = shade.shape
    row = place[0] + place[1] * north + place[2] * east
    col = place[3] + place[4] * north + place[5] * east
    i, j = int(np.floor(row)), int(np.floor(col))
    a, b = row - i, col - j
    i, j = i % rows, j % cols
    p, q = (i + 1) % rows, (j + 1) % cols
    upper = shade[i, j] + b * (shade[i, q] - shade[i, j])
    lower = shade[p, j] + b * (shade[p, q] - shade[p, j])
    return float(min(max(upper + a * (lower - upper), least), 1.0))


@njit(cache=True)
def index_map(grid: Array, place: Array, ground: float) -> tuple[float, ...]:  # pragma: no cover - compiled
    """Row and column of a window as affine functions of metres north and east of the camera.

    grid: easting, northing of the camera and the map's Jacobian, (6,), as `LocalMap` returns them.
    place: easting and northing of the window's first cell and its two steps, (4,), m.
    ground: height of the ground, m; a metre up there is less on the ellipsoid.
    Returns row0, row per north, row per east, col0, col per north, col per east.
    """
    x0, y0, dx, dy = place[0], place[1], place[2], place[3]
    metre = EARTH_RADIUS / (EARTH_RADIUS + ground)
    return (
        (grid[1] - y0) / dy, metre * grid[4] / dy, metre * grid[5] / dy,
        (grid[0] - x0) / dx, metre * grid[2] / dx, metre * grid[3] / dx,
    )  # fmt: skip


@njit(cache=True, fastmath=FAST)
def relief_depth(
    d_north: float,
    d_east: float,
    d_down: float,
    height: float,
    guess: float,
    relief: Grey,
    place: tuple[float, ...],
) -> tuple[float, float]:  # pragma: no cover - compiled
    """Length s of the ray s (d_north, d_east, d_down) to the relief, and the height there; NaN if it misses.

    place: of the relief's window, see `index_map`.  Fixed point on the height, which converges for slopes below
    the cotangent of the view angle (here 24 deg); a point that lies s ahead is lifted by the Earth's curvature.
    """
    h = guess
    if d_down <= 0.0:
        return np.nan, np.nan
    per_down = 1.0 / d_down
    level2 = 0.5 / EARTH_RADIUS * per_down * (d_north * d_north + d_east * d_east)
    to_row, to_col = place[1] * d_north + place[2] * d_east, place[4] * d_north + place[5] * d_east
    for _ in range(STEPS):
        s = (height - h) * per_down
        s += s * s * level2
        found = _between(relief, place[0] + s * to_row, place[3] + s * to_col)
        if not abs(found - h) >= LEVEL:  # also ends with NaN
            break
        h = found
    s = (height - found) * per_down
    return s + s * s * level2, found


@njit(cache=True)
def spread(smear: float, motion: float, cell: float) -> tuple[int, float]:  # pragma: no cover - compiled
    """Number of samples in a line, and their step (px), that blur like a pixel's box, its smear and its motion.

    smear, motion: widths of their boxes, cell: of the raster's, px.  Equal samples have the second moment of the
    three boxes, less what the raster brings along (a cell's box and the bilinear hat: cell^2/4).  On cells of
    half a pixel two do for a pixel smeared by another one: their response stays within 0.13 of the exact one at
    all wavelengths, and within 0.01 above 3 px; other widths, with more samples, stay within 0.25.
    """
    moment = max((1.0 + smear * smear + motion * motion) / 12.0 - cell * cell / 4.0, 0.0)
    count = max(int(np.ceil(np.sqrt(12.0 * moment / FURTHEST**2 + 1.0))), 2)
    return count, float(np.sqrt(12.0 * moment / (count * count - 1.0)))


@njit(cache=True, fastmath=FAST)
def expose_row(
    grey: Grey,
    noise: Grey,
    rays: Array,
    optics: Array,
    converter: Array,
    height: float,
    mat_nc: Array,
    vel_n: Array,
    omega: Array,
    grid: Array,
    ortho: Grey,
    ortho_place: Array,
    relief: Grey,
    relief_place: Array,
    guess: float,
    shade: Grey | None,
    shade_place: Array | None,
) -> tuple[float, float, int]:  # pragma: no cover - compiled
    """Read one row.  Returns mean ground height (m), mean radiance (grey levels of the orthophoto), and the number
    of pixels that saw no terrain, which read 0.

    grey: (pixels,), filled.  rays: (2, pixels) ideal places along x and y of c, px.  optics: focal length, smear
    along and across (px), exposure (s).  converter: grey per radiance, dark level, noise, full scale (grey).
    height, mat_nc, vel_n, omega: pose and motion of the camera.  Each pixel's centre is brought down to the
    relief; the picture around it is blurred (`spread`) on the level plane through that point.  shade: light on the
    ground, as `_light` has it; shade_place: of its window, and the least light, (5,).  Both None: no shadows, and
    compiled without them.
    """
    pixels = grey.shape[0]
    focal, smear_along, smear_across, exposure = optics[0], optics[1], optics[2], optics[3]
    m = mat_nc
    on_relief, on_ortho = index_map(grid, relief_place, guess), index_map(grid, ortho_place, guess)
    middle = rays[0, pixels // 2]
    (along, step_x), (across, step_y) = _blur(
        middle, focal, smear_along, smear_across, exposure, height - guess, m, vel_n, omega, ortho_place
    )
    total_h, total_light, missing, h, slope = 0.0, 0.0, 0, guess, 0.0
    for i in range(pixels):
        x, y = rays[0, i], rays[1, i]
        d0 = m[0, 0] * x + m[0, 1] * y + m[0, 2] * focal
        d1 = m[1, 0] * x + m[1, 1] * y + m[1, 2] * focal
        d2 = m[2, 0] * x + m[2, 1] * y + m[2, 2] * focal
        s, found = relief_depth(d0, d1, d2, height, h + slope, relief, on_relief)
        light = np.nan
        if not np.isnan(s):
            slope, h = (found - h if i > 0 else 0.0), found
            # ground vectors from sample to sample: along x and y of c, on the level plane
            k0, k1 = d0 / d2, d1 / d2
            xn, xe = s * step_x * (m[0, 0] - m[2, 0] * k0), s * step_x * (m[1, 0] - m[2, 0] * k1)
            yn, ye = s * step_y * (m[0, 1] - m[2, 1] * k0), s * step_y * (m[1, 1] - m[2, 1] * k1)
            n = s * d0 - (along - 1) / 2.0 * xn - (across - 1) / 2.0 * yn
            e = s * d1 - (along - 1) / 2.0 * xe - (across - 1) / 2.0 * ye
            row = on_ortho[0] + on_ortho[1] * n + on_ortho[2] * e
            col = on_ortho[3] + on_ortho[4] * n + on_ortho[5] * e
            xr, xc = on_ortho[1] * xn + on_ortho[2] * xe, on_ortho[4] * xn + on_ortho[5] * xe
            yr, yc = on_ortho[1] * yn + on_ortho[2] * ye, on_ortho[4] * yn + on_ortho[5] * ye
            light = 0.0
            for j in range(along):
                for k in range(across):
                    light += _between(ortho, row + j * xr + k * yr, col + j * xc + k * yc)
            light /= along * across
            if shade is not None and shade_place is not None:
                light *= _light(shade, index_map(grid, shade_place, guess), shade_place[4], s * d0, s * d1)
        if np.isnan(light):
            missing += 1
            grey[i] = 0.0
            continue
        total_h += h
        total_light += light
        level = np.floor(converter[0] * light + converter[1] + converter[2] * noise[i] + 0.5)
        grey[i] = min(max(level, 0.0), converter[3])
    seen = pixels - missing
    if seen == 0:
        return np.nan, np.nan, missing
    return total_h / seen, total_light / seen, missing


@njit(cache=True)
def _blur(
    ahead: float,
    focal: float,
    smear_along: float,
    smear_across: float,
    exposure: float,
    above: float,
    m: Array,
    vel_n: Array,
    omega: Array,
    place: Array,
) -> tuple[tuple[int, float], tuple[int, float]]:  # pragma: no cover - compiled
    """Samples along x and y of c: number and step (px), for the middle pixel of a row.

    The footprint moves over the ground by the camera's path and by its rotation; above: height over ground, m.
    """
    d0 = m[0, 0] * ahead + m[0, 2] * focal
    d1 = m[1, 0] * ahead + m[1, 2] * focal
    d2 = m[2, 0] * ahead + m[2, 2] * focal
    s = above / d2
    xn, xe = s * (m[0, 0] - m[2, 0] * d0 / d2), s * (m[1, 0] - m[2, 0] * d1 / d2)
    yn, ye = s * (m[0, 1] - m[2, 1] * d0 / d2), s * (m[1, 1] - m[2, 1] * d1 / d2)
    vn, ve = vel_n[0] - vel_n[2] * d0 / d2, vel_n[1] - vel_n[2] * d1 / d2
    area = xn * ye - xe * yn
    zoom = -omega[1] * ahead / focal
    move_x = (vn * ye - ve * yn) / area + omega[1] * focal - zoom * ahead
    move_y = (xn * ve - xe * vn) / area + omega[2] * ahead - omega[0] * focal
    cell = abs(place[2]) / np.sqrt(abs(area))
    return spread(smear_along, move_x * exposure, cell), spread(smear_across, move_y * exposure, cell)
