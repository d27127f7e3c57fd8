"""Section `air`: what does not fit together is refused by key; what fits is built, and comes back from a file."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from aerosim.errors import InputError
from aerosim.scenario import load, parse_setting
from aerosim.scenario.emit import to_yaml

Write = Callable[[str | bytes], Path]

LEVEL = "{{height_m: {}, speed_m_s: 5, from_deg: 90}}"
PROFILE = f"[{LEVEL.format(0)}, {LEVEL.format(1000)}]"
THERMAL = "{{center_deg: [36.5, -84.3], radius_m: {}, strength_m_s: 2}}"


@pytest.mark.parametrize(
    ("setting", "line"),
    [
        (f"air.wind={{profile: [{LEVEL.format(500)}, {LEVEL.format(500)}]}}", "air.wind.profile.1.height_m: 500 m is not above the level before it (more than 500)"),
        (f"air.wind={{profile: [{LEVEL.format(500)}, {LEVEL.format(400)}]}}", "air.wind.profile.1.height_m: 400 m is not above the level before it (more than 500)"),
        ("air.wind={profile: []}", "air.wind.profile: has 0 values (allowed: at least 1)"),
        (f"air={{wind: {{profile: {PROFILE}}}, shear: {{exponent: 0.2}}}}", "air.shear.exponent: shear on top of a wind profile (put it into the levels)"),
        (f"air={{wind: {{profile: {PROFILE}}}, shear: {{veer_deg_per_km: 2}}}}", "air.shear.veer_deg_per_km: shear on top of a wind profile (put it into the levels)"),
        (f"air.wind={{profile: {PROFILE}, speed_m_s: 3}}", "air.wind.speed_m_s: is given besides profile (speed_m_s and from_deg, or profile)"),
        ("air.gusts=[{start_s: 1, duration_s: 2}]", "air.gusts.0: gust without strength (one of north_m_s, east_m_s, down_m_s other than 0)"),
        ("air.turbulence={model: mil_f_8785c}", "air.turbulence.severity: mil_f_8785c has no strength (severity, exceedance or wind_20ft_m_s)"),
        ("air.turbulence={model: mil_f_8785c, severity: light, sigma_m_s: 1}", "air.turbulence.sigma_m_s: 1 m/s is given, but model mil_f_8785c finds sigma by its rules (severity, or another model)"),
        ("air.turbulence={model: mil_f_8785c, severity: light, length_m: 300}", "air.turbulence.length_m: does not belong to model mil_f_8785c (another model, or leave it out)"),
        ("air.turbulence={model: mil_f_8785c, severity: light, exceedance: 0.1}", "air.turbulence.exceedance: is given besides severity light (one of both)"),
        ("air.turbulence={model: mil_f_8785c, exceedance: 1}", "air.turbulence.exceedance: 1 is out of range (allowed: at least 1e-06, at most 0.2)"),
        ("air.turbulence={model: mil_f_8785c, severity: severee}", "air.turbulence.severity: 'severee' is not known (allowed: light, moderate, severe; did you mean severe?)"),
        ("air.turbulence={severity: light}", "air.turbulence.severity: does not belong to model dryden (another model, or leave it out)"),
        ("air.turbulence={model: von_karman, wind_20ft_m_s: 5}", "air.turbulence.wind_20ft_m_s: does not belong to model von_karman (another model, or leave it out)"),
        ("air.slow_wind={model: mesoscale, sigma_m_s: 1}", "air.slow_wind.sigma_m_s: does not belong to model mesoscale (another model, or leave it out)"),
        ("air.slow_wind={sigma_m_s: 1, longest_km: 100}", "air.slow_wind.longest_km: does not belong to model gauss_markov (another model, or leave it out)"),
        ("air.slow_wind={model: mesoscale, longest_km: 20, shortest_km: 20}", "air.slow_wind.longest_km: 20 km is too short (more than 20)"),
        (f"air.thermals=[{THERMAL.format(0)}]", "air.thermals.0.radius_m: 0 is out of range (allowed: more than 0, at most 20000)"),
        ("air.thermals=[{radius_m: 100, strength_m_s: 2}]", "air.thermals.0.center_deg: is missing"),
        ("air.thermal_field={spacing_m: 500, radius_m: 600}", "air.thermal_field.radius_m: 600 m is wider than spacing_m (at most 500)"),
        ("air.thermal_field={}", "air.thermal_field.spacing_m: is missing"),
        ("air.gusts=[{start_s: 1, duration_s: 0}]", "air.gusts.0.duration_s: 0 is out of range (allowed: more than 0, at most 3600)"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(write: Write, good: str, setting: str, line: str) -> None:
    with pytest.raises(InputError) as caught:
        load(write(good), [parse_setting(setting)])
    assert str(caught.value).startswith(f"--set {line}")


@pytest.mark.parametrize(
    "setting",
    [
        f"air={{wind: {{profile: {PROFILE}}}}}",
        f"air={{wind: {{profile: [{LEVEL.format(900)}]}}, shear: {{exponent: 0.2, veer_deg_per_km: 3}}}}",
        "air.slow_wind={model: mesoscale, change_100km_m_s: 1.5, longest_km: 100}",
        "air.slow_wind={model: gauss_markov, sigma_m_s: 1}",
        "air.turbulence={model: von_karman, sigma_m_s: 0.7, length_m: 762}",
        "air.turbulence={model: mil_f_8785c, severity: light, wind_20ft_m_s: 4, spectrum: von_karman}",
        "air.turbulence={model: mil_f_8785c, exceedance: 1e-2}",
        f"air={{thermals: [{THERMAL.format(300)}], thermals_drift: true}}",
        "air.thermal_field={spacing_m: 3000}",
        "air.gusts=[{start_s: 10, duration_s: 4, east_m_s: 5}, {start_s: 12, duration_s: 4, down_m_s: -2}]",
    ],
)
def test_what_fits_is_taken_and_comes_back_from_its_own_file(write: Write, good: str, setting: str) -> None:
    # A resolved scenario spells all defaults out, those of the other models, too.
    wanted = load(write(good), [parse_setting(setting)])
    assert load(write(to_yaml(wanted))).air == wanted.air
