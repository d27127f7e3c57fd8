"""What a sweep says: means with confidence limits, paired differences, main effects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from aerosim.sweep.stoprule import LEVEL, StopRule

__all__ = ["LEVEL", "Difference", "Effect", "Mean", "StopRule", "effects", "means", "paired"]


class Mean(NamedTuple):
    """Mean of a metric over the seeds, for one combination of values.

    values: of the keys it is by.  mean, sd (standard deviation of one seed) and half_width (of the confidence
    interval, Student's t) in the metric's unit; NaN where there are too few.  count: seeds that it rests on.
    missing: seeds left out because a run of theirs is done and has no such value; failed: because one failed.
    """

    values: dict[str, Any]
    mean: float
    half_width: float
    sd: float
    count: int
    missing: int
    failed: int


class Difference(NamedTuple):
    """Mean over common seeds of the metric at value `a` less at value `b` of a key, all others being equal.

    values: of the other keys.  mean and half_width (Student's t over the seeds' differences) in the metric's
    unit; standard_error: of the paired mean; unpaired_standard_error: what the same two samples would give
    without common seeds, sqrt(s_a^2 / n + s_b^2 / n); correlation of the two over the seeds, NaN if one is
    constant.  count: pairs; missing, failed: seeds left out, as in Mean.
    """

    values: dict[str, Any]
    mean: float
    half_width: float
    standard_error: float
    unpaired_standard_error: float
    correlation: float
    count: int
    missing: int
    failed: int


class Effect(NamedTuple):
    """Main effect of one value of a key: mean over all points that have it less the mean over all points.

    kind "level": of a grid, balanced over the other keys.  kind "slope": of a sample that is no grid, the change
    of the metric over the key's whole range in a linear fit of all numeric keys; value is then (lowest, highest).
    effect and half_width (Student's t over the seeds) in the metric's unit.  count: seeds; left_out: seeds of
    which a run failed or has no value.
    """

    key: str
    value: Any
    kind: str
    effect: float
    half_width: float
    count: int
    left_out: int


def means(table: Any, metric: str, by: Sequence[str], level: float = LEVEL) -> list[Mean]:
    """Means with confidence limits for each combination of values of the keys `by`, in order of the points.

    table: Arrow table of runs.parquet.  Points that differ in other keys only are averaged for each seed first,
    so that the interval holds although they fly in the same air.  Raises InputError for an unknown name.
    """
    raise NotImplementedError


def paired(
    table: Any, metric: str, key: str, a: Any, b: Any, keys: Sequence[str], level: float = LEVEL
) -> list[Difference]:
    """Paired differences (at `a` less at `b`) for each combination of values of the other of the varied `keys`.

    Raises InputError for an unknown name, or if no two points differ in `key` = a, b only.
    """
    raise NotImplementedError


def effects(table: Any, metric: str, keys: Sequence[str], level: float = LEVEL) -> list[Effect]:
    """Main effects of all varied `keys`, each averaged over the others.  Raises InputError for an unknown name."""
    raise NotImplementedError
