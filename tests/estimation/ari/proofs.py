"""Many runs of the fit against truth: what the slow tests and docs/ari.md quote.

Run as a script it prints the figures: python -m estimation.ari.proofs N SEED WHAT [POINT ...], from tests/.
"""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np

from aerosim.estimation.ari import filter_ari, fit_ari
from aerosim.estimation.ari.robust import clean
from aerosim.estimation.ari.series import checked_series, scaled
from estimation.ari.points import HELD_OUT, POINTS, Point


class Quality(NamedTuple):
    """Of many fits: relative bias and rms of sigma_n; error over that of the filter that knows the truth (median,
    95 % quantile); coverage of 95 % intervals of x and of the 90 % interval of sigma_n; median sigma_e over truth;
    share of runs with each flag."""

    bias: float
    rms: float
    ratio: float
    ratio_95: float
    coverage: float
    interval: float
    sigma_e: float
    flags: dict[str, float]


def quality(point: Point, seeds: range, **options: object) -> Quality:
    rows, inside, flags = [], [], {}
    for seed in seeds:
        truth, y = point.series(seed)
        best = filter_ari(y, point.a, point.d, point.sigma_n, point.sigma_e)
        fit = fit_ari(y, *point.order, **options)  # type: ignore[arg-type]
        strip = fit.strip
        rows.append(
            (
                fit.sigma_n.value / point.sigma_n,
                np.sqrt(np.mean((strip.x - truth) ** 2) / np.mean((best.x - truth) ** 2)),
                np.mean(np.abs(strip.x - truth) < 1.96 * strip.sigma_x),
                fit.sigma_n.low <= point.sigma_n <= fit.sigma_n.high,
                fit.sigma_e.value / point.sigma_e,
            )
        )
        for flag in fit.flags:
            flags[flag] = flags.get(flag, 0.0) + 1.0 / len(seeds)
    sn, ratio, inside, interval, se = np.array(rows, float).T
    return Quality(
        float(np.mean(sn) - 1.0),
        float(np.sqrt(np.mean((sn - 1.0) ** 2))),
        float(np.median(ratio)),
        float(np.quantile(ratio, 0.95)),
        float(np.mean(inside)),
        float(np.mean(interval)),
        float(np.median(se)),
        flags,
    )


def blunders(point: Point, seeds: range, share: float) -> tuple[float, float]:
    """Share of 10-sigma blunders that are rejected, and of good observations."""
    found = placed = false = good = 0
    for seed in seeds:
        _, y = point.series(seed)
        rng = np.random.default_rng(seed + 77)
        bad = rng.uniform(size=len(y)) < share
        y = y + np.where(bad, 10.0 * point.sigma_n * rng.choice([-1.0, 1.0], len(y)), 0.0)
        ready = scaled([checked_series(y, None, None, 1.0, None)], *point.order)
        rejected = clean(ready.y, ready.w, *point.order, blunders=True, steps=True).weights[0] == 0.0
        found, placed = found + np.sum(rejected & bad), placed + np.sum(bad)
        false, good = false + np.sum(rejected & ~bad), good + np.sum(~bad)
    return found / max(placed, 1), false / good


def steps(point: Point, seeds: range, size: float) -> tuple[float, float]:
    """Share of strips whose one step of `size` sigma_n is found within one epoch, and of others found a strip."""
    hit = other = 0
    for seed in seeds:
        _, y = point.series(seed)
        at = int(np.random.default_rng(seed + 99).integers(20, len(y) - 20))
        y = y + size * point.sigma_n * (np.arange(len(y)) >= at)
        ready = scaled([checked_series(y, None, None, 1.0, None)], *point.order)
        found = clean(ready.y, ready.w, *point.order, blunders=True, steps=True).steps[0]
        right = [step for step in found if size and abs(step.index - at) <= 1]
        hit, other = hit + bool(right), other + len(found) - bool(right)
    return hit / len(seeds), other / len(seeds)


def pooled(point: Point, seeds: range, strips: int) -> tuple[float, float, float, float]:
    """Of so many strips of 120 to 800 points fitted together: bias and rms of sigma_n, median error over that of
    the filter that knows the truth, coverage."""
    found, ratios, inside = [], [], []
    for seed in seeds:
        lengths = np.linspace(120, 800, strips).astype(int)
        pairs = [point.series(1000 * seed + k, int(n)) for k, n in enumerate(lengths)]
        fit = fit_ari([y for _, y in pairs], *point.order)
        found.append(fit.sigma_n.value / point.sigma_n)
        ours = theirs = covered = 0.0
        for strip, (truth, y) in zip(fit.strips, pairs, strict=True):
            best = filter_ari(y, point.a, point.d, point.sigma_n, point.sigma_e)
            ours, theirs = ours + np.sum((strip.x - truth) ** 2), theirs + np.sum((best.x - truth) ** 2)
            covered += np.sum(np.abs(strip.x - truth) < 1.96 * strip.sigma_x)
        ratios.append(np.sqrt(ours / theirs))
        inside.append(covered / lengths.sum())
    off = np.array(found) - 1.0
    return float(off.mean()), float(np.sqrt(np.mean(off**2))), float(np.median(ratios)), float(np.mean(inside))


def main(arguments: list[str]) -> None:
    n, first, what, *names = arguments
    seeds = range(int(first), int(first) + int(n))
    points = POINTS | HELD_OUT
    for name in names or points:
        point = points[name]
        if what == "quality":
            print(name, quality(point, seeds), flush=True)
        elif what == "blunders":
            print(name, [(share, blunders(point, seeds, share)) for share in (0.0, 0.01, 0.05)], flush=True)
        elif what == "steps":
            print(name, [(size, steps(point, seeds, size)) for size in (0.0, 10.0)], flush=True)
        elif what == "pooled":
            print(name, pooled(point, seeds, 21), flush=True)
        elif what == "lost":
            lost = point._replace(sigma_n=0.05 * point.sigma_e)
            print(name, quality(lost, seeds, robust="none", steps=False).flags, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
