"""Tools to look back at a filter: running means of the truth, and its recorded gains run over other values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerosim.frames import Array


class Mean:
    """Mean over time of a sampled quantity, by the trapezoid rule."""

    def __init__(self, t: Array, values: Array) -> None:
        """t: (n,), s, increasing; values: (n,)."""
        self._t = t
        self._sum = np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t))])

    def __call__(self, begin: Array, end: Array) -> Array:
        """Mean between two times (m,), s, begin before end."""
        total = np.interp(end, self._t, self._sum) - np.interp(begin, self._t, self._sum)
        return np.asarray(total / (end - begin))


def centred_mean(t: Array, values: Array, line: NDArray[np.int64], span: float) -> Array:
    """Moving mean over `span` seconds about each sample, (n,).

    Towards the ends of a line (samples of one number in `line`) the span shrinks on both sides, so that the mean
    stays centred and a ramp goes through unchanged.
    """
    edges = np.flatnonzero(np.diff(line)) + 1
    first, last = np.r_[0, edges], np.r_[edges, len(t)] - 1
    counts = last - first + 1
    half = np.minimum(span / 2.0, np.minimum(t - np.repeat(t[first], counts), np.repeat(t[last], counts) - t))
    inside = half > 0.0
    out = values.astype(float)
    out[inside] = Mean(t, values)((t - half)[inside], (t + half)[inside])
    return out


class Gains:
    """The gains of a scalar filter, estimate += gain (value - estimate), as they were recorded."""

    def __init__(self, decided: Array, gains: Array) -> None:
        """decided: times (n,), s, at which the filter took its values; gains: (n,), 1 where it began anew."""
        self._decided, self._gains = decided, gains
        self.begins = gains == 1.0
        self.begins[:1] = True

    def over(self, values: Array) -> Array:
        """Estimates after each value (n,), the filter fed with these instead of what it took."""
        out = np.empty(len(values))
        estimate = 0.0
        for i, (gain, value, begins) in enumerate(
            zip(self._gains.tolist(), values.tolist(), self.begins.tolist(), strict=True)
        ):
            estimate = value if begins else estimate + gain * (value - estimate)
            out[i] = estimate
        return out

    def at(self, t: Array) -> NDArray[np.int64]:
        """Index of the value taken last at each time (m,), s; -1 before the first."""
        # a microsecond: times of telemetry and of strips are counted by different devices
        return np.searchsorted(self._decided, t + 1e-6, side="right") - 1
