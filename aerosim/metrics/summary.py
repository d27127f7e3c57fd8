"""The figures of summary.json: statistics over the survey lines, without the start of each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.frames import Array
from aerosim.metrics.consistency import FEWEST, judge, overconfident
from aerosim.metrics.lock import bad_share, silence
from aerosim.metrics.split import own_filter, split_crab, split_vh, strip_time
from aerosim.recorder import Columns

SETTLED_DEG = 2.0
SETTLED_S = 10.0
LOST_PCT = 50.0


class Wanted(NamedTuple):
    """What the flight was to keep: ellipsoidal height (m), true airspeed (m/s), end lap (%)."""

    height: float
    airspeed: float
    end_lap_pct: float
    exclude_first_s: float


def summarise(telemetry: Columns, matches: Columns, photos: Columns, wanted: Wanted) -> dict[str, Any]:
    """Sections flight, crab, vh, consistency, photos and notes of summary.json.

    Everything but counts is over the survey lines without the first `exclude_first_s` of each: a fixed time,
    since a rule about settling would reward slow controllers.  What could not be measured is None, with the
    reason under its path in notes; there are also lines on which the track was not seen.
    """
    t, line = telemetry["t_s"], telemetry["line"]
    starts = _line_starts(t, line)
    used = _used(t, line, starts, wanted.exclude_first_s)
    notes: dict[str, str] = {}
    summary: dict[str, Any] = {
        "flight": _flight(telemetry, used, starts, wanted),
        "crab": _crab(telemetry, matches, used, starts, wanted.exclude_first_s),
        "vh": _vh(telemetry, matches, used, starts, wanted.exclude_first_s),
        "consistency": {},
        "photos": _photos(photos, starts, wanted),
    }
    reasons = {"photos.side_lap_min_pct": "side lap is not computed in this version"}
    reasons |= _add_splits(summary, telemetry, matches, used)
    reasons |= _add_consistency(summary, telemetry, matches, used, starts, wanted.exclude_first_s)
    reason = _reason(used, matches)
    for section, values in summary.items():
        notes |= _nulls(values, section, reasons, reason)
    summary["notes"] = notes | _lines_not_seen(telemetry, matches, starts) | _warnings(summary)
    return summary


def _nulls(values: dict[str, Any], section: str, reasons: Mapping[str, str], otherwise: str) -> dict[str, str]:
    """Set what is no number to None; why, by path.  reasons: by path, or by the path above it."""
    found: dict[str, str] = {}
    for name, value in values.items():
        path = f"{section}.{name}"
        if isinstance(value, dict):
            found |= _nulls(value, path, reasons, reasons.get(path) or otherwise)
        elif value is None or (isinstance(value, float) and not np.isfinite(value)):
            values[name] = None
            found[path] = reasons.get(path) or otherwise
    return found


def _add_splits(
    summary: dict[str, Any], tel: Columns, matches: Columns, used: NDArray[np.bool_]
) -> dict[str, str]:
    """Put crab.split_deg and vh.split_pct in; why a part is not known, by path."""
    crab, vh = split_crab(tel, matches, used), split_vh(tel, matches, used)
    summary["crab"]["split_deg"], summary["vh"]["split_pct"] = crab.rms, vh.rms
    return {"crab.split_deg": crab.reason, "vh.split_pct": vh.reason}


def _add_consistency(
    summary: dict[str, Any],
    tel: Columns,
    matches: Columns,
    used: NDArray[np.bool_],
    starts: dict[int, float],
    exclude: float,
) -> dict[str, str]:
    """Put the judgement on the filters' innovations in; why there is none, by path."""
    strips = _strips_used(matches, starts, tel, exclude) & matches["accepted"]
    own = own_filter(tel, matches, used)
    line, in_flight = _lines_of(matches["t_decided_s"], tel), _in_flight(matches)
    for name in ("drift", "vh"):
        innovations = matches[f"innovation_{name}"]
        there = strips & np.isfinite(innovations) & own
        summary["consistency"][name] = judge(innovations[there], line[there], in_flight)._asdict()
    few = f"fewer than {FEWEST} strips with an innovation"
    told = "the estimate is not that of the filters over the strips"
    return {f"consistency.{name}": few if own else told for name in ("drift", "vh")}


def _in_flight(matches: Columns) -> int:
    """How many strips are in flight together."""
    span, begins = strip_time(matches), np.sort(matches["t_row1_s"])
    apart = np.diff(begins)
    return 1 if span is None or not len(apart) else max(1, round(span / float(np.median(apart))))


def _warnings(summary: Mapping[str, Any]) -> dict[str, str]:
    """Notes about filters that are wrong by more than they say."""
    return {f"consistency.{name}": text for name, text in overconfident(summary).items()}


def _lines_not_seen(tel: Columns, matches: Columns, starts: dict[int, float]) -> dict[str, str]:
    """Lines with few strips accepted: their crab and v/h are not to be trusted, whatever the means say."""
    line = _lines_of(matches["t_decided_s"], tel)
    found = {}
    for number in starts:
        accepted = matches["accepted"][line == number]
        if len(accepted) and 100.0 * accepted.mean() < LOST_PCT:
            share = f"only {100.0 * accepted.mean():.0f} % of its {len(accepted)} strips were accepted"
            found[f"line {number}"] = share
    return found


def lines_not_seen(summary: Mapping[str, Any]) -> list[str]:
    """Sentences about the lines of a summary on which the track was not seen."""
    return [f"{key}: {text}" for key, text in (summary.get("notes") or {}).items() if key.startswith("line ")]


def _reason(used: NDArray[np.bool_], matches: Columns) -> str:
    if not used.any():
        return "no survey line was flown beyond record.exclude_first_s"
    if not matches["accepted"].any():
        return "no strip was accepted"
    return "too little was recorded on the survey lines"


def _line_starts(t: Array, line: NDArray[np.int64]) -> dict[int, float]:
    """First time on each survey line, s."""
    numbers = sorted(set(line[line >= 0].tolist()))
    return {number: float(t[np.argmax(line == number)]) for number in numbers}


def _used(t: Array, line: NDArray[np.int64], starts: dict[int, float], exclude: float) -> NDArray[np.bool_]:
    used = np.zeros(len(t), bool)
    for number, start in starts.items():
        used |= (line == number) & (t >= start + exclude)
    return used


def _rms(values: Array) -> float:
    values = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")


def _mean(values: Array) -> float:
    values = values[np.isfinite(values)]
    return float(values.mean()) if len(values) else float("nan")


def _flight(tel: Columns, used: NDArray[np.bool_], starts: dict[int, float], wanted: Wanted) -> dict[str, Any]:
    def rms_about_mean(name: str) -> float:
        return _rms(tel[name][used] - _mean(tel[name][used]))

    # lines run in several directions, so that their drifts differ in sign: the mean of the lines' sizes
    drifts = [abs(_mean(tel["drift_true_deg"][used & (tel["line"] == number)])) for number in starts]
    return {
        "duration_s": float(tel["t_s"][-1]) if len(tel["t_s"]) else None,
        "lines": len(starts),
        "cross_track_rms_m": _rms(tel["cross_track_m"][used]),
        "height_rms_m": _rms(tel["height_m"][used] - wanted.height),
        "airspeed_rms_m_s": _rms(tel["airspeed_m_s"][used] - wanted.airspeed),
        "roll_rms_deg": rms_about_mean("roll_deg"),
        "pitch_rms_deg": rms_about_mean("pitch_deg"),
        "roll_rate_rms_deg_s": _rms(tel["p_deg_s"][used]),
        "pitch_rate_rms_deg_s": _rms(tel["q_deg_s"][used]),
        "yaw_rate_rms_deg_s": _rms(tel["r_deg_s"][used]),
        "drift_mean_deg": _mean(np.array(drifts)),
    }


def _strips_used(matches: Columns, starts: dict[int, float], tel: Columns, exclude: float) -> NDArray[np.bool_]:
    """Strips decided on a survey line, after its start was left out."""
    decided = matches["t_decided_s"]
    line = _lines_of(decided, tel)
    begin = np.array([starts.get(int(number), np.inf) for number in line])
    return np.asarray((line >= 0) & (decided >= begin + exclude))


def _lines_of(times: Array, tel: Columns) -> NDArray[np.int64]:
    """Line that was flown at each of the times (n,), s; -1: none."""
    if not len(tel["t_s"]):
        return np.full(len(times), -1)
    at = np.searchsorted(tel["t_s"], times, side="right") - 1
    return np.where(at >= 0, tel["line"][np.maximum(at, 0)], -1)


def _counted(tel: Columns, used: NDArray[np.bool_]) -> dict[int, tuple[float, float]]:
    """From when to when each line counts, s."""
    t, line = tel["t_s"][used], tel["line"][used]
    return {
        number: (float(t[line == number][0]), float(t[line == number][-1])) for number in np.unique(line).tolist()
    }


def _settle(tel: Columns, starts: dict[int, float]) -> float:
    """Mean time until the crab is small and stays so for SETTLED_S, or to the line's end; lines that never do
    are left out."""
    times = []
    for number, start in starts.items():
        here = tel["line"] == number
        t, large = tel["t_s"][here], np.abs(tel["crab_true_deg"][here]) > SETTLED_DEG
        after = np.append(t[large], np.inf)
        calm = after[np.searchsorted(after, t, side="left")] - t > SETTLED_S
        times.append(float(t[np.argmax(calm)] - start) if calm.any() else float("nan"))
    return _mean(np.array(times))


def _crab(
    tel: Columns, matches: Columns, used: NDArray[np.bool_], starts: dict[int, float], exclude: float
) -> dict[str, Any]:
    crab = tel["crab_true_deg"][used]
    strips = _strips_used(matches, starts, tel, exclude)
    accepted = matches["accepted"][strips]
    silent = silence(matches, _counted(tel, used))
    return {
        "residual_rms_deg": _rms(crab),
        "residual_mean_deg": _mean(crab),
        "residual_max_deg": float(np.abs(crab).max()) if len(crab) else None,
        "estimate_error_rms_deg": _rms(tel["crab_est_deg"][used] - crab),
        "settle_s": _settle(tel, starts),
        "strips": int(strips.sum()),
        "accepted_pct": float(100.0 * accepted.mean()) if len(accepted) else None,
        "bad_pct": bad_share(matches, strips),
        "silent_max_s": silent[0],
        "silent_end_s": silent[1],
    }


def _vh(
    tel: Columns, matches: Columns, used: NDArray[np.bool_], starts: dict[int, float], exclude: float
) -> dict[str, Any]:
    error = 100.0 * (tel["vh_est_per_s"][used] / tel["vh_true_per_s"][used] - 1.0)
    strips = _strips_used(matches, starts, tel, exclude) & matches["accepted"]
    strip_error = 100.0 * (matches["vh_per_s"][strips] / matches["vh_true_per_s"][strips] - 1.0)
    return {"error_rms_pct": _rms(error), "error_mean_pct": _mean(error), "strip_error_rms_pct": _rms(strip_error)}


def _photos(photos: Columns, starts: dict[int, float], wanted: Wanted) -> dict[str, Any]:
    begin = np.array([starts.get(int(number), np.inf) for number in photos["line"]])
    late = photos["t_s"] >= begin + wanted.exclude_first_s
    lap, blur = photos["end_lap_pct"][late], photos["blur_px"][late]
    known = lap[np.isfinite(lap)]
    return {
        "count": len(photos["t_s"]),
        "end_lap_mean_pct": _mean(lap),
        "end_lap_error_rms_pct": _rms(lap - wanted.end_lap_pct),
        "end_lap_min_pct": float(known.min()) if len(known) else None,
        "side_lap_min_pct": None,
        "blur_rms_px": _rms(blur),
        "out_of_tolerance": int((photos["verdict"][late] != "ok").sum()),
    }
