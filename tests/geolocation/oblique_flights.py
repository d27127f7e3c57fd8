"""Pictures of the paper's control point with known errors of everything: what is measured, and where it truly was.

The gimbal's angles are solved from the chain's own rotations, which test_chain.py compares with scipy's.
"""

import numpy as np

from aerosim import frames
from aerosim.geolocation.calibrated import DEG, ControlPoints, Sigmas
from aerosim.geolocation.chain import Corrections, ObliqueCamera, Poses, e_from_n, n_from_e, turn, turns
from aerosim.geolocation.refraction import apparent
from aerosim.projection import Camera

CAMERA = ObliqueCamera(
    Camera(150_000.0, 4096, 4096, 2060.3, 2031.8), (0.8 * DEG, -0.5 * DEG, 0.6 * DEG), (1.2, -0.4, -2.1)
)
SIGMAS = Sigmas()
# Li et al. 2020, section 4; roll and alpha add up.
TRUE = Corrections(yaw=0.030 * DEG, pitch=-0.015 * DEG, roll=0.012 * DEG, alpha=0.010 * DEG, beta=-0.020 * DEG)
EXPECTED = np.array([0.030, -0.015, 0.022, -0.020])
POINT = (33.980849 * DEG, 107.523239 * DEG, 3132.10)


def flight(
    count, seed, *, lines=None, white=1.0, two_sided=True, spread=30.0, off=(70.0, 80.0), true=TRUE, camera=CAMERA
):
    """Measured poses (n), pixels (n, 2) and line numbers of pictures of the control point from 8.5 to 9.5 km
    above it.

    lines: number of flight lines; white: share of the navigation's variance that their rows do not share.
    spread: of the sight about broadside, deg.
    """
    rng = np.random.default_rng(seed)
    point = frames.ecef_from_geodetic(*POINT)
    off_nadir, above, azimuth = (
        rng.uniform(*off, count) * DEG,
        rng.uniform(8500, 9500, count),
        rng.uniform(0, 2 * np.pi, count),
    )
    level = above * np.tan(off_nadir)
    back = np.stack([-level * np.cos(azimuth), -level * np.sin(azimuth), -above], axis=-1)
    pos_e = point + e_from_n(np.full(count, POINT[0]), np.full(count, POINT[1]), back)
    lat, lon, height = frames.geodetic_from_ecef(pos_e)
    side = np.where(rng.random(count) < 0.5, 1.0, -1.0) if two_sided else np.ones(count)
    heading = azimuth + side * (90.0 + rng.uniform(-spread, spread, count)) * DEG
    pitch, roll = rng.uniform(-3.0, 3.0, (2, count)) * DEG
    level_pose = Poses(lat, lon, height, heading, pitch, roll, 0.0, 0.0)
    # what the gimbal has to turn the pixel's ray to
    wanted = n_from_e(lat, lon, apparent(pos_e, np.broadcast_to(point, (count, 3))))
    for axis, angle in turns(camera, level_pose, true)[:6]:
        wanted = turn(axis, -angle, wanted)
    pixel = rng.uniform(1000.0, 3000.0, (count, 2))
    los_c = camera.optics.rays(pixel)
    los_c /= np.linalg.norm(los_c, axis=-1, keepdims=True)
    beta = np.arcsin(wanted[:, 0] / np.hypot(los_c[:, 0], los_c[:, 2])) - np.arctan2(los_c[:, 0], los_c[:, 2])
    turned = turn(1, beta, los_c)
    alpha = np.arctan2(wanted[:, 2], wanted[:, 1]) - np.arctan2(turned[:, 2], turned[:, 1])
    arm = np.broadcast_to(camera.antenna_b, (count, 3))
    for axis, angle in ((0, roll), (1, pitch), (2, heading)):
        arm = turn(axis, angle, arm)
    lat, lon, height = frames.geodetic_from_ecef(pos_e + e_from_n(lat, lon, arm))
    line = np.arange(count) % lines if lines else None

    def error(sigma):
        own = sigma * rng.standard_normal(count)
        if lines is None:
            return own
        return np.sqrt(white) * own + np.sqrt(1.0 - white) * sigma * rng.standard_normal(lines)[line]

    s = SIGMAS
    north, east, down = (error(sigma) for sigma in s.position)
    measured = Poses(
        lat + north / frames.radii(lat)[0],
        lon + east / (frames.radii(lat)[1] * np.cos(lat)),
        height - down,
        heading + error(s.heading),
        pitch + error(s.pitch),
        roll + error(s.roll),
        alpha - true.alpha + s.gimbal * rng.standard_normal(count),
        beta - true.beta + s.gimbal * rng.standard_normal(count),
    )
    return measured, pixel + s.pixel * rng.standard_normal((count, 2)), line


def control(seed, sigma=0.3):
    """The control point as it is known."""
    error = sigma * np.random.default_rng(10**6 + seed).standard_normal(3)
    return ControlPoints((frames.ecef_from_geodetic(*POINT) + error)[None], np.array([sigma]))
