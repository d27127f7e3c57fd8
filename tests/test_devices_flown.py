"""What the devices' errors and faults do in flight, each with its sign: short flights, the loop closed."""

from __future__ import annotations

import numpy as np
import pytest
from flights import air, on_line, rms, scenario

from aerosim import simulate
from aerosim.record import Record

CROSSWIND = air(8.0, 0.0)


def flown(mode: str, **sections: dict[str, object]) -> Record:
    """6 km in 8 m/s from the left: 6.6 deg of drift."""
    return simulate(scenario(6.0, air=CROSSWIND, control={"mode": mode}, **sections))


@pytest.fixture(scope="module")
def modern() -> Record:
    return flown("gnss_ins")


def test_satellites_and_compass_leave_no_crab(modern: Record) -> None:
    # 0.03 m/s across 69 m/s are 0.025 deg, the heading's 0.003 deg beside it, and the mount follows with 0.15 s.
    crab = on_line(modern, "crab_true_deg", after=20.0)
    assert rms(crab) < 3.0 * 0.025
    assert abs(crab.mean()) < 0.01
    assert rms(on_line(modern, "drift_est_deg") - on_line(modern, "drift_true_deg")) < 3.0 * 0.025


def test_satellites_and_compass_know_no_relief(modern: Record) -> None:
    speed = np.hypot(on_line(modern, "v_north_m_s"), on_line(modern, "v_east_m_s"))
    planned = speed / on_line(modern, "vh_est_per_s")
    assert planned.std() < 3.0  # m, of height over one mean ground
    assert (on_line(modern, "vh_true_per_s") / on_line(modern, "vh_est_per_s")).std() > 0.003


@pytest.mark.parametrize("yaw_deg", [0.5, -0.5])
def test_boresight_becomes_crab(yaw_deg: float) -> None:
    made = flown("gnss_ins", navigation={"ins": {"boresight_deg": [0.0, 0.0, yaw_deg]}})
    assert on_line(made, "crab_true_deg", after=20.0).mean() == pytest.approx(-yaw_deg, abs=0.01)


def test_navigator_turns_the_camera_in_whole_degrees() -> None:
    made = flown("navigator")
    yaw, crab = on_line(made, "mount_yaw_deg"), on_line(made, "crab_true_deg")
    # Most of the time the mount stands, and where it stands are whole degrees.
    stands = np.abs(np.diff(yaw, append=yaw[-1])) < 1e-6
    assert stands.mean() > 0.9
    assert yaw[stands] == pytest.approx(np.round(yaw[stands]), abs=1e-3)
    # Found in the run-in to within a look's error (1 deg) and half a step of words; 3 of it.
    assert rms(crab) < 3.4
    assert rms(crab) < 0.5 * rms(on_line(made, "drift_true_deg"))
    again = flown("navigator")
    assert np.array_equal(yaw, on_line(again, "mount_yaw_deg"))


@pytest.mark.parametrize("bias_deg", [1.0, -1.0])
def test_encoder_bias_becomes_crab(bias_deg: float) -> None:
    # The rows see crab, the encoder makes drift of it: drift too large by the bias, and the camera turned too far.
    made = flown("pipelined", mount={"faults": {"encoder_bias_deg": bias_deg}})
    crab = on_line(made, "crab_true_deg", after=20.0)
    assert crab.mean() == pytest.approx(-bias_deg, abs=0.2)
    assert on_line(made, "drift_est_deg", after=20.0).mean() > 5.0


def test_mount_that_sticks_is_where_it_was_and_comes_back() -> None:
    made = flown("pipelined", mount={"faults": {"stuck_from_s": 2.0, "stuck_until_s": 60.0}})
    t, yaw = made.telemetry["t_s"], made.telemetry["mount_yaw_deg"]
    assert not yaw[t < 59.9].any()  # no strip was decided in its first 2 s
    crab = on_line(made, "crab_true_deg")
    assert np.abs(crab[on_line(made, "t_s") < 60.0]).min() > 5.0
    assert rms(crab[on_line(made, "t_s") > 62.0]) < 0.6
