"""Fuel of a plan against a flight that burns it; the forecast refuses what a run refuses."""

from __future__ import annotations

from typing import Any

import pytest

from aerosim.errors import InputError
from aerosim.forecast.check import forecast
from aerosim.scenario import load_scenario
from aerosim.scenario.build import aircraft_of, route_of, terrain_of
from aerosim.world.mil import mil_turbulence

SECTION = "air.turbulence"


def check(**changed: Any) -> dict[str, Any]:
    return forecast(load_scenario("crosswind", changed))


def test_fuel_is_what_a_flight_burns() -> None:
    # The model itself, flown on for five minutes on its course in still air: it grows lighter by 2 %.
    scenario = load_scenario("crosswind", {"air.wind.speed_m_s": 0})
    plan = route_of(scenario, terrain_of(scenario)).plan
    aircraft = aircraft_of(scenario)
    aircraft.start(*plan.lines[0].start, plan.height, plan.lines[0].course, plan.airspeed)
    before = aircraft.fuel
    aircraft.advance(round(300.0 * aircraft.step_rate))
    found = forecast(scenario)["flight"]
    assert found["fuel_kg"] == pytest.approx(before)
    assert found["fuel_flow_kg_h"] == pytest.approx(12.0 * (before - aircraft.fuel), rel=0.02)
    assert found["fuel_needed_kg"] == pytest.approx(found["fuel_flow_kg_h"] * found["duration_s"] / 3600.0)


def test_too_little_fuel_is_told() -> None:
    (told,) = (line for line in check(**{"aircraft.fuel_kg": 20.0})["warnings"] if "fuel" in line)
    assert told.startswith("fuel of 20 kg lasts 0.1")
    assert not [line for line in check()["warnings"] if "fuel" in line]


def test_fuel_for_less_than_a_second_is_wrong_input() -> None:
    with pytest.raises(InputError, match="fuel used up"):
        check(**{"aircraft.fuel_kg": 1e-4})


def test_turbulence_is_that_of_the_run_or_refused() -> None:
    found = check(**{SECTION: {"model": "mil_f_8785c", "severity": "moderate"}})
    agl = found["flight"]["height_m"] - found["flight"]["terrain_mean_height_m"]
    rule = mil_turbulence("dryden", height=found["flight"]["height_m"], agl=agl, severity="moderate")
    assert tuple(found["air"].values()) == rule[1:]
    with pytest.raises(InputError, match="does not follow the wind near the ground") as caught:
        check(**{SECTION: {"model": "mil_f_8785c", "wind_20ft_m_s": 10.0}})
    assert "air.turbulence.wind_20ft_m_s" in str(caught.value)
