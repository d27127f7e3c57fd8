"""The error split on records with one known cause each, on all together, and on a flight."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from split_record import APART, LATE, RATE, SPAN, SPEED, counted, record, still

from aerosim.estimation.kalman import stationary_gain
from aerosim.frames import Array
from aerosim.metrics.replay import Gains, centred_mean
from aerosim.metrics.split import Split, own_filter, split_crab, split_vh
from aerosim.record import Run

GAMMA = 0.05


def noise(seed: int, sigma: float) -> Any:
    """White over the strips, which begin at whole seconds."""
    values = sigma * np.random.default_rng(seed).standard_normal(1000)
    values[0] = 0.0  # of the first strip: that is convergence
    return lambda t: values[np.rint(t).astype(int)]


def total(found: Split) -> float:
    """Sum of the signed squares."""
    return sum(value * abs(value) for value in found.rms.values() if value is not None)


def crab_of(record: tuple[Any, Any]) -> tuple[Split, float]:
    """Split and measured rms."""
    telemetry, matches = record
    used = counted(telemetry)
    return split_crab(telemetry, matches, used), float(np.sqrt(np.mean(telemetry["crab_true_deg"][used] ** 2)))


def vh_of(record: tuple[Any, Any]) -> tuple[Split, float]:
    telemetry, matches = record
    used = counted(telemetry)
    error = 100.0 * (telemetry["vh_est_per_s"] / telemetry["vh_true_per_s"] - 1.0)[used]
    return split_vh(telemetry, matches, used), float(np.sqrt(np.mean(error**2)))


def only(found: Split, name: str, rms: float, other: float) -> None:
    """All of the error is in one part: the others, and rest, stay below a bound."""
    values = dict(found.rms)
    assert found.reason == ""
    assert values.pop(name) == pytest.approx(rms, rel=1e-3)
    assert max(abs(value) for value in values.values() if value is not None) < other
    assert None not in values.values()


def ramp_lag(begin: float = 0.0) -> Array:
    """How late the stationary filter's answer is, s, at the samples of one strip period.

    After a decision: half the strip time, the time to the decision, and (1 - q)/q strips; then it grows until the
    next one.
    """
    q = stationary_gain(GAMMA)
    return SPAN / 2.0 + LATE + APART * (1.0 - q) / q + begin + np.arange(RATE) / RATE


def test_noise() -> None:
    found, rms = crab_of(record(wrong_drift=noise(1, 1.0), gamma=GAMMA))
    only(found, "noise", rms, 1e-6)
    # a filter of gain q passes q/(2 - q) of white noise; over 467 strips, correlated over 1/q, within 4 sd
    q = stationary_gain(GAMMA)
    assert rms == pytest.approx(np.sqrt(q / (2.0 - q)), rel=4.0 / np.sqrt(2.0 * 467 * q / 2.0))


def test_a_ramp_of_the_drift_is_lag() -> None:
    slope = 0.02
    found, rms = crab_of(record(drift=lambda t: slope * t, gamma=GAMMA))
    assert rms == pytest.approx(slope * np.sqrt(np.mean(ramp_lag() ** 2)), rel=1e-6)
    only(found, "lag", rms, 1e-5)


def test_a_wrong_first_strip_is_convergence() -> None:
    # a filter that expects no change takes the mean of all strips: after i of them the first weighs 1/i
    telemetry, matches = record(wrong_drift=lambda t: np.where(t == 0.0, 5.0, 0.0), gamma=1e-12)
    taken = np.floor((telemetry["t_s"] - SPAN - LATE) / APART + 1e-9) + 1.0
    found, rms = crab_of((telemetry, matches))
    assert rms == pytest.approx(5.0 * np.sqrt(np.mean(1.0 / taken[counted(telemetry)] ** 2)), rel=1e-6)
    only(found, "convergence", rms, 1e-6)


def test_before_the_first_strip_everything_is_convergence_or_fast_yaw() -> None:
    telemetry, matches = record(drift=lambda t: 8.0 + 0.5 * np.sin(2.0 * np.pi * t / 2.6))
    matches = {name: values[60:] for name, values in matches.items()}
    telemetry["drift_est_deg"] = np.full(len(telemetry["t_s"]), np.nan)
    telemetry["mount_yaw_deg"] = np.full(len(telemetry["t_s"]), 1.0)
    telemetry["crab_true_deg"] = telemetry["drift_true_deg"] - 1.0
    used = (telemetry["t_s"] >= 67.0) & (
        telemetry["t_s"] < 72.2
    )  # two swings, half a strip after the line's start
    found = split_crab(telemetry, matches, used)
    assert found.rms["convergence"] == pytest.approx(7.0, abs=1e-3)
    assert found.rms["fast_yaw"] == pytest.approx(0.5 / np.sqrt(2.0), rel=1e-3)
    assert found.rms["lag"] == found.rms["noise"] == found.rms["mount"] == 0.0


def test_a_swinging_nose_is_fast_yaw() -> None:
    # five swings in a strip: their mean is naught; a strip each second knows the nose at its two ends
    found, rms = crab_of(record(drift=lambda t: 8.0 + np.sin(2.0 * np.pi * t / 2.6), gamma=GAMMA))
    assert rms > 0.7
    only(found, "fast_yaw", rms, 2e-3)


def test_the_mount_beside_its_command() -> None:
    found, rms = crab_of(record(mount=-0.3))
    assert rms == pytest.approx(0.3)
    only(found, "mount", 0.3, 1e-6)


def test_a_camera_that_stands_leaves_the_drift() -> None:
    telemetry, matches = record(drift=lambda t: 8.0 + np.sin(2.0 * np.pi * t / 2.6), wrong_drift=noise(2, 1.0))
    telemetry["mount_yaw_deg"] = 0.0 * telemetry["t_s"]
    telemetry["crab_true_deg"] = telemetry["drift_true_deg"]
    found, rms = crab_of((telemetry, matches))
    assert found.rms["mount"] == pytest.approx(8.0, abs=1e-3)
    assert found.rms["fast_yaw"] == pytest.approx(np.sqrt(0.5), rel=0.01)
    assert found.rms["lag"] == found.rms["noise"] == 0.0
    assert total(found) == pytest.approx(rms**2, rel=1e-12)


def told_truth() -> tuple[dict[str, Any], dict[str, Any]]:
    telemetry, matches = record(drift=lambda t: 8.0 + np.sin(t), wrong_drift=noise(3, 1.0))
    telemetry["drift_est_deg"], telemetry["vh_est_per_s"] = telemetry["drift_true_deg"], telemetry["vh_true_per_s"]
    telemetry["mount_yaw_deg"] = telemetry["drift_true_deg"] - 0.1 * np.cos(telemetry["t_s"])
    telemetry["crab_true_deg"] = telemetry["drift_true_deg"] - telemetry["mount_yaw_deg"]
    return telemetry, matches


def test_who_is_told_the_truth_leaves_the_mount() -> None:
    found, rms = crab_of(told_truth())
    only(found, "mount", rms, 1e-6)
    assert set(vh_of(told_truth())[0].rms.values()) == {0.0}
    telemetry, matches = told_truth()
    assert not own_filter(telemetry, matches, counted(telemetry))
    assert own_filter(*record(wrong_drift=noise(3, 1.0)), counted(telemetry))


def test_another_filter_is_split_as_far_as_it_can_be() -> None:
    telemetry, matches = told_truth()
    t = telemetry["t_s"]
    telemetry["drift_est_deg"] = telemetry["drift_true_deg"] - 0.4 - 0.2 * np.sin(2.0 * np.pi * t / 2.6)
    telemetry["vh_est_per_s"] = telemetry["vh_true_per_s"] * (1.02 + 0.01 * np.sin(2.0 * np.pi * t / 2.6))
    telemetry["mount_yaw_deg"] = telemetry["drift_est_deg"] - 0.1
    telemetry["crab_true_deg"] = telemetry["drift_true_deg"] - telemetry["mount_yaw_deg"]
    for gains in (matches["gain_drift"], np.full(len(matches["gain_drift"]), np.nan)):
        found, rms = crab_of((telemetry, matches | {"gain_drift": gains, "gain_vh": gains}))
        assert found.rms["lag"] is found.rms["noise"] is found.rms["convergence"] is None
        assert "scalar filter" in found.reason
        assert found.rms["fast_yaw"] == pytest.approx(0.2 / np.sqrt(2.0), rel=2e-3)
        assert found.rms["mount"] == pytest.approx(0.1)
        # the estimator's 0.4 deg and its cross term with the mount's 0.1 deg
        assert found.rms["rest"] == pytest.approx(np.sqrt(0.4**2 + 2.0 * 0.4 * 0.1), rel=2e-3)
        assert total(found) == pytest.approx(rms**2, rel=1e-12)
        of_vh, vh_rms = vh_of((telemetry, matches | {"gain_drift": gains, "gain_vh": gains}))
        assert of_vh.rms["relief"] is of_vh.rms["lag"] is None
        assert of_vh.rms["fast_speed"] == pytest.approx(1.0 / np.sqrt(2.0), rel=5e-3)
        assert total(of_vh) == pytest.approx(vh_rms**2, rel=1e-12)


def test_vh_noise() -> None:
    found, rms = vh_of(record(wrong_vh=noise(4, 0.02), gamma=GAMMA))
    only(found, "noise", rms, 1e-6)
    assert rms > 0.2


def test_a_ramp_of_the_speed_is_lag() -> None:
    # h/v falls in the ratio of the speed: 0.02 m/s each second late
    found, rms = vh_of(record(speed=lambda t: SPEED + 0.02 * t, gamma=GAMMA))
    mean_late, speed = ramp_lag().mean(), SPEED + 0.02 * 350.0
    assert rms == pytest.approx(100.0 * 0.02 * mean_late / speed, rel=0.02)
    assert found.rms["lag"] == pytest.approx(rms, rel=1e-3)
    assert (found.rms["fast_speed"] or 0.0) < 1e-3
    # the mean height over the mean speed of a strip is not the mean of the quotient
    assert (found.rms["relief"] or 0.0) < 0.01


def test_gusts_along_the_track_are_fast_speed() -> None:
    found, rms = vh_of(record(speed=lambda t: SPEED + np.sin(2.0 * np.pi * t / 2.6), gamma=GAMMA))
    assert rms == pytest.approx(100.0 / SPEED / np.sqrt(2.0), rel=0.01)
    assert found.rms["fast_speed"] == pytest.approx(rms, rel=0.01)
    assert max(found.rms[name] or 0.0 for name in ("lag", "relief", "noise", "convergence")) < 0.03 * rms


def test_hills_are_relief() -> None:
    found, rms = vh_of(record(ground=lambda t: 400.0 + 150.0 * np.sin(2.0 * np.pi * t / 60.0), gamma=GAMMA))
    assert rms > 3.0
    only(found, "relief", rms, 0.02 * rms)


def test_a_plateau_at_any_height_is_no_relief() -> None:
    found, rms = vh_of(record(ground=still(1400.0), speed=lambda t: SPEED + 0.02 * t, gamma=GAMMA))
    assert rms > 0.25
    assert (found.rms["relief"] or 0.0) < 0.01


@pytest.mark.parametrize("seed", range(3))
def test_everything_at_once_adds_up(seed: int) -> None:
    rng = np.random.default_rng(seed)
    period, slope, hills = rng.uniform(2.0, 90.0), rng.uniform(-0.02, 0.02), rng.uniform(0.0, 200.0)
    telemetry, matches = record(
        drift=lambda t: 8.0 + slope * t + np.sin(2.0 * np.pi * t / period),
        speed=lambda t: SPEED + np.sin(2.0 * np.pi * t / period),
        ground=lambda t: 400.0 + hills * np.sin(2.0 * np.pi * t / 77.0),
        wrong_drift=noise(seed, 2.0),
        wrong_vh=noise(seed + 10, 0.03),
        mount=0.1,
    )
    for found, rms in (crab_of((telemetry, matches)), vh_of((telemetry, matches))):
        assert None not in found.rms.values()
        assert total(found) == pytest.approx(rms**2, rel=1e-12)


def test_moments_over_no_terrain_do_not_count() -> None:
    telemetry, matches = record(ground=lambda t: 400.0 + 100.0 * np.sin(t / 9.0), wrong_vh=noise(6, 0.02))
    whole, _ = vh_of((telemetry, matches))
    hole = (telemetry["t_s"] > 300.0) & (telemetry["t_s"] < 301.0)
    telemetry["vh_true_per_s"] = np.where(hole, np.nan, telemetry["vh_true_per_s"])
    used = counted(telemetry)
    found = split_vh(telemetry, matches, used)
    error = 100.0 * (telemetry["vh_est_per_s"] / telemetry["vh_true_per_s"] - 1.0)[used & ~hole]
    assert total(found) == pytest.approx(np.mean(error**2), rel=1e-12)
    assert found.rms["relief"] == pytest.approx(whole.rms["relief"], rel=0.01)


def test_a_filter_in_whole_numbers_is_split_too() -> None:
    common: dict[str, Any] = {"drift": lambda t: 8.0 + np.sin(t / 20.0), "wrong_drift": noise(5, 1.0)}
    real, _ = crab_of(record(**common))
    whole, rms = crab_of(record(**common, word=1.0 / 256.0))
    for name in ("lag", "noise", "fast_yaw"):
        assert whole.rms[name] == pytest.approx(real.rms[name], rel=1e-6)
    assert total(whole) == pytest.approx(rms**2, rel=1e-12)


def test_without_strips_or_samples_nothing_is_told() -> None:
    telemetry, matches = record()
    none = {name: values[:0] for name, values in matches.items()}
    for split in (split_crab, split_vh):
        assert set(split(telemetry, none, counted(telemetry)).rms.values()) == {None}
        assert "no strip" in split(telemetry, none, counted(telemetry)).reason
        assert set(split(telemetry, matches, counted(telemetry, until=0.0)).rms.values()) == {None}


def test_the_centred_mean_keeps_a_ramp_to_both_ends_of_a_line() -> None:
    t = np.arange(200) / 10.0
    line = np.repeat([-1, 0, 1, -1], 50)
    assert centred_mean(t, 3.0 * t, line, 4.0) == pytest.approx(3.0 * t, abs=1e-9)
    step = np.where(line == 1, 5.0, 0.0)
    assert centred_mean(t, step, line, 4.0)[:100] == pytest.approx(0.0, abs=1e-9)  # nothing of the next line


def test_gains_begin_anew_where_they_are_one() -> None:
    gains = Gains(np.array([1.0, 2.0, 3.0]), np.array([1.0, 0.5, 1.0]))
    assert gains.over(np.array([4.0, 2.0, 7.0])).tolist() == [4.0, 3.0, 7.0]
    assert gains.at(np.array([0.5, 1.0, 2.9, 9.0])).tolist() == [-1, 0, 1, 2]


def test_a_flight(crosswind: Run) -> None:
    crab, vh = crosswind.summary["crab"], crosswind.summary["vh"]
    for split, rms in ((crab["split_deg"], crab["residual_rms_deg"]), (vh["split_pct"], vh["error_rms_pct"])):
        assert sum(x * abs(x) for x in split.values()) == pytest.approx(rms**2, rel=1e-9)
    # two minutes after the first strip it weighs nothing; a mount of 0.15 s stays behind a yaw rate by as much
    assert crab["split_deg"]["convergence"] < 0.01
    assert crab["split_deg"]["mount"] < 0.1
    # the strips are 13 s long and late by half of it: in a wandering wind lag is a good part
    assert crab["split_deg"]["lag"] > 0.3 * crab["residual_rms_deg"]
    # the land has 150 m of relief at 3000 m
    assert vh["split_pct"]["relief"] > vh["split_pct"]["fast_speed"]
