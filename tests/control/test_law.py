"""The control law: signs, what holds before the first estimate, and what each loop does."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerosim.control.law import ControlParameters, camera_command
from aerosim.signals import MotionEstimate

# end lap 60 % of 230 mm over 152 mm, 69.44 m/s in 3000 m
FOLLOW = ControlParameters(
    base_ratio=0.4 * 230.0 / 152.0,
    half_format=115.0 / 152.0,
    planned_vh=69.44 / 3000.0,
    min_interval=2.0,
    follow_drift=True,
    follow_vh=True,
    fmc=True,
)
NOTHING = MotionEstimate(0.0, math.nan, math.nan, math.nan, math.nan, False)


def believed(drift_deg: float, vh: float) -> MotionEstimate:
    return MotionEstimate(100.0, math.radians(drift_deg), vh, 0.01, 1e-4, True)


@given(drift=st.floats(-25.0, 25.0), vh=st.floats(0.01, 0.08))
def test_camera_turns_into_the_track_and_photos_keep_the_base(drift: float, vh: float) -> None:
    command = camera_command(FOLLOW, believed(drift, vh))
    # crab = drift - mount yaw: wind from the left drifts to the right, and the camera turns clockwise
    assert math.radians(drift) - command.mount_yaw == 0.0
    # base: way over height in one interval, 0.6 of the picture's side in the image left over
    assert command.interval * vh == pytest.approx(0.4 * 230.0 / 152.0)
    assert command.fmc_rate == vh


def test_interval_by_hand() -> None:
    """The picture covers 230/152 x 3000 m = 4539 m; 40 % of it are 1816 m, 26.15 s at 69.44 m/s."""
    assert camera_command(FOLLOW, believed(0.0, 69.44 / 3000.0)).interval == pytest.approx(26.15, abs=0.005)


def test_before_the_first_estimate_the_plan_holds() -> None:
    command = camera_command(FOLLOW, NOTHING)
    assert command.mount_yaw == 0.0
    assert command.interval == pytest.approx(26.15, abs=0.005)
    assert command.fmc_rate == FOLLOW.planned_vh


def test_camera_has_a_shortest_interval() -> None:
    low = believed(0.0, 1.0)  # 0.6 s wanted
    assert camera_command(FOLLOW, low).interval == 2.0
    assert camera_command(replace(FOLLOW, min_interval=0.1), low).interval == pytest.approx(0.605, abs=5e-4)


def test_without_compensation_the_image_is_not_moved() -> None:
    command = camera_command(replace(FOLLOW, fmc=False), believed(5.0, 0.03))
    assert command.fmc_rate == 0.0
    assert command.mount_yaw == math.radians(5.0)
    assert camera_command(replace(FOLLOW, fmc=False), NOTHING).fmc_rate == 0.0


def test_fixed_camera_keeps_the_plan_whatever_is_believed() -> None:
    fixed = replace(FOLLOW, follow_drift=False, follow_vh=False)
    assert camera_command(fixed, believed(8.0, 0.03)) == camera_command(FOLLOW, NOTHING)


def test_loops_are_closed_one_by_one() -> None:
    only_drift = camera_command(replace(FOLLOW, follow_vh=False), believed(8.0, 0.03))
    assert (only_drift.mount_yaw, only_drift.fmc_rate) == (math.radians(8.0), FOLLOW.planned_vh)
    only_vh = camera_command(replace(FOLLOW, follow_drift=False), believed(8.0, 0.03))
    assert (only_vh.mount_yaw, only_vh.fmc_rate) == (0.0, 0.03)


@pytest.mark.parametrize("pitches_deg", [(0.0, 0.0), (2.0, -1.0), (-3.0, 3.0), (4.0, 4.0)])
def test_leads_keep_the_end_lap_of_footprints(pitches_deg: tuple[float, float]) -> None:
    """Way that the command asks for between two photos of different pitch: their footprints lap by 60 %.

    In flight lead and left enter as: way / base + lead now = 1 + left of the photo before.
    """
    before, now = (math.radians(p) for p in pitches_deg)
    first = camera_command(FOLLOW, believed(0.0, 0.02)._replace(pitch=before))
    second = camera_command(FOLLOW, believed(0.0, 0.02)._replace(pitch=now))
    way = (1.0 + first.left - second.lead) * FOLLOW.base_ratio
    a = math.atan(115.0 / 152.0)
    front_before = math.tan(before + a)
    front, rear = way + math.tan(now + a), way + math.tan(now - a)
    assert (front_before - rear) / (front - rear) == pytest.approx(0.6, abs=1e-12)


def test_a_trigger_without_pitch_has_no_lead() -> None:
    command = camera_command(FOLLOW, believed(1.0, 0.02))
    assert (command.lead, command.left) == (0.0, 0.0)


def test_v_over_h_that_nobody_has_read_is_the_planned_one() -> None:
    """The navigator may have turned the camera before there was land below."""
    command = camera_command(FOLLOW, believed(3.0, math.nan))
    assert command.mount_yaw == pytest.approx(math.radians(3.0))
    assert command.interval == pytest.approx(FOLLOW.base_ratio / FOLLOW.planned_vh)


def test_a_lead_sets_the_yaw_to_what_the_drift_will_be() -> None:
    """The nose turns right by 2 deg/s: 0.15 s later the drift is 0.3 deg less."""
    turning = believed(5.0, 0.02)._replace(yaw_rate=math.radians(2.0))
    ahead = camera_command(replace(FOLLOW, yaw_lead=0.15), turning)
    assert math.degrees(ahead.mount_yaw) == pytest.approx(4.7)
    assert math.degrees(camera_command(FOLLOW, turning).mount_yaw) == pytest.approx(5.0)


def test_a_change_within_the_dead_band_is_not_commanded() -> None:
    par, held = replace(FOLLOW, dead_band=math.radians(0.5)), math.radians(4.0)
    assert camera_command(par, believed(4.49, 0.02), held).mount_yaw == held
    assert camera_command(par, believed(3.51, 0.02), held).mount_yaw == held
    assert math.degrees(camera_command(par, believed(4.51, 0.02), held).mount_yaw) == pytest.approx(4.51)
    assert math.degrees(camera_command(par, believed(4.3, 0.02)).mount_yaw) == pytest.approx(4.3)  # the first


def test_dead_band_leaves_its_sawtooth() -> None:
    """A drift that grows evenly: the camera follows in steps, off by 0 to the dead band, 1/sqrt(3) of it rms."""
    par, held, off = replace(FOLLOW, dead_band=math.radians(0.2)), math.nan, []
    for k in range(20000):
        drift = 1e-4 * k  # deg
        held = camera_command(par, believed(drift, 0.02), held).mount_yaw
        off.append(drift - math.degrees(held))
    # in steps of 1e-4 deg of 0.2: one part in 2000
    assert max(map(abs, off)) == pytest.approx(0.2, rel=1e-3)
    assert math.sqrt(sum(x * x for x in off) / len(off)) == pytest.approx(0.2 / math.sqrt(3.0), rel=2e-3)
