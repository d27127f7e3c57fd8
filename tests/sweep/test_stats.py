"""Means, paired differences and main effects against scipy and against made-up truths; nothing lost silently."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from scipy import stats as reference
from sweep_tables import grid, noise, table

from aerosim.errors import InputError
from aerosim.sweep.stats import effects, means, paired

WIND, MODE, CRAB = "air.wind.speed_m_s", "control.mode", "crab.residual_rms_deg"
KEYS = (WIND, MODE)
POINTS = grid({WIND: (0, 10, 20), MODE: ("fixed", "pipelined")})
SEEDS = 9


def crab(point: Mapping[str, Any], seed: int) -> float:
    """Wind and mode add up; the air of a seed is common to all, each run has a little of its own."""
    mine = POINTS.index(dict(point))
    own = 0.1 * noise("own", seed, mine)
    return 1.0 + 0.05 * point[WIND] + (2.0 if point[MODE] == "fixed" else 0.0) + noise("air", seed) + own


@pytest.fixture(scope="module")
def runs() -> pa.Table:
    return table(POINTS, SEEDS, {CRAB: crab})


def values(point: int) -> np.ndarray:
    return np.array([crab(POINTS[point], seed) for seed in range(1, SEEDS + 1)])


def test_means_are_those_of_scipy(runs: pa.Table) -> None:
    found = means(runs, CRAB, KEYS)
    assert [m.values for m in found] == POINTS
    for number, m in enumerate(found):
        x = values(number)
        low, high = reference.t.interval(0.95, SEEDS - 1, loc=x.mean(), scale=reference.sem(x))
        assert (m.mean - m.half_width, m.mean + m.half_width) == pytest.approx((low, high), rel=1e-12)
        assert m.sd == pytest.approx(x.std(ddof=1))
        assert (m.seeds, m.missing, m.failed) == (SEEDS, 0, 0)


def test_means_over_other_keys_rest_on_seeds_not_on_runs(runs: pa.Table) -> None:
    """Runs of one seed fly in the same air: six times as many of them do not make the mean six times as sure."""
    (all_of,) = means(runs, CRAB, ())
    per_seed = np.mean([values(number) for number in range(len(POINTS))], axis=0)
    low, high = reference.t.interval(0.95, SEEDS - 1, loc=per_seed.mean(), scale=reference.sem(per_seed))
    assert all_of.seeds == SEEDS
    assert (all_of.mean - all_of.half_width, all_of.mean + all_of.half_width) == pytest.approx((low, high))
    by_mode = means(runs, CRAB, (MODE,))
    assert [m.values for m in by_mode] == [{MODE: "fixed"}, {MODE: "pipelined"}]
    assert by_mode[0].mean == pytest.approx(np.mean([values(number) for number in (0, 2, 4)]))


def test_what_failed_and_what_is_null_is_counted() -> None:
    def sparse(point: Mapping[str, Any], seed: int) -> float | None:
        return None if seed == 3 and point == POINTS[1] else crab(point, seed)

    runs = table(POINTS, SEEDS, {CRAB: sparse}, failed={(0, 1): "aircraft lost", (1, 2): "terrain left"})
    found = means(runs, CRAB, KEYS)
    assert [(m.seeds, m.missing, m.failed) for m in found[:3]] == [(8, 0, 1), (7, 1, 1), (9, 0, 0)]
    assert found[1].mean == pytest.approx(np.delete(values(1), [1, 2]).mean())
    (calm, *_) = paired(runs, CRAB, MODE, "fixed", "pipelined", KEYS)
    assert (calm.seeds, calm.missing, calm.failed) == (6, 1, 2)
    assert calm.mean == pytest.approx((values(0) - values(1))[3:].mean())
    assert {(e.seeds, e.left_out) for e in effects(runs, CRAB, KEYS)} == {(6, 3)}
    lost = runs.filter(pa.array([row % 7 != 0 for row in range(runs.num_rows)]))
    assert means(lost, CRAB, KEYS)[2].missing == 1  # not run yet


def test_values_of_a_failed_run_do_not_count() -> None:
    runs = table(POINTS[:1], 4, {CRAB: lambda _, seed: float(seed)})
    status = pa.array(["done", "failed", "done", "done"])
    runs = runs.set_column(runs.column_names.index("status"), "status", status)
    (found,) = means(runs, CRAB, KEYS)
    assert (found.mean, found.seeds, found.failed) == (pytest.approx(8.0 / 3.0), 3, 1)


def test_one_seed_has_a_mean_and_no_limits() -> None:
    runs = table(POINTS, 1, {CRAB: crab})
    assert all(np.isnan(m.half_width) and m.mean == crab(m.values, 1) for m in means(runs, CRAB, KEYS))
    (d, *_) = paired(runs, CRAB, MODE, "fixed", "pipelined", KEYS)
    assert np.isnan([d.half_width, d.standard_error, d.correlation]).all()
    nothing = table(POINTS, 2, {CRAB: lambda *_: None})
    assert all(np.isnan(m.mean) and m.missing == 2 for m in means(nothing, CRAB, KEYS))


def test_paired_differences_are_those_of_scipy(runs: pa.Table) -> None:
    found = paired(runs, CRAB, MODE, "fixed", "pipelined", KEYS)
    assert [d.values for d in found] == [{WIND: 0}, {WIND: 10}, {WIND: 20}]
    for number, d in enumerate(found):
        a, b = values(2 * number), values(2 * number + 1)
        test = reference.ttest_rel(a, b)
        interval = test.confidence_interval(0.95)
        assert (d.mean - d.half_width, d.mean + d.half_width) == pytest.approx((interval.low, interval.high))
        assert d.standard_error == pytest.approx(d.mean / test.statistic)
        apart = reference.ttest_ind(a, b, equal_var=False)
        assert d.unpaired_standard_error == pytest.approx((a.mean() - b.mean()) / apart.statistic)
        assert d.correlation == pytest.approx(reference.pearsonr(a, b).statistic)
        # air of deviation 1 is common, 0.1 is each run's own: sqrt(2) 0.1 against sqrt(2) 1.005
        assert d.standard_error < 0.3 * d.unpaired_standard_error
    turned = paired(runs, CRAB, MODE, "pipelined", "fixed", KEYS)
    assert [d.mean for d in turned] == pytest.approx([-d.mean for d in found])
    (over_all,) = paired(runs, CRAB, MODE, "fixed", "pipelined", KEYS, by=())
    assert over_all.mean == pytest.approx(np.mean([d.mean for d in found]))


def test_a_number_is_found_however_it_is_written(runs: pa.Table) -> None:
    assert [d.mean for d in paired(runs, CRAB, WIND, 20.0, 10, KEYS)] == pytest.approx(
        [(values(4 + mode) - values(2 + mode)).mean() for mode in (0, 1)]
    )


def test_main_effects_of_a_grid(runs: pa.Table) -> None:
    found = {(e.key, e.value): e for e in effects(runs, CRAB, KEYS)}
    assert list(found) == [(WIND, 0), (WIND, 10), (WIND, 20), (MODE, "fixed"), (MODE, "pipelined")]
    assert {e.kind for e in found.values()} == {"level"}
    cube = np.array([values(number) for number in range(6)]).reshape(3, 2, SEEDS)
    for i, wind in enumerate((0, 10, 20)):
        per_seed = cube[i].mean(axis=0) - cube.mean(axis=(0, 1))  # the textbook's definition
        low, high = reference.t.interval(0.95, SEEDS - 1, loc=per_seed.mean(), scale=reference.sem(per_seed))
        e = found[WIND, wind]
        assert (e.effect - e.half_width, e.effect + e.half_width) == pytest.approx((low, high), rel=1e-9)
        # the made-up truth: 0.05 per m/s about the middle; own noise 0.1 leaves 0.02 of deviation
        assert e.effect == pytest.approx(0.05 * (wind - 10), abs=0.08)
    assert found[MODE, "fixed"].effect == pytest.approx(1.0, abs=0.08)
    assert found[MODE, "fixed"].effect == pytest.approx(-found[MODE, "pipelined"].effect)


def test_main_effects_of_a_sample_are_slopes_over_the_range() -> None:
    rng = np.random.default_rng(4)
    points = [
        {"a": float(a), "b": float(b), MODE: mode}
        for a, b, mode in zip(rng.uniform(0, 8, 12), rng.uniform(-1, 1, 12), ["x", "y"] * 6, strict=True)
    ]
    runs = table(points, 3, {"m": lambda p, seed: 2.0 * p["a"] - 3.0 * p["b"] + 4.0 * (p[MODE] == "x") + seed})
    found = {(e.key, e.kind): e for e in effects(runs, "m", ("a", "b", MODE))}
    spans = {key: (min(p[key] for p in points), max(p[key] for p in points)) for key in ("a", "b")}
    for key, slope in (("a", 2.0), ("b", -3.0)):
        e = found[key, "slope"]
        assert e.value == spans[key]
        assert e.effect == pytest.approx(slope * (spans[key][1] - spans[key][0]), rel=1e-9)
    assert found[MODE, "level"].effect == pytest.approx(-2.0)  # the last one, "y"


def test_keys_that_move_together_cannot_be_told_apart() -> None:
    runs = table([{"a": x, "b": 2 * x} for x in (1.0, 2.0, 3.0)], 3, {"m": lambda p, seed: p["a"] + seed})
    with pytest.raises(InputError, match="too few to tell the varied keys apart"):
        effects(runs, "m", ("a", "b"))
    assert effects(runs, "m", ()) == []


def test_limits_cover_the_truth() -> None:
    """95 % limits of a mean over three points that share their air, of four seeds only: in 95 % of 2,000 cases.

    2,000 cases of probability 0.95 have a standard deviation of sqrt(2000 0.95 0.05) = 9.7 cases, 0.5 %: four of
    them are 2 %.  Limits from all twelve runs as if they were independent would cover about two thirds.
    """
    points = grid({"k": (1, 2, 3)})
    rng = np.random.default_rng(11)
    hits = 0
    cases = 2000
    base = table(points, 4, {"m": lambda *_: 0.0})
    place = base.column_names.index("m")
    for _ in range(cases):
        x = rng.normal(0, 1, 4)[None, :] + rng.normal(0, 0.3, (3, 4))
        (found,) = means(base.set_column(place, "m", pa.array(x.ravel())), "m", ())
        hits += abs(found.mean) <= found.half_width
    assert hits / cases == pytest.approx(0.95, abs=0.02)


def test_lists_and_mappings_may_be_values() -> None:
    points = [{"gusts": [1, 2]}, {"gusts": [1, 3]}]
    runs = table(points, 3, {"m": lambda p, seed: float(p["gusts"][1] * seed)})
    assert [m.mean for m in means(runs, "m", ("gusts",))] == [4.0, 6.0]
    assert paired(runs, "m", "gusts", [1, 3], [1, 2], ("gusts",))[0].mean == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda t: means(t, "crab.residual_rms", KEYS), "did you mean crab.residual_rms_deg"),
        (lambda t: means(t, CRAB, ("control.mod",)), "did you mean control.mode"),
        (lambda t: means(t, "status", KEYS), "no metric: its values are no numbers"),
        (lambda t: paired(t, CRAB, MODE, "fixed", "best", KEYS), "its values are fixed, pipelined"),
        (lambda t: paired(t, CRAB, MODE, "fixed", "fixed", KEYS), "no two points differ"),
        (lambda t: paired(t, CRAB, "control.mod", "a", "b", KEYS), "did you mean control.mode"),
        (lambda t: effects(t, CRAB, ("wind",)), "the sweep has no key wind"),
        (lambda t: means(t.slice(0, 0), CRAB, KEYS), "the sweep has no runs yet"),
    ],
)
def test_wrong_questions(runs: pa.Table, call: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call(runs)


def test_points_keep_their_order_whatever_the_order_of_rows(runs: pa.Table) -> None:
    shuffled = runs.take(np.random.default_rng(1).permutation(runs.num_rows))
    assert means(shuffled, CRAB, KEYS) == means(runs, CRAB, KEYS)
    assert all(a.values != b.values for a, b in pairwise(means(shuffled, CRAB, KEYS)))
