"""Three aerial-survey flights that really were flown, as their signals were received: replayed over made land."""

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from flown_paths import SteadyAir

from aerosim.flight.replay.replay import Replay, ReplayParameters, prepare
from aerosim.flight.replay.replay_flight import ReplayFlight
from aerosim.frames import WGS84_A, Array, wrap_pi
from aerosim.record import Record
from aerosim.scenario import from_mapping
from aerosim.simulate import simulate
from aerosim.world.synthetic import Ground, make_terrain

# data that is handed out beside the project, and is not part of it
DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "real_flights"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data/real_flights is not there")

KNOT, FOOT = 1852.0 / 3600.0, 0.3048
WIND, WIND_FROM = 6.7, 296.6  # m/s, deg; nobody wrote down what it was


class Case(NamedTuple):
    """A flight: part of it with one line (s), steps of its height (ft), lines in all at least."""

    name: str
    first: float
    last: float
    height_step: float
    lines: int


CASES = (
    Case("ign_fontainebleau", 8750.0, 9200.0, 100.0, 40),
    Case("liguria", 1500.0, 1780.0, 25.0, 30),
    Case("pixair_toulouse", 2600.0, 2790.0, 100.0, 20),
)


def replay_of(case: Case, whole: bool) -> Replay:
    span = {} if whole else {"first": case.first, "last": case.last}
    return prepare(DATA / f"{case.name}.csv", ReplayParameters(**span))


def flown(case: Case, replay: Replay, folder: Path, whole: bool) -> Record:
    """The part of the file flown closed loop over land made around its lines, three pixels to one of the rows."""
    detail = replay.height / 132.6
    ways = []
    for line in replay.lines:
        lat, lon, _ = replay.path.place(np.arange(line.run_in, line.end + 5.0, 5.0))
        ways.append((lat, lon))
    ground = Ground(0.0, 0.0, round(detail / 3.0, 1), 50.0, detail)
    photo, heights = make_terrain(ways, 0.9 * replay.height, ground, folder)
    part = {} if whole else {"from_s": case.first, "to_s": case.last}
    scenario = from_mapping({
        "name": "real",
        "terrain": {"source": {"orthophoto": str(photo), "elevation": str(heights)}},
        "air": {"wind": {"speed_m_s": WIND, "from_deg": WIND_FROM}},
        "flight": {"replay": {"file": str(DATA / f"{case.name}.csv"), **part}},
        "control": {"mode": "pipelined"},
        "record": {"exclude_first_s": 20, "rrd": False, "report": False},
    })  # fmt: skip
    return simulate(scenario)


def share_locked(record: Record) -> tuple[float, int]:
    """Part of the strips decided on lines that were accepted, and how many these are."""
    strips, telemetry = record.matches, record.telemetry
    at = np.searchsorted(telemetry["t_s"], strips["t_decided_s"], side="right") - 1
    on_line = telemetry["line"][at] >= 0
    return float(strips["accepted"][on_line].mean()), int(on_line.sum())


ONE_BY_DEFAULT = [
    pytest.param(case, id=case.name, marks=[pytest.mark.slow] if k else []) for k, case in enumerate(CASES)
]


@pytest.mark.parametrize("case", ONE_BY_DEFAULT)
def test_strips_lock_on_a_straight_part(case: Case, tmp_path: Path) -> None:
    replay = replay_of(case, whole=False)
    assert len(replay.lines) == 1
    record = flown(case, replay, tmp_path, whole=False)
    assert record.status == "done", record.reason
    share, strips = share_locked(record)
    assert strips > 100
    assert share >= 0.8
    # what the camera made of it: the wind's drift is taken out to a degree, v/h known to a few per cent
    summary = record.summary
    assert abs(summary["flight"]["drift_mean_deg"]) > 2.0
    assert summary["crab"]["residual_rms_deg"] < 1.5
    assert summary["vh"]["strip_error_rms_pct"] < 3.0


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_strips_lock_on_all_straight_parts(case: Case, tmp_path: Path) -> None:
    replay = replay_of(case, whole=True)
    assert len(replay.lines) >= case.lines
    record = flown(case, replay, tmp_path, whole=True)
    assert record.status == "done", record.reason
    share, strips = share_locked(record)
    assert strips > 2000
    assert share >= 0.8


class Off(NamedTuple):
    """What the points on the lines are off the path: s before or behind, m aside, and the columns' residuals."""

    stamp: Array
    aside: Array
    height: Array
    speed: Array
    track: Array


def residuals(replay: Replay) -> Off:
    points = replay.points
    on_line = np.zeros(len(points), bool)
    for line in replay.lines:
        on_line |= (points.t >= line.start) & (points.t <= line.end)
    points = points.part(on_line)
    path = replay.path.motion(points.t)
    speed = np.hypot(*path.vel_n[:, :2].T)
    course = np.arctan2(path.vel_n[:, 1], path.vel_n[:, 0])
    north = (points.lat - path.lat) * WGS84_A
    east = (points.lon - path.lon) * WGS84_A * np.cos(points.lat)
    return Off(
        (north * np.cos(course) + east * np.sin(course)) / speed,
        east * np.cos(course) - north * np.sin(course),
        points.height - path.height,
        points.speed - speed,
        wrap_pi(points.track - course),
    )


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_time_path_and_speed_are_those_of_the_file(case: Case, caplog: pytest.LogCaptureFixture) -> None:
    """Within the steps of each column, on all straight parts of the whole flight."""
    caplog.set_level(logging.INFO)
    replay = replay_of(case, whole=True)
    assert len(replay.lines) >= case.lines
    off = residuals(replay)
    assert len(off.stamp) > 300
    # time: stamps of points are late by 0 to 8 s, found from the points themselves; no more is made of it
    assert np.abs(np.median(off.stamp)) < 1.0
    assert np.quantile(np.abs(off.stamp), 0.95) < 6.0
    assert off.stamp.std() < 2.5
    # path: a position by compact position reports is good to 5 m, and twice that where receivers mix them
    assert np.median(np.abs(off.aside)) < 5.1
    assert abs(off.aside.mean()) < 1.0
    # height: one step of the altimeter
    assert np.quantile(np.abs(off.height), 0.95) < case.height_step * FOOT
    assert abs(off.height.mean()) < 0.25 * case.height_step * FOOT
    # speed: steps of one knot (0.3 kt rms) and a knot of smoothing; track: cut off to whole degrees
    assert abs(off.speed.mean()) < 0.5 * KNOT
    assert off.speed.std() < 1.0 * KNOT
    assert -1.0 < math.degrees(np.median(off.track)) < 0.5
    assert np.quantile(np.abs(off.track), 0.95) < math.radians(3.0)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_nothing_wiggles_that_did_not_fly(case: Case) -> None:
    """Roll, climb and speed on the straight parts are those of a survey aircraft in calm air."""
    replay = replay_of(case, whole=False)
    flight = ReplayFlight(replay, SteadyAir(-3.0, 6.0), 3, 120.0)
    rows = []
    while not flight.done:
        if flight.line >= 0:
            rows.append(flight.state())
        flight.advance(12)
    state = np.array(rows)
    assert np.degrees(state[:, 7].std()) < 1.5
    assert np.degrees(np.sqrt((state[:, 10:13] ** 2).mean(axis=0))).max() < 0.7
    assert np.abs(np.gradient(np.hypot(state[:, 4], state[:, 5]), 0.1)).max() < 1.0


def test_a_short_part_is_smoothed_like_the_whole_flight() -> None:
    """Seventeen points alone would say nothing of their scatter, and each would be followed."""
    file = DATA / "ign_fontainebleau.csv"
    part = prepare(file, ReplayParameters(first=9000.0, last=9200.0))
    assert len(part.points) < 20
    whole = prepare(file, ReplayParameters())
    assert part.path.scatter == whole.path.scatter
    t = np.arange(9040.0, 9160.0, 1.0)
    (a, b), (c, d) = (replay.path.place(t)[:2] for replay in (part, whole))
    # the rest of the flight is not seen: metres at the scatter of 10 m across and 90 m along
    assert np.hypot((a - c) * WGS84_A, (b - d) * WGS84_A * np.cos(a)).max() < 60.0
