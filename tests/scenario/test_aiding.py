"""Devices that a mode and its aiding need: brought by presets, refused where nothing reads them."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from aerosim.errors import InputError
from aerosim.scenario import load, parse_setting, with_overrides
from aerosim.scenario.aiding import unaided
from aerosim.scenario.control import Control
from aerosim.scenario.estimation import Estimation
from aerosim.scenario.navigation import Navigation
from aerosim.scenario.presets import with_mode_defaults
from aerosim.scenario.scenario import Scenario

Write = Callable[[str | bytes], Path]


def refused_with(file: Path, *settings: str) -> str:
    with pytest.raises(InputError) as caught:
        load(file, [parse_setting(setting) for setting in settings])
    return str(caught.value)


def test_gnss_ins_brings_its_devices(write: Write, good: str) -> None:
    got = load(write(good), [parse_setting("control.mode=gnss_ins")])
    assert got.navigation is not None
    assert got.navigation.gnss is not None
    assert got.navigation.ins is not None
    assert (got.navigation.gnss.period_s, got.navigation.ins.period_s) == (0.6, 0.1)
    assert got.navigation.imu is None
    told = load(write(good), [parse_setting("control.mode=gnss_ins"), parse_setting("navigation.ins.sigma_deg=1")])
    assert told.navigation == got.navigation.model_copy(update={"ins": told.navigation.ins})  # type: ignore[union-attr]
    assert with_overrides(got, {"control.mode": "pipelined"}).navigation is None


@pytest.mark.parametrize("aiding", ["gyro", "bank", "imu"])
def test_aiding_brings_a_unit_that_is_read_with_the_rows(aiding: str) -> None:
    found = with_mode_defaults({"estimation": {"aiding": aiding}, "ccd_rows": {"period_s": 0.1}})
    alone = {"gnss": None, "ins": None, "smooth": None}
    assert found["navigation"] == {**alone, "imu": {"period_s": 0.1}}
    given = with_mode_defaults({"estimation": {"aiding": aiding}, "navigation": {"imu": {"level_error_deg": 0.3}}})
    assert given["navigation"] == {**alone, "imu": {"level_error_deg": 0.3}}


@pytest.mark.parametrize(
    "data", [{}, {"estimation": {"aiding": "none"}}, {"estimation": {"aiding": 3}}, {"estimation": 3}, "x"]
)
def test_no_aiding_brings_nothing(data: Any) -> None:
    assert with_mode_defaults(data) == data


def test_null_that_is_written_stays() -> None:
    for navigation in (None, {"imu": None}):
        found = with_mode_defaults({"estimation": {"aiding": "imu"}, "navigation": navigation})["navigation"]
        assert found is None or found["imu"] is None


def of_best(base: Scenario, aiding: str, **navigation: Any) -> Scenario:
    """A scenario of mode `best`, not checked."""
    devices = (
        None
        if navigation.get("all", 1) is None
        else Navigation.model_validate({"gnss": None, "ins": None, **navigation})
    )
    return base.model_copy(
        update={"control": Control(mode="best"), "estimation": Estimation(aiding=aiding), "navigation": devices}
    )


def test_aiding_needs_the_unit(write: Write, good: str) -> None:
    base = load(write(good))
    assert unaided(of_best(base, "imu", imu={})) == []
    assert unaided(of_best(base, "none")) == []
    allowed = "allowed: none, or navigation.imu"
    assert unaided(of_best(base, "gyro", imu=None)) == [
        ("estimation.aiding", "gyro needs navigation.imu, and navigation.imu is null", allowed)
    ]
    assert unaided(of_best(base, "bank", all=None)) == [
        ("estimation.aiding", "bank needs navigation.imu, and navigation is null", allowed)
    ]
    assert unaided(of_best(base, "imu", imu={"period_s": 0.1})) == [
        ("navigation.imu.period_s", "the unit is read at each exposure of the rows", "allowed: 0.05")
    ]


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (["estimation.aiding=imu"], "--set estimation.aiding: imu needs control.mode best, which here is pipelined (allowed: none)"),
        (["estimation.aiding=gyro", "control.mode=fixed"], "--set estimation.aiding: gyro needs control.mode best, which here is fixed (allowed: none)"),
        (["estimation.aiding=gyros"], "--set estimation.aiding: 'gyros' is not known (allowed: none, gyro, bank, imu; did you mean gyro?)"),
        (["control.mode=gnss_ins", "navigation=null"], "--set control.mode: gnss_ins needs navigation.gnss and navigation.ins, null here (allowed: another mode)"),
        (["control.mode=gnss_ins", "navigation.gnss=null"], "--set control.mode: gnss_ins needs navigation.gnss, null here (allowed: another mode)"),
        (["navigation.gnss={}"], "--set navigation.gnss: is read in control.mode gnss_ins only in this version (allowed: null, or control.mode: gnss_ins)"),
        (["control.mode=gnss_ins", "navigation.gnss.period_s=0.62"], "--set navigation.gnss.period_s: 0.62 s is no whole number of row exposures of 0.05 s (nearest: 0.6 or 0.65)"),
        (["control.mode=gnss_ins", "navigation.ins.period_s=0.01"], "--set navigation.ins.period_s: 0.01 s is no whole number of row exposures of 0.05 s (nearest: 0.05)"),
        (["control.mode=gnss_ins", "navigation.gnss.velocity_sigma_m_s=-1"], "--set navigation.gnss.velocity_sigma_m_s: -1 is out of range (allowed: at least 0, at most 100)"),
        (["control.navigator.least_deg=0"], "--set control.navigator.least_deg: 0 is out of range (allowed: at least 1, at most 10)"),
        (["control.navigator.offset_sigma_m=3"], "--set control.navigator.offset_sigma_m: unknown key here (did you mean flight.navigator.offset_sigma_m?)"),
        (["control.yaw_lead_s=0.1"], "--set control.yaw_lead_s: is a feed-forward of a gyro, and there is none (allowed: 0, or estimation.aiding: gyro, bank, imu)"),
        (["control.yaw_lead_s=null"], "--set control.yaw_lead_s: is a feed-forward of a gyro, and there is none (allowed: 0, or estimation.aiding: gyro, bank, imu)"),
        (["control.yaw_lead_s=-1"], "--set control.yaw_lead_s: -1 is out of range (allowed: at least 0, at most 10)"),
        (["control.yaw_dead_band_deg=31"], "--set control.yaw_dead_band_deg: 31 is out of range (allowed: at least 0, at most 30)"),
        (["frame_camera.fmc_limit_mm_s=-1"], "--set frame_camera.fmc_limit_mm_s: -1 is out of range (allowed: at least 0, at most 10000)"),
        (["navigation.imu.level_time_s=0"], "--set navigation.imu.level_time_s: 0 is out of range (allowed: more than 0, at most 100000)"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(write: Write, good: str, settings: list[str], line: str) -> None:
    assert refused_with(write(good), *settings) == line


@pytest.mark.parametrize(
    ("setting", "line"),
    [
        ("ccd_rows.faults.dead_px=[3, 96]", "--set ccd_rows.faults.dead_px: row II has no pixel 96 (0 to 95)"),
        ("ccd_rows.faults.dead_px=[-1]", "--set ccd_rows.faults.dead_px.0: -1 is out of range (allowed: at least 0)"),
        ("ccd_rows.faults.blind_row=row3", "--set ccd_rows.faults.blind_row: 'row3' is not known (allowed: none, row1, row2; did you mean row2?)"),
        ("ccd_rows.faults.gain_step_pct=-100", "--set ccd_rows.faults.gain_step_pct: -100 is out of range (allowed: more than -100, at most 1000)"),
        ("ccd_rows.faults.stuck_from_s=3", "--set ccd_rows.faults.stuck_from_s: unknown key here (did you mean mount.faults.stuck_from_s?)"),
        ("mount.faults.stuck_from_s=-1", "--set mount.faults.stuck_from_s: -1 is out of range (allowed: at least 0)"),
        ("mount.faults.encoder_bias_deg=200", "--set mount.faults.encoder_bias_deg: 200 is out of range (allowed: at least -180, at most 180)"),
        # 4/27 over the square of the outermost pixel's radius: (55^2 + 19.85^2)/132.6^2 = 0.1945
        ("ccd_rows.distortion=-0.9", "--set ccd_rows.distortion: -0.9 folds the picture at the rows' ends (at least -0.762)"),
        ("estimation.distortion=0.1", "--set estimation.distortion: 0.1 is for control.mode best, which here is pipelined (null)"),
        ("estimation.distortion=2", "--set estimation.distortion: 2 is out of range (allowed: at least -1, at most 1)"),
        ("ccd_rows.gain_difference_pct=-100", "--set ccd_rows.gain_difference_pct: -100 is out of range (allowed: more than -100, at most 1000)"),
    ],
)  # fmt: skip
def test_faults_that_cannot_be(write: Write, good: str, setting: str, line: str) -> None:
    assert refused_with(write(good), setting) == line


def test_a_belief_that_folds_the_picture(write: Write, good: str) -> None:
    line = "--set estimation.distortion: -0.9 folds the picture at the rows' ends (at least -0.762)"
    assert refused_with(write(good), "control.mode=best", "estimation.distortion=-0.9") == line


def test_sound_devices_by_default(write: Write, good: str) -> None:
    got = load(write(good))
    assert (got.ccd_rows.faults, got.mount.faults, got.navigation) == (None, None, None)
    assert (got.ccd_rows.distortion, got.ccd_rows.gain_difference_pct) == (0.0, 0.0)
