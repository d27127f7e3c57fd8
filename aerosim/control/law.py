"""The camera's control law: mount yaw, time between photos, forward-motion compensation."""

from __future__ import annotations

import math
from dataclasses import dataclass

from aerosim.signals import CameraCommand, MotionEstimate


@dataclass(frozen=True)
class ControlParameters:
    """base_ratio: wanted base over height, (1 - end lap) x format along / focal length.

    half_format: half of the format along over the focal length.  planned_vh: 1/s, used until there is an estimate,
    and for good if v/h is not followed.  min_interval: s, of the camera.  follow_drift, follow_vh, fmc: which
    loops are closed.  yaw_lead: s, by which the yaw command runs ahead of the nose.  dead_band: rad, smaller
    changes of the yaw are not commanded.
    """

    base_ratio: float
    half_format: float
    planned_vh: float
    min_interval: float
    follow_drift: bool
    follow_vh: bool
    fmc: bool
    yaw_lead: float = 0.0
    dead_band: float = 0.0


def camera_command(par: ControlParameters, estimate: MotionEstimate, held: float = math.nan) -> CameraCommand:
    """Turn the camera into the track and space the photos.

    held: mount yaw of the last command, rad; NaN: there was none.
    The mount's yaw is set to the drift, which leaves no crab (crab = drift - mount yaw), or to where the track is
    looked for while none is known.  A nose that turns takes the drift with it: with a lead the yaw is set to what
    the drift will be then.  The interval is the time in which the ground moves by the wanted base,
    base_ratio/(v/h), never below the camera's shortest.  An estimate that knows the pitch tells the trigger how
    far the footprint lies ahead: end lap is of footprints.
    """
    yaw = 0.0
    if par.follow_drift:
        yaw = estimate.drift - par.yaw_lead * estimate.yaw_rate if estimate.valid else estimate.seek
        if abs(yaw - held) <= par.dead_band:
            yaw = held
    known = par.follow_vh and estimate.valid and not math.isnan(estimate.vh)
    vh = estimate.vh if known else par.planned_vh
    lead, left = _leads(par, estimate.pitch) if par.follow_vh and estimate.valid and estimate.pitch else (0.0, 0.0)
    return CameraCommand(yaw, max(par.base_ratio / vh, par.min_interval), vh if par.fmc else 0.0, lead, left)


def _leads(par: ControlParameters, pitch: float) -> tuple[float, float]:
    """By how much of a base a photo with this pitch may come earlier, and the next one later.

    With front and rear edge at tan(pitch +- a) ahead of the nadir, a: half of the view, the end lap
    (front before - rear - way) / (front - rear), all over height, is the wanted one at
    way = front before - rear - wanted (front - rear).
    """
    a = math.atan(par.half_format)
    front, rear, wanted = math.tan(pitch + a), math.tan(pitch - a), 1.0 - par.base_ratio / (2.0 * par.half_format)
    level = par.half_format
    lead = rear + wanted * (front - rear) - (2.0 * wanted - 1.0) * level
    return lead / par.base_ratio, (front - level) / par.base_ratio
