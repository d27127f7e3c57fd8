"""Rows and mount with declared faults, and errors of gain and optics: each with its sign."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from row_world import FOCAL, PIXELS, SHIFT, SPACING, pose, rows, spot

from aerosim.sensing.ccd_rows import CcdRows, RowParameters, pixel_rays
from aerosim.sensing.faults import FaultyMount, FaultyRows, MountFaults, RowFaults
from aerosim.sensing.mount import Mount, MountParameters

DT = 1.0 / 120.0
SOUND = RowParameters(PIXELS, SHIFT, SPACING, FOCAL, 1.0, 1.0, 0.01, 0.0, 0.0, 8)


def even(grey):
    return spot(lambda x, y: grey)


def faulty(faults, seed=1, **changes):
    return FaultyRows(SOUND._replace(**changes), faults, 0.0, np.random.default_rng(seed))


class TestRows:
    def test_without_a_fault_they_read_as_sound_ones(self):
        land = spot(lambda x, y: 100.0 + 0.02 * x)
        sound = CcdRows(SOUND._replace(noise_grey=2.0), 0.0, np.random.default_rng(1))
        device = faulty(RowFaults(), noise_grey=2.0)
        for t in (0.0, 50.0):
            a, b = device.expose(pose(t=t), land), sound.expose(pose(t=t), land)
            assert np.array_equal(a.row1, b.row1)
            assert np.array_equal(a.row2, b.row2)

    @pytest.mark.parametrize(("step", "after"), [(0.2, 96.0), (-0.5, 40.0)])
    def test_gain_step_of_both_rows_at_its_time(self, step, after):
        device = faulty(RowFaults(gain_step=step, gain_step_at=10.0))
        found = [device.expose(pose(t=t), even(80.0)) for t in (0.0, 9.95, 10.0, 60.0)]
        assert [set(each.row1.tolist() + each.row2.tolist()) for each in found] == [{80.0}] * 2 + [{after}] * 2
        # the device tells its exposure time, not its gain
        assert {each.exposure for each in found} == {0.01}

    def test_automatic_exposure_follows_the_gain_with_the_next_strip(self):
        device = faulty(RowFaults(gain_step=0.25, gain_step_at=10.0), exposure=None)
        device.expose(pose(t=0.0), even(80.0))
        device.new_cycle()
        kept = device.expose(pose(t=9.0), even(80.0))
        stepped = device.expose(pose(t=10.0), even(80.0))
        assert (kept.row1 == 110.0).all()
        assert (stepped.row2 == 137.0).all() or (stepped.row2 == 138.0).all()  # 137.5
        device.new_cycle()
        again = device.expose(pose(t=10.05), even(80.0))
        assert (again.row2 == 110.0).all()
        assert again.exposure == pytest.approx(kept.exposure / 1.25)

    def test_dead_pixels_of_row_two(self):
        made = faulty(RowFaults(dead=(0, 7, 95))).expose(pose(), even(80.0))
        assert np.flatnonzero(made.row2 == 0.0).tolist() == [0, 7, 95]
        assert (np.delete(made.row2, [0, 7, 95]) == 80.0).all()
        assert (made.row1 == 80.0).all()
        assert made.missing == 0  # land is there: nobody tells the estimator

    @pytest.mark.parametrize("blind", ["row1", "row2"])
    def test_blind_row_in_its_time(self, blind):
        device = faulty(RowFaults(blind=blind, blind_from=5.0, blind_until=9.0))
        for t, dark in ((4.95, False), (5.0, True), (8.95, True), (9.0, False)):
            made = device.expose(pose(t=t), even(80.0))
            assert (getattr(made, blind) == (0.0 if dark else 80.0)).all()
            assert ((made.row2 if blind == "row1" else made.row1) == 80.0).all()

    def test_blind_row_does_not_move_the_exposure_time(self):
        device = faulty(RowFaults(blind="row2", blind_from=5.0), exposure=None)
        device.expose(pose(t=0.0), even(80.0))
        device.expose(pose(t=6.0), even(40.0))
        device.new_cycle()
        assert device.expose(pose(t=7.0), even(40.0)).exposure == pytest.approx(0.01 * 110.0 / 80.0)

    @pytest.mark.parametrize(("difference", "row2"), [(0.1, 88.0), (-0.25, 60.0)])
    def test_gain_of_row_two_against_row_one(self, difference, row2):
        made = rows(bits=8, gain_difference=difference).expose(pose(), even(80.0))
        assert (made.row1 == 80.0).all()
        assert (made.row2 == row2).all()


class TestDistortion:
    @pytest.mark.parametrize("k1", [0.1, -0.2, 0.02])
    def test_against_opencv(self, k1):
        # The ideal places, distorted by another library, are the pixels' own.
        parameters = SOUND._replace(distortion=k1)
        camera = np.array([[FOCAL, 0, 0], [0, FOCAL, 0], [0, 0, 1.0]])
        for rays, count, ahead in zip(pixel_rays(parameters), (110, 96), (19.85, -19.85), strict=True):
            points = np.column_stack([*rays, np.full(count, FOCAL)])
            image, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera, np.array([k1, 0, 0, 0]))
            expected = np.column_stack([np.full(count, ahead), np.arange(count) - (count - 1) / 2.0])
            assert image[:, 0] == pytest.approx(expected, abs=1e-9)

    def test_none_is_none(self):
        for rays, count, ahead in zip(pixel_rays(SOUND), (110, 96), (19.85, -19.85), strict=True):
            assert np.array_equal(rays, [np.full(count, ahead), np.arange(count) - (count - 1) / 2.0])

    def test_most_that_does_not_fold(self):
        furthest = math.hypot(PIXELS / 2 + SHIFT, SPACING / 2) / FOCAL
        least = -4.0 / (27.0 * furthest**2)
        ahead, _ = pixel_rays(SOUND._replace(distortion=0.999 * least))
        assert (np.diff(ahead[1]) > 0.9).all()

    @pytest.mark.parametrize("k1", [0.1, -0.1])
    def test_sign(self, k1):
        # k1 > 0 draws the picture's ends apart: an outer pixel sees land nearer to the middle.
        found = {}
        for distortion in (0.0, k1):
            made = rows(distortion=distortion).expose(pose(), spot(lambda x, y: (x + 2500.0) / 5000.0 * 255.0))
            found[distortion] = made.row2 / 65535.0 * 5000.0 - 2500.0
        moved = (found[k1] - found[0.0]) / (3000.0 / FOCAL)  # px
        radius = math.hypot(47.5, SPACING / 2) / FOCAL
        # to first order -k1 r^2 y, 0.72 px at the end; the next term is 3 k1 r^2 of it, 4.5 %
        assert moved[-1] == pytest.approx(-k1 * radius**2 * 47.5, rel=0.06)
        assert moved[0] == pytest.approx(-moved[-1], abs=0.03)
        assert abs(moved[47:49]).max() < 0.03

    def test_reach_covers_the_outermost_rays(self):
        device = rows(distortion=-0.5, start_height=0.0)
        (ahead, _) = pixel_rays(SOUND._replace(distortion=-0.5))
        assert device.reach(3000.0) > 3000.0 * math.tan(
            math.atan(np.hypot(*ahead[:, -1]) / FOCAL) + math.radians(15)
        )


class TestMount:
    PARAMETERS = MountParameters(1.0, 0.2, 0.1, 0.05, 0.0)

    def made(self, faults, **changes):
        return FaultyMount(self.PARAMETERS._replace(**changes), faults, DT, np.random.default_rng(1))

    def yaws(self, device, command, steps):
        found = []
        for _ in range(steps):
            device.step(command)
            found.append((device.yaw, device.rate))
        return np.array(found)

    def test_without_a_fault_it_moves_and_reads_as_a_sound_one(self):
        sound = Mount(self.PARAMETERS._replace(encoder_sigma=0.01), DT, np.random.default_rng(1))
        device = self.made(MountFaults(), encoder_sigma=0.01)
        assert np.array_equal(self.yaws(device, 0.3, 100), self.yaws(sound, 0.3, 100))
        assert device.read(1.0) == sound.read(1.0)

    def test_sticks_in_its_time_and_then_turns_on(self):
        device = self.made(MountFaults(stuck_from=0.5, stuck_until=1.5))
        found = self.yaws(device, 0.3, 360)
        free = self.yaws(self.made(MountFaults()), 0.3, 360)
        assert np.array_equal(found[:60], free[:60])
        assert (found[60:180, 0] == found[59, 0]).all()
        assert (found[60:180, 1] == 0.0).all()
        # a first-order drive at its rate limit goes on as if the time had stood still
        assert np.array_equal(found[180:], free[60:240])

    def test_commands_given_meanwhile_are_not_made_up_for(self):
        device = self.made(MountFaults(stuck_from=0.0, stuck_until=1.0))
        self.yaws(device, 0.5, 114)
        self.yaws(device, -0.1, 6)  # the delay's length before it is free
        assert device.yaw == 0.0
        assert self.yaws(device, -0.1, 240)[-1, 0] == pytest.approx(-0.1, abs=1e-6)
        assert device.yaw < 0.0

    def test_several_steps_at_once(self):
        faults = MountFaults(stuck_from=0.1, stuck_until=0.3)
        one, many = self.made(faults), self.made(faults)
        for command, steps in ((0.1, 6), (-0.05, 1), (0.3, 40), (0.0, 6), (0.2, 30)):
            self.yaws(one, command, steps)
            many.advance(command, steps)
            assert (many.yaw, many.rate) == (one.yaw, one.rate)

    def test_stuck_for_good(self):
        device = self.made(MountFaults(stuck_from=0.5))
        found = self.yaws(device, 0.3, 1200)
        assert (found[60:, 0] == found[59, 0]).all()

    @pytest.mark.parametrize("bias", [0.02, -0.02])
    def test_encoder_bias_is_added_to_the_reading_alone(self, bias):
        device = self.made(MountFaults(encoder_bias=bias))
        free = self.yaws(self.made(MountFaults()), 0.3, 100)
        assert np.array_equal(self.yaws(device, 0.3, 100), free)
        assert device.read(2.0) == pytest.approx((2.0, device.yaw + bias))
