from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerosim.errors import InputError
from aerosim.flight.turns import Turn, plan_turn, roll_lag, turn_radius

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
