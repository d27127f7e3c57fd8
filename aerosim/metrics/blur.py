"""Image motion during the exposure: flight, rotation, forward-motion compensation."""

from __future__ import annotations

import numpy as np

from aerosim.frames import Array
from aerosim.projection import Camera
from aerosim.truth import CameraPose


def image_motion(camera: Camera, pose: CameraPose, los_c: Array, depth: Array, fmc_rate: float) -> Array:
    """Speed at which the image of fixed ground moves over the film, along x_c and y_c, px/s.

    los_c: (n, 3), z_c = focal_px; depth: (n,), of the ground along z_c, m; fmc_rate: of the film, rad/s.
    Returns (n, 2).  Signs: flight along +x_c moves the image towards -x_c; a positive pitch rate (about y_c)
    towards -x_c; a positive roll rate (about x_c) towards +y_c; a positive yaw rate (about z_c) moves the front
    edge towards -y_c and the middle not at all; the compensation moves the film along -x_c at focal * fmc_rate,
    so that a level camera flown straight along x_c at v over ground h below has none left at fmc_rate = v/h.
    The turn of n over the Earth's curve is left out (h/R, 0.05 % of the flight's part from 3 km).
    """
    vel_c = pose.mat_nc.T @ pose.vel_n
    point = los_c * (depth / camera.focal_px)[:, None]
    rate = -vel_c - np.cross(pose.omega_nc_c, point)
    motion = (camera.focal_px * rate[:, :2] - los_c[:, :2] * rate[:, 2:]) / depth[:, None]
    motion[:, 0] += camera.focal_px * fmc_rate
    return np.asarray(motion)


def blur(camera: Camera, pose: CameraPose, ground_n: Array, exposure: float, fmc_rate: float) -> float:
    """Largest image motion of ground points over an exposure, px.

    ground_n: (n, 3), from the projection centre, in n, m; exposure: s; fmc_rate: rad/s.  NaN if a point is.
    """
    ground_c = ground_n @ pose.mat_nc
    depth = ground_c[:, 2]
    los_c = ground_c * (camera.focal_px / depth)[:, None]
    motion = image_motion(camera, pose, los_c, depth, fmc_rate)
    return float(exposure * np.hypot(motion[:, 0], motion[:, 1]).max())
