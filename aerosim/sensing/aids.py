"""The devices that aid an observer, read together at each exposure time."""

from __future__ import annotations

from typing import Protocol

from aerosim.signals import NO_AIDS, Aids, InertialReading, MotionEstimate
from aerosim.truth import AircraftState


class InertialDevice(Protocol):
    """An inertial unit."""

    def read(self, aircraft: AircraftState) -> InertialReading:
        """Its reading at the aircraft's time."""


class TellingDevice(Protocol):
    """A device that tells drift and v/h itself."""

    def tell(self, aircraft: AircraftState, terrain_height: float, mount_yaw: float) -> MotionEstimate | None:
        """Drift and v/h, None if there is nothing new.

        terrain_height: mean of the rows' footprint, ellipsoidal, m.  mount_yaw: of the camera, rad.
        """


class NoAids:
    """There is nothing but the rows."""

    def read(self, aircraft: AircraftState, terrain_height: float, mount_yaw: float) -> Aids:
        """Nothing."""
        return NO_AIDS


class AidingDevices:
    """Readings of the devices that a scenario has."""

    def __init__(self, inertial: InertialDevice | None = None, telling: TellingDevice | None = None) -> None:
        """None: there is no such device."""
        self._inertial, self._telling = inertial, telling

    def read(self, aircraft: AircraftState, terrain_height: float, mount_yaw: float) -> Aids:
        """What they say now.  terrain_height: mean of the rows' footprint, ellipsoidal, m; mount_yaw: rad."""
        inertial = self._inertial.read(aircraft) if self._inertial is not None else None
        telling = self._telling
        told = telling.tell(aircraft, terrain_height, mount_yaw) if telling is not None else None
        return Aids(inertial, told)
