"""The figures of summary.json by hand, on small tables."""

# ruff: noqa: E501  (lists of columns)

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from aerosim.metrics.summary import Wanted, lines_not_seen, summarise
from aerosim.record import plain
from aerosim.sweep.work import flat

WANTED = Wanted(height=3000.0, airspeed=70.0, end_lap_pct=60.0, exclude_first_s=2.0)


def telemetry(line: list[int], **columns: Any) -> dict[str, Any]:
    """One sample a second; columns not given are zero, v/h one."""
    names = (
        "cross_track_m height_m airspeed_m_s roll_deg pitch_deg p_deg_s q_deg_s r_deg_s drift_true_deg crab_true_deg "
        "crab_est_deg vh_true_per_s vh_est_per_s drift_est_deg mount_yaw_deg heading_deg v_north_m_s v_east_m_s"
    )
    out: dict[str, Any] = {name: np.zeros(len(line)) for name in names.split()}
    out |= {name: np.ones(len(line)) for name in ("vh_true_per_s", "vh_est_per_s")}
    out |= {"t_s": np.arange(float(len(line))), "line": np.array(line)}
    return out | {name: np.array(values, float) for name, values in columns.items()}


def strips(decided: list[float], accepted: list[bool], **columns: Any) -> dict[str, Any]:
    out = {"t_decided_s": np.array(decided, float), "accepted": np.array(accepted, bool)}
    out |= {name: np.ones(len(decided)) for name in ("vh_per_s", "vh_true_per_s")}
    unknown = (
        "t_row1_s t_row2_s angle_deg crab_true_deg drift_deg gain_drift gain_vh innovation_drift innovation_vh"
    )
    out |= {name: np.full(len(decided), np.nan) for name in unknown.split()}
    return out | {name: np.array(values, float) for name, values in columns.items()}


def shots(
    t: list[float], line: list[int], lap: list[float], blur: list[float], verdict: list[str]
) -> dict[str, Any]:
    return {
        "t_s": np.array(t, float), "line": np.array(line), "end_lap_pct": np.array(lap, float),
        "blur_px": np.array(blur, float), "verdict": np.array(verdict, object),
    }  # fmt: skip


NO_STRIPS, NO_PHOTOS = strips([], []), shots([], [], [], [], [])


def test_flight_by_hand() -> None:
    # line 0 from 1 s, line 1 from 7 s; the first 2 s of each do not count: 3, 4 and 9, 10 s do
    line = [-1, 0, 0, 0, 0, -1, -1, 1, 1, 1, 1]
    tel = telemetry(
        line,
        cross_track_m=[99, 99, 99, 3, -1, 99, 99, 99, 99, 1, -3],
        height_m=[0, 0, 0, 3001, 2999, 0, 0, 0, 0, 3003, 2997],
        airspeed_m_s=[0, 0, 0, 70, 72, 0, 0, 0, 0, 70, 70],
        roll_deg=[50, 50, 50, 4, 6, 50, 50, 50, 50, 4, 6],
        pitch_deg=[50, 50, 50, 2, 2, 50, 50, 50, 50, 2, 2],
        p_deg_s=[9, 9, 9, 2, -2, 9, 9, 9, 9, 2, 2],
        q_deg_s=[9, 9, 9, 0, 0, 9, 9, 9, 9, 0, 4],
        r_deg_s=[9, 9, 9, 1, 1, 9, 9, 9, 9, -1, -1],
        drift_true_deg=[99, 99, 99, 8, 9, 99, 99, 99, 99, -7, -6],
    )
    flight = summarise(tel, NO_STRIPS, NO_PHOTOS, WANTED)["flight"]
    assert flight == pytest.approx(
        {
            "duration_s": 10.0,
            "lines": 2,
            "cross_track_rms_m": np.sqrt((9 + 1 + 1 + 9) / 4),
            "height_rms_m": np.sqrt((1 + 1 + 9 + 9) / 4),
            "airspeed_rms_m_s": np.sqrt(4 / 4),
            "roll_rms_deg": 1.0,  # about its mean of 5 deg
            "pitch_rms_deg": 0.0,  # the trim is no motion
            "roll_rate_rms_deg_s": 2.0,
            "pitch_rate_rms_deg_s": 2.0,
            "yaw_rate_rms_deg_s": 1.0,
            "drift_mean_deg": (8.5 + 6.5) / 2,  # sizes of the lines' means: on the way back the sign turns
        }
    )


def test_crab_and_vh_by_hand() -> None:
    tel = telemetry(
        [-1, 0, 0, 0, 0, 0],
        crab_true_deg=[50, 8, -3, 1.5, -1, 2],
        crab_est_deg=[0, 0, 0, 1.5, 0, np.nan],
        vh_true_per_s=[9, 9, 9, 0.02, 0.02, 0.02],
        vh_est_per_s=[1, 1, 1, 0.0206, 0.0198, np.nan],
    )
    found = strips(
        [0.5, 2.9, 3.0, 4.0, 4.5, 5.0], [True, True, True, False, True, True],
        vh_per_s=[9, 9, 0.021, 9, 0.019, 0.02], vh_true_per_s=[1, 1, 0.02, 1, 0.02, 0.02],
        angle_deg=[9, 9, 1.6, 9, -1.51, 2], crab_true_deg=[0, 0, 1.1, 0, -1, np.nan],
    )  # fmt: skip
    summary = summarise(tel, found, NO_PHOTOS, WANTED)
    # without exposures and gains there is nothing to split, nor innovations to judge
    assert set(summary["crab"].pop("split_deg").values()) == {None} == set(summary["vh"].pop("split_pct").values())
    assert summary["consistency"]["drift"] == summary["consistency"]["vh"]
    assert summary["consistency"]["vh"].pop("strips") == 0
    assert set(summary["consistency"]["vh"].values()) == {None}
    assert summary["crab"] == pytest.approx(
        {
            "residual_rms_deg": np.sqrt((2.25 + 1 + 4) / 3),
            "residual_mean_deg": 2.5 / 3,
            "residual_max_deg": 2.0,
            "estimate_error_rms_deg": np.sqrt((0 + 1) / 2),  # where there is an estimate
            "settle_s": 2.0,  # from the line's start at 1 s until it is first within 2 deg, at 3 s
            "strips": 4,  # decided from 3 s on
            "accepted_pct": 75.0,
            "bad_pct": 50.0,  # of those at 3, 4.5 and 5 s one has no truth; 0.5 deg is not bad, 0.51 is
            "silent_max_s": 1.5,  # from 3 to 4.5 s
            "silent_end_s": 0.0,
        }
    )
    assert summary["vh"] == pytest.approx(
        {
            "error_rms_pct": np.sqrt((9 + 1) / 2),
            "error_mean_pct": 1.0,
            "strip_error_rms_pct": np.sqrt((25 + 25 + 0) / 3),
        }
    )


def test_the_largest_crab_may_be_to_the_left() -> None:
    tel = telemetry([0] * 5, crab_true_deg=[0, 0, 1, -7, 2])
    assert summarise(tel, NO_STRIPS, NO_PHOTOS, WANTED)["crab"]["residual_max_deg"] == 7.0


def test_settling_is_the_lines_mean() -> None:
    tel = telemetry([0, 0, 0, -1, 1, 1, 1, 1, 2, 2], crab_true_deg=[5, -1, 1, 0, -5, 1, -5, 1.9, 0, 4])
    # line 0 after 1 s, line 1 after 3 s for good; line 2 never, and says nothing about how long the others took
    assert summarise(tel, NO_STRIPS, NO_PHOTOS, WANTED)["crab"]["settle_s"] == 2.0


def test_settled_is_what_stays_small_for_ten_seconds() -> None:
    crab = [5] * 3 + [0] * 8 + [5] + [0] * 11 + [5] * 5
    tel = telemetry([0] * len(crab), crab_true_deg=crab)
    # small for 8 s from 3 s on does not count, small for 11 s from 12 s on does
    assert summarise(tel, NO_STRIPS, NO_PHOTOS, WANTED)["crab"]["settle_s"] == 12.0


def test_a_line_whose_track_was_not_seen_is_told() -> None:
    tel = telemetry([0] * 5 + [-1] * 3 + [1] * 5)
    found = strips([1, 2, 3, 9, 10, 11], [True, True, False, True, False, False])
    told = lines_not_seen(summarise(tel, found, NO_PHOTOS, WANTED))
    assert told == ["line 1: only 33 % of its 3 strips were accepted"]
    assert lines_not_seen(summarise(tel, NO_STRIPS, NO_PHOTOS, WANTED)) == []


def test_photos_by_hand() -> None:
    tel = telemetry([-1, 0, 0, 0, 0, 0, 0])
    photos = shots(
        [0.5, 1.0, 2.9, 3.0, 4.0, 5.0, 6.0], [-1, 0, 0, 0, 0, 0, 0], [99, np.nan, 20, 61, np.nan, 58, 62],
        [9, 9, 9, 1, 1, 1, 3], ["ok", "ok", "end_lap", "ok", "blur", "ok", "ok"],
    )  # fmt: skip
    found = summarise(tel, NO_STRIPS, photos, WANTED)["photos"]
    assert found.pop("side_lap_min_pct") is None
    assert found == pytest.approx(
        {
            "count": 7,
            "end_lap_mean_pct": (61 + 58 + 62) / 3,
            "end_lap_error_rms_pct": np.sqrt((1 + 4 + 4) / 3),
            "end_lap_min_pct": 58.0,
            "blur_rms_px": np.sqrt((1 + 1 + 1 + 9) / 4),
            "out_of_tolerance": 1,  # as the others, without the first seconds of the line
        }
    )


@pytest.mark.parametrize(
    ("tel", "found", "reason"),
    [
        (telemetry([]), NO_STRIPS, "no survey line was flown beyond record.exclude_first_s"),
        (telemetry([-1, -1, 0]), strips([1.0], [True]), "no survey line was flown beyond record.exclude_first_s"),
        (telemetry([0] * 6), strips([4.0, 5.0], [False, False]), "no strip was accepted"),
    ],
)
def test_what_was_not_measured_is_null_with_its_reason(
    tel: dict[str, Any], found: dict[str, Any], reason: str
) -> None:
    tel["vh_est_per_s"] = tel["crab_est_deg"] = np.full(len(tel["t_s"]), np.nan)
    summary = summarise(tel, found, NO_PHOTOS, WANTED)
    json.dumps(plain(summary), allow_nan=False)
    json.dumps(summary, allow_nan=False)  # not a NaN in it, even before
    nulls = {path for path, v in flat(summary).items() if v is None}
    assert nulls == {path for path in summary["notes"] if not path.startswith("line ")}
    assert {
        "crab.estimate_error_rms_deg",
        "vh.error_rms_pct",
        "vh.strip_error_rms_pct",
        "photos.end_lap_mean_pct",
    } <= nulls
    notes = dict(summary["notes"])
    assert "not computed" in notes.pop("photos.side_lap_min_pct")
    assert notes["vh.error_rms_pct"] == reason
    assert (summary["crab"]["accepted_pct"] is None) == (summary["crab"]["strips"] == 0)
    if len(tel["t_s"]) == 0:
        assert summary["flight"]["duration_s"] is None
