"""How well the two rows will recognise a strip of land: forecast from the orthophoto and the relief alone.

What both rows will see is taken from the orthophoto at their pixel.  Noise is drawn for it a few times, always the
same, and the recogniser's own bounds judge the trough of each MAD surface.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit

from aerosim.estimation.mad import FLAT, NEAR_PX, PLAIN, RIVAL
from aerosim.forecast.row_view import look
from aerosim.frames import Array
from aerosim.raster import Window, bilinear
from aerosim.rasterfile import Values
from aerosim.sensing.ccd_rows import EXPOSURE_RANGE, REFERENCE_EXPOSURE, TARGET_GREY

STEP_PX = 0.25  # of the surface along the flight
PHASES_PX = (0.0, 0.25, -0.25, 0.5)  # shifts beside whole pixels, one after the other in the draws
MEAN_PHASE = 1  # the one whose distance from a whole pixel is the mean one
DRAWS = 8
SETTLE_PX = 2.0  # what is seen behind a plain trough before it is decided
SPREAD = 0.04  # of ln(mean / minimum) and ln(second / minimum): a draw stands for others beside it
# Set once over the shipped terrain (60 pieces of land, 10 strips each, noise of 5), and not by the tests' land
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
    clean = _surface(row1[MEAN_PHASE], rows2, eye.max_shift, eye.mean_subtracted)
    surface = np.sqrt(clean**2 + 2.0 / math.pi * noise)
    least = np.unravel_index(int(surface.argmin()), surface.shape)
    value = float(surface[least])
    flat, rival = _ratios(surface, least)
    accepted, near = _drawn(eye, row1, rows2, math.sqrt(noise / 2.0))
    sd_mu, sd_n = _formal(slopes, value * math.sqrt(math.pi / 2.0))
    floor = FLOOR_PX if eye.subpixel else WHOLE_PX
    sd_angle = math.hypot(EFFICIENCY * sd_mu, floor) / eye.spacing_px
    sd_vh = math.hypot(EFFICIENCY * sd_n, floor) / eye.spacing_px
    right = 1.0 - math.erfc(math.radians(RIGHT_DEG) / sd_angle / math.sqrt(2.0))
    return Prospect(accepted, near * right, sd_angle, sd_vh, flat, rival)


@cache
def _noise(pixels: int, max_shift: int, steps: int) -> tuple[Values, Values]:
    """Noise of row I (draws, u + 2 j) and of rows II (draws, steps, u), of unit variance, always the same."""
    rng = np.random.default_rng(0)
    wide = rng.standard_normal((DRAWS, pixels + 2 * max_shift), dtype=np.float32)
    return wide, rng.standard_normal((DRAWS, steps, pixels), dtype=np.float32)


def _drawn(eye: Eye, row1: Array, rows2: Array, noise: float) -> tuple[float, float]:
    """Probability that a strip is taken, and that it is taken within a pixel of its shift.

    row1: (phases, u + 2 j); rows2: (steps, u), without noise; noise: of a pixel, in the orthophoto's grey levels.
    """
    noise1, noise2 = _noise(eye.pixels, eye.max_shift, len(rows2))
    found = _troughs(
        row1.astype(np.float32), rows2.astype(np.float32), np.float32(noise), noise1, noise2, eye.mean_subtracted,
        round(SETTLE_PX / STEP_PX), NEAR_PX / STEP_PX,
    )  # fmt: skip
    accepted = near = 0.0
    for step, k, flat, rival, flat_soon, rival_soon in found.tolist():
        if k in (0, 2 * eye.max_shift) or step in (0, len(rows2) - 1):
            continue
        taken = max(_chance(flat, rival, FLAT), _chance(flat_soon, rival_soon, PLAIN)) / len(found)
        accepted += taken
        # the next whole pixel is what a quadratic surface puts right; one further off is a mistake
        if abs(k - eye.max_shift) <= 1:
            near += taken
    return accepted, near


def _chance(flat: float, rival: float, bound: float) -> float:
    """Probability that a trough with such ratios is taken."""
    return _normal(math.log(flat / bound) / SPREAD) * _normal(math.log(rival / RIVAL) / SPREAD)


def _gain(eye: Eye, mean: float) -> float:
    """Converter's grey levels for a grey level of the orthophoto, at the exposure that the mean asks for."""
    exposure = eye.exposure
    if exposure is None:
        exposure = REFERENCE_EXPOSURE * TARGET_GREY * 255.0 / max(mean, 1e-3)
        exposure = min(max(exposure, EXPOSURE_RANGE[0]), EXPOSURE_RANGE[1])
    return eye.full_grey / 255.0 * exposure / REFERENCE_EXPOSURE


def _ratios(surface: Array, least: tuple[np.intp, ...]) -> tuple[float, float]:
    """Mean over minimum, second over minimum."""
    value = float(surface[least])
    steps, shifts = np.ogrid[: surface.shape[0], : surface.shape[1]]
    far = (np.abs(steps - least[0]) * STEP_PX > NEAR_PX) | (np.abs(shifts - least[1]) > NEAR_PX)
    return float(surface.mean()) / value, float(surface[far].min()) / value


def _normal(x: float) -> float:
    return 0.5 * math.erfc(-x / math.sqrt(2.0))


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
    """Row I at each phase, rows II at STEP_PX over the window, slopes of the grey values; None without land."""
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
    phases = np.array(PHASES_PX)
    row1 = np.empty((len(phases), eye.pixels + 2 * eye.max_shift))
    rows2 = np.empty((len(steps), eye.pixels))
    slopes = np.empty((2, eye.pixels))
    known = look(
        *ortho[:5], *relief[:5], place, ahead, height, pixel, eye.focal_px, eye.spacing_px, blur[0], blur[1],
        steps, phases, row1, rows2, slopes,
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


@njit(cache=True, fastmath=True)
def _troughs(
    row1: Values, rows2: Values, noise: np.float32, noise1: Values, noise2: Values, centre: bool, settle: int,
    near: float,
) -> Array:  # fmt: skip  # pragma: no cover - compiled
    """Troughs of the MAD surfaces of noisy rows, (draws, 6): step and shift of the least element, mean and second
    over it in the whole window, and in the part seen when `settle` steps have gone by since.

    row1: (phases, u + 2 j), rows2: (steps, u), noise1, noise2: as `_noise` has them.  near: steps to either side
    of the least element in which there is no second one.
    """
    steps, u = rows2.shape
    j = (row1.shape[1] - u) // 2
    shifts = 2 * j + 1
    out = np.empty((noise1.shape[0], 6))
    surface = np.empty((steps, shifts), np.float32)
    row2 = np.empty(u, np.float32)
    for draw in range(noise1.shape[0]):
        first = row1[draw % row1.shape[0]] + noise * noise1[draw]
        if centre:
            first -= first[j : j + u].mean()
        for s in range(steps):
            mean = np.float32(0.0)
            for i in range(u):
                row2[i] = rows2[s, i] + noise * noise2[draw, s, i]
                mean += row2[i]
            mean = mean / u if centre else np.float32(0.0)
            for k in range(shifts):
                total = np.float32(0.0)
                for i in range(u):
                    total += abs(first[k + i] - row2[i] + mean)
                surface[s, k] = total / u
        at = int(surface.argmin())
        step, shift = at // shifts, at % shifts
        out[draw, 0], out[draw, 1] = step, shift
        for part in range(2):
            last = min(step + settle + 1, steps) if part else steps
            total, second = np.float32(0.0), np.float32(np.inf)
            for s in range(last):
                for k in range(shifts):
                    total += surface[s, k]
                    if (abs(s - step) > near or abs(k - shift) > NEAR_PX) and surface[s, k] < second:
                        second = surface[s, k]
            out[draw, 2 + 2 * part] = total / (last * shifts) / surface[step, shift]
            out[draw, 3 + 2 * part] = second / surface[step, shift]
    return out
