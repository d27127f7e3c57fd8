"""Blur of the rows' picture: response to waves on the land against the product of boxes that it stands for."""

import math

import numpy as np
import pytest
from row_world import EAST, FOCAL, NORTH, level_ground, pose, rows, spot

PIXEL = 20.0  # m, from 2652 m
HEIGHT = PIXEL * FOCAL
WAVES = (0.7, 0.9, 1.1, 1.3, 1.6, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0, 20.0)  # px


def response(wave_px, axis, *, smear=(1.0, 1.0), exposure=0.01, cell_px=0.5, seed=3, **motion):
    """Amplitude of a wave in row II over that of the land.  axis: 0 along (to the north), 1 across.

    The orthophoto holds means over its cells, as a camera's and every overview do; the wave's phase is varied.
    """
    k, cell = 2.0 * np.pi / (wave_px * PIXEL), cell_px * PIXEL
    amplitude = 40.0 * np.sinc(cell_px / wave_px)
    rng = np.random.default_rng(seed)
    device = rows(smear_along_px=smear[0], smear_across_px=smear[1], exposure=exposure)
    where, gain = pose(height=HEIGHT, **motion), 257.0 * exposure / 0.01
    ground = level_ground(where, 2)[axis]
    grey, phase = [], []
    for begin in rng.uniform(0.0, 2.0 * np.pi, 8):
        land = spot(lambda x, y, b=begin: 60.0 + amplitude * np.cos(k * (y, x)[axis] + b), half=1600.0, cell=cell)
        for north, east in rng.uniform(-300.0, 300.0, (12, 2)):
            moved = land._replace(grid=np.array([EAST + east, NORTH + north, 0.0, 1.0, 1.0, 0.0]))
            grey.append(device.expose(where, moved, ahead=False).row2 / gain)
            phase.append(k * (ground + (north, east)[axis]) + begin)
    p = np.concatenate(phase)
    design = np.column_stack([np.ones_like(p), np.cos(p), np.sin(p)])
    _, even, odd = np.linalg.lstsq(design, np.concatenate(grey), rcond=None)[0]
    assert abs(odd) < 0.06 * 40.0  # nothing is shifted, but for the fit: 0.02 of 40
    return even / 40.0


def exact(wave_px, smear, motion):
    return math.prod(float(np.sinc(width / wave_px)) for width in (1.0, smear, motion))


@pytest.mark.parametrize("axis", [0, 1])
def test_a_pixel_and_its_smear_on_cells_of_half_a_pixel(axis):
    # As documented, and 0.02 for the fit where cells and pixels beat.
    for wave in WAVES:
        error = response(wave, axis) - exact(wave, 1.0, 0.0)
        assert abs(error) < 0.15, f"{wave} px"
        assert abs(error) < 0.01 or wave < 3.0, f"{wave} px"


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(
    ("smear", "motion"), [(0.5, 0.0), (1.0, 0.5), (1.0, 1.0), (2.0, 0.0), (3.0, 0.0), (8.0, 0.0), (1.0, 4.0)]
)
def test_wide_smear_and_motion(axis, smear, motion):
    moving = {"speed": motion * PIXEL / 0.02} if axis == 0 else {"omega": (-motion / FOCAL / 0.02, 0.0, 0.0)}
    # As documented within 0.25 at all widths; in those that are tried here within 0.15.
    for wave in (*WAVES, 40.0):
        found = response(wave, axis, smear=(smear, smear), exposure=0.02, **moving)
        assert found == pytest.approx(exact(wave, smear, motion), abs=0.15), f"{wave} px"


def test_smear_has_its_direction():
    along, across = (response(6.0, axis, smear=(3.0, 0.5)) for axis in (0, 1))
    assert along == pytest.approx(exact(6.0, 3.0, 0.0), abs=0.02)
    assert across == pytest.approx(exact(6.0, 0.5, 0.0), abs=0.02)


@pytest.mark.parametrize(("axis", "omega"), [(0, (0.0, 1.0, 0.0)), (1, (1.0, 0.0, 0.0)), (1, (0.0, 0.0, 1.0))])
def test_motion_of_the_footprint_by_rotation(axis, omega):
    # 2 px of motion: pitching by f omega, rolling by f omega, yawing by half the spacing times omega.
    arm = 39.7 / 2.0 if omega[2] else FOCAL
    found = response(5.0, axis, exposure=0.02, omega=tuple(2.0 / 0.02 / arm * w for w in omega))
    assert found == pytest.approx(exact(5.0, 1.0, 2.0), abs=0.03)


def test_pitching_down_with_the_ground_stops_the_motion():
    # The footprint moves ahead with the aircraft by v/h; the nose that goes down at v/h holds it back:
    # what remains is second order in the row's angle off the nadir, (x/f)^2 = 2 % of 2 px.
    speed = 2.0 * PIXEL / 0.02
    held = response(5.0, 0, exposure=0.02, speed=speed, omega=(0.0, -speed / HEIGHT, 0.0))
    doubled = response(5.0, 0, exposure=0.02, speed=speed, omega=(0.0, speed / HEIGHT, 0.0))
    assert held == pytest.approx(exact(5.0, 1.0, 0.0), abs=0.02)
    assert doubled == pytest.approx(exact(5.0, 1.0, 4.0), abs=0.05)
