"""What the reference controller is told."""

import math

import pytest

from aerosim.sensing.oracle import tell
from aerosim.truth import AircraftState


def state(heading_deg, track_deg, speed=70.0):
    track = math.radians(track_deg)
    north, east = speed * math.cos(track), speed * math.sin(track)
    return AircraftState(
        12.5, 0.6, -1.4, 3300.0, north, east, 3.0, 0.1, 0.05, math.radians(heading_deg), 0, 0, 0, 60.0
    )


@pytest.mark.parametrize(
    ("heading", "track", "drift"), [(80, 90, 10), (90, 80, -10), (179, -179, 2), (1, 359, -2), (360, 5, 5)]
)
def test_drift_is_track_less_heading(heading, track, drift):
    # The wind from the left carries the aircraft to the right of its heading: drift is positive.
    assert math.degrees(tell(state(heading, track), 300.0).drift) == pytest.approx(drift, abs=1e-9)


def test_vh_is_level_ground_speed_over_height_above_the_terrain():
    told = tell(state(0, 0), 300.0)
    assert told.vh == pytest.approx(70.0 / 3000.0)
    assert (told.t, told.sigma_drift, told.sigma_vh, told.valid) == (12.5, 0.0, 0.0, True)
