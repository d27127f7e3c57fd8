"""What both rows see of the land, taken from the orthophoto at their pixel, compiled."""

from __future__ import annotations

import numpy as np
from numba import njit

from aerosim.frames import Array
from aerosim.raster import bilinear
from aerosim.rasterfile import Values


@njit(cache=True)
def look(
    grey: Values, gx: float, gy: float, gdx: float, gdy: float,
    heights: Values, hx: float, hy: float, hdx: float, hdy: float,
    place: Array, ahead: Array, height: float, pixel: float, focal: float, spacing: float,
    blur_along: float, blur_across: float, steps: Array, phases: Array, row1: Array, rows2: Array, slopes: Array,
) -> bool:  # fmt: skip  # pragma: no cover - compiled
    """Fill what the rows see; False if some of it is not there.

    A pixel meets the height of the land where the row crosses it.  Ground dh above the middle passes from row I
    to row II d dh / height earlier, half of it before and half behind the middle.
    """
    u, wide = rows2.shape[1], row1.shape[1]
    j = (wide - u) // 2
    middle = height - pixel * focal
    # row and column of the window: at the place, for a metre ahead, and for one to the right
    r0, r_ahead, r_right = (place[1] - gy) / gdy, ahead[1] / gdy, -ahead[0] / gdy
    c0, c_ahead, c_right = (place[0] - gx) / gdx, ahead[0] / gdx, ahead[1] / gdx
    blur_r, blur_c = blur_along * pixel * r_ahead, blur_along * pixel * c_ahead
    wide_r, wide_c = blur_across * pixel * r_right, blur_across * pixel * c_right
    for i in range(wide):
        y = (i - (wide - 1) / 2.0) * pixel
        h = bilinear(heights, hx, hy, hdx, hdy, place[0] + y * ahead[1], place[1] - y * ahead[0])
        across = (i - (wide - 1) / 2.0) * (height - h) / focal
        lead = 0.5 * spacing * (h - middle) / focal
        r, c = r0 + across * r_right, c0 + across * c_right
        for k in range(phases.shape[0]):
            shift = phases[k] * pixel
            row1[k, i] = _blurred(
                grey, r + shift * r_right - lead * r_ahead, c + shift * c_right - lead * c_ahead,
                blur_r, blur_c, wide_r, wide_c,
            )  # fmt: skip
        if np.isnan(row1[0, i]):  # also without a height
            return False
        if i < j or i >= wide - j:
            continue
        for s in range(steps.shape[0]):
            way = lead + steps[s] * pixel
            rows2[s, i - j] = _blurred(grey, r + way * r_ahead, c + way * c_ahead, blur_r, blur_c, wide_r, wide_c)
        half = 0.5 * pixel
        for axis in range(2):
            dr, dc = (half * r_ahead, half * c_ahead) if axis == 0 else (half * r_right, half * c_right)
            slopes[axis, i - j] = _blurred(grey, r + dr, c + dc, blur_r, blur_c, wide_r, wide_c) - _blurred(
                grey, r - dr, c - dc, blur_r, blur_c, wide_r, wide_c
            )
    return not (np.isnan(row1).any() or np.isnan(slopes).any() or np.isnan(rows2).any())


@njit(cache=True)
def _blurred(
    grey: Values, row: float, col: float, blur_r: float, blur_c: float, wide_r: float, wide_c: float
) -> float:  # pragma: no cover - compiled
    """Mean of four values around a point: the standard deviations of the blur along and across, in cells."""
    total = 0.0
    for a in (-1.0, 1.0):
        for c in (-1.0, 1.0):
            x = row + a * blur_r + c * wide_r
            y = col + a * blur_c + c * wide_c
            if not (x >= 0.0 and y >= 0.0 and x < grey.shape[0] - 1 and y < grey.shape[1] - 1):
                return np.nan
            p, q = int(x), int(y)
            u, v = x - p, y - q
            upper = grey[p, q] + v * (grey[p, q + 1] - grey[p, q])
            lower = grey[p + 1, q] + v * (grey[p + 1, q + 1] - grey[p + 1, q])
            total += upper + u * (lower - upper)
    return 0.25 * total
