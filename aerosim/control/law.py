"""The camera's control law: mount yaw, time between photos, forward-motion compensation."""

from __future__ import annotations

from dataclasses import dataclass

from aerosim.signals import CameraCommand, MotionEstimate


@dataclass(frozen=True)
class ControlParameters:
    """base_ratio: wanted base over height, (1 - end lap) x format along / focal length.

    planned_vh: 1/s, used until there is an estimate, and for good if v/h is not followed.  min_interval: s, of
    the camera.  follow_drift, follow_vh, fmc: which loops are closed.
    """

    base_ratio: float
    planned_vh: float
    min_interval: float
    follow_drift: bool
    follow_vh: bool
    fmc: bool


def camera_command(par: ControlParameters, estimate: MotionEstimate) -> CameraCommand:
    """Turn the camera into the track and space the photos.

    The mount's yaw is set to the drift, which leaves no crab (crab = drift - mount yaw), or to where the track is
    looked for while none is known.  The interval is the time in which the ground moves by the wanted base:
    base_ratio/(v/h), never below the camera's shortest.
    """
    yaw = 0.0
    if par.follow_drift:
        yaw = estimate.drift if estimate.valid else estimate.seek
    vh = estimate.vh if par.follow_vh and estimate.valid else par.planned_vh
    return CameraCommand(yaw, max(par.base_ratio / vh, par.min_interval), vh if par.fmc else 0.0)
