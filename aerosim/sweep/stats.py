"""What a sweep says: means with confidence limits, paired differences, main effects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.sweep.matrix import Matrix, identity, is_value, known, matrix
from aerosim.sweep.stoprule import LEVEL, StopRule

__all__ = ["LEVEL", "Difference", "Effect", "Mean", "StopRule", "effects", "means", "paired"]


class Mean(NamedTuple):
    """Mean of a metric over the seeds, for one combination of values.

    values: of the keys it is by.  mean, sd (standard deviation of one seed) and half_width (of the confidence
    interval, Student's t) in the metric's unit; NaN where there are too few.  seeds: how many it rests on.
    missing: seeds left out because a run is not there or has no such value; failed: because one failed.
    """

    values: dict[str, Any]
    mean: float
    half_width: float
    sd: float
    seeds: int
    missing: int
    failed: int


class Difference(NamedTuple):
    """Mean over common seeds of the metric at value `a` less at value `b` of a key, all others being equal.

    values: of the other keys.  mean and half_width (Student's t over the seeds' differences) in the metric's
    unit; standard_error: of the paired mean; unpaired_standard_error: what the same two samples would give
    without common seeds, sqrt(s_a^2 / n + s_b^2 / n); correlation of the two over the seeds, NaN if one is
    constant.  seeds: common ones that it rests on; missing, failed: those left out, as in Mean.
    """

    values: dict[str, Any]
    mean: float
    half_width: float
    standard_error: float
    unpaired_standard_error: float
    correlation: float
    seeds: int
    missing: int
    failed: int


class Effect(NamedTuple):
    """Main effect of one value of a key: mean over all points that have it less the mean over all points.

    kind "level": of a grid, balanced over the other keys.  kind "slope": of a sample that is no grid, the change
    of the metric over the key's whole range in a linear fit of all numeric keys; value is then (lowest, highest).
    effect and half_width (Student's t over the seeds) in the metric's unit.  seeds: how many it rests on;
    left_out: those of which a run failed or has no value.
    """

    key: str
    value: Any
    kind: str
    effect: float
    half_width: float
    seeds: int
    left_out: int


def means(table: Any, metric: str, by: Sequence[str], level: float = LEVEL) -> list[Mean]:
    """Means with confidence limits for each combination of values of the keys `by`, in order of the points.

    table: Arrow table of runs.parquet.  Points that differ in other keys only are averaged for each seed first,
    so that the interval holds although they fly in the same air.  Raises InputError for an unknown name.
    """
    runs = matrix(table, metric, by)
    out = []
    for rows in _groups(runs.points, by):
        values = runs.values[rows].mean(axis=0)
        mean, half_width, sd = _interval(values, level)
        out.append(Mean(runs.points[rows[0]], mean, half_width, sd, *_told(runs, rows, values)))
    return out


def paired(
    table: Any,
    metric: str,
    key: str,
    a: Any,
    b: Any,
    keys: Sequence[str],
    by: Sequence[str] | None = None,
    level: float = LEVEL,
) -> list[Difference]:
    """Paired differences of the metric, at `a` less at `b` of a key, over common seeds.

    keys: all that are varied.  by: those that the differences are told apart by (default: all but `key`); over
    the others they are averaged for each seed.
    Raises InputError for an unknown name, or if no two points differ in `key` = a, b only.
    """
    known(table, key, "key")
    runs = matrix(table, metric, keys)
    others = [name for name in keys if name != key]
    by = others if by is None else by
    at_a, at_b = (
        {_named(p, others): row for row, p in enumerate(runs.points) if is_value(p[key], value)}
        for value in (a, b)
    )
    common = [row for other, row in at_a.items() if other in at_b]
    if a == b or not common:
        raise InputError(f"no two points differ only in {key} = {a} and {b}", key=key, allowed=_values(runs, key))
    out = []
    for group in _groups([runs.points[row] for row in common], by):
        first = [common[i] for i in group]
        second = [at_b[_named(runs.points[row], others)] for row in first]
        values = {name: runs.points[first[0]][name] for name in by}
        out.append(_difference(values, runs, first, second, level))
    return out


def effects(table: Any, metric: str, keys: Sequence[str], level: float = LEVEL) -> list[Effect]:
    """Main effects of all varied `keys`, each averaged over the others.

    They are found for each seed and then averaged, so that the limits are those of paired runs.  In a grid every
    key counts by its values; in other samples (list, Latin hypercube) numeric keys count by their slope in a
    linear fit, and their limits are those of the seeds, not of the fit.
    Raises InputError for an unknown name, or if the points do not tell the keys apart.
    """
    runs = matrix(table, metric, keys)
    design, reader, labels = _design(runs.points, keys)
    if not labels:
        return []
    if np.linalg.matrix_rank(design) < design.shape[1]:
        raise InputError("the points are too few to tell the varied keys apart", key=metric)
    whole = np.isfinite(runs.values).all(axis=0)
    per_seed = reader @ (np.linalg.pinv(design) @ runs.values[:, whole])
    left_out = int((~whole).sum())
    out = []
    for (key, value, kind), row in zip(labels, per_seed, strict=True):
        effect, half_width, _ = _interval(row, level)
        out.append(Effect(key, value, kind, effect, half_width, len(row), left_out))
    return out


def _design(
    points: Sequence[dict[str, Any]], keys: Sequence[str]
) -> tuple[Array, Array, list[tuple[str, Any, str]]]:
    """Columns of the fit (points, k), what reads effects off its k coefficients (effects, k), their labels."""
    varied = [key for key in keys if len(_order(points, key)) > 1]
    size = math.prod(len(_order(points, key)) for key in varied)
    grid = len(points) == len({_named(point, varied) for point in points}) == size
    codings = [_coding(points, key, slope=not grid) for key in varied]
    design = np.concatenate([np.ones((len(points), 1)), *(coding[0] for coding in codings)], axis=1)
    labels = [(key, *label) for key, coding in zip(varied, codings, strict=True) for label in coding[2]]
    reader = np.zeros((len(labels), design.shape[1]))
    row, column = 0, 1
    for _, part, _ in codings:
        reader[row : row + len(part), column : column + part.shape[1]] = part
        row, column = row + len(part), column + part.shape[1]
    return design, reader, labels


def _named(point: dict[str, Any], keys: Sequence[str]) -> tuple[Any, ...]:
    return tuple(identity(point[key]) for key in keys)


def _groups(points: Sequence[dict[str, Any]], by: Sequence[str]) -> list[list[int]]:
    """Places of points that agree in `by`, in the order of their first ones."""
    found: dict[tuple[Any, ...], list[int]] = {}
    for place, point in enumerate(points):
        found.setdefault(_named(point, by), []).append(place)
    return list(found.values())


def _order(points: Sequence[dict[str, Any]], key: str) -> list[Any]:
    """Values of a key in the order of the points."""
    return list({identity(point[key]): point[key] for point in points}.values())


def _values(runs: Matrix, key: str) -> str:
    return "its values are " + ", ".join(str(value) for value in _order(runs.points, key))


def _interval(values: Array, level: float) -> tuple[float, float, float]:
    """Mean, half width of its interval by Student's t, standard deviation; of the values that are finite."""
    from scipy.stats import t

    there = values[np.isfinite(values)]
    n = len(there)
    mean = float(there.mean()) if n else float("nan")
    if n < 2:
        return mean, float("nan"), float("nan")
    sd = float(there.std(ddof=1))
    return mean, float(t.ppf(0.5 + level / 2.0, n - 1)) * sd / float(np.sqrt(n)), sd


def _told(runs: Matrix, rows: Sequence[int], values: Array) -> tuple[int, int, int]:
    """Seeds used, missing, failed."""
    used = np.isfinite(values)
    failed = runs.failed[list(rows)].any(axis=0) & ~used
    return int(used.sum()), int((~used & ~failed).sum()), int(failed.sum())


def _difference(
    values: dict[str, Any], runs: Matrix, first: list[int], second: list[int], level: float
) -> Difference:
    """The difference of two groups of points, paired row by row."""
    a, b = runs.values[first].mean(axis=0), runs.values[second].mean(axis=0)
    both = np.isfinite(a) & np.isfinite(b)
    mean, half_width, sd = _interval(a - b, level)
    n = int(both.sum())
    _, _, sd_a = _interval(a[both], level)
    _, _, sd_b = _interval(b[both], level)
    unpaired = float(np.hypot(sd_a, sd_b)) / float(np.sqrt(max(n, 1)))
    constant = not (sd_a > 0.0 and sd_b > 0.0)
    together = float("nan") if constant else float(np.corrcoef(a[both], b[both])[0, 1])
    told = _told(runs, first + second, a - b)
    return Difference(values, mean, half_width, sd / float(np.sqrt(max(n, 1))), unpaired, together, *told)


def _is_number(values: Sequence[Any]) -> bool:
    return all(isinstance(value, (int, float)) and not isinstance(value, bool) for value in values)


def _coding(points: Sequence[dict[str, Any]], key: str, slope: bool) -> tuple[Array, Array, list[tuple[Any, str]]]:
    """How a key enters the fit: its columns (points, k), what reads effects off k coefficients, their labels.

    Values enter so that their effects add up to 0; with `slope`, numbers enter by their place in their range.
    """
    order = _order(points, key)
    if slope and _is_number(order):
        x = np.array([float(point[key]) for point in points])
        low, high = x.min(), x.max()
        return ((x - low) / (high - low))[:, None], np.ones((1, 1)), [((low, high), "slope")]
    reader = np.vstack([np.eye(len(order) - 1), -np.ones(len(order) - 1)])
    place = {identity(value): i for i, value in enumerate(order)}
    rows: NDArray[np.int64] = np.array([place[identity(point[key])] for point in points])
    return reader[rows], reader, [(value, "level") for value in order]
