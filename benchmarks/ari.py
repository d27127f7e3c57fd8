"""ARI filter and fits against statsmodels on the same series; times of a strip and of a million points."""

from __future__ import annotations

import statistics
import time
import warnings
from collections.abc import Callable

import numpy as np
from statsmodels.tsa.statespace.sarimax import SARIMAX

from aerosim.estimation.ari import filter_ari, fit_ari, simulate_ari

# the paper's GPS (5, 2) and Shuttle (6, 1) processes: m = 7
GPS = (-0.31823754, 0.63867057, -0.57521724, 0.0975253, -0.20966707)
YAW = (-0.74145450, 0.38044451)


def seconds(call: Callable[[], object], rounds: int = 3) -> float:
    """Least time of a call, s, after one that is not counted: others use the machine too."""
    call()
    times = []
    for _ in range(rounds):
        started = time.perf_counter()
        call()
        times.append(time.perf_counter() - started)
    return min(times)


def smoother(n: int) -> tuple[float, float]:
    """Smoothed values, their covariances and the likelihood of n points, p + d = 7: ours and statsmodels', s."""
    _, y = simulate_ari(n, GPS, 2, 1.0, 1.34, rng=np.random.default_rng(1))
    model = SARIMAX(y, order=(5, 2, 0), measurement_error=True, use_exact_diffuse=True)
    parameters = np.r_[-np.array(GPS), 1.0, 1.34**2]
    theirs = seconds(lambda: model.smooth(parameters), 1)
    return seconds(lambda: filter_ari(y, GPS, 2, 1.0, 1.34)), theirs


def fits(n: int, seeds: int) -> tuple[float, float]:
    """Maximum likelihood of n points, (2, 2): median of ours (18 starts) and statsmodels' (one), s."""
    ours, theirs = [], []
    for seed in range(seeds):
        _, y = simulate_ari(n, YAW, 2, 1.0, 0.3, rng=np.random.default_rng(seed))
        ours.append(seconds(lambda y=y: fit_ari(y, 2, 2, method="ml", robust="none", steps=False), 1))  # type: ignore[misc]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model = SARIMAX(y, order=(2, 2, 0), measurement_error=True)
            theirs.append(seconds(lambda model=model: model.fit(disp=False, maxiter=200), 1))  # type: ignore[misc]
    return statistics.median(ours), statistics.median(theirs)


def main() -> None:
    """Print times and ratios."""
    for n in (1000, 10_000):
        ours, theirs = smoother(n)
        print(f"smoother with covariance band, {n} points: {ours * 1e3:.2f} ms, {theirs / ours:.0f} x statsmodels")
    _, y = simulate_ari(1_000_000, GPS, 2, 1.0, 1.34, rng=np.random.default_rng(2))
    print(f"a million points filtered: {seconds(lambda: filter_ari(y, GPS, 2, 1.0, 1.34), 2):.2f} s (goal 1)")
    for n, seeds in ((600, 3), (4000, 1)):
        ours, theirs = fits(n, seeds)
        print(f"maximum likelihood, {n} points: {ours:.2f} s, {theirs / ours:.1f} x statsmodels (goal 4)")
    times = []
    for seed in range(5):
        _, y = simulate_ari(130, GPS, 2, 0.018, 0.024, rng=np.random.default_rng(seed))
        times.append(seconds(lambda y=y: fit_ari(y, 5, 2), 2))  # type: ignore[misc]
    print(f"default fit of 130 points, (5, 2): {statistics.median(times):.2f} s (goal 0.5)")


if __name__ == "__main__":
    main()
