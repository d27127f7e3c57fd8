"""When a sweep has runs enough: the sequential rule ``METRIC:HALFWIDTH`` or ``METRIC:PERCENT%``."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.sweep.matrix import identity

LEVEL = 0.95  # of the confidence intervals
LEAST = 10  # runs of a point before the rule may stop: a variance of fewer is too often small by chance
EARLY = 1.1825  # runs by which looking after each run stops early on average, Woodroofe (1977), normal law
FORM = re.compile(
    r"(?P<metric>[\w.]+)(\[(?P<key>[\w.]+)=(?P<a>[^,\]]+),(?P<b>[^,\]]+)\])?:(?P<width>[^:]+)(?P<each>:each)?"
)
ALLOWED = (
    "METRIC:HALFWIDTH, METRIC:5% of the mean, either with :each for points that stop by themselves, "
    "or METRIC[KEY=A,B]:HALFWIDTH; HALFWIDTH above 0 in the metric's unit"
)


class Look(NamedTuple):
    """Where a sweep stands.

    seeds: run so far; half_width: the widest there is, in the metric's unit, of a relative rule as a part of the
    mean (NaN: not known yet); expected: seeds at which the rule will hold, as far as can be told now (NaN: not
    known).
    """

    seeds: int
    half_width: float
    expected: float


@dataclass(frozen=True)
class StopRule:
    """Stop when the mean of `metric` is known to `half_width` at every point, or its difference of two modes is.

    metric: dotted path of the summary.  half_width: in the metric's unit; relative: as part of each mean's size.
    key, a, b: with a key, the mean of the paired difference (at `a` less at `b`) at each point of the other keys.
    level: of the interval.  each: a point that is known so well is not flown again, whatever the others do; the
    sweep ends when all are.

    The rule looks after each whole seed, in the order of the seeds, never in the order in which runs end: the
    result does not depend on the number of workers, and quick runs are not preferred.  With k values of standard
    deviation S it stops at the first k >= 10 with ``t(level, k - 1) S / sqrt(k - 1.1825) <= half_width``.
    Student's t stands for the deviation that is estimated; 1.1825 runs make up for looking again and again.
    Chow, Robbins (1965): coverage tends to `level`.  For a normal law and theoretical number
    n = (z sigma / half_width)^2, coverage = level + z phi(z) (E N - n - (1 + z^2) / 2) / n + o(1 / n); t instead
    of z adds (1 + z^2) / 2 to E N, repeated looks take 1.1825 off (Woodroofe 1977, Ann. Statist. 5, 984-995).
    """

    metric: str
    half_width: float
    key: str = ""
    a: Any = None
    b: Any = None
    level: float = LEVEL
    relative: bool = False
    each: bool = False

    @classmethod
    def parse(cls, text: str) -> StopRule:
        """Rule of ``METRIC:HALFWIDTH``, ``METRIC:5%`` or ``METRIC[KEY=A,B]:HALFWIDTH``.  Raises InputError."""
        found = FORM.fullmatch(text.strip())
        relative = found is not None and found["width"].endswith("%")
        width = _number(found["width"].rstrip("%")) if found else math.nan
        if found is None or not (0.0 < width < math.inf) or (found["key"] and (relative or found["each"])):
            raise InputError(f"{text!r} is no rule for stopping", key="--stop-when", allowed=ALLOWED)
        if found["key"] is None:
            part = width / 100.0 if relative else width
            return cls(found["metric"], part, relative=relative, each=found["each"] is not None)
        a, b = _scalar(found["a"]), _scalar(found["b"])
        if a == b:
            raise InputError(f"{text!r} compares a value with itself", key="--stop-when", allowed=ALLOWED)
        return cls(found["metric"], width, found["key"], a, b)

    def __str__(self) -> str:
        """The form that `parse` reads."""
        pair = f"[{self.key}={self.a},{self.b}]" if self.key else ""
        width = f"{100.0 * self.half_width:g}%" if self.relative else f"{self.half_width:g}"
        return f"{self.metric}{pair}:{width}{':each' if self.each else ''}"

    def allowed(self, means: Array) -> Array:
        """Half widths up to which the rule holds, for means of any shape; both in the metric's unit."""
        return self.half_width * (np.abs(means) if self.relative else np.ones_like(means))

    def series(self, values: Array, points: Sequence[Mapping[str, Any]]) -> Array:
        """What has to be known: the metric of each point, or the differences asked for.

        values: (points, seeds), NaN where there is none.  points: the varied keys' values of each row.
        Returns (series, seeds).  Raises InputError if no two points differ as the rule wants.
        """
        if not self.key:
            return values
        first, second = self.pairs(points)
        return np.asarray(values[first] - values[second])

    def pairs(self, points: Sequence[Mapping[str, Any]]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows of the points that are compared: those at `a`, and those at `b` that are like them in all else.

        Raises InputError if there are none.
        """
        a, b = identity(self.a), identity(self.b)
        named = [{key: identity(value) for key, value in point.items()} for point in points]
        # of several grids, points need not have the same keys
        others = [frozenset(item for item in point.items() if item[0] != self.key) for point in named]
        at_b = {others[row]: row for row, point in enumerate(named) if point.get(self.key) == b}
        found = [
            (row, at_b[others[row]])
            for row, point in enumerate(named)
            if self.key in point and point[self.key] == a and others[row] in at_b
        ]
        if not found:
            problem = f"no two points differ only in {self.key} = {self.a} and {self.b}"
            raise InputError(problem, key="--stop-when", allowed="two values that are varied")
        first, second = np.array(found).T
        return first, second

    def first(self, values: Array, points: Sequence[Mapping[str, Any]]) -> int | None:
        """Number of seeds after which the rule holds for the first time, None if it does not yet.

        values: (points, seeds) of the seeds that are run at all points, in their order; NaN for a run that
        failed or has no such value.  A point that has none never lets the rule hold.
        """
        series = self.series(values, points)
        widths, counts = half_widths(series, self.level, EARLY)
        holds = ((widths <= self.allowed(_running(series))) & (counts >= LEAST)).all(axis=0)
        return int(np.argmax(holds)) + 1 if holds.any() else None

    def look(self, values: Array, points: Sequence[Mapping[str, Any]]) -> Look:
        """Where the sweep stands now; arguments as of `first`."""
        series = self.series(values, points)
        seeds = series.shape[1]
        if not seeds:
            return Look(0, math.nan, math.nan)
        widths, counts = (each[:, -1] for each in half_widths(series, self.level, EARLY))
        if not np.isfinite(widths).all():
            return Look(seeds, math.nan, math.nan)
        means = _running(series)[:, -1]
        needed = np.maximum((counts - EARLY) * (widths / self.allowed(means)) ** 2 + EARLY, LEAST)
        told = widths / np.abs(means) if self.relative else widths
        return Look(seeds, float(told.max()), float((needed * seeds / counts).max()))


class Watch:
    """A rule that is told one seed after the other; each takes the same time, however many there were."""

    def __init__(self, rule: StopRule, points: Sequence[Mapping[str, Any]]) -> None:
        """points: varied keys' values of each.  Raises InputError if no two points differ as the rule wants."""
        self.rule, self._pairs = rule, rule.pairs(points) if rule.key else None
        count = len(self._pairs[0]) if self._pairs else len(points)
        self._centre = np.full(count, np.nan)
        self._count, self._sum, self._squares = np.zeros(count), np.zeros(count), np.zeros(count)

    def add(self, values: Array) -> bool:
        """Take in the metric of all points with the next seed, NaN where there is none; whether the rule holds."""
        each = values if self._pairs is None else values[self._pairs[0]] - values[self._pairs[1]]
        there = np.isfinite(each)
        self._centre = np.where(np.isnan(self._centre) & there, each, self._centre)
        off = np.where(there, each - self._centre, 0.0)
        self._count += there
        self._sum += off
        self._squares += off**2
        if (self._count < LEAST).any():
            return False
        widths = _widths(self._count, self._sum, self._squares, self.rule.level, EARLY)
        return bool((widths <= self.rule.allowed(self._centre + self._sum / self._count)).all())


def half_widths(series: Array, level: float, early: float = 0.0) -> tuple[Array, Array]:
    """Half widths of the confidence intervals of running means.

    series: (series, seeds), NaN where there is no value.  early: runs that do not count.
    Returns half widths (series, seeds), inf below two values, and numbers of values (series, seeds).
    """
    if not series.size:
        return np.empty(series.shape), np.empty(series.shape, np.int64)
    there = np.isfinite(series)
    counts = there.cumsum(axis=1)
    # about each series' first value: sums of squares of large numbers would lose the spread, and about a mean
    # of all the result of the first seeds would change with later ones
    centre = series[np.arange(len(series)), there.argmax(axis=1)][:, None]
    off = np.where(there, series - centre, 0.0)
    widths = _widths(counts, off.cumsum(axis=1), (off**2).cumsum(axis=1), level, early)
    return np.where(counts >= 2, widths, np.inf), counts


def _running(series: Array) -> Array:
    """Means (series, seeds) of the values so far, NaN before the first."""
    there = np.isfinite(series)
    counts = there.cumsum(axis=1)
    return np.where(counts > 0, np.where(there, series, 0.0).cumsum(axis=1) / np.maximum(counts, 1), np.nan)


def _widths(counts: Array, sums: Array, squares: Array, level: float, early: float) -> Array:
    """Half widths from numbers, sums and sums of squares of values about any centre."""
    from scipy.stats import t

    freedom = np.maximum(counts - 1, 1)
    spread = np.maximum(squares - sums**2 / np.maximum(counts, 1), 0.0)
    different, which = np.unique(freedom, return_inverse=True)
    quantile = t.ppf(0.5 + level / 2.0, different)[which].reshape(freedom.shape)
    return np.asarray(quantile * np.sqrt(spread / freedom / np.maximum(counts - early, 0.5)))


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _scalar(text: str) -> Any:
    """A value as YAML reads it."""
    from ruamel.yaml import YAML

    return YAML(typ="safe", pure=True).load(text)
