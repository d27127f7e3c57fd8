"""Flat coordinates around a point, for air that varies over kilometres."""

from __future__ import annotations

from math import cos, pi

from aerosim.frames import radii

Drift = tuple[float, float]


class LocalPlane:
    """Metres north and east of an origin, at one height, in a plane that may be carried along by the wind.

    North and east run along meridian and parallel with the origin's radii: 100 km away a distance is up to 2 % off
    at 50 deg of latitude, which does not matter for random air.
    """

    def __init__(self, lat: float, lon: float, height: float, drift: Drift = (0.0, 0.0)) -> None:
        """lat, lon: origin at time 0, rad; height: ellipsoidal, m; drift: of the plane, north, east, m/s."""
        meridian, normal = radii(lat)
        self._lat, self._lon = lat, lon
        self._north = float(meridian) + height
        self._east = (float(normal) + height) * cos(lat)
        self._drift = drift

    def at(self, t: float, lat: float, lon: float) -> tuple[float, float]:
        """North and east, m, of a point (rad) at time t (s)."""
        turn = (lon - self._lon + pi) % (2.0 * pi) - pi
        north, east = self._drift
        return (lat - self._lat) * self._north - north * t, turn * self._east - east * t
