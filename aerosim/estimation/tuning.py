"""Disturbances out of what was recorded: the last chapter of the 1988 paper, and statistics beside it.

b2 is the intensity of the random walk that a filter assumes (rad^2/s, or a share squared per s), N0 the variance
of one strip (rad^2, or a share squared).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.stats import chi2

Array = NDArray[np.float64]

CONFIDENCE = 0.95
DRAWS = 200  # series drawn to find the limits of a fit
SEED = 1988
PIXELS = 9  # of the row over which a reading is averaged


class Measured(NamedTuple):
    """A variance or intensity with its 95 % limits.  samples: independent values that it rests on."""

    value: float
    low: float
    high: float
    samples: float

    def scaled(self, factor: float) -> Measured:
        """In another unit."""
        return Measured(self.value * factor, self.low * factor, self.high * factor, self.samples)


def with_limits(value: float, samples: float) -> Measured:
    """A mean square of so many independent Gaussian values of mean zero: limits by chi squared."""
    low, high = chi2.ppf([(1.0 + CONFIDENCE) / 2.0, (1.0 - CONFIDENCE) / 2.0], samples)
    return Measured(value, value * samples / float(low), value * samples / float(high), samples)


class CorrectionWalk(NamedTuple):
    """b2 from a navigator's corrections, rad^2/s, two readings of the paper.

    squares: sum of their squares over the time.  largest: one of the largest size in each mean interval.
    """

    squares: Measured
    largest: float


def walk_from_corrections(
    sizes: Sequence[float] | Array, duration: float, count: float | None = None
) -> CorrectionWalk:
    """b2 of a drift that a navigator kept near zero.

    sizes: rad, of all corrections within duration, s; signs do not matter.  count: how many there were, if sizes
    holds one typical size only; it need not be whole.
    A random walk W that is set back at times tau has E W(tau)^2 = b2 E tau whatever makes the navigator speak
    (Wald's identity), so the sum of squares over the time has no bias.  The limits are those of Gaussian sizes at
    given times; a navigator who waits for a given size scatters less (2/3 of a size^4 instead of 2).
    """
    square = np.asarray(sizes, float) ** 2
    number = float(len(square) if count is None else count)
    value = float(square.mean()) * number / duration
    return CorrectionWalk(with_limits(value, number), float(square.max()) * number / duration)


def strip_time(spacing: float, focal: float, vh: float) -> float:
    """T, s: from row I to row II, d/(f v/h).  spacing, focal: px; vh: 1/s."""
    return spacing / (focal * vh)


def drift_of_roll(roll1: Array, roll2: Array, spacing: float, focal: float, pixels: int) -> Array:
    """Drift that is read where there is none, because the roll differs between the exposures of row I and II, rad.

    Full rotation: a pixel y of row II sees the ground at atan(y/f) from the axis and row I the same ground at
    f tan(atan(y/f) + roll1 - roll2): mu is the difference, averaged over the row.  At the centre and for small
    angles that is f/d (roll1 - roll2): 1.5 deg read as 5.
    roll1, roll2: (n,), rad; spacing, focal, pixels: d, f, u of the rows, px.
    """
    y = ((np.arange(PIXELS) + 0.5) / PIXELS - 0.5) * pixels
    turned = np.arctan(y / focal) + (np.asarray(roll1) - np.asarray(roll2))[..., None]
    mu = (focal * np.tan(turned) - y).mean(axis=-1)
    found: Array = np.arctan(mu / spacing)
    return found


def n_of_pitch(pitch1: Array, pitch2: Array, spacing: float, focal: float) -> Array:
    """Error of n, as a share, that pitch makes at the exposures of row I and II.

    Full rotation: row I looks atan(d/2f) ahead and pitch1 more, row II as far behind and pitch2 less; the way
    between the two sights of one place is h (tan(beta + pitch1) + tan(beta - pitch2)) instead of 2 h tan(beta).
    For small angles f/d (pitch1 - pitch2): 5.8 % a degree.  pitch1, pitch2: (n,), rad, against the levelled mount.
    """
    tangent = spacing / (2.0 * focal)
    beta = math.atan(tangent)
    found: Array = (np.tan(beta + pitch1) + np.tan(beta - np.asarray(pitch2))) / (2.0 * tangent) - 1.0
    return found


class Segment(NamedTuple):
    """A record without a gap.  t, x: (n,), s and any unit."""

    t: Array
    x: Array


def pairs(segments: Sequence[Segment], lag: float) -> list[tuple[Array, Array]]:
    """Values of each segment `lag` seconds apart: (n,), (n,); segments that are shorter fall out."""
    found = []
    for t, x in segments:
        first = t <= t[-1] - lag
        if first.any():
            found.append((x[first], np.interp(t[first] + lag, t, x)))
    return found


def mean_square(series: Sequence[Array], reach: int) -> Measured:
    """Mean square of series of mean zero that are correlated in themselves.

    series: each without a gap.  reach: samples up to which they may be correlated.  Bartlett: N values count as
    N/(1 + 2 sum rho_k^2).
    """
    count = sum(len(each) for each in series)
    value = float(sum((each**2).sum() for each in series) / count)
    if value == 0.0:
        return Measured(0.0, 0.0, 0.0, float(count))
    spread = 1.0
    for lag in range(1, reach + 1):
        products = [each[lag:] * each[:-lag] for each in series if len(each) > lag]
        many = sum(len(each) for each in products)
        if many == 0:
            break
        rho = sum(each.sum() for each in products) / many / value
        spread += 2.0 * float(rho) ** 2 * many / count
    return with_limits(value, max(count / spread, 1.0))


def _steps(t: Array) -> float:
    return float(np.median(np.diff(t)))


def roll_noise(roll: Sequence[Segment], time: float, spacing: float, focal: float, pixels: int) -> Measured | None:
    """N0 of the drift, rad^2: mean square of what roll adds to a strip of `time` s; None if no segment is as long.

    roll: rad; spacing, focal, pixels: d, f, u of the rows, px.
    """
    errors = [drift_of_roll(a, b, spacing, focal, pixels) for a, b in pairs(roll, time)]
    return mean_square(errors, math.ceil(1.5 * time / _steps(roll[0].t))) if errors else None


def pitch_noise(pitch: Sequence[Segment], time: float, spacing: float, focal: float) -> Measured | None:
    """N0 of n, a share squared, out of the pitch; its mean is the trim, which a static mount levels out."""
    mean = float(np.concatenate([each.x for each in pitch]).mean())
    level = [Segment(each.t, each.x - mean) for each in pitch]
    errors = [n_of_pitch(a, b, spacing, focal) for a, b in pairs(level, time)]
    return mean_square(errors, math.ceil(1.5 * time / _steps(pitch[0].t))) if errors else None


def drift_walk(drift: Sequence[Segment], time: float) -> Measured | None:
    """b2 of a recorded drift, rad^2/s: mean square of its change over a strip's time, over that time.

    It holds the aircraft's fast yaw besides the slow change; the filter has to follow both.
    """
    changes = [b - a for a, b in pairs(drift, time)]
    found = mean_square(changes, math.ceil(1.5 * time / _steps(drift[0].t))) if changes else None
    return found.scaled(1.0 / time) if found else None


class PhotoWalk(NamedTuple):
    """What a photo series without v/h control says of n, as shares squared.

    greatest_error: greatest error of n; greatest: that, squared, over the time between two exposures, as the
    paper has it.  walk: b2, 1/s; noise: N0 of one overlap, both by the structure function.
    """

    greatest_error: float
    greatest: float
    walk: Measured
    noise: Measured


def photo_walk(lines: Sequence[tuple[Array, Array]], wanted: float) -> PhotoWalk:
    """b2 and N0 of n from the end laps of a series with a fixed interval.

    lines: of each line, times of its photos (s) and end lap with the photo before (share; NaN for the first).
    wanted: preset end lap, share.  The base is (1 - end lap) of the footprint, so n goes as 1/(1 - end lap).
    """
    series = [np.log((1.0 - lap[1:]) / np.diff(t)) for t, lap in lines if len(t) > 1]
    laps = np.concatenate([lap[1:] for _, lap in lines])
    interval = float(np.median(np.concatenate([np.diff(t) for t, _ in lines])))
    worst = float(np.abs((1.0 - wanted) / (1.0 - laps) - 1.0).max())
    walk, noise = structure_fit(series, interval)
    return PhotoWalk(worst, worst**2 / interval, walk, noise)


def structure_fit(series: Sequence[Array], interval: float) -> tuple[Measured, Measured]:
    """b2 and N0 of a random walk seen with white noise: fit of its structure function, D = b2 tau + 2 N0.

    series: each without a gap, a value each `interval` s; two values do not tell noise from walk, and N0 is 0.
    Lags up to a quarter of the longest series, at most 10, weighted by what each is worth (a variance as tau^2/N);
    neither comes out negative.  Limits: 2.5 and 97.5 % of fits to 200 series drawn from the fit.
    """
    longest = max(len(each) for each in series)
    lags = min(max(longest // 4, 2), 10, longest - 1)
    walk, noise = _fit(series, interval, lags)
    rng = np.random.default_rng(SEED)
    drawn = np.array([_fit(_drawn(series, walk * interval, noise, rng), interval, lags) for _ in range(DRAWS)])
    low, high = np.quantile(drawn, [(1.0 - CONFIDENCE) / 2.0, (1.0 + CONFIDENCE) / 2.0], axis=0)
    count = float(sum(len(each) for each in series))
    return (
        Measured(walk, float(low[0]), float(high[0]), count),
        Measured(noise, float(low[1]), float(high[1]), count),
    )


def _fit(series: Sequence[Array], interval: float, lags: int) -> tuple[float, float]:
    rows, seen = [], []
    for lag in range(1, lags + 1):
        changes = np.concatenate([each[lag:] - each[:-lag] for each in series if len(each) > lag])
        weight = math.sqrt(len(changes)) / lag
        rows.append([weight * lag * interval, weight * 2.0])
        seen.append(weight * float((changes**2).mean()))
    if len(rows) == 1:
        return seen[0] / rows[0][0], 0.0
    found, _ = nnls(np.array(rows), np.array(seen))
    return float(found[0]), float(found[1])


def _drawn(series: Sequence[Array], step: float, noise: float, rng: np.random.Generator) -> list[Array]:
    """Series as long as these of a walk with this variance a step, and white noise."""
    return [
        np.cumsum(math.sqrt(step) * rng.standard_normal(len(each)))
        + math.sqrt(noise) * rng.standard_normal(len(each))
        for each in series
    ]
