"""The hot kernels against bare ones on as much input: a row against cv2.remap, MAD against a bare SIMD sum."""

from __future__ import annotations

import time
from collections.abc import Callable

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

from aerosim.estimation.mad import correlate
from aerosim.estimation.tracking.window import surface
from aerosim.scenario import load_scenario
from aerosim.scenario.build import build
from aerosim.sensing.row_kernel import expose_row

STRIPS, SHIFTS, PIXELS, ROW = 64, 15, 96, 110
ROUNDS, REPEAT = 40, 40
STEPS = 27  # exposures of a window of `best` with an inertial unit


def microseconds(call: Callable[[], object]) -> float:
    """Shortest time of a call, us: what others do on the machine makes any of them longer."""
    call()
    times = []
    for _ in range(ROUNDS):
        started = time.perf_counter()
        for _ in range(REPEAT):
            call()
        times.append((time.perf_counter() - started) / REPEAT * 1e6)
    return min(times)


@njit(fastmath=True)
def bare_sum(rows: NDArray[np.float32], row: NDArray[np.float32], out: NDArray[np.float32]) -> None:
    for s in range(rows.shape[0]):
        for k in range(out.shape[1]):
            total = np.float32(0.0)
            for i in range(row.shape[0]):
                total += abs(rows[s, k + i] - row[i])
            out[s, k] = total


def matching() -> tuple[float, float]:
    """MAD of 64 strips x 15 shifts x 96 px, and the bare sum, us."""
    rng = np.random.default_rng(1)
    rows = rng.normal(0.0, 20.0, (STRIPS, PIXELS + SHIFTS - 1)).astype(np.float32)
    row = rows[0, 7:-7].copy()
    surfaces = np.zeros((STRIPS, 4, SHIFTS), np.float32)
    least, at, ready = np.zeros(STRIPS, np.float32), np.zeros(STRIPS, np.int64), np.zeros(STRIPS, np.bool_)
    steps = np.zeros(STRIPS, np.int64)

    def ours() -> None:
        steps[:] = 0
        correlate(row, rows, steps, 9, surfaces, least, at, ready)

    out = np.zeros((STRIPS, SHIFTS), np.float32)
    return microseconds(ours), microseconds(lambda: bare_sum(rows, row, out))


def windowing() -> tuple[float, float]:
    """MAD surface of a strip of `best`, and the bare sum of as many differences, us."""
    rng = np.random.default_rng(1)
    rows2 = rng.normal(0.0, 20.0, (512, PIXELS)).astype(np.float32)
    row1 = rng.normal(0.0, 20.0, PIXELS + SHIFTS - 1).astype(np.float32)
    weights, bow = np.ones(PIXELS, np.float32), np.zeros(PIXELS)
    rows, out = np.tile(row1, (STEPS, 1)), np.zeros((STEPS, SHIFTS), np.float32)
    return (
        microseconds(lambda: surface(row1, rows2, weights, 500, STEPS, 0, SHIFTS // 2, 0.1, bow)),
        microseconds(lambda: bare_sum(rows, rows2[0], out)),
    )


def seeing() -> tuple[float, float]:
    """One row of 110 px over relief with footprint, smear and noise, and cv2.remap of 4 x 110 points, us."""
    mission = build(load_scenario("crosswind"))
    lat, lon = np.mean([mission.flight.plan.lines[0].start, mission.flight.plan.lines[0].end], axis=0)
    aircraft = mission.flight.state()._replace(lat=float(lat), lon=float(lon))
    pose = mission.mount.pose(aircraft)
    spot = mission.ground.around(aircraft.lat, aircraft.lon, mission.rows.reach(aircraft.height))
    grey, noise = np.zeros(ROW, np.float32), np.zeros(ROW, np.float32)
    rays = np.stack([np.full(ROW, -19.85), np.arange(ROW) - (ROW - 1) / 2.0])
    optics = np.array([132.6, 1.0, 1.0, 0.01])
    converter = np.array([1.0, 0.0, 1.5, 255.0])

    def ours() -> None:
        expose_row(
            grey, noise, rays, optics, converter, pose.height, pose.mat_nc, pose.vel_n, pose.omega_nc_c,
            spot.grid, spot.ortho, spot.ortho_place, spot.relief, spot.relief_place, 500.0,
            spot.shade, spot.shade_place,
        )  # fmt: skip

    ours()
    if not grey.any():
        raise SystemExit("the row sees nothing")
    at = np.random.default_rng(1).uniform(10, 400, (2, 1, 4 * ROW)).astype(np.float32)
    return microseconds(ours), microseconds(lambda: cv2.remap(spot.ortho, at[0], at[1], cv2.INTER_LINEAR))


def main() -> None:
    """Print times and ratios."""
    ours, bare = matching()
    print(f"MAD of {STRIPS} strips: {ours:.1f} us (goal 20), {ours / bare:.2f} of the bare sum")
    ours, bare = windowing()
    print(f"window of best, {STEPS} exposures x {SHIFTS} shifts: {ours:.1f} us, {ours / bare:.2f} of the bare sum")
    ours, bare = seeing()
    print(f"row of {ROW} px: {ours:.1f} us (goal 10), {ours / bare:.2f} of cv2.remap of 4 x {ROW} points")


if __name__ == "__main__":
    main()
