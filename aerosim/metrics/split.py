"""Where the residual comes from: crab and v/h error on the survey lines, split by cause.

The error at each moment is a sum of parts; a figure of a part is its root mean square.  What the mean squares of
the parts leave of the measured one (cross terms) is `rest`, with the sign of its square: so the squares of the
figures, that of rest with its sign, add up to the square of the measured rms.  docs/controller.md derives it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.frames import Array, wrap_pi
from aerosim.metrics.replay import Gains, Mean, centred_mean
from aerosim.recorder import Columns

CRAB_PARTS = ("fast_yaw", "lag", "noise", "convergence", "mount")
VH_PARTS = ("fast_speed", "lag", "relief", "noise", "convergence")
REST = "rest"
TINY = 1e-6  # deg, or shares of v/h: the estimate is the truth
AGAIN = 0.05  # of the error: a filter in whole numbers is only so well run again in real ones
OTHER_FILTER = "the estimate is not that of a scalar filter over the strips: rest holds what is wrong with it"
NO_STRIP = "no strip was accepted, so the time that one averages over is not known"


class Split(NamedTuple):
    """Root mean square of each part, in the unit of the error; None where it cannot be told, and why."""

    rms: dict[str, float | None]
    reason: str


class _Strips(NamedTuple):
    """Accepted strips in the order of their decisions: gains, times of both exposures and of the decision, s."""

    rows: NDArray[np.bool_]
    gains: Gains
    begin: Array
    end: Array
    decided: Array


def _strips(matches: Columns, gain: str) -> _Strips:
    rows = np.asarray(matches["accepted"] & np.isfinite(matches[gain]))
    begin, end, decided = (matches[name][rows] for name in ("t_row1_s", "t_row2_s", "t_decided_s"))
    return _Strips(rows, Gains(decided, matches[gain][rows]), begin, end, decided)


def strip_time(matches: Columns) -> float | None:
    """Time that a strip averages over, s: the median of the accepted ones; None if there are none."""
    spans = (matches["t_row2_s"] - matches["t_row1_s"])[matches["accepted"]]
    spans = spans[np.isfinite(spans)]
    return float(np.median(spans)) if len(spans) else None


def _result(error: Array, parts: dict[str, Array], names: tuple[str, ...], reason: str) -> Split:
    """Figures of the parts over the samples (n,); parts that are not given are not known."""
    squares = {name: float(np.mean(part**2)) for name, part in parts.items()}
    rest = float(np.mean(error**2)) - sum(squares.values())
    rms: dict[str, float | None] = {
        name: float(np.sqrt(squares[name])) if name in squares else None for name in names
    }
    return Split(rms | {REST: float(np.copysign(np.sqrt(abs(rest)), rest))}, reason)


def _unknown(names: tuple[str, ...], reason: str) -> Split:
    return Split(dict.fromkeys((*names, REST)), reason)


def split_crab(tel: Columns, matches: Columns, used: NDArray[np.bool_]) -> Split:
    """Split of the crab (true drift less mount yaw), deg.

    fast_yaw: drift faster than a strip sees (less its centred mean over the strip time), and what the same
    swinging of the nose puts into the strips, which know the headings of two moments only.  lag: that mean now
    less the filter's mix of the true means of its strips.  noise: the same mix of what the strips read wrong.
    convergence: what is left of the wrong reading of a line's first strip, and everything before it.  mount:
    estimate less mount yaw.  used: samples that count, (n,).

    A camera that stands along the airframe follows nothing: its crab is fast yaw and mount.  If the estimate is
    not what the recorded gains make of the strips, only fast yaw (what is left of it in the estimate's error) and
    mount are told, and the estimate's slow error is in rest.
    """
    span = strip_time(matches)
    if span is None or not used.any():
        return _unknown(CRAB_PARTS, NO_STRIP if used.any() else "")
    t, line, crab = tel["t_s"], tel["line"], tel["crab_true_deg"]
    drift, yaw, estimate = tel["drift_true_deg"], tel["mount_yaw_deg"], tel["drift_est_deg"]
    slow = centred_mean(t, drift, line, span)
    known = np.isfinite(estimate)
    command = np.where(known, estimate, yaw)
    zero = np.zeros(len(t))
    if not yaw[used].any():
        parts = dict.fromkeys(CRAB_PARTS, zero) | {"fast_yaw": drift - slow, "mount": slow - yaw}
    elif _small((drift - command)[used]):
        parts = dict.fromkeys(CRAB_PARTS, zero) | {"mount": command - yaw}
    else:
        causes = _crab_causes(tel, matches, used & known, slow)
        if causes is None:
            left = drift - command
            fast = left - centred_mean(t, left, line, span)
            parts = {"fast_yaw": fast, "mount": command - yaw}
            return _result(crab[used], {k: v[used] for k, v in parts.items()}, CRAB_PARTS, OTHER_FILTER)
        blind = dict.fromkeys(CRAB_PARTS, zero) | {"fast_yaw": drift - slow, "convergence": slow - yaw}
        parts = {name: np.where(known, part, blind[name]) for name, part in causes.items()}
        parts["mount"] = command - yaw
    return _result(crab[used], {k: v[used] for k, v in parts.items()}, CRAB_PARTS, "")


def _small(error: Array) -> bool:
    return bool(np.all(np.abs(error) < TINY))


def _runs_again(difference: Array, error: Array) -> bool:
    """Whether the filter run again gave the recorded estimate: differences and errors, (n,)."""
    return bool(np.sum(difference**2) <= AGAIN**2 * np.sum(error**2))


def own_filter(tel: Columns, matches: Columns, used: NDArray[np.bool_]) -> bool:
    """Whether the estimate may be that of the filters whose gains and innovations are recorded.

    False only if it is seen to be another: somebody was told, and the filters ran beside.  used: samples, (n,).
    """
    samples = used & np.isfinite(tel["drift_est_deg"])
    strips = _strips(matches, "gain_drift")
    if not strips.rows.any() or not samples.any():
        return True
    return _crab_causes(tel, matches, samples, np.zeros(len(used))) is not None


def _crab_causes(
    tel: Columns, matches: Columns, samples: NDArray[np.bool_], slow: Array
) -> dict[str, Array] | None:
    """Parts of the estimate's error, deg, (n,), good at the samples; None if its filter cannot be run again."""
    strips = _strips(matches, "gain_drift")
    t, at = tel["t_s"], strips.gains.at(tel["t_s"])
    read = matches["drift_deg"][strips.rows]
    if not len(read) or (at[samples] < 0).any():
        return None
    again = tel["drift_est_deg"] - strips.gains.over(read)[at]
    if not _runs_again(again[samples], (tel["drift_true_deg"] - tel["drift_est_deg"])[samples]):
        return None
    mean = Mean(t, tel["drift_true_deg"])(strips.begin, strips.end)
    seen = _seen_drift(tel, strips.begin, strips.end)
    noise, first = _wrong(strips.gains, read - seen)
    swing = strips.gains.over(seen - mean)
    return {
        "fast_yaw": tel["drift_true_deg"] - slow - swing[at],
        "lag": slow - strips.gains.over(mean)[at],
        "noise": -noise[at],
        "convergence": -first[at],
    }


def _wrong(gains: Gains, wrong: Array) -> tuple[Array, Array]:
    """The filter's mix of wrong readings (n,): of all strips but a line's first, and of that one."""
    return gains.over(np.where(gains.begins, 0.0, wrong)), gains.over(np.where(gains.begins, wrong, 0.0))


def _seen_drift(tel: Columns, begin: Array, end: Array) -> Array:
    """Drift that a strip would read without error, deg: its way's direction less the mean of two headings."""
    north, east = (Mean(tel["t_s"], tel[f"v_{axis}_m_s"])(begin, end) for axis in ("north", "east"))
    heading = np.unwrap(np.radians(tel["heading_deg"]))
    ends = (np.interp(begin, tel["t_s"], heading) + np.interp(end, tel["t_s"], heading)) / 2.0
    return np.degrees(wrap_pi(np.arctan2(east, north) - ends))


def split_vh(tel: Columns, matches: Columns, used: NDArray[np.bool_]) -> Split:
    """Split of the v/h error (estimate over truth, less one), %.

    The filter runs on n, so on h/v.  Its parts are those of the crab, of h/v with the line's mean height of the
    ground: fast_speed (speed faster than a strip sees), lag; noise and convergence are of the strips' readings.
    relief: what the height of the ground about that mean adds, now and in the strips.  used: samples, (n,); those
    without an estimate, or over no terrain, do not count.  Another filter: only fast_speed is told, the rest is in
    rest.
    """
    error = tel["vh_est_per_s"] / tel["vh_true_per_s"] - 1.0
    samples = used & np.isfinite(error)
    span = strip_time(matches)
    if span is None or not samples.any():
        return _unknown(VH_PARTS, NO_STRIP if used.any() and span is None else "")
    if _small(error[samples]):
        parts = dict.fromkeys(VH_PARTS, np.zeros(len(error)))
    else:
        causes = _vh_causes(tel, matches, samples, span)
        if causes is None:
            known = np.where(np.isfinite(error), error, 0.0)
            fast = known - centred_mean(tel["t_s"], known, tel["line"], span)
            return _result(100.0 * error[samples], {"fast_speed": 100.0 * fast[samples]}, VH_PARTS, OTHER_FILTER)
        parts = causes
    return _result(100.0 * error[samples], {k: 100.0 * v[samples] for k, v in parts.items()}, VH_PARTS, "")


def _vh_causes(tel: Columns, matches: Columns, samples: NDArray[np.bool_], span: float) -> dict[str, Array] | None:
    """Parts of the error as shares, (n,), good at the samples; None if the filter cannot be run again."""
    strips = _strips(matches, "gain_vh")
    t, line, at = tel["t_s"], tel["line"], strips.gains.at(tel["t_s"])
    read, seen = (1.0 / matches[name][strips.rows] for name in ("vh_per_s", "vh_true_per_s"))
    if not len(read) or (at[samples] < 0).any() or not np.isfinite(seen).all():
        return None
    estimate = 1.0 / tel["vh_est_per_s"]
    again = strips.gains.over(read)[at] / estimate - 1.0
    if not _runs_again(again[samples], (tel["vh_est_per_s"] / tel["vh_true_per_s"] - 1.0)[samples]):
        return None
    speed = np.hypot(tel["v_north_m_s"], tel["v_east_m_s"])
    now = 1.0 / tel["vh_true_per_s"]
    ground = _mean_ground(tel["height_m"] - speed * now, line, samples)
    flat = tel["height_m"] - ground
    slow = centred_mean(t, flat, line, span) / centred_mean(t, speed, line, span)
    of_strip = ground[np.clip(np.searchsorted(t, strips.decided + 1e-6, side="right") - 1, 0, None)]
    height = Mean(t, tel["height_m"])(strips.begin, strips.end) - of_strip
    mean = height / Mean(t, speed)(strips.begin, strips.end)
    noise, first = _wrong(strips.gains, read - seen)
    return {
        "fast_speed": (flat / speed - slow) / estimate,
        "lag": (slow - strips.gains.over(mean)[at]) / estimate,
        "relief": (now - flat / speed - strips.gains.over(seen - mean)[at]) / estimate,
        "noise": -noise[at] / estimate,
        "convergence": -first[at] / estimate,
    }


def _mean_ground(ground: Array, line: NDArray[np.int64], samples: NDArray[np.bool_]) -> Array:
    """Mean height of the ground below the line that is flown, or flown next, (n,), m; NaN where none counts."""
    count = np.arange(len(line))
    coming = np.minimum.accumulate(np.where(line >= 0, count, len(line) - 1)[::-1])[::-1]
    out = np.full(len(line), np.nan)
    for number in set(line[samples].tolist()):
        out[line[coming] == number] = ground[samples & (line == number)].mean()
    return out
