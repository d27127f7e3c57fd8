"""The results of a sweep while it goes on, and when it has runs enough."""

from __future__ import annotations

import math
import re
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from aerosim.sweep.spec import SweepSpec
from aerosim.sweep.stoprule import StopRule, Watch
from aerosim.sweep.table import runs_table
from aerosim.sweep.work import Result

if TYPE_CHECKING:
    import pyarrow as pa

REASONS = 20  # shown of why runs failed
NUMBER = re.compile(r"\d+(\.\d+)?")


def alike(reasons: Sequence[str]) -> list[tuple[str, list[int]]]:
    """Reasons, those that differ in numbers only (times, heights) as one, with places; most frequent first."""
    groups: dict[str, list[int]] = {}
    for place, reason in sorted(enumerate(reasons), key=lambda item: item[1]):
        groups.setdefault(NUMBER.sub("#", reason), []).append(place)
    out = []
    for places in sorted(groups.values(), key=len, reverse=True):
        differ = len({reasons[place] for place in places}) > 1
        note = " (with other numbers in other runs)" if differ else ""
        out.append((f"{reasons[places[0]]}{note}", sorted(places)))
    return out


class _Alone:
    """A point that stops by itself: told its runs in any order, it looks at them in the order of the seeds."""

    def __init__(self, rule: StopRule, values: Mapping[str, Any]) -> None:
        self.stopped: int | None = None
        self._watch = Watch(rule, [values])
        self._seen, self._waiting = 0, dict[int, float]()

    def add(self, seed: int, value: float) -> None:
        """A run that ended.  value: of the rule's metric, NaN if there is none."""
        self._waiting[seed] = value
        while self.stopped is None and self._seen + 1 in self._waiting:
            self._seen += 1
            if self._watch.add(np.array([self._waiting.pop(self._seen)])):
                self.stopped = self._seen


class Book:
    """Results by run, and after which seed the sweep may stop.

    stopped: number of seeds after which the rule for stopping held, None while it does not; where each point
    stops by itself, that of the last.  It depends on the
    results of whole seeds in their order only: neither on how many fly at the same time nor on who is quicker.
    """

    def __init__(self, spec: SweepSpec) -> None:
        self.spec = spec
        self.results: dict[str, Result] = {}
        self.stopped: int | None = None
        self._of_seed: Counter[int] = Counter()
        self._whole = 0  # seeds of which all points are flown, from the first on
        rule = spec.stop_when
        each, together = (rule, None) if rule and rule.each else (None, rule)
        self._watch = Watch(together, [point.values for point in spec.points]) if together else None
        self._alone = [_Alone(each, point.values) for point in spec.points] if each else []
        self._waiting: dict[int, dict[int, float]] = {}

    def add(self, result: Result) -> None:
        """Take a result in.  Its paths are kept once for all results."""
        named = {sys.intern(path): value for path, value in result.summary.items()}
        self.results[result.id] = replace(result, summary=named)
        self._of_seed[result.seed] += 1
        rule = self.spec.stop_when
        if rule is None or self.stopped is not None:
            return
        value = result.summary.get(rule.metric)
        number = float(value) if isinstance(value, (int, float)) else math.nan
        if self._watch is None:
            self._alone[result.point].add(result.seed, number)
            if all(each.stopped is not None for each in self._alone):
                self.stopped = max(each.stopped or 0 for each in self._alone)
            return
        self._waiting.setdefault(result.seed, {})[result.point] = number
        while self.stopped is None and self._of_seed[self._whole + 1] == len(self.spec.points):
            self._whole += 1
            found = self._waiting.pop(self._whole)
            if self._watch.add(np.array([found[point.number] for point in self.spec.points])):
                self.stopped = self._whole

    def last(self, point: int) -> int:
        """Last seed that is flown at a point, as far as is known."""
        stopped = self._alone[point].stopped if self._alone else self.stopped
        return stopped or self.spec.seeds

    def counted(self) -> Iterator[Result]:
        """Results that count: all, or those of the seeds up to which the sweep, or their point, stopped."""
        return (result for result in self.results.values() if result.seed <= self.last(result.point))

    @property
    def wanted(self) -> int:
        """Number of runs that the sweep needs, as far as is known."""
        return sum(self.last(number) for number in range(len(self.spec.points)))

    def table(self) -> pa.Table:
        """Table of the results that count."""
        return runs_table(self.counted(), list(self.spec.vary))

    def figures(self) -> dict[str, Any]:
        """How many runs are wanted, done and failed, and why they failed (most frequent reasons first)."""
        counted = list(self.counted())
        reasons = alike([result.reason for result in counted if result.status != "done"])
        failed = sum(len(places) for _, places in reasons)
        return {
            "points": len(self.spec.points),
            "seeds": self.stopped or self.spec.seeds,
            "stopped_early": self.stopped is not None and self.stopped < self.spec.seeds,
            "runs": self.wanted,
            "done": len(counted) - failed,
            "failed": failed,
            "reasons": [{"reason": reason, "runs": len(places)} for reason, places in reasons[:REASONS]],
        }
