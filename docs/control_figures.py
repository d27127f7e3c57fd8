"""Makes the pictures of the controller's loop in docs/controller.md: ``python docs/control_figures.py``."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from aerosim.estimation.kalman import (
    ScalarFilter,
    next_gain_halving,
    next_gain_riccati,
    next_variance,
    stationary_gain,
)
from aerosim.report import plots

sys.path.insert(0, str(Path(__file__).parent))

IMAGES = Path(__file__).parent / "images"
COLOURS = ("#D55E00", "#E69F00", "#0072B2")
PERIOD = 0.05  # s between exposures
N = 259  # exposures of a strip: 3000 m, 250 km/h
SETTLE = 14  # exposures by which the minimum has to be left behind: 2 px of 6.5 exposures
Array = NDArray[np.float64]


class Loop(NamedTuple):
    """A mode as its loop has it.  q: stationary gain; every: exposures between two strips' beginnings.

    first, second: steps (strips) by which the mount's yaw at row I and row II is older than the estimate that the
    strip makes.
    """

    name: str
    gamma: float
    every: int
    first: int
    second: int

    @property
    def q(self) -> float:
        """Stationary gain."""
        return stationary_gain(self.gamma)


# One strip at a time: kept one exposure after the last was decided, before the mount has moved.  Pipelined: a
# strip each second, met 0.7 s and kept 13.65 s before it is decided, at the yaw of the estimates before.
LOOPS = (
    Loop("1988, printed gamma 0.01", 0.01, N + SETTLE + 1, 2, 1),
    Loop("1988, consistent gamma 0.116", 0.225 * N * PERIOD / 25.0, N + SETTLE + 1, 2, 1),
    Loop("pipelined", 0.225 / 25.0, 20, 14, 1),
)


def step_response(loop: Loop, seconds: float, along_track: bool = False) -> tuple[Array, Array]:
    """Estimate of a drift that steps from 0 to 1 at t = 0, just after a strip was kept: (k,) s, (k,).

    A strip tells the mean of the heading at its two exposures, so a step of the heading is seen by half in the
    strips in flight; along_track: the track steps instead, and they see the share of their time behind it.
    """
    state = ScalarFilter(loop.gamma, 1.0)
    for _ in range(2000):
        state.update(0.0)
    t, x = [0.0], [0.0]
    kept = 0 if loop.every > N else -loop.every * ((N + SETTLE) // loop.every)
    while (decided := kept + N + SETTLE) * PERIOD <= seconds:
        met = kept + N
        ends = (float(kept > 0) + float(met > 0)) / 2.0
        share = min(max(met / N, 0.0), 1.0)
        state.update(share if along_track else ends)
        if decided > 0:
            t += [decided * PERIOD] * 2
            x += [x[-1], state.estimate]
        kept += loop.every
    return np.array([*t, seconds]), np.array([*x, x[-1]])


def time_to(share: float, t: Array, x: Array) -> float:
    """When the response has come to this share for good, s."""
    return float(t[np.flatnonzero(x < share)[-1] + 1])


def ladder(loop: Loop, omega: float) -> complex:
    """The mount's mean yaw at both exposures against the estimate, at omega rad a step."""
    return complex(np.exp(-1j * omega * loop.first) + np.exp(-1j * omega * loop.second)) / 2.0


def through_encoder(loop: Loop, omega: float) -> complex:
    """Loop of a scale error 1: (1 - q) of the estimate stays, q of the new strip comes in, the error of it."""
    return loop.q * ladder(loop, omega) / (1.0 - (1.0 - loop.q) * complex(np.exp(-1j * omega)))


def plain_feedback(loop: Loop, omega: float) -> complex:
    """Loop of a controller without an encoder, which turns the mount by q of each crab that it sees."""
    return loop.q * ladder(loop, omega) / (1.0 - complex(np.exp(-1j * omega)))


class Margin(NamedTuple):
    """gain: factor; phase: deg, NaN if the loop gain is below 1 everywhere; delay: steps."""

    gain: float
    phase: float
    delay: float


def margin(loop: Loop, open_loop: Callable[[Loop, float], complex], sign: float = 1.0) -> Margin:
    """Of 1 + sign x open loop: the gain at which it oscillates, the phase and the delay that it has to spare."""
    grid = np.linspace(1e-6, math.pi, 20001)
    values = sign * np.array([open_loop(loop, w) for w in grid])
    crossings = [
        brentq(lambda w: (sign * open_loop(loop, w)).imag, grid[k], grid[k + 1])
        for k in np.flatnonzero(np.diff(np.sign(values.imag)) != 0)
    ]
    if abs(values[0].imag) < 1e-3 * abs(values[0]):  # at rest
        crossings.append(grid[0])
    reals = [(sign * open_loop(loop, at)).real for at in crossings]
    gains = [-1.0 / real for real in reals if real < 0.0]
    phase = delay = math.nan
    for k in np.flatnonzero(np.diff(np.sign(np.abs(values) - 1.0)) != 0)[:1]:
        at = brentq(lambda w: abs(open_loop(loop, w)) - 1.0, grid[k], grid[k + 1])
        phase = math.degrees((np.angle(sign * open_loop(loop, at)) + math.pi) % (2.0 * math.pi))
        delay = math.radians(phase) / at
    return Margin(min(gains, default=math.inf), phase, delay)


def simulated(loop: Loop, scale: float, steps: int, plain: bool = False, late: int = 0) -> Array:
    """Estimates after a disturbance of 1 at step 0, drift 0: the loop itself, step by step.

    scale: error of the encoder's scale against that of the rows, or factor on the gain of `plain`.
    late: further steps of delay.
    """
    lag = max(loop.first, loop.second) + late
    x = np.zeros(steps + lag)
    x[:lag] = 1.0
    for k in range(lag, len(x)):
        yaw = (x[k - loop.first - late] + x[k - loop.second - late]) / 2.0
        if plain:
            x[k] = x[k - 1] - scale * loop.q * yaw
        else:
            x[k] = (1.0 - loop.q) * x[k - 1] + loop.q * scale * yaw
    return x


def gains(file: Path) -> None:
    """Series (15) and (17) from q = 1, and the weight that the first strip keeps with each."""
    steps = np.arange(31)
    slow, fast = [1.0], [1.0]
    limit = stationary_gain(0.01)
    for _ in steps[1:]:
        slow.append(next_gain_riccati(slow[-1], 0.01))
        fast.append(next_gain_halving(fast[-1], limit))
    with plots.style() as figure_class:
        figure = figure_class(figsize=(9.0, 3.6), layout="constrained", dpi=120)
        left, right = figure.subplots(1, 2)
        for values, name, colour in ((slow, "(15), Riccati", COLOURS[2]), (fast, "(17), halving", COLOURS[0])):
            left.plot(steps, values, marker=".", color=colour, label=name)
            q = np.array(values)
            right.plot(steps, weight_of_first(q), marker=".", color=colour, label=name)
        left.axhline(limit, color="#8c8c8c", lw=0.8)
        left.annotate(
            f"limit {limit:.4f}", (30, limit), ha="right", va="top", xytext=(0, -3), textcoords="offset points"
        )
        left.set(xlabel="strip", ylabel="gain q", ylim=(0, 1.03))
        right.set(xlabel="strip", ylabel="weight of the first strip", yscale="log")
        left.legend()
        save(figure, file)


def weight_of_first(q: Array) -> Array:
    """Share of the first strip in the estimate, after each strip."""
    return np.cumprod(np.r_[1.0, 1.0 - q[1:]])


def variance_of(q: Array, gamma: float = 0.01) -> Array:
    """Error variance over N0 of a filter that uses these gains on a walk of this gamma, from the first strip on.

    K_j = (1 - q_j)^2 (K_{j-1} + gamma) + q_j^2: holds for any gain; (14) is its least.
    """
    found = [1.0]
    for each in q[1:]:
        found.append((1.0 - each) ** 2 * (found[-1] + gamma) + each**2)
    return np.array(found)


def steps(file: Path) -> None:
    """Step responses of the three loops: heading and track."""
    with plots.style() as figure_class:
        figure = figure_class(figsize=(9.0, 3.6), layout="constrained", dpi=120)
        axes = figure.subplots(1, 2, sharey=True)
        for ax, along, title in zip(
            axes, (False, True), ("step of the heading", "step of the track"), strict=True
        ):
            for loop, colour in zip(LOOPS, COLOURS, strict=True):
                t, x = step_response(loop, 300.0, along)
                ax.plot(t, x, color=colour, label=loop.name)
            ax.axhline(1.0, color="#8c8c8c", lw=0.8)
            ax.set(xlabel="time [s]", title=title, ylim=(0, 1.05))
        axes[0].set(ylabel="estimate / step")
        axes[0].legend(loc="lower right")
        save(figure, file)


def save(figure: object, file: Path) -> None:
    """As the other pictures."""
    from make_figures import save as save_png

    save_png(figure, file)


def main() -> None:
    """Pictures, and the figures of the text."""
    gains(IMAGES / "gain_series.png")
    steps(IMAGES / "loop_steps.png")
    for loop in LOOPS:
        for along in (False, True):
            t, x = step_response(loop, 2000.0, along)
            shown = ", ".join(f"{100 * s:.0f} % after {time_to(s, t, x):.1f} s" for s in (0.632, 0.9))
            print(f"{loop.name}, q {loop.q:.4f}, {'track' if along else 'heading'}: {shown}")
        print("  encoder error +1:", margin(loop, through_encoder, -1.0), " -1:", margin(loop, through_encoder))
        print("  plain feedback:", margin(loop, plain_feedback))
    k = [100.0]
    for _ in range(10):
        k.append(next_variance(k[-1], 0.25, 25.0))
    print("K from 100 deg2, printed gamma:", np.round(k, 2))


if __name__ == "__main__":
    main()
