from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerosim.errors import InputError
from aerosim.flight.turns import Shape, Turn, plan_turn, roll_lag, turn_radius

AIRSPEED = 69.44
BANK = math.radians(18.0)
RADIUS = turn_radius(AIRSPEED, BANK)


def flown(
    turn: Turn, position: tuple[float, float], heading: float, wind: tuple[float, float]
) -> tuple[np.ndarray, float]:
    """The turn integrated in time, as an aircraft that banks at once would fly it: end position and heading."""
    rate = AIRSPEED / RADIUS
    lag = roll_lag(BANK)
    parts = [
        (lag, 0.0),
        (turn.angle_first / rate, turn.first * rate),
        (turn.straight_s, 0.0),
        (turn.angle_last / rate, turn.last * rate),
        (lag, 0.0),
    ]
    at = np.array(position)
    for duration, turning in parts:
        count = 4000
        # Midpoints of small steps: error of the arcs below (rate step)^2 / 24 of the radius, a millimetre.
        headings = heading + turning * duration * (np.arange(count) + 0.5) / count
        velocity = AIRSPEED * np.array([np.cos(headings).mean(), np.sin(headings).mean()]) + np.array(wind)
        at = at + duration * velocity
        heading += turning * duration
    return at, heading


@settings(deadline=None, max_examples=150)
@given(
    st.tuples(st.floats(-15e3, 15e3), st.floats(-15e3, 15e3)),
    st.floats(-math.pi, math.pi),
    st.floats(0.0, 0.6),
    st.floats(-math.pi, math.pi),
)
def test_turn_arrives_on_the_line(
    position: tuple[float, float], heading: float, share: float, wind_to: float
) -> None:
    wind = (share * AIRSPEED * math.cos(wind_to), share * AIRSPEED * math.sin(wind_to))
    turn = plan_turn(position, heading, AIRSPEED, wind, RADIUS, BANK)
    at, end = flown(turn, position, heading, wind)
    assert at == pytest.approx([0.0, 0.0], abs=0.5)
    track = math.atan2(AIRSPEED * math.sin(end) + wind[1], AIRSPEED * math.cos(end) + wind[0])
    assert math.sin(track) == pytest.approx(0.0, abs=1e-6)
    assert turn.straight_s >= 0.0


def test_same_line_back_is_a_tear_drop_of_least_length() -> None:
    # From Dubins (1957) for a turn back onto the same line, the target a distance d ahead: both arcs' centres lie
    # on one side of the line, d apart (the lags before and after shift both alike), and the straight part is
    # their inner tangent.
    distance = 4200.0
    turn = plan_turn((distance, 0.0), math.pi, AIRSPEED, (0.0, 0.0), RADIUS, BANK)
    straight = math.sqrt(distance**2 - 4.0 * RADIUS**2)
    assert turn.straight_s == pytest.approx(straight / AIRSPEED, rel=1e-6)
    assert turn.first == -turn.last
    assert turn.angle_last - turn.angle_first == pytest.approx(math.pi)


def test_radius_in_closed_form() -> None:
    assert turn_radius(100.0, math.radians(45.0)) == pytest.approx(1e4 / 9.80665)


def test_wind_above_the_airspeed() -> None:
    with pytest.raises(InputError, match="in a turn"):
        plan_turn((0.0, 5000.0), 1.0, AIRSPEED, (0.0, 70.0), RADIUS, BANK)


def back_turn(
    spacing: float, run_in: float, wind: tuple[float, float] = (0.0, 0.0), heading: float | None = None
) -> Turn:
    """Turn from the end of one line of a block onto the run-in of the next, which goes back beside it.

    spacing: of the lines, m; run_in: from the target to the line, m.  The line's frame: x back along it, y right.
    """
    if heading is None:
        heading = math.pi - math.asin(-wind[1] / AIRSPEED)
    return plan_turn((run_in, spacing), heading, AIRSPEED, wind, RADIUS, BANK)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("spacing", [2.2, 3.0, 6.0])
def test_far_lines_take_a_race_track(spacing: float, side: float) -> None:
    # Without wind two right angles with a straight part across, as long as the spacing less the two radii.
    turn = back_turn(side * spacing * RADIUS, 0.0)
    assert turn.shape is Shape.RACE_TRACK
    assert turn.first == turn.last == side
    assert np.degrees([turn.angle_first, turn.angle_last]) == pytest.approx(90.0, abs=0.1)
    assert turn.straight_s == pytest.approx((spacing - 2.0) * RADIUS / AIRSPEED, abs=0.1)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("run_in", [3000.0, 4200.0, 8000.0])
@pytest.mark.parametrize("spacing", [300.0, 800.0, 1500.0])
def test_near_lines_take_a_teardrop_or_a_procedure_turn(spacing: float, run_in: float, side: float) -> None:
    # Two circles that touch a straight from opposite sides: their centres are a spacing apart across the line and
    # the run-in along it, since the two lags are flown in opposite directions.  The straight's angle is the lead.
    apart = math.hypot(run_in, spacing)
    turn = back_turn(side * spacing, run_in)
    if apart < 2.0 * RADIUS:
        assert turn.shape is Shape.RACE_TRACK
        return
    lead = math.asin(2.0 * RADIUS / apart) - math.atan2(spacing, run_in)
    assert turn.first == -turn.last
    assert turn.angle_first == pytest.approx(lead, abs=1e-3)
    assert turn.angle_last == pytest.approx(math.pi + lead, abs=1e-3)
    assert turn.shape is (Shape.TEARDROP if lead < math.radians(45.0) else Shape.PROCEDURE)


@pytest.mark.parametrize(("lead", "shape"), [(44.0, "teardrop"), (46.0, "procedure"), (80.0, "procedure")])
def test_shape_is_the_same_flown_backwards(lead: float, shape: str) -> None:
    # The 80/260 and the 45/180 procedure turn of ICAO Doc 8168, and a base turn, from either end.
    for arcs in ((lead, 180.0 + lead), (180.0 + lead, lead)):
        first, last = (math.radians(arc) for arc in arcs)
        assert Turn(-1, first, 0.0, 10.0, 1, last, 0.0, 200.0).shape == shape
        assert Turn(1, first, 0.0, 10.0, 1, last, 0.0, 200.0).shape == "race_track"


def test_lines_in_the_same_direction_take_an_s_turn() -> None:
    turn = plan_turn((-20_000.0, 1500.0), 0.0, AIRSPEED, (0.0, 0.0), RADIUS, BANK)
    assert turn.shape is Shape.S_TURN
    assert turn.angle_first == pytest.approx(turn.angle_last, abs=1e-6)


@pytest.mark.parametrize("from_deg", range(0, 360, 30))
@pytest.mark.parametrize("speed", [6.0, 15.0])
@pytest.mark.parametrize("spacing", [400.0, 1500.0, 4500.0])
def test_shape_says_what_is_flown(spacing: float, speed: float, from_deg: int) -> None:
    # Counted on the nose as it swings: a lead goes out to the other side first, a race-track never does.
    wind = (-speed * math.cos(math.radians(from_deg)), -speed * math.sin(math.radians(from_deg)))
    turn = back_turn(spacing, 6000.0, wind)
    swing = np.degrees(np.cumsum([turn.first * turn.angle_first, turn.last * turn.angle_last]))
    if turn.shape == "race_track":
        assert (np.diff([0.0, *swing]) >= 0.0).all() or (np.diff([0.0, *swing]) <= 0.0).all()
    else:
        lead = abs(swing[0]) if abs(swing[0]) < abs(np.diff(swing)[0]) else abs(np.diff(swing)[0])
        assert swing[0] * np.diff(swing)[0] < 0.0
        assert turn.shape == ("teardrop" if lead < 45.0 else "procedure")
    # With a run-in longer than a turn is wide, near lines take a lead in any wind, far ones none.
    assert (turn.shape == "race_track") == (spacing > 2.5 * RADIUS)
