"""Series as they come: checked, put on a grid of equal steps, unwrapped, scaled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.frames import Array

LARGEST = 1e100  # squares of what is larger overflow
STEP_TOLERANCE = 1e-3  # of a step: time stamps are rounded
GRID_MAX = 20  # epochs per given row: beyond, the times are no series with gaps
DIGITS = 1e-13  # variation below this share of the values is rounding


@dataclass(frozen=True)
class Series:
    """One strip on a grid of equal steps.

    y: values (n,), 0 where missing.  w: weights (n,), 0 = missing.  rows: index on the grid of each row that was
    given.  start, dt: first time and step.
    """

    y: Array
    w: Array
    rows: np.ndarray
    start: float
    dt: float

    @property
    def observed(self) -> int:
        """Number of observations that are there."""
        return int(np.count_nonzero(self.w))


def unwrap(y: ArrayLike, period: float) -> Array:
    """Values of an angle without its jumps by whole periods; NaN are skipped.  y: (n,); period: 360 or 2 pi."""
    values = np.array(y, float)
    there = np.isfinite(values)
    values[there] = np.unwrap(values[there], period=period)
    return values


def resample(times: ArrayLike, y: ArrayLike, dt: float) -> tuple[Array, Array]:
    """Values at equal steps dt, straight between neighbours; NaN where the neighbours are more than 2 dt apart.

    times: (n,), growing.  Returns times and values on the grid.  Interpolated noise is correlated, and smaller
    than it was: what is estimated from it errs in that.  Raises InputError on times that do not grow.
    """
    t, values = np.asarray(times, float), np.asarray(y, float)
    _checked_times(t, len(values))
    if not (np.isfinite(dt) and 0.0 < dt <= t[-1] - t[0]):
        raise InputError(f"{dt} is no step", "dt", f"above 0, at most {t[-1] - t[0]:g}")
    grid = t[0] + dt * np.arange(int((t[-1] - t[0]) / dt + 1e-9) + 1)
    there = np.isfinite(values)
    if np.count_nonzero(there) < 2:
        raise InputError("fewer than two values", "y")
    out = np.interp(grid, t[there], values[there], left=np.nan, right=np.nan)
    after = np.clip(np.searchsorted(t[there], grid), 1, np.count_nonzero(there) - 1)
    known = t[there]
    on_point = np.minimum(np.abs(known[after] - grid), np.abs(known[after - 1] - grid)) < STEP_TOLERANCE * dt
    out[(known[after] - known[after - 1] > 2.0 * dt * (1.0 + STEP_TOLERANCE)) & ~on_point] = np.nan
    return grid, out


def checked_series(
    y: ArrayLike,
    times: ArrayLike | None,
    weights: ArrayLike | None,
    dt: float,
    period: float | None,
    key: str = "y",
) -> Series:
    """One strip of raw values (n,) on its grid.  NaN is a missing value.

    times: (n,), steps of one length or whole multiples of it; None: one step dt each.  weights: (n,), relative,
    0 leaves a value out.  period: of an angle, which is unwrapped.  Raises InputError.
    """
    values = np.asarray(y, float)
    if values.ndim != 1:
        raise InputError(f"shape {values.shape}", key, "one value an epoch")
    bad = np.flatnonzero(np.isinf(values) | (np.abs(values) > LARGEST))
    if len(bad):
        raise InputError(
            f"value {bad[0]} is {values[bad[0]]:g}", key, f"finite, below {LARGEST:g}; NaN where missing"
        )
    w = np.ones(len(values)) if weights is None else np.asarray(weights, float)
    if w.shape != values.shape or not np.all(np.isfinite(w)) or np.any(w < 0.0):
        raise InputError("weights do not fit", "weights", f"{len(values)} finite numbers, none negative")
    if period is not None:
        values = unwrap(values, period)
    else:
        _refuse_wrapped(values, key)
    there = np.isfinite(values) & (w > 0.0)
    if times is None:
        if not (np.isfinite(dt) and dt > 0.0):
            raise InputError(f"{dt} is no step", "dt", "above 0")
        rows, start, n = np.arange(len(values)), 0.0, len(values)
    else:
        rows, start, dt = _on_grid(np.asarray(times, float), len(values))
        n = int(rows[-1]) + 1
    grid_y, grid_w = np.zeros(n), np.zeros(n)
    grid_y[rows[there]], grid_w[rows[there]] = values[there], w[there]
    return Series(grid_y, grid_w, rows, start, dt)


def _checked_times(t: Array, n: int) -> None:
    if t.shape != (n,) or not np.all(np.isfinite(t)):
        raise InputError("times do not fit", "times", f"{n} finite numbers")
    if n < 2:
        raise InputError(f"{n} points", "times", "at least 2")
    steps = np.diff(t)
    if np.any(steps <= 0.0):
        k = int(np.flatnonzero(steps <= 0.0)[0]) + 1
        what = "appears twice" if steps[k - 1] == 0.0 else "goes back"
        raise InputError(f"time {t[k]:.10g} of row {k} {what}", "times", "times that grow")


def _on_grid(t: Array, n: int) -> tuple[np.ndarray, float, float]:
    _checked_times(t, n)
    steps = np.diff(t)
    dt = float(np.median(steps))
    whole = np.rint(steps / dt)
    # time stamps are rounded; single precision and large times leave less
    odd = np.flatnonzero(
        (whole < 1.0) | (np.abs(steps - whole * dt) > STEP_TOLERANCE * dt + 1e-12 * np.abs(t[1:]))
    )
    if len(odd):
        k = int(odd[0])
        raise InputError(
            f"unequal steps: {steps[k]:.6g} after row {k}, elsewhere {dt:.6g}",
            "times",
            "equal steps; or resample first",
        )
    rows = np.r_[0, np.cumsum(whole)].astype(int)
    if rows[-1] + 1 > GRID_MAX * n:
        raise InputError(f"{n} rows over {rows[-1] + 1} steps", "times", "mostly gaps: cut it into strips")
    return rows, float(t[0]), float((t[-1] - t[0]) / rows[-1])


def _refuse_wrapped(values: Array, key: str) -> None:
    """Refuse jumps of one turn in a series that is otherwise calm: a wrapped angle would be taken for a flight."""
    known = np.flatnonzero(np.isfinite(values))
    if len(known) < 3 or np.ptp(values[known]) > 1.05 * 360.0:
        return
    steps = np.abs(np.diff(values[known]))
    for turn in (360.0, 2.0 * np.pi):
        jumps = np.abs(steps - turn) < 0.1 * turn
        calm = np.quantile(np.where(jumps, np.abs(steps - turn), steps), 0.95) < 0.1 * turn
        if np.any(jumps) and np.ptp(values[known]) < 1.05 * turn and calm:
            k = known[np.flatnonzero(jumps)[0] + 1]
            raise InputError(f"jumps by {turn:.4g} at row {k}", key, f"an angle? then period={turn:.6g}")


def checked_order(p: int, d: int) -> None:
    """Raises InputError unless 0 <= p <= 20 and 0 <= d <= 3."""
    if int(p) != p or not 0 <= p <= 20:
        raise InputError(f"order {p}", "p", "a whole number from 0 to 20")
    if int(d) != d or not 0 <= d <= 3:
        raise InputError(f"{d} differences", "d", "0, 1, 2 or 3")


def points_needed(p: int, d: int) -> int:
    """Observations without which an order is not fitted: four for each parameter."""
    return 4 * (p + d + 2)


@dataclass(frozen=True)
class Scaled:
    """Strips with their trend of degree d - 1 taken out and their scale divided away: the fit sees numbers near 1.

    Neither changes the likelihood's shape: the first d values are free anyway.
    """

    y: list[Array]
    w: list[Array]
    trend: list[Array]
    scale: float


def trend_of(strip: Series, d: int) -> Array:
    """Polynomial of degree d - 1 through some of the observations, at each epoch (n,); zero for d = 0."""
    t = np.linspace(-1.0, 1.0, len(strip.y))
    there = strip.w > 0.0
    if not d:
        return np.zeros(len(t))
    # any such polynomial leaves the likelihood as it is: a few points are enough to place it
    few = np.flatnonzero(there)
    few = few[np.linspace(0, len(few) - 1, min(len(few), 1000)).astype(int)]
    fit = np.polynomial.Polynomial.fit(t[few], strip.y[few], d - 1, domain=[-1, 1])
    return np.asarray(fit(t), float)


def scaled(strips: list[Series], p: int, d: int) -> Scaled:
    """Raises InputError: too few points, or no variation to estimate anything from."""
    needed, found = points_needed(p, d), sum(s.observed for s in strips)
    if found < needed:
        raise InputError(f"{found} points for order ({p},{d})", "y", f"at least {needed}")
    y, trend, squares, count = [], [], 0.0, 0
    for k, strip in enumerate(strips):
        if strip.observed < p + d + 2:
            raise InputError(
                f"strip {k} has {strip.observed} points", "y", f"at least {p + d + 2} for order ({p},{d})"
            )
        line, there = trend_of(strip, d), strip.w > 0.0
        rest = np.where(there, strip.y - line, 0.0)
        diff = np.diff(np.where(there, rest, np.nan), n=d)
        diff = diff[np.isfinite(diff)]
        if not np.any(np.abs(diff) > DIGITS * max(float(np.max(np.abs(strip.y))), 1e-290)):
            raise InputError(
                f"strip {k} does not vary" if len(strips) > 1 else "does not vary", "y", "a noisy series"
            )
        squares, count = squares + float(np.sum(diff**2)), count + len(diff)
        y.append(rest)
        trend.append(line)
    scale = float(np.sqrt(squares / count))
    return Scaled([v / scale for v in y], [s.w for s in strips], trend, scale)
