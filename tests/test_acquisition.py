"""A drift beyond the field of the rows: the camera starts along the airframe and has to look for the track."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flights import air, on_line, rms, scenario

from aerosim.simulate import simulate


@pytest.mark.parametrize("from_deg", [0.0, 180.0])
def test_a_drift_of_thirteen_degrees_is_found(from_deg: float) -> None:
    """16 m/s across 69.44 m/s drift by asin(16/69.44) = 13.3 deg; seven pixels of the rows are 10 deg."""
    record = simulate(
        scenario(12.0, air=air(16.0, from_deg), record={"exclude_first_s": 60, "rrd": False, "report": False})
    )
    expected = math.degrees(math.asin(16.0 / 69.44)) * (1.0 if from_deg == 0.0 else -1.0)
    # on the eastward line wind from the north comes from the left: drift positive
    assert np.mean(on_line(record, "drift_true_deg")) == pytest.approx(expected, abs=0.2)
    assert rms(on_line(record, "crab_true_deg", after=60.0)) < 0.5
    assert np.mean(on_line(record, "mount_yaw_deg", after=60.0)) == pytest.approx(expected, abs=0.4)


def test_no_strip_is_taken_before_the_wings_are_level() -> None:
    # Rolling out of a turn the rows see ground that slides sideways: strips of then once turned the camera away.
    record = simulate(scenario(4.0, back=True, air=air(8.0, 320.0), flight={"run_in_s": 60}))
    tel = record.telemetry
    roll = np.interp(record.matches["t_row1_s"], tel["t_s"], tel["roll_deg"])
    assert len(roll) > 50
    assert np.abs(roll).max() < 5.5
    assert np.abs(tel["roll_deg"]).max() > 15.0
