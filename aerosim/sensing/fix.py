"""A modern mount's own guide: track and speed of a satellite receiver, heading of an inertial system."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

from aerosim.signals import MotionEstimate
from aerosim.truth import AircraftState

NOISE_BLOCK = 512
TURN = 2.0 * math.pi
EARLY = 1e-6  # s; times of exposures are sums of steps


class FixParameters(NamedTuple):
    """How receiver and inertial system err.  s, m, m/s, rad, rad/s.

    period, delay: of the receiver's fixes; velocity_sigma: of each level component; height_sigma: of its height.
    heading_period, heading_sigma: of the inertial heading; heading_drift: standard deviation of its drift rate;
    boresight_yaw: camera against the unit, clockwise seen from above, which nobody has told the mount.
    """

    period: float
    delay: float
    velocity_sigma: float
    height_sigma: float
    heading_period: float
    heading_sigma: float
    heading_drift: float
    boresight_yaw: float


class Fix(NamedTuple):
    """What a fix says.  arrives: s; track: rad; speed: level, m/s; height: ellipsoidal, m."""

    arrives: float
    track: float
    speed: float
    height: float


class SatelliteCompass:
    """Tells drift as satellite track less inertial heading, and v/h as satellite speed over planned height.

    Between fixes the last track is kept and the heading goes on.  The lever arm of the antenna is taken out, which
    the inertial rates allow.  Of the relief it knows nothing.
    """

    def __init__(self, parameters: FixParameters, ground_height: float, rng: np.random.Generator) -> None:
        """ground_height: mean of the land as planned, ellipsoidal, m: a belief, whatever lies below."""
        par = self._par = parameters
        self._ground = ground_height
        self._rng = rng
        self._drift_rate = par.heading_drift * rng.standard_normal()
        self._next_fix = self._next_heading = -math.inf
        self._on_the_way: deque[Fix] = deque()
        self._last: Fix | None = None
        self._noise: list[list[float]] = []

    def tell(self, aircraft: AircraftState, terrain_height: float, mount_yaw: float) -> MotionEstimate | None:
        """Drift and v/h at each reading of the heading, None in between and before the first fix has arrived.

        terrain_height, mount_yaw: not known to it.
        """
        t = aircraft.t
        if t >= self._next_fix - EARLY:
            self._next_fix = max(self._next_fix, t) + self._par.period
            self._on_the_way.append(self._fix(aircraft))
        while self._on_the_way and t >= self._on_the_way[0].arrives - EARLY:
            self._last = self._on_the_way.popleft()
        if t < self._next_heading - EARLY:
            return None
        self._next_heading = max(self._next_heading, t) + self._par.heading_period
        noise = self._draw()[3]
        if self._last is None:
            return None
        return self._estimate(
            t, aircraft.heading - self._par.boresight_yaw + self._drift_rate * t + noise, self._last
        )

    def _draw(self) -> list[float]:
        if not self._noise:
            par = self._par
            scale = [par.velocity_sigma, par.velocity_sigma, par.height_sigma, par.heading_sigma]
            self._noise = (self._rng.standard_normal((NOISE_BLOCK, 4)) * scale).tolist()
        return self._noise.pop()

    def _fix(self, aircraft: AircraftState) -> Fix:
        n_north, n_east, n_height, _ = self._draw()
        north, east = aircraft.v_north + n_north, aircraft.v_east + n_east
        return Fix(
            aircraft.t + self._par.delay,
            math.atan2(east, north),
            math.hypot(north, east),
            aircraft.height + n_height,
        )

    def _estimate(self, t: float, heading: float, fix: Fix) -> MotionEstimate:
        """Drift and v/h with the standard deviations that their white noise alone gives."""
        par, above = self._par, fix.height - self._ground
        vh = fix.speed / above
        across = par.velocity_sigma / fix.speed
        sigma_vh = vh * math.hypot(across, par.height_sigma / above)
        drift = math.remainder(fix.track - heading, TURN)
        return MotionEstimate(t, drift, vh, math.hypot(across, par.heading_sigma), sigma_vh, True)
