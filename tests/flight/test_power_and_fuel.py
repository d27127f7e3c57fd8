from __future__ import annotations

import math

import pytest

from aerosim.flight.limits import density

from .made import TABLES, aircraft

EAST = math.radians(90.0)
# Specific consumption of each, kg/kWh.
SPECIFIC = {"survey_twin": 0.38, "beech_99": 0.38, "beaver": 0.31}


@pytest.mark.parametrize("name", TABLES)
def test_fuel_burnt_is_the_integral_of_power(name: str) -> None:
    # Ten minutes with steps of speed and height, so that the power moves by a third: rectangle rule at 20 Hz.
    table = TABLES[name]
    plane = aircraft(name)
    plane.start(0.9, 0.2, 2000.0, EAST, table.check_m_s - 8.0)
    begin, weight = plane.fuel, plane._fdm["inertia/weight-lbs"]
    energy, powers = 0.0, []
    for second in range(600):
        if second == 60:
            plane.command(0.0, 2050.0, table.check_m_s - 8.0)
        if second == 240:
            plane.command(0.0, 2050.0, table.check_m_s - 4.0)
        for _ in range(20):
            plane.advance(6)
            powers.append(plane._fdm["power/shaft-w"])
            energy += powers[-1] * 0.05
    burnt = SPECIFIC[name] * energy / 3.6e6
    assert max(powers) > 1.2 * min(powers)
    assert begin - plane.fuel == pytest.approx(burnt, rel=2e-3)
    # What is burnt is gone from the mass that flies.
    assert weight - plane._fdm["inertia/weight-lbs"] == pytest.approx(burnt / 0.45359237, rel=2e-3)


@pytest.mark.parametrize("name", TABLES)
def test_lighter_aircraft_flies_at_less_alpha_and_power(name: str) -> None:
    # Two hours' fuel apart.  Alpha by the change of lift over the slope, CLa between 5 and 6 per rad.
    table = TABLES[name]
    heavy, light = (
        aircraft(name, fuel).start(0.9, 0.2, 3000.0, EAST, table.check_m_s) for fuel in (table.mass.fuel_kg, 20.0)
    )
    lift = heavy.lift - light.lift
    assert heavy.power > light.power
    assert lift / 6.3 < heavy.alpha - light.alpha < lift / 4.5
    assert light.lift / heavy.lift == pytest.approx(
        (table.mass.total_kg - table.mass.fuel_kg + 20.0) / table.mass.total_kg, rel=2e-3
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
def test_alpha_falls_as_fuel_is_burnt_in_flight(name: str) -> None:
    table = TABLES[name]
    plane = aircraft(name)
    trim = plane.start(0.9, 0.2, 3000.0, EAST, table.check_m_s)
    plane.advance(3600 * 120)
    light = aircraft(name, plane.fuel).start(0.9, 0.2, 3000.0, EAST, table.check_m_s)
    state = plane.state()
    assert state.height == pytest.approx(3000.0, abs=0.5)
    assert plane._get("aero/alpha-rad") < trim.alpha
    assert plane._get("aero/alpha-rad") == pytest.approx(light.alpha, abs=1e-4)
    assert plane._fdm["power/shaft-w"] == pytest.approx(light.power, rel=2e-3)


@pytest.mark.parametrize(("name", "rated"), [("survey_twin", 924e3), ("beech_99", 1106e3)])
@pytest.mark.parametrize("height", [0.0, 3000.0, 6000.0])
def test_turboprops_lose_power_with_density(name: str, rated: float, height: float) -> None:
    trim = aircraft(name).start(0.9, 0.2, height, EAST, 80.0)
    assert trim.power_available == pytest.approx(rated * (density(height) / 1.225) ** 0.7, rel=2e-3)


@pytest.mark.parametrize(
    ("height", "manifold"),
    # ICAO pressures, inHg: 24.90 at 1524 m, 20.70 at 3000 m, 17.06 at 4500 m; full throttle: 34.5/24.90 of it.
    [(0.0, 34.5), (1500.0, 34.5), (3000.0, 34.5 * 20.70 / 24.90), (4500.0, 34.5 * 17.06 / 24.90)],
)
def test_radial_engine_holds_its_pressure_up_to_the_critical_height(height: float, manifold: float) -> None:
    # LR-556's formula at 2200 rpm.
    ratio = density(height) / 1.225
    power = 735.5 * (
        -326.5 + 0.00412 * (manifold + 7.4) * (2200.0 + 2010.0) + (408.0 - 0.0965 * 2200.0) * (1.0 - ratio)
    )
    trim = aircraft("beaver").start(0.9, 0.2, height, EAST, 50.0)
    assert trim.power_available == pytest.approx(power, rel=3e-3)


def test_formula_gives_the_engines_rating() -> None:
    # 450 hp (336 kW) for take-off, 36.5 inHg and 2300 rpm.
    assert TABLES["beaver"].engine.power_kw(36.5, 2300.0, 1.0) == pytest.approx(336.0, rel=0.01)


def test_power_ends_where_the_engine_does() -> None:
    # Asked for more than there is, the autopilot gets what there is, and the aircraft slows down.
    plane = aircraft("beaver")
    plane.start(0.9, 0.2, 4500.0, EAST, 60.0)
    plane.command(0.0, 4500.0, 75.0)
    plane.advance(120 * 120)
    available = plane._fdm["power/available-w"]
    assert plane._fdm["power/shaft-w"] == pytest.approx(available, rel=1e-9)
    assert 60.0 < plane.state().airspeed < 72.0
