"""How well the two rows will recognise a strip of land: forecast from the orthophoto and the relief alone.

What both rows will see is taken from the orthophoto at their pixel, the MAD surface of a strip is formed without
noise, and the mean of the noise is added; the recogniser's own bounds then judge its trough.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.estimation.mad import FLAT, NEAR_PX, PLAIN, RIVAL
from aerosim.frames import Array
from aerosim.raster import Window, bilinear
from aerosim.rasterfile import Values
from aerosim.sensing.ccd_rows import EXPOSURE_RANGE, REFERENCE_EXPOSURE, TARGET_GREY

STEP_PX = 0.5  # of the surface along the flight
PHASE_PX = 0.25  # mean distance of the shift from the next whole pixel
SETTLE_PX = 2.0  # what is seen behind a plain trough before it is decided
# Set once over the shipped terrain (60 pieces of land, 10 strips each, noise of 5), and not by the tests' land
SPREAD_FLAT = 0.12  # of ln(mean / minimum) between forecast and flight
SPREAD_RIVAL = 0.12  # of ln(second / minimum)
FLOOR_PX = 0.08  # what a quadratic surface through the MAD adds to the formal error
WHOLE_PX = 0.29  # the same of whole pixels
EFFICIENCY = 1.2  # error of the minimum of the MAD over that of least squares, over the shipped terrain
RIGHT_DEG = 0.5


class Eye(NamedTuple):
    """The rows and their recogniser.  px; noise and full scale in grey levels of the converter.

    exposure: s; None: automatic.  search: window of n as shares of the planned one.
    """

    pixels: int
    max_shift: int
    spacing_px: float
    focal_px: float
    smear_along_px: float
    smear_across_px: float
    noise_grey: float
    full_grey: float
    exposure: float | None
    search: tuple[float, float]
    mean_subtracted: bool
    subpixel: bool


class Prospect(NamedTuple):
    """What is forecast of a strip.

    accepted: probability that the recogniser takes it; locked: that it takes it and is right within 0.5 deg;
    sd_angle: standard deviation of its angle, rad; sd_vh: of its v/h, relative; flat, rival: mean and second
    trough over the minimum of its MAD surface.  NaN where there is no land.
    """

    accepted: float
    locked: float
    sd_angle: float
    sd_vh: float
    flat: float
    rival: float


NOTHING = Prospect(np.nan, np.nan, np.nan, np.nan, np.nan, np.nan)


def prospect(
    eye: Eye, ortho: Window, relief: Window, place: Array, ahead: Array, height: float, motion: float = 0.0
) -> Prospect:
    """Forecast of the strip whose middle lies at a place.

    ortho: grey values of 0 to 255; relief: ellipsoidal heights, m.  place: (2,) easting, northing, m; ahead: (2,)
    unit vector of the flight on the grid; height: of the flight, ellipsoidal, m; motion: way over the ground
    during an exposure, m.
    """
    first, last = ((share - 1.0) * eye.spacing_px for share in eye.search)
    seen = _seen(eye, ortho, relief, place, ahead, height, motion, first, last)
    if seen is None:
        return NOTHING
    row1, rows2, slopes = seen
    gain = _gain(eye, float(row1.mean()))
    # both rows are noisy, and rounded to whole grey levels
    noise = 2.0 * (eye.noise_grey**2 + 1.0 / 12.0) / gain**2
    surface = np.sqrt(_surface(row1, rows2, eye.max_shift, eye.mean_subtracted) ** 2 + 2.0 / math.pi * noise)
    least = np.unravel_index(int(surface.argmin()), surface.shape)
    value = float(surface[least])
    whole = _judged(surface, least, FLAT)
    settled = int(least[0]) + round(SETTLE_PX / STEP_PX) + 1
    soon = _judged(surface[:settled], least, PLAIN)
    accepted = max(whole[0], soon[0])
    if least[1] in (0, surface.shape[1] - 1) or least[0] in (0, len(surface) - 1):
        accepted = 0.0
    sd_mu, sd_n = _formal(slopes, value * math.sqrt(math.pi / 2.0))
    floor = FLOOR_PX if eye.subpixel else WHOLE_PX
    sd_angle = math.hypot(EFFICIENCY * sd_mu, floor) / eye.spacing_px
    sd_vh = math.hypot(EFFICIENCY * sd_n, floor) / eye.spacing_px
    off = abs(float(least[1]) - eye.max_shift)
    # the next whole pixel is what a quadratic surface puts right; one further off is a mistake
    right = _within(math.radians(RIGHT_DEG), off / eye.spacing_px if off > 1.0 else 0.0, sd_angle)
    return Prospect(accepted, accepted * right, sd_angle, sd_vh, whole[1], whole[2])


def _gain(eye: Eye, mean: float) -> float:
    """Converter's grey levels for a grey level of the orthophoto, at the exposure that the mean asks for."""
    exposure = eye.exposure
    if exposure is None:
        exposure = REFERENCE_EXPOSURE * TARGET_GREY * 255.0 / max(mean, 1e-3)
        exposure = min(max(exposure, EXPOSURE_RANGE[0]), EXPOSURE_RANGE[1])
    return eye.full_grey / 255.0 * exposure / REFERENCE_EXPOSURE


def _judged(surface: Array, least: tuple[np.intp, ...], bound: float) -> tuple[float, float, float]:
    """Probability that a trough is taken, mean over minimum, second over minimum."""
    value = float(surface[least])
    flat = float(surface.mean()) / value
    steps, shifts = np.ogrid[: surface.shape[0], : surface.shape[1]]
    far = (np.abs(steps - least[0]) * STEP_PX > NEAR_PX) | (np.abs(shifts - least[1]) > NEAR_PX)
    rival = float(surface[far].min()) / value
    chance = _normal(math.log(flat / bound) / SPREAD_FLAT) * _normal(math.log(rival / RIVAL) / SPREAD_RIVAL)
    return chance, flat, rival


def _normal(x: float) -> float:
    return 0.5 * math.erfc(-x / math.sqrt(2.0))


def _within(bound: float, off: float, sd: float) -> float:
    return _normal((bound - off) / sd) - _normal((-bound - off) / sd)


def _formal(slopes: Array, residual: float) -> tuple[float, float]:
    """Formal errors of mu and n as ground motion, px, by least squares.

    slopes: (2, u) of the grey values along and across, per px.  residual: standard deviation of a difference.
    Unknowns as a strip has them: shift, step, rotation of the row, offset of the grey values.
    """
    along, across = slopes
    arm = np.linspace(-1.0, 1.0, along.size)
    design = np.column_stack([across, along, along * arm, np.ones_like(arm)])
    normal = design.T @ design
    # a land without contrast has no answer: the ridge lets its error be large and finite
    inverse = np.linalg.inv(normal + 1e-6 * np.eye(4))
    return residual * math.sqrt(inverse[0, 0]), residual * math.sqrt(inverse[1, 1])


def _seen(
    eye: Eye, ortho: Window, relief: Window, place: Array, ahead: Array, height: float, motion: float,
    first: float, last: float,
) -> tuple[Array, Array, Array] | None:  # fmt: skip
    """Row I, rows II at STEP_PX over the window, and slopes of the grey values; None without land."""
    ground = bilinear(*relief[:5], float(place[0]), float(place[1]))
    if math.isnan(ground):
        return None
    pixel = (height - ground) / eye.focal_px
    cell = abs(ortho.dx) / pixel
    blur = [
        math.sqrt(max((1.0 + smear**2 + moved**2) / 12.0 - cell**2 / 4.0, 0.0))
        for smear, moved in ((eye.smear_along_px, motion / pixel), (eye.smear_across_px, 0.0))
    ]
    steps = STEP_PX * np.arange(math.ceil(first / STEP_PX), math.floor(last / STEP_PX) + 1, dtype=np.float64)
    row1 = np.empty(eye.pixels + 2 * eye.max_shift)
    rows2 = np.empty((len(steps), eye.pixels))
    slopes = np.empty((2, eye.pixels))
    known = _look(
        *ortho[:5], *relief[:5], place, ahead, height, pixel, eye.focal_px, eye.spacing_px, blur[0], blur[1],
        steps, row1, rows2, slopes,
    )  # fmt: skip
    return (row1, rows2, slopes) if known else None


@njit(cache=True)
def _surface(row1: Array, rows2: Array, max_shift: int, centre: bool) -> Array:  # pragma: no cover - compiled
    """MAD of rows II (steps, u) and row I (u + 2 j,), their means taken out if `centre`."""
    steps, u = rows2.shape
    out = np.empty((steps, 2 * max_shift + 1))
    mean1 = row1[max_shift : max_shift + u].mean() if centre else 0.0
    for s in range(steps):
        mean2 = rows2[s].mean() if centre else 0.0
        for k in range(2 * max_shift + 1):
            total = 0.0
            for i in range(u):
                total += abs(row1[k + i] - mean1 - rows2[s, i] + mean2)
            out[s, k] = total / u
    return out


@njit(cache=True)
def _look(
    grey: Values, gx: float, gy: float, gdx: float, gdy: float,
    heights: Values, hx: float, hy: float, hdx: float, hdy: float,
    place: Array, ahead: Array, height: float, pixel: float, focal: float, spacing: float,
    blur_along: float, blur_across: float, steps: Array, row1: Array, rows2: Array, slopes: Array,
) -> bool:  # fmt: skip  # pragma: no cover - compiled
    """Fill what the rows see; False if some of it is not there.

    A pixel meets the height of the land where the row crosses it.  Ground dh above the middle passes from row I
    to row II d dh / height earlier, half of it before and half behind the middle.
    """
    u, wide = rows2.shape[1], row1.shape[0]
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
        shift = PHASE_PX * pixel
        row1[i] = _blurred(
            grey, r + shift * r_right - lead * r_ahead, c + shift * c_right - lead * c_ahead,
            blur_r, blur_c, wide_r, wide_c,
        )  # fmt: skip
        if np.isnan(row1[i]):  # also without a height
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
    return not (np.isnan(slopes).any() or np.isnan(rows2).any())


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
