"""The one device that tells the truth: reference controllers get it here and nowhere else."""

from __future__ import annotations

import math

from aerosim.signals import MotionEstimate
from aerosim.truth import AircraftState


def tell(aircraft: AircraftState, terrain_height: float) -> MotionEstimate:
    """Drift and v/h as they are now.  terrain_height: mean of the footprint, ellipsoidal, m."""
    drift = math.remainder(math.atan2(aircraft.v_east, aircraft.v_north) - aircraft.heading, 2.0 * math.pi)
    vh = math.hypot(aircraft.v_north, aircraft.v_east) / (aircraft.height - terrain_height)
    return MotionEstimate(aircraft.t, drift, vh, 0.0, 0.0, True)


class Oracle:
    """Tells the truth at every moment: mode `ideal`."""

    def tell(self, aircraft: AircraftState, terrain_height: float, mount_yaw: float) -> MotionEstimate:
        """Drift and v/h as they are now."""
        return tell(aircraft, terrain_height)
