"""A flight by JSBSim, recorded and flown again; lines found and matched; the flight's interface."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flown_paths import PLACE, SteadyAir, columns_of, on_plane, race_track, write_csv

from aerosim import assets
from aerosim.errors import InputError
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.guidance import Phase
from aerosim.flight.jsbsim_flight import JsbsimFlight
from aerosim.flight.plan import FlightPlan, Line
from aerosim.flight.replay.replay import Replay, ReplayParameters, prepare
from aerosim.flight.replay.replay_flight import ReplayFlight
from aerosim.frames import WGS84_A, Array
from aerosim.rng import generator
from aerosim.truth import AircraftState
from aerosim.world.process import GaussProcess

RATE = 120.0
START = (0.89, 0.23)
WIND = (-11.28, 4.10)  # 12 m/s from 340 deg


def beside(north: float, east: float) -> tuple[float, float]:
    return START[0] + north / WGS84_A, START[1] + east / (WGS84_A * math.cos(START[0]))


LINES = [Line(beside(0, 0), beside(0, 7000)), Line(beside(1500, 7000), beside(1500, 0))]
# A second into the end of a record with ten seconds between points nobody can see.
SHORTER = [LINES[0], Line(beside(1500, 7000), beside(1500, 1500))]


class Gusty(SteadyAir):
    """A steady wind and vertical gusts that roll nobody, of 0.4 m/s."""

    def __init__(self) -> None:
        super().__init__(*WIND)
        source = GaussProcess([[-0.15]], [[0.4 * math.sqrt(0.3)]], [[1.0]], 3 / RATE, generator(1, "w"))
        self.gusts = source.draw(40 * 1200)[:, 0].tolist()

    def at(self, index: int, where: Any) -> Any:
        return self.state._replace(w=self.gusts[index])


@pytest.fixture(scope="module")
def flown() -> Array:
    """State, line, cross-track of each step, (n, 16)."""
    plan = FlightPlan(LINES, 3000.0, 69.44, run_in_s=40.0)
    flight = JsbsimFlight(Aircraft(assets.folder("aircraft") / "survey_twin", RATE), plan, Gusty(), 3)
    rows = []
    while not flight.done:
        rows.append((*flight.state(), flight.line, flight.cross_track))
        flight.advance(1)
    return np.array(rows)


def recorded(flown: Array, path: Path, every: int, attitude: bool, coarse: bool) -> Path:
    """Files of that flight: exact, or as a receiver on the ground has it."""
    rows = flown[::every]
    state = AircraftState(*rows.T[:14])
    columns = {"t_s": state.t, "latitude_deg": np.degrees(state.lat), "longitude_deg": np.degrees(state.lon)}
    formats = {"t_s": ".3f", "latitude_deg": ".9f", "longitude_deg": ".9f", "height_m": ".3f"}
    if coarse:
        columns["barometric_altitude_ft"] = 25.0 * np.round(state.height / 0.3048 / 25.0)
        columns["groundspeed_kt"] = np.round(np.hypot(state.v_north, state.v_east) * 3600.0 / 1852.0)
        columns["track_deg"] = np.round(np.degrees(np.arctan2(state.v_east, state.v_north)) % 360.0)
        formats |= {"latitude_deg": ".5f", "longitude_deg": ".5f"}
    else:
        columns["height_m"] = state.height
    if attitude:
        columns |= {f"{name}_deg": np.degrees(getattr(state, name)) for name in ("roll", "pitch", "heading")}
    return write_csv(path, columns, formats)


def replayed(replay: Replay, air: Any) -> Array:
    flight = ReplayFlight(replay, air, 3, RATE)
    rows = []
    while not flight.done:
        rows.append((*flight.state(), flight.line, flight.cross_track))
        flight.advance(1)
    found = np.array(rows)
    found[:, 0] += replay.begin
    return found


def error(found: Array, flown: Array, name: str) -> Array:
    """Replay less truth on the lines, at the same times."""
    index = AircraftState._fields.index(name)
    here = found[found[:, 14] >= 0]
    angle = name in ("heading", "roll", "pitch")
    true = np.interp(here[:, 0], flown[:, 0], np.unwrap(flown[:, index]) if angle else flown[:, index])
    off = here[:, index] - true
    return np.asarray(np.mod(off + math.pi, 2.0 * math.pi) - math.pi if angle else off)


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def place_error(found: Array, flown: Array) -> Array:
    north = error(found, flown, "lat") * WGS84_A
    return np.hypot(north, error(found, flown, "lon") * WGS84_A * math.cos(START[0]))


def test_ten_points_a_second_give_the_flight_back(flown: Array, tmp_path: Path) -> None:
    file = recorded(flown, tmp_path / "a.csv", 12, attitude=True, coarse=False)
    replay = prepare(file, ReplayParameters(run_in=40.0), LINES)
    found = replayed(replay, Gusty())
    # decimals: 0.1 mm, 1 mm; the smoothing of what moves at 1 Hz costs as much again
    assert place_error(found, flown).max() < 3e-3
    assert np.abs(error(found, flown, "height")).max() < 3e-3
    for name in ("v_north", "v_east", "v_down"):
        # a tenth of a millimetre in a tenth of a second and three more in height (1 mm rounded)
        assert rms(error(found, flown, name)) < (1e-2 if name == "v_down" else 5e-3)
        assert np.abs(error(found, flown, name)).max() < 0.03
    for name in ("roll", "pitch", "heading"):
        assert np.abs(np.degrees(error(found, flown, name))).max() < 0.01
    for name in ("p", "q", "r"):
        assert np.degrees(rms(error(found, flown, name))) < 0.05
    # the same air was met, so the airspeed is the same
    assert rms(error(found, flown, "airspeed")) < 0.05
    on_line = found[:, 14] >= 0
    true = np.interp(found[on_line, 0], flown[:, 0], flown[:, 15])
    assert np.abs(found[on_line, 15] - true).max() < 5e-3


def test_drift_and_v_over_h_come_from_position_and_wind_alone(flown: Array, tmp_path: Path) -> None:
    """No attitude in the file: drift is the wind triangle's."""
    file = recorded(flown, tmp_path / "a.csv", 12, attitude=False, coarse=False)
    found = replayed(prepare(file, ReplayParameters(run_in=40.0), LINES), Gusty())
    heading = np.degrees(error(found, flown, "heading"))
    # what JSBSim's aircraft slips and its dutch roll wags is not in the path: tenths of a degree
    assert abs(heading.mean()) < 0.1
    assert rms(heading) < 0.3
    assert abs(np.degrees(error(found, flown, "roll").mean())) < 0.15
    vh = np.hypot(found[:, 4], found[:, 5])[found[:, 14] >= 0]
    here = found[found[:, 14] >= 0]
    true = np.interp(here[:, 0], flown[:, 0], np.hypot(flown[:, 4], flown[:, 5]))
    assert np.abs(vh / true - 1.0).max() < 1e-3


def test_points_of_a_receiver_give_the_flight_back_within_their_steps(flown: Array, tmp_path: Path) -> None:
    file = recorded(flown, tmp_path / "a.csv", 1200, attitude=False, coarse=True)
    replay = prepare(file, ReplayParameters(run_in=40.0), SHORTER)
    found = replayed(replay, Gusty())
    # 1e-5 deg is 1.1 m, a point each 10 s
    assert place_error(found, flown).max() < 3.0
    assert np.abs(error(found, flown, "height")).max() < 25 * 0.3048
    assert np.abs(error(found, flown, "v_east")).max() < 1852.0 / 3600.0
    assert abs(np.degrees(error(found, flown, "heading").mean())) < 0.15
    assert rms(np.degrees(error(found, flown, "heading"))) < 0.5


def test_its_rates_are_its_attitudes_derivative(flown: Array, tmp_path: Path) -> None:
    file = recorded(flown, tmp_path / "a.csv", 1200, attitude=False, coarse=True)
    found = replayed(prepare(file, ReplayParameters(run_in=40.0), SHORTER), SteadyAir(*WIND))
    state = AircraftState(*found.T[:14])
    roll, pitch, heading = (np.gradient(np.unwrap(a), 1 / RATE) for a in (state.roll, state.pitch, state.heading))
    p = roll - heading * np.sin(state.pitch)
    q = pitch * np.cos(state.roll) + heading * np.cos(state.pitch) * np.sin(state.roll)
    r = -pitch * np.sin(state.roll) + heading * np.cos(state.pitch) * np.cos(state.roll)
    # plus v/R of 1.1e-5 rad/s; turns included
    for mine, told in ((p, state.p), (q, state.q), (r, state.r)):
        assert np.abs(mine - told)[5:-5].max() < 5e-5


@pytest.fixture
def tracked(tmp_path: Path) -> Callable[..., Replay]:
    def make(lines: list[Line] | None = None, **more: Any) -> Replay:
        file = write_csv(tmp_path / "flight.csv", columns_of(race_track(rate=2.0)))
        return prepare(file, ReplayParameters(**{"shortest": 3000.0, "run_in": 20.0, **more}), lines or [])

    return make


def test_straight_parts_are_found(tracked: Callable[..., Replay]) -> None:
    replay = tracked()
    assert len(replay.lines) == 2
    first, second = replay.lines
    # legs of 6000 m at 60 m/s, a quarter at most is run-in; the turn's looking around costs 10 s at each end
    assert first.start - first.run_in == pytest.approx(20.0, abs=1.0)
    assert 60.0 < first.end - first.start < 80.0
    assert math.degrees(first.line.course) == pytest.approx(0.0, abs=0.1)
    assert abs(math.degrees(second.line.course)) == pytest.approx(180.0, abs=0.1)
    assert replay.ground_speed == pytest.approx(60.0, abs=0.05)
    assert replay.duration == pytest.approx(second.end - first.run_in)
    assert replay.plan(10.0, 0.0).airspeed == pytest.approx(60.0, abs=0.3)  # 50 one way, 70 the other
    told = replay.forecast(0.0, 6.0)
    assert told.line_s[0] * told.ground_speed[0] == pytest.approx(
        first.line.length * (1 + 1500 / WGS84_A), rel=1e-3
    )
    # north in a wind from the left that goes east: track 0, nose to the left of it
    assert math.degrees(told.drift[0]) == pytest.approx(math.degrees(math.atan2(6.0, 60.0)), abs=0.05)
    assert told.turn_s[0] == pytest.approx(second.run_in - first.end)


def test_phases_follow_each_other(tracked: Callable[..., Replay]) -> None:
    replay = tracked()
    flight = ReplayFlight(replay, SteadyAir(), 3, RATE)
    seen = [(flight.phase, flight.line, flight.next_line)]
    times = [0.0]
    while not flight.done:
        flight.advance(7)
        now = (flight.phase, flight.line, flight.next_line)
        if now != seen[-1]:
            seen.append(now)
            times.append(flight.state().t)
    assert seen == [
        (Phase.RUN_IN, -1, 0), (Phase.LINE, 0, 0), (Phase.TURN, -1, 1), (Phase.RUN_IN, -1, 1), (Phase.LINE, 1, 1),
        (Phase.DONE, -1, 1),
    ]  # fmt: skip
    wanted = [*replay.lines[0][1:], *replay.lines[1][1:]]
    assert np.array(times) + replay.begin == pytest.approx(wanted, abs=7 / RATE)


def test_the_air_is_asked_once_each_in_rising_order(tracked: Callable[..., Replay]) -> None:
    air = SteadyAir(3.0, 4.0)
    flight = ReplayFlight(tracked(), air, 3, RATE)
    while not flight.done:
        flight.advance(50)
        assert flight.air.wind_east == 4.0
    assert all(b == a + 1 for a, b in pairwise(air.asked))


def test_gusts_show_in_the_airspeed_and_move_nothing(tracked: Callable[..., Replay]) -> None:
    calm, gusty = (
        ReplayFlight(tracked(), SteadyAir(gust=gust), 3, RATE) for gust in ((0, 0, 0), (-2.0, 0.0, 0.0))
    )
    for flight in (calm, gusty):
        flight.advance(2000)
    a, b = calm.state(), gusty.state()
    assert b.airspeed - a.airspeed == pytest.approx(2.0, abs=0.01)
    assert b[:13] == a[:13]


def test_slow_wind_turns_the_nose_smoothly(tracked: Callable[..., Replay]) -> None:
    class Stepping(SteadyAir):
        """East wind of 6 m/s that begins at 30 s."""

        def at(self, index: int, where: Any) -> Any:
            return self.state._replace(wind_east=-6.0 * (index >= 30 * 40))

    flight = ReplayFlight(tracked(), Stepping(), 3, RATE)
    rows = []
    for _ in range(60 * 120):
        rows.append(flight.state())
        flight.advance(1)
    state = AircraftState(*np.array(rows).T)
    assert np.degrees(state.heading[0]) == pytest.approx(0.0, abs=0.1)
    # north against wind from the right: the nose 6/60 to the right
    assert np.degrees(state.heading[-1]) == pytest.approx(math.degrees(math.atan2(6.0, 60.0)), abs=0.1)
    assert np.degrees(np.abs(state.r).max()) < 6.0
    assert state.airspeed[-1] == pytest.approx(math.hypot(60.0, 6.0), abs=0.1)


def test_given_lines_are_matched_and_refused(tracked: Callable[..., Replay]) -> None:
    found = tracked().lines
    start, end = found[0].line.start, found[0].line.end
    aside = (start[0], start[1] + 200.0 / (WGS84_A * math.cos(start[0])))
    end_aside = (end[0], end[1] + 200.0 / (WGS84_A * math.cos(end[0])))
    line = tracked([Line(aside, end_aside)]).lines[0]
    assert (line.start, line.end) == pytest.approx((found[0].start, found[0].end), abs=0.2)
    assert line.start - line.run_in == pytest.approx(20.0, abs=1.0)
    with pytest.raises(
        InputError, match=r"line 0 is not flown in the trajectory \(it comes as near as 200 m; 100 m"
    ):
        tracked([Line(aside, end_aside)], within=100.0)
    with pytest.raises(InputError, match="line 0 is not flown"):
        tracked([Line(end, start)])  # the other way round
    with pytest.raises(InputError, match=r"line 1 is not flown in the trajectory .*after the line before"):
        tracked([found[1].line, found[0].line])


def test_a_line_that_is_left_on_its_way_is_not_flown(tmp_path: Path) -> None:
    t = np.arange(0.0, 150.0, 0.5)
    bulge = 600.0 * np.exp(-(((t - 75.0) / 15.0) ** 2))
    file = write_csv(tmp_path / "flight.csv", columns_of(on_plane(t, 60.0 * t, bulge, np.full_like(t, 1500.0))))
    line = Line(PLACE, (PLACE[0] + 8000.0 / WGS84_A, PLACE[1]))
    with pytest.raises(InputError, match="line 0 is not flown"):
        prepare(file, ReplayParameters(), [line])
    assert len(prepare(file, ReplayParameters(within=700.0), [line]).lines) == 1


def test_parts_that_hold_no_line_are_refused(tracked: Callable[..., Replay]) -> None:
    with pytest.raises(InputError, match="no straight and level part of 9000 m"):
        tracked(shortest=9000.0)
    with pytest.raises(InputError, match=r"0 points of .*flight.csv from 1000 to inf s"):
        tracked(first=1000.0)
    assert len(tracked(first=120.0).lines) == 1


def test_an_asked_part_with_a_long_gap_is_refused_and_the_rest_can_be_flown(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    columns = columns_of(race_track(rate=0.5, leg=9000.0))
    keep = (columns["t_s"] < 160.0) | (columns["t_s"] > 200.0)
    file = write_csv(tmp_path / "flight.csv", {name: values[keep] for name, values in columns.items()})
    parameters = {"shortest": 3000.0, "run_in": 20.0, "gap_max": 30.0}
    replay = prepare(file, ReplayParameters(**parameters))  # type: ignore[arg-type]
    assert "the flight is broken" in caplog.text
    assert all(not (line.run_in < 180.0 < line.end) for line in replay.lines)
    with pytest.raises(InputError, match=r"the flight is broken .*or one of 0 to 158 s, 202 to"):
        prepare(file, ReplayParameters(first=0.0, **parameters))  # type: ignore[arg-type]
    assert prepare(file, ReplayParameters(first=202.0, **parameters)).lines  # type: ignore[arg-type]


def test_carried_elsewhere_it_flies_the_same(tracked: Callable[..., Replay]) -> None:
    here, to = tracked(), (math.radians(36.5), math.radians(-84.3))
    there = tracked(move_to=to)
    assert there.lines[0].line.start == pytest.approx(to, abs=2e-7)
    flights = [ReplayFlight(replay, SteadyAir(), 3, RATE) for replay in (here, there)]
    for flight in flights:
        flight.advance(3000)
    a, b = (flight.state() for flight in flights)
    assert (b.v_north, b.v_east, b.height) == pytest.approx((a.v_north, a.v_east, a.height), abs=0.02)
