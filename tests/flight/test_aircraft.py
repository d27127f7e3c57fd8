from __future__ import annotations

import math
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from aerosim.errors import InputError, RunFailure
from aerosim.flight.aircraft import Aircraft
from aerosim.frames import ecef_from_geodetic, mat_ne
from aerosim.truth import AircraftState, AirState

EAST = math.radians(90.0)
CALM = (0.0,) * 6


def start(aircraft: Aircraft, wind: tuple[float, float, float] = (0.0, 0.0, 0.0), course: float = EAST) -> None:
    aircraft.start(math.radians(51.0), 0.2, 3000.0, course, 69.44, wind)


def hold(aircraft: Aircraft, count: int, *air: float) -> None:
    """So many steps in air of this velocity in n (m/s) and rotation in b (rad/s)."""
    aircraft.feel(AirState(*air[:3], 0.0, 0.0, 0.0, *air[3:]), (0.0,) * 9)
    for _ in range(count):
        aircraft.advance(1)


@pytest.mark.parametrize(("wind_north", "sign"), [(-10.0, 1.0), (10.0, -1.0)])
def test_starts_in_crosswind_without_sideslip(twin: Aircraft, wind_north: float, sign: float) -> None:
    start(twin, (wind_north, 0.0, 0.0))
    state = twin.state()
    track = math.atan2(state.v_east, state.v_north)
    # Wind from the left (north, on an easterly course) pushes to the right: drift is positive.
    drift = math.degrees(track - state.heading)
    assert drift == pytest.approx(sign * math.degrees(math.asin(10.0 / 69.44)), abs=0.05)
    assert track == pytest.approx(EAST, abs=1e-9)
    assert state.height == pytest.approx(3000.0, abs=1e-6)
    assert state.airspeed == pytest.approx(69.44, abs=1e-9)
    assert math.hypot(state.v_north, state.v_east) == pytest.approx(math.sqrt(69.44**2 - 100.0), abs=1e-6)
    assert abs(twin._fdm["aero/beta-rad"]) < 1e-6


def test_stays_there_in_the_wind(twin: Aircraft) -> None:
    start(twin, (-10.0, 3.0, 0.0))
    hold(twin, 2400, -10.0, 3.0, *CALM[2:])
    state = twin.state()
    assert state.height == pytest.approx(3000.0, abs=0.05)
    assert state.airspeed == pytest.approx(69.44, abs=0.01)
    assert abs(state.v_north) < 0.05


def test_vertical_wind_carries_the_aircraft_level(twin: Aircraft) -> None:
    # In air that rises at 1 m/s a level flight sinks through the air: the nose lies 1/69.44 rad lower.
    start(twin, (0.0, 0.0, -1.0))
    state = twin.state()
    assert state.v_down == pytest.approx(0.0, abs=1e-9)
    assert state.pitch == pytest.approx(twin._fdm["aero/alpha-rad"] - 1.0 / 69.44, abs=1e-5)


def test_position_and_velocity_agree(twin: Aircraft) -> None:
    start(twin, (-10.0, 0.0, 0.0))
    twin.command_roll(0.2)
    hold(twin, 1000, -10.0, 0.0, *CALM[2:])
    before, at = twin.ecef(), twin.state()
    assert ecef_from_geodetic(at.lat, at.lon, at.height) == pytest.approx(before[:3], abs=2e-4)
    vel_n = mat_ne(at.lat, at.lon) @ np.array(before[3:])
    assert vel_n == pytest.approx([at.v_north, at.v_east, at.v_down], abs=1e-6)
    assert at.t == pytest.approx(1000.0 / 120.0)


# Each part of the air, and what it does at once to a level aircraft flying north: sign of an acceleration.
@pytest.mark.parametrize(
    ("part", "property_name", "sign"),
    [
        (0, "accelerations/udot-ft_sec2", 1.0),  # north wind velocity: a tail wind slows the air over the wing
        (1, "accelerations/vdot-ft_sec2", 1.0),  # air going east pushes to the right
        (2, "accelerations/wdot-ft_sec2", 1.0),  # air going down pushes down
        (3, "accelerations/pdot-rad_sec2", 1.0),  # air that turns takes the aircraft along
        (4, "accelerations/qdot-rad_sec2", 1.0),
        (5, "accelerations/rdot-rad_sec2", 1.0),
    ],
)
def test_air_takes_the_aircraft_along(twin: Aircraft, part: int, property_name: str, sign: float) -> None:
    start(twin, course=0.0)
    before = twin._fdm[property_name]
    air = [0.0] * 6
    air[part] = 1.0 if part < 3 else 0.1
    hold(twin, 1, *air)
    assert sign * (twin._fdm[property_name] - before) > 0.01


def fly_turbulent(folder: Path) -> AircraftState:
    aircraft = Aircraft(folder, 120.0)
    start(aircraft, (-8.0, 2.0, 0.0))
    rng = np.random.default_rng(7)
    for gust in rng.normal(0.0, 1.0, (1500, 6)).tolist():
        hold(aircraft, 1, gust[0] - 8.0, gust[1] + 2.0, gust[2], *(0.02 * g for g in gust[3:]))
    return aircraft.state()


def test_same_air_same_flight_to_the_bit(folder: Path) -> None:
    first = fly_turbulent(folder)
    assert fly_turbulent(folder) == first
    with ThreadPoolExecutor(2) as pool:
        assert set(pool.map(fly_turbulent, [folder] * 4)) == {first}


def test_nothing_is_printed(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with ThreadPoolExecutor(1) as pool:
        pool.submit(fly_turbulent, folder).result()
    fly_turbulent(folder)
    assert capfd.readouterr() == ("", "")


def test_fuel_is_burnt_at_its_specific_rate(twin: Aircraft) -> None:
    start(twin)
    before, trim_power = twin.fuel, twin._fdm["power/shaft-w"]
    hold(twin, 7200, *CALM)
    assert before == pytest.approx(540.0, abs=0.01)
    assert before - twin.fuel == pytest.approx(0.38 * trim_power / 1e3 / 60.0, rel=0.01)


@pytest.mark.parametrize("command", [3060.0, 2940.0])
def test_height_step_is_taken_without_much_overshoot(twin: Aircraft, command: float) -> None:
    start(twin)
    twin.command(0.0, command, 69.44)
    side = math.copysign(1.0, command - 3000.0)
    past = []
    for step in range(120 * 120):
        hold(twin, 1, *CALM)
        if step % 120 == 0:
            past.append(side * (twin.state().height - command))
    assert max(past) < 4.0
    assert past[-1] == pytest.approx(0.0, abs=0.5)


def test_speed_step(twin: Aircraft) -> None:
    start(twin)
    twin.command(0.0, 3000.0, 75.0)
    hold(twin, 14_400, *CALM)
    state = twin.state()
    assert state.airspeed == pytest.approx(75.0, abs=0.05)
    assert state.height == pytest.approx(3000.0, abs=0.5)


@pytest.mark.parametrize("rate", [60.0, 240.0])
def test_step_rate_does_not_change_the_flight(folder: Path, rate: float) -> None:
    # A filter that took another step than the flight's would move the height, speed and roll of this turn by
    # metres, m/s and degrees; a step of 1/60 s itself is worth 0.04 deg of roll (first order).
    states = []
    for each in (120.0, rate):
        aircraft = Aircraft(folder, each)
        start(aircraft)
        aircraft.command(0.3, 3010.0, 72.0)
        hold(aircraft, round(12.0 * each), *CALM)
        states.append(aircraft.state())
    expected, found = states
    assert found.t == pytest.approx(12.0)
    assert found.height == pytest.approx(expected.height, abs=0.1)
    assert found.airspeed == pytest.approx(expected.airspeed, abs=0.02)
    assert found.roll == pytest.approx(expected.roll, abs=math.radians(0.05))


def test_lost_aircraft_ends_the_run(twin: Aircraft) -> None:
    start(twin)
    with pytest.raises(RunFailure, match=r"aircraft lost at \d\.\d\d s: its state is not finite"):
        hold(twin, 48, math.nan, *CALM[1:])


def test_gust_beyond_the_model_ends_the_run(twin: Aircraft) -> None:
    start(twin)
    with pytest.raises(RunFailure, match="angle of attack"):
        hold(twin, 48, 0.0, 0.0, -40.0, 0.0, 0.0, 0.0)


def test_empty_tank_ends_the_run(folder: Path) -> None:
    aircraft = Aircraft(folder, 120.0, fuel_kg=0.05)
    start(aircraft)
    with pytest.raises(RunFailure, match="fuel used up"):
        hold(aircraft, 360, *CALM)


@pytest.mark.parametrize(
    ("height", "airspeed", "message"),
    [
        (3000.0, 40.0, r"40 m/s at 3000 m is too near its stall .*\(\d+\.?\d* to \d+\.?\d* m/s\)"),
        (3000.0, 130.0, r"130 m/s at 3000 m is faster than it may fly .*\(\d+\.?\d* to \d+\.?\d* m/s\)"),
        (9000.0, 70.0, r"cannot fly at 9000 m \(-400 to 7600 m\)"),
        (3000.0, math.nan, "nan m/s"),
    ],
)
def test_speeds_outside_the_limits(twin: Aircraft, height: float, airspeed: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        twin.check_speed(height, airspeed)
    with pytest.raises(InputError, match=message):
        twin.start(0.9, 0.2, height, 0.0, airspeed)


def test_stall_speed_in_closed_form(twin: Aircraft) -> None:
    # Lift equal to weight at the greatest coefficient, sea level.
    area = 420.0 * 0.3048**2
    speed = math.sqrt(2.0 * 4600.0 * 9.80665 / (1.225 * area * 1.3))
    assert twin.limits.stall_speed(0.0, 4600.0) == pytest.approx(speed, rel=1e-9)


def test_wind_above_the_airspeed(twin: Aircraft) -> None:
    with pytest.raises(InputError, match=r"wind of 80 m/s cannot be flown against \(below 69.44 m/s\)"):
        start(twin, (80.0, 0.0, 0.0))


def test_bad_models(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="limits of the aircraft cannot be read"):
        Aircraft(tmp_path / "none", 120.0)
    twin = tmp_path / "survey_twin"
    shutil.copytree(folder, twin)
    model = twin / "survey_twin.xml"
    text = model.read_text(encoding="utf-8")
    model.write_text(text[: len(text) // 2], encoding="utf-8")
    with pytest.raises(InputError, match="aircraft model refused"):
        Aircraft(twin, 120.0)
    model.unlink()
    with pytest.raises(InputError, match="no aircraft model"):
        Aircraft(twin, 120.0)
    (twin / "limits.yaml").write_text("model: survey_twin\n", encoding="utf-8")
    with pytest.raises(InputError, match="not complete"):
        Aircraft(twin, 120.0)


@pytest.mark.parametrize(("rate", "fuel"), [(0.0, None), (math.nan, None), (120.0, -1.0), (120.0, 5000.0)])
def test_bad_numbers(folder: Path, rate: float, fuel: float | None) -> None:
    with pytest.raises(InputError):
        Aircraft(folder, rate, fuel)
