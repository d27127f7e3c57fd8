"""Records of a made-up camera with one cause of error each: a filter over strips, without rows and ground."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from aerosim.estimation.kalman import ScalarFilter
from aerosim.frames import Array

RATE = 20  # Hz
LENGTH, START, COUNTED = 600.0, 60.0, 120.0  # s: of the record, of its one line, of what counts
SPAN, LATE, APART = 13.0, 0.4, 1.0  # s: strip time, decision after row II, from strip to strip
SPEED, GROUND = 70.0, 400.0
Of = Callable[[Array], Array]


def still(value: float) -> Of:
    """A quantity that stays."""
    return lambda t: np.full_like(np.asarray(t, float), value)


def record(
    drift: Of = still(8.0),  # noqa: B008
    speed: Of = still(SPEED),  # noqa: B008
    ground: Of = still(GROUND),  # noqa: B008
    wrong_drift: Of = still(0.0),  # noqa: B008
    wrong_vh: Of = still(0.0),  # noqa: B008
    mount: float = 0.0,
    gamma: float = 0.05,
    word: float = 0.0,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Telemetry and matches: east along one line, the nose swinging; the mount stands `mount` deg beside.

    drift: deg, speed: m/s, ground: m, of time.  wrong_drift (deg), wrong_vh (share): what a strip reads wrong, of
    the time of its first row.  word: the drift filter's resolution, deg, if it runs in whole numbers.
    """
    t = np.arange(round(LENGTH * RATE)) / RATE
    begin = np.arange(0.0, LENGTH - SPAN - 1.0, APART)
    end, decided = begin + SPAN, begin + SPAN + LATE
    seen = (drift(begin) + drift(end)) / 2.0
    within = np.linspace(begin, end, 261)
    way = np.trapezoid(speed(within), within, axis=0)
    true_vh = way / SPAN / (3400.0 - ground((begin + end) / 2.0))
    read, read_vh = seen + wrong_drift(begin), true_vh * (1.0 + wrong_vh(begin))
    filters = ScalarFilter(gamma, 25.0), ScalarFilter(gamma, 1.0)
    found: list[tuple[float, ...]] = []
    for one, other in zip(read, read_vh, strict=True):
        innovations = filters[0].update(one), filters[1].update(1.0 / other)
        if word:
            filters[0].estimate = word * round(filters[0].estimate / word)
        found.append((filters[0].estimate, filters[1].estimate, filters[0].gain, filters[1].gain, *innovations))
    estimate, inverse, gain, gain_vh, innovation, innovation_vh = np.array(found).T
    at = np.searchsorted(decided, t + 1e-9, side="right") - 1
    believed = np.where(at >= 0, estimate[at], np.nan)
    yaw = np.where(at >= 0, estimate[at], 0.0) + mount
    telemetry = {
        "t_s": t, "line": np.where(t >= START, 0, -1), "height_m": np.full(len(t), 3400.0),
        "heading_deg": 90.0 - drift(t), "v_north_m_s": 0.0 * t, "v_east_m_s": speed(t), "drift_true_deg": drift(t),
        "mount_yaw_deg": yaw, "crab_true_deg": drift(t) - yaw, "drift_est_deg": believed,
        "vh_true_per_s": speed(t) / (3400.0 - ground(t)),
        "vh_est_per_s": np.where(at >= 0, 1.0 / inverse[at], np.nan),
    }  # fmt: skip
    matches = {
        "t_row1_s": begin, "t_row2_s": end, "t_decided_s": decided, "drift_deg": read, "vh_per_s": read_vh,
        "vh_true_per_s": true_vh, "gain_drift": gain, "gain_vh": gain_vh, "innovation_drift": innovation,
        "innovation_vh": innovation_vh, "accepted": np.ones(len(begin), bool),
    }  # fmt: skip
    return telemetry, matches


def counted(telemetry: dict[str, Any], until: float = LENGTH - SPAN) -> Any:
    """Samples that count: without the filter's start, and the end, where the mean's span shrinks."""
    return (telemetry["t_s"] >= COUNTED) & (telemetry["t_s"] < until)
