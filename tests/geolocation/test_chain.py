"""The chain of an oblique picture: signs, scipy's rotations, round trips through the air."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerosim import frames
from aerosim.errors import InputError
from aerosim.geolocation.chain import Corrections, ObliqueCamera, Poses, n_from_e, pixels, projection_centres, rays
from aerosim.projection import Camera

OPTICS = Camera(150_000.0, 4096, 4096, 2060.3, 2031.8)
CAMERA = ObliqueCamera(OPTICS, tuple(np.radians([0.8, -0.5, 0.6])), (1.2, -0.4, -2.1))
MIDDLE = np.array([[2060.3, 2031.8]])


def poses(n=50, seed=1):
    rng = np.random.default_rng(seed)
    deg = rng.uniform(
        [-89.9, -180, 0, -5, -10, -80, -20], [89.9, 180, 360, 5, 10, 80, 20], (n, 7)
    )  # fmt: skip
    lat, lon, heading, pitch, roll, alpha, beta = np.radians(deg).T
    return Poses(lat, lon, rng.uniform(6000, 12_000, n), heading, pitch, roll, alpha, beta)


def one(**angles_deg):
    named = dict.fromkeys(("heading", "pitch", "roll", "alpha", "beta"), 0.0) | angles_deg
    return Poses(0.5, 1.0, 7000.0, *(np.radians(named[k]) for k in named))


def los_n(camera, pose, pixel=MIDDLE, corrections=Corrections()):  # noqa: B008
    return n_from_e(pose.lat, pose.lon, rays(camera, pose, pixel, corrections).los_e)[0]


class TestSigns:
    """One disturbance each, north-east-down."""

    bare = ObliqueCamera(OPTICS)

    def test_all_zero_looks_straight_down_row_0_to_the_nose(self):
        assert los_n(self.bare, one()) == pytest.approx([0, 0, 1])
        assert los_n(self.bare, one(), [[0.0, 2031.8]])[0] > 0.01
        assert los_n(self.bare, one(heading=90.0), [[0.0, 2031.8]])[1] > 0.01
        assert los_n(self.bare, one(), [[2060.3, 4000.0]])[1] > 0.01

    def test_alpha_looks_left_beta_forward(self):
        assert los_n(self.bare, one(alpha=30.0)) == pytest.approx([0, -0.5, np.sqrt(0.75)])
        assert los_n(self.bare, one(beta=30.0)) == pytest.approx([0.5, 0, np.sqrt(0.75)])
        assert los_n(self.bare, one(heading=90.0, alpha=30.0)) == pytest.approx([0.5, 0, np.sqrt(0.75)], abs=1e-12)

    def test_mirror_turns_the_sight_twice(self):
        mirror = ObliqueCamera(OPTICS, mirror_factor=2.0)
        assert los_n(mirror, one(beta=15.0)) == pytest.approx([0.5, 0, np.sqrt(0.75)])

    def test_roll_and_alpha_are_one(self):
        a = los_n(CAMERA, one(alpha=70.0, beta=10.0, heading=20.0), corrections=Corrections(roll=0.01))
        b = los_n(CAMERA, one(alpha=70.0, beta=10.0, heading=20.0), corrections=Corrections(alpha=0.01))
        assert a == pytest.approx(b, abs=1e-12)

    def test_antenna_above_the_camera(self):
        camera = ObliqueCamera(OPTICS, antenna_b=(0.0, 0.0, -2.0))
        height = frames.geodetic_from_ecef(projection_centres(camera, one()))[2]
        assert height == pytest.approx([6998.0])
        ahead = ObliqueCamera(OPTICS, antenna_b=(3.0, 0.0, 0.0))
        lat = frames.geodetic_from_ecef(projection_centres(ahead, one()))[0]
        assert (0.5 - lat) * 6.36e6 == pytest.approx([3.0], abs=0.02)


def test_is_the_contract_in_scipys_rotations():
    """R.from_euler('ZYX') is Rz Ry Rx of intrinsic angles."""
    pose, c = poses(), Corrections(0.01, -0.02, 0.03, 0.015, -0.01)
    px = np.random.default_rng(2).uniform(0, 4095, (pose.count, 2))
    y, p, r = CAMERA.boresight
    turned = (
        Rotation.from_euler("ZYX", np.stack([pose.heading, pose.pitch, pose.roll], axis=-1))
        * Rotation.from_euler("ZYX", [y + c.yaw, p + c.pitch, r + c.roll])
        * Rotation.from_euler("XY", np.stack([pose.alpha + c.alpha, pose.beta + c.beta], axis=-1))
    )
    los_c = np.column_stack([2060.3 - px[:, 0], px[:, 1] - 2031.8, np.full(pose.count, 150_000.0)])
    expected = turned.apply(los_c / np.linalg.norm(los_c, axis=-1, keepdims=True))
    found = rays(CAMERA, pose, px, c)
    assert n_from_e(pose.lat, pose.lon, found.los_e) == pytest.approx(expected, abs=1e-12)
    arm = Rotation.from_euler("ZYX", np.stack([pose.heading, pose.pitch, pose.roll], axis=-1)).apply(
        [1.2, -0.4, -2.1]
    )
    for k in range(pose.count):
        antenna = frames.ecef_from_geodetic(pose.lat[k], pose.lon[k], pose.height[k])
        place = antenna - frames.mat_ne(pose.lat[k], pose.lon[k]).T @ arm[k]
        assert found.pos_e[k] == pytest.approx(place, abs=1e-6)


@pytest.mark.parametrize("side", ["gimbal", "navigation"])
def test_pixels_come_back_through_the_air(side):
    """Down to a height surface and up again; the two integrations agree to 1e-7 rad, 0.02 px."""
    from aerosim.geolocation.ground import HIT, on_height

    camera = ObliqueCamera(OPTICS, CAMERA.boresight, CAMERA.antenna_b, 2.0, side)
    pose = poses(200)
    c = Corrections(0.001, -0.002, 0.0, 0.003, 0.001, 0.002, -0.003)
    px = np.random.default_rng(3).uniform(0, 4095, (200, 2))
    hits = on_height(rays(camera, pose, px, c), 1000.0)
    good = (hits.status == HIT) & (hits.distance < 100_000.0)
    assert good.sum() > 100
    back = pixels(camera, pose.rows(good), hits.pos_e[good], c)
    assert back == pytest.approx(px[good], abs=0.02)
    assert np.abs(pixels(camera, pose.rows(good), hits.pos_e[good], c, None) - px[good]).max() > 1.0


class TestBadInput:
    def test_poses(self):
        with pytest.raises(InputError, match=r"lat: row 1 lies beyond a pole: 107.5 deg .*swapped"):
            Poses(np.radians([34.0, 107.5]), np.radians([107.5, 34.0]), 7000.0, 0, 0, 0, 0, 0)
        with pytest.raises(InputError, match="pitch: row 1 is not a finite number"):
            Poses([0.1, 0.2], 0.1, 7000.0, 0, [0.0, np.inf], 0, 0, 0)
        with pytest.raises(InputError, match="differ in length"):
            Poses([0.1, 0.2], [0.1, 0.2, 0.3], 7000.0, 0, 0, 0, 0, 0)

    def test_pixels(self):
        for bad in ([[-0.6, 5.0]], [[5.0, 4095.6]], [[np.nan, 5.0]]):
            with pytest.raises(InputError, match=r"pixel: row 0: .* is not of the picture"):
                rays(CAMERA, one(), bad)
        with pytest.raises(InputError, match="for 1 exposures"):
            rays(CAMERA, one(), [[1.0, 2.0], [3.0, 4.0]])

    def test_camera(self):
        with pytest.raises(InputError, match="too far"):
            ObliqueCamera(OPTICS, antenna_b=(0.0, 1200.0, 0.0))
        with pytest.raises(InputError, match="mirror factor"):
            ObliqueCamera(OPTICS, mirror_factor=0.0)
        with pytest.raises(InputError, match="finite"):
            ObliqueCamera(OPTICS, boresight=(0.0, np.nan, 0.0))
        with pytest.raises(InputError, match="gimbal, navigation"):
            ObliqueCamera(OPTICS, boresight_on="mount")
