from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from aerosim.errors import InputError, RunFailure
from aerosim.flight.guidance import Phase
from aerosim.flight.jsbsim_flight import JsbsimFlight, bare_loop
from aerosim.flight.plan import Line
from aerosim.truth import AirState

from .conftest import AIRSPEED, HEIGHT, Steady, beside, line_of, steps

Make = Callable[..., JsbsimFlight]


@pytest.mark.parametrize("wind", [(0.0, 0.0), (-10.0, 0.0), (7.0, -9.0)])
def test_line_is_held_in_steady_wind(fly: Make, wind: tuple[float, float]) -> None:
    flight = fly([line_of(90.0, 15_000.0)], wind, run_in_s=20.0)
    assert abs(flight.cross_track) < 0.01
    phases, worst, heights = [], 0.0, []
    for step in steps(flight, 400.0):
        if step % 12 == 0:
            worst = max(worst, abs(flight.cross_track))
            heights.append(flight.state().height)
        if not phases or flight.phase is not phases[-1]:
            phases.append(flight.phase)
        assert flight.line == (0 if flight.phase is Phase.LINE else -1)
    assert phases == [Phase.RUN_IN, Phase.LINE, Phase.DONE]
    assert worst < 1.0
    assert heights == pytest.approx([HEIGHT] * len(heights), abs=0.5)


def test_line_begins_and_ends_where_it_should(fly: Make) -> None:
    line = line_of(90.0, 8000.0)
    flight = fly([line], run_in_s=20.0)
    at = {}
    for _ in steps(flight, 300.0):
        at.setdefault(flight.phase, flight.state())
    assert at[Phase.LINE].t == pytest.approx(20.0, abs=0.06)
    # One period of the guidance, 0.05 s, is 3.5 m.
    assert (at[Phase.LINE].lon - line.start[1]) * 6.38e6 * math.cos(0.89) == pytest.approx(0.0, abs=4.0)
    end = flight.state()
    assert (end.lon - line.end[1]) * 6.38e6 * math.cos(0.89) == pytest.approx(0.0, abs=4.0)


def test_off_the_line_is_flown_back_to_it(fly: Make) -> None:
    flight = fly([line_of(0.0, 20_000.0)], run_in_s=5.0)
    start = line_of(0.0, 20_000.0).before_start(300.0, HEIGHT)
    lat, lon = beside(start, 200.0, 0.0)
    flight.aircraft.start(lat, lon, HEIGHT, 0.0, AIRSPEED)
    assert flight.cross_track == pytest.approx(200.0, abs=1.0)
    offsets = [flight.cross_track for _ in steps(flight, 400.0)]
    assert np.abs(offsets[60 * 120 :]).max() < 10.0
    assert np.abs(offsets[-120:]).max() < 0.5


def block(course_deg: float, spacing: float) -> list[Line]:
    """A line, and its neighbour flown back; no spacing: the same line back."""
    first = line_of(course_deg, 6000.0)
    right = math.radians(course_deg + 90.0)
    east, north = spacing * math.sin(right), spacing * math.cos(right)
    return [first, Line(beside(first.end, east, north), beside(first.start, east, north))]


@pytest.mark.parametrize("spacing", [0.0, 700.0, -3500.0])
@pytest.mark.parametrize("wind", [(0.0, 0.0), (0.0, 12.0), (-12.0, 0.0), (8.5, -8.5)])
def test_next_line_is_captured_before_it_begins(fly: Make, spacing: float, wind: tuple[float, float]) -> None:
    flight = fly(block(90.0, spacing), wind)
    forecast = flight.plan.forecast(*wind)
    offsets, rolls = [], []
    for _ in steps(flight, 1500.0):
        roll, _, _ = flight.aircraft.attitude()
        assert abs(roll) < math.radians(20.5)
        if flight.line == 1:
            assert flight.next_line == 1
            offsets.append(flight.cross_track)
            rolls.append(roll)
    assert len(offsets) > 60 * 120
    assert np.abs(offsets).max() < 3.0
    assert np.degrees(np.abs(rolls)).max() < 0.5
    assert flight.state().t == pytest.approx(forecast.duration, rel=0.02)


def test_wind_from_the_other_side_mirrors_the_drift(fly: Make) -> None:
    drift = {}
    for wind_north in (-10.0, 10.0):
        flight = fly([line_of(90.0, 6000.0)], (wind_north, 0.0), run_in_s=10.0)
        flight.advance(120 * 40)
        state = flight.state()
        drift[wind_north] = math.degrees(math.atan2(state.v_east, state.v_north) - state.heading)
    assert drift[-10.0] == pytest.approx(math.degrees(math.asin(10.0 / AIRSPEED)), abs=0.05)
    # What holds the course against the Earth's rotation does not mirror: 0.05 deg of bank, seen at 1.7 deg of
    # pitch, and the sideslip of a centred ball, below 0.01 deg.
    assert drift[10.0] == pytest.approx(-drift[-10.0], abs=0.02)


def test_gusts_come_along_the_axes_of_the_body(fly: Make) -> None:
    # The airspeed vector is what JSBSim makes of velocity over ground, wind and gust: put into the body by us.
    from aerosim.frames import mat_from_attitude

    flight = fly([line_of(37.0, 20_000.0)], (3.0, -4.0))
    flight.aircraft.command_roll(0.2)
    flight.advance(240)
    before = flight.state()  # guidance is due in this step, so the gust is turned by the attitude of now
    mat_nb = mat_from_attitude(before.heading, before.pitch, before.roll)
    gust_b = np.array([2.0, -3.0, 4.0])
    blow(flight, AirState(3.0, -4.0, 0.0, *gust_b, 0.0, 0.0, 0.0))
    flight.advance(1)
    assert flight.air.u == 2.0
    names = ("north", "east", "down")
    found = [flight.aircraft._fdm[f"atmosphere/wind-{name}-fps"] * 0.3048 for name in names]
    assert found == pytest.approx(mat_nb @ gust_b + [3.0, -4.0, 0.0], abs=1e-9)


def blow(flight: JsbsimFlight, state: AirState) -> None:
    """Other air from the next state on."""
    assert isinstance(flight._air, Steady)
    flight._air.state = state


def gusty(flight: JsbsimFlight, sigma: float, seconds: int, seed: int) -> dict[str, np.ndarray]:
    """A flight through first-order gusts of the given sigma (m/s), 533 m long, and rates that go with them."""
    rng = np.random.default_rng(seed)
    keep = math.exp(-AIRSPEED / 533.0 / 40.0)
    keep_rate = math.exp(-math.pi * AIRSPEED / (4.0 * 19.8) / 40.0)
    noise = rng.normal(0.0, sigma * math.sqrt(1.0 - keep**2), (seconds * 40, 3)).tolist()
    # rms of the roll gust by MIL-F-8785C for 19.8 m of span and this length: 0.0160 rad/s for each m/s.
    rates = rng.normal(0.0, 0.016 * sigma * math.sqrt(1.0 - keep_rate**2), seconds * 40).tolist()
    u = v = w = p = 0.0
    rows = []
    for index, (du, dv, dw) in enumerate(noise):
        u, v, w = keep * u + du, keep * v + dv, keep * w + dw
        p = keep_rate * p + rates[index]
        blow(flight, AirState(-8.0, 0.0, 0.0, u, v, w, p, 0.0, 0.0))
        flight.advance(3)
        if index % 2 == 0:
            state = flight.state()
            rows.append((flight.cross_track, state.height - HEIGHT, state.roll, state.p, state.q, state.r))
    return dict(zip(("across", "height", "roll", "p", "q", "r"), np.transpose(rows), strict=True))


@pytest.mark.parametrize(
    ("sigma", "seconds", "across"),
    [(1.4, 200, 8.0), pytest.param(0.7, 1200, 4.0, marks=pytest.mark.slow),
     pytest.param(1.4, 1200, 8.0, marks=pytest.mark.slow)],
)  # fmt: skip
def test_line_is_held_in_gusts(fly: Make, sigma: float, seconds: int, across: float) -> None:
    flight = fly([line_of(90.0, 110_000.0)], (-8.0, 0.0), run_in_s=5.0)
    found = gusty(flight, sigma, seconds, seed=4)
    rms = {name: math.sqrt(np.mean(column**2)) for name, column in found.items()}
    assert rms["across"] < across
    assert rms["height"] < 5.0
    # Survey turbulence: roll rate amplitudes up to 4 deg/s at the medium level, and no more than 2 deg of roll.
    assert np.degrees(np.abs(found["p"])).max() < 4.0
    assert math.degrees(rms["roll"]) < 1.0
    assert rms["q"] < rms["p"]


@pytest.mark.slow
@pytest.mark.parametrize("wind_to", range(0, 360, 45))
def test_block_of_ten_lines_in_wind_and_gusts(fly: Make, wind_to: int) -> None:
    # Photos begin with roll below 2 deg and cross-track below 15 m on every line, at sigma 0.7 m/s.
    wind = (12.0 * math.cos(math.radians(wind_to)), 12.0 * math.sin(math.radians(wind_to)))
    corner = (0.89, 0.23)
    rows = [(beside(corner, 0.0, 800.0 * k), beside(corner, 10_000.0, 800.0 * k)) for k in range(10)]
    flight = fly([Line(*row) if k % 2 == 0 else Line(*row[::-1]) for k, row in enumerate(rows)], wind)
    rng = np.random.default_rng(wind_to)
    keep, gust, line, begun, offsets = math.exp(-AIRSPEED / 533.0 / 40.0), np.zeros(3), -1, 0, []
    while not flight.done:
        gust = keep * gust + rng.normal(0.0, 0.7 * math.sqrt(1.0 - keep**2), 3)
        blow(flight, AirState(*wind, 0.0, *gust.tolist(), 0.0, 0.0, 0.0))
        flight.advance(3)
        if flight.line != line:
            line = flight.line
            if line >= 0:
                begun += 1
                assert abs(flight.cross_track) < 15.0
                assert abs(flight.aircraft.attitude()[0]) < math.radians(2.0)
        if line >= 0:
            offsets.append(flight.cross_track)
    assert begun == 10
    assert np.std(offsets) < 4.0
    assert flight.state().t == pytest.approx(flight.plan.forecast(*wind).duration, rel=0.03)


def test_wind_that_rises_above_the_airspeed_ends_the_run(fly: Make) -> None:
    flight = fly(block(90.0, 700.0), run_in_s=0.0)
    guidance = flight._guidance
    at = flight.aircraft.ecef()
    end = flight.plan.lines[0].end_points(HEIGHT)[1] + 10.0 * flight.plan.lines[0].forward_end
    guidance.update((*end.tolist(), *at[3:]), 0.0, 0.0, 0.0, 0.0)
    assert guidance.line == 0
    with pytest.raises(RunFailure, match="line 1 cannot be reached: wind of 80 m/s"):
        guidance.update((*end.tolist(), *at[3:]), 0.0, 0.0, 80.0, 0.0)


def test_commands_do_not_chatter_or_saturate_in_gusts(fly: Make) -> None:
    flight = fly([line_of(90.0, 60_000.0)], (-8.0, 0.0), run_in_s=5.0)
    commands = []
    command = flight.aircraft.command_roll

    def listen(roll: float) -> None:
        commands.append(math.degrees(roll))
        command(roll)

    flight.aircraft.command_roll = listen
    gusty(flight, 1.4, 120, seed=5)
    assert np.abs(commands).max() < 5.0
    # 20 Hz: a change of 0.1 deg from call to call would be 2 deg/s.
    assert np.std(np.diff(commands)) < 0.1


def test_bare_loop_flies_the_same_aircraft(fly: Make) -> None:
    flight = fly([line_of(90.0, 20_000.0)], (-8.0, 0.0))
    bare_loop(flight.aircraft, 1200)
    state = flight.state()
    assert state.height == pytest.approx(HEIGHT, abs=0.1)
    assert state.airspeed == pytest.approx(AIRSPEED, abs=0.02)


def test_line_that_the_wind_forbids(fly: Make) -> None:
    with pytest.raises(InputError, match="wind of 75 m/s"):
        fly([line_of(90.0, 6000.0)], (75.0, 0.0))
