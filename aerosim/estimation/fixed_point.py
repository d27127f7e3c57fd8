"""The instrument of 1988 in whole numbers: MAD sums (2), gain series (15) and (17), filter (16).

Word lengths are those of the single-chip microcomputers of its time: results in 16 bits, products and sums on the
way in 32.  The paper gives no formats; these are ours.

| what | format | word |
|---|---|---|
| grey value | whole grey levels | 8 bits, unsigned |
| MAD sum over at most 128 pairs | whole grey levels | 16 bits, unsigned |
| gain q, gamma | Q15: 1 is 32768 | 16 bits, unsigned |
| drift | Q8 of a degree: 1/256 deg | 16 bits, signed |
| n | Q6: 1/64 of an exposure, up to 1023 | 16 bits, unsigned |

Rounding is to the nearest, halves upwards (add half, shift); only (17) cuts off, as its shift does.  What does not
fit into its word is set to the word's end.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from aerosim.estimation.kalman import Series

Bytes = NDArray[np.uint8]
Sums = NDArray[np.uint16]

PAIRS_MAX = 128  # 128 differences of at most 510 fit into 16 bits
GAIN_BITS = 15
ONE = 1 << GAIN_BITS
GAMMA_MAX = (1 << 16) - 1  # nearly 2: the numerator of (15), shifted by 15, fits into 32 bits
N_MAX = 1023  # exposures in a 16-bit word with six bits behind the point
UNSIGNED_16 = (0, (1 << 16) - 1)
SIGNED_16 = (-(1 << 15), (1 << 15) - 1)


def mean_difference(row1: Bytes, row2: Bytes, max_shift: int) -> int:
    """Difference of the row means, grey levels, rounded to a whole one, halves upwards.

    row1: (u + 2 max_shift,), its mean is that of the u inner pixels; row2: (u,).  One division for both means.
    """
    return int(_difference(row1, row2, max_shift))


@njit(cache=True)
def _difference(row1: Bytes, row2: Bytes, max_shift: int) -> int:  # pragma: no cover - compiled
    u, total = len(row2), 0
    for i in range(u):
        total += int(row1[max_shift + i]) - int(row2[i])
    return (2 * total + u) // (2 * u)


def padded_bytes(row1: Bytes, max_shift: int) -> Bytes:
    """Row I with its extension replaced by the mean of the inner pixels, rounded: it correlates with nothing."""
    row = row1.copy()
    if max_shift:
        inner = row1[max_shift:-max_shift]
        row[:max_shift] = row[-max_shift:] = (2 * int(inner.sum(dtype=np.int64)) + len(inner)) // (2 * len(inner))
    return row


def mad_sums(row1: Bytes, row2: Bytes, mean_subtracted: bool) -> Sums:
    """Equation (2) as the paper computes it: sums of absolute differences, not divided by u.

    row1: (u + 2 j,), row2: (u,) with u at most 128.  Returns (2 j + 1,): element j + mu is the shift mu.
    mean_subtracted: the rounded difference of the row means is subtracted within the absolute value.
    Against (2) in real numbers each of the u differences is then wrong by at most half a grey level, the sum by
    u/2; without it the sums are exact.
    """
    shift = (len(row1) - len(row2)) // 2
    found: Sums = _sums(row1, row2, mean_difference(row1, row2, shift) if mean_subtracted else 0)
    return found


@njit(cache=True)
def _sums(row1: Bytes, row2: Bytes, offset: int) -> Sums:  # pragma: no cover - compiled
    u = row2.shape[0]
    shifts = row1.shape[0] - u + 1
    out = np.empty(shifts, np.uint16)
    for k in range(shifts):
        total = np.int32(0)
        for i in range(u):
            total += abs(np.int32(row1[k + i]) - np.int32(row2[i]) - np.int32(offset))
        out[k] = total
    return out


def least(surface: Sums) -> tuple[int, int]:
    """Place of the least sum: exposure, element of the shifts.

    Of equal sums the first exposure counts, and in it the shift farthest to the left (mu = -j): what a search with
    "less than" finds as the sums come up.  The real instrument's rule is the same.
    """
    at = int(surface.argmin())
    return at // surface.shape[1], at % surface.shape[1]


def next_gain_riccati(q: int, gamma: int) -> int:
    """Equation (15), all Q15: one division of 32 bits."""
    below = q + gamma + ONE
    return (((q + gamma) << GAIN_BITS) + below // 2) // below


def next_gain_halving(q: int, q_inf: int) -> int:
    """Equation (17), all Q15: an addition and a shift, which cuts off half a unit.

    From above it ends at q_inf, from below one unit short of it.
    """
    return (q + q_inf) >> 1


def stationary_gain(gamma: int) -> int:
    """Limit of (15), Q15, by the whole-number square root: computed beforehand, as the paper has it."""
    return (math.isqrt(gamma * gamma + (gamma << (GAIN_BITS + 2))) - gamma + 1) >> 1


def to_gain(value: float) -> int:
    """A gamma as Q15; beyond nearly 2 it stays there."""
    return min(math.floor(value * ONE + 0.5), GAMMA_MAX)


def within(value: int, word: tuple[int, int]) -> int:
    """The value, or the end of the word that it is beyond."""
    return min(max(value, word[0]), word[1])


def next_estimate(estimate: int, gain: int, observed: int, word: tuple[int, int]) -> int:
    """Equation (16): estimate and observation in the state's format, gain Q15; the product has 32 bits."""
    step = (gain * (observed - estimate) + (ONE >> 1)) >> GAIN_BITS
    return within(estimate + step, word)


class FixedFilter:
    """The scalar filter (16) in whole numbers; seen from outside like `kalman.ScalarFilter`.

    unit: of the state's last bit, in the unit of the observations.  word: least and greatest value of the state.
    gamma: real, taken to Q15 at each update, as a table over n in the ROM would have it.  noise: N0, scales the
    variance only.

    Against the real filter with the same gamma the gain is wrong by e_q and the estimate by e_x, step by step
    at most
        e_q <- e_q/(1 + q + gamma)^2 + 1/2            units of Q15, q the smaller of the two gains, (15)
        e_q <- e_q/2 + 1                              (17): cut off by half, its limit rounded by half
        e_x <- (1 - q) e_x + q/2 + e_q |y - x| + 1/2  units of the state; q/2 for the rounded observation
    by the mean value theorem for (15) and the triangle inequality for (16).
    """

    def __init__(self, gamma: float, noise: float, series: Series, unit: float, word: tuple[int, int]) -> None:
        """Not started: the first observation is taken as it is (q_0 = 1)."""
        self.gamma, self.noise, self.series = gamma, noise, series
        self._unit, self._word = unit, word
        self._estimate, self._gain, self.started = 0, ONE, False

    @property
    def estimate(self) -> float:
        """In the unit of the observations, NaN before the first."""
        return self._estimate * self._unit if self.started else math.nan

    @property
    def gain(self) -> float:
        """The gain q as a number."""
        return self._gain / ONE

    @property
    def variance(self) -> float:
        """K = q N0."""
        return self.gain * self.noise

    def update(self, observed: float) -> float:
        """Take one observation; returns its innovation over its standard deviation (NaN for the first)."""
        seen = within(math.floor(observed / self._unit + 0.5), self._word)
        if not self.started:
            self._estimate, self._gain, self.started = seen, ONE, True
            return math.nan
        gamma = to_gain(self.gamma)
        spread = math.sqrt(self.noise * (self._gain + gamma + ONE) / ONE)
        innovation = (seen - self._estimate) * self._unit
        if self.series == "riccati":
            self._gain = next_gain_riccati(self._gain, gamma)
        else:
            self._gain = next_gain_halving(self._gain, stationary_gain(gamma))
        self._estimate = next_estimate(self._estimate, self._gain, seen, self._word)
        return innovation / spread

    def restart(self) -> None:
        """Forget the state: the next observation starts anew."""
        self._estimate, self._gain, self.started = 0, ONE, False


DRIFT_UNIT = math.radians(1.0 / 256.0)
N_UNIT = 1.0 / 64.0


def drift_filter(noise: float, series: Series) -> FixedFilter:
    """Filter of the drift, observations in rad.  noise: N0, rad^2."""
    return FixedFilter(0.0, noise, series, DRIFT_UNIT, SIGNED_16)


def n_filter(series: Series) -> FixedFilter:
    """Filter of n, observations in exposures."""
    return FixedFilter(0.0, 1.0, series, N_UNIT, UNSIGNED_16)
