"""The planned flight: lines, run-ins, what they take in a given wind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from aerosim.errors import InputError
from aerosim.flight.turns import Turn, plan_turn, turn_radius
from aerosim.frames import Array, ecef_from_geodetic, geodetic_from_ecef, mat_ne, radii

SHORTEST_LINE = 100.0
LONGEST_LINE = 1.0e6
TURN_BANK = 0.9


def wind_triangle(course: float, airspeed: float, wind_north: float, wind_east: float) -> tuple[float, float]:
    """Heading that keeps a course in the wind, and the ground speed on it.

    course: of the ground track, rad; airspeed: true, m/s; wind: velocity of the air (where it goes to), m/s.
    drift = course - heading: wind from the left pushes to the right and makes it positive.
    Raises InputError when the wind lets no such course be flown.
    """
    along = wind_north * math.cos(course) + wind_east * math.sin(course)
    across = wind_east * math.cos(course) - wind_north * math.sin(course)
    speed = math.hypot(wind_north, wind_east)
    if not abs(across) < airspeed or along + math.sqrt(airspeed**2 - across**2) <= 0.0:
        raise InputError(f"wind of {speed:.3g} m/s cannot be flown against", allowed=f"below {airspeed:.4g} m/s")
    drift = math.asin(across / airspeed)
    return course - drift, airspeed * math.cos(drift) + along


@dataclass(frozen=True)
class Line:
    """A survey line from start to end: (latitude, longitude), rad.

    It is the plane through both points that holds the ellipsoid's normal midway between them.
    Raises InputError for points off the Earth, equal ones, and lines of absurd length.
    """

    start: tuple[float, float]
    end: tuple[float, float]

    def __post_init__(self) -> None:
        for lat, lon in (self.start, self.end):
            if not (abs(lat) <= math.radians(85.0) and abs(lon) <= 2.0 * math.pi):
                raise InputError(
                    f"line at latitude {math.degrees(lat):g} deg, longitude {math.degrees(lon):g} deg",
                    allowed="latitude -85 to 85 deg, longitude -360 to 360 deg",
                )
        if not SHORTEST_LINE <= self._chord <= LONGEST_LINE:
            raise InputError(
                f"line of {self._chord / 1e3:.4g} km",
                allowed=f"{SHORTEST_LINE:g} m to {LONGEST_LINE / 1e3:g} km, points as latitude, longitude",
            )

    @cached_property
    def _ends(self) -> Array:
        lat, lon = np.transpose([self.start, self.end])
        return ecef_from_geodetic(lat, lon, np.zeros(2))

    @cached_property
    def _chord(self) -> float:
        return float(np.linalg.norm(self._ends[1] - self._ends[0]))

    @cached_property
    def normal(self) -> Array:
        """Unit normal of the line's plane in e, to the right of the line.  (3,)."""
        lat, lon, _ = geodetic_from_ecef(self._ends.mean(axis=0))
        right = np.cross(self._ends[1] - self._ends[0], -mat_ne(float(lat), float(lon))[2])
        return np.asarray(right / np.linalg.norm(right))

    @cached_property
    def offset(self) -> float:
        """Distance of the plane from the Earth's centre along its normal, m."""
        return float(self.normal @ self._ends[0])

    def course_at(self, lat: float, lon: float) -> float:
        """Course over ground of the line, or its extension, at a point on it (rad), rad."""
        north, east, _ = mat_ne(lat, lon) @ self._forward((lat, lon))
        return math.atan2(east, north)

    def _forward(self, point: tuple[float, float]) -> Array:
        forward = np.cross(-mat_ne(*point)[2], self.normal)
        return np.asarray(forward / np.linalg.norm(forward))

    @cached_property
    def forward_start(self) -> Array:
        """Level unit vector along the line at its start, in e.  (3,)."""
        return self._forward(self.start)

    @cached_property
    def forward_end(self) -> Array:
        """Level unit vector along the line at its end, in e.  (3,)."""
        return self._forward(self.end)

    @cached_property
    def course(self) -> float:
        """Course over ground at the start, rad."""
        return self.course_at(*self.start)

    @cached_property
    def course_end(self) -> float:
        """Course over ground at the end, rad."""
        return self.course_at(*self.end)

    @cached_property
    def _radius(self) -> float:
        """Radius of the ellipsoid midway along the line (Euler)."""
        meridian, normal = radii((self.start[0] + self.end[0]) / 2.0)
        return float(1.0 / (math.cos(self.course) ** 2 / meridian + math.sin(self.course) ** 2 / normal))

    @cached_property
    def length(self) -> float:
        """Length on the ellipsoid, m."""
        return 2.0 * self._radius * math.asin(self._chord / (2.0 * self._radius))

    def length_at(self, height: float) -> float:
        """Length of the path flown at a height (m) above the ellipsoid, m."""
        return self.length * (1.0 + height / self._radius)

    def end_points(self, height: float) -> Array:
        """Start and end at a height (m) above the ellipsoid, in e.  (2, 3), m."""
        lat, lon = np.transpose([self.start, self.end])
        return ecef_from_geodetic(lat, lon, np.full(2, height))

    def before_start(self, distance: float, height: float) -> tuple[float, float]:
        """Latitude and longitude (rad) of the point on the line's extension, a distance (m) before its start."""
        lat, lon, _ = geodetic_from_ecef(self.end_points(height)[0] - distance * self.forward_start)
        return float(lat), float(lon)

    def frame_wind(self, wind_north: float, wind_east: float) -> tuple[float, float]:
        """Wind along the line and to its right, at its start, m/s."""
        cos, sin = math.cos(self.course), math.sin(self.course)
        return wind_north * cos + wind_east * sin, wind_east * cos - wind_north * sin


@dataclass(frozen=True)
class Forecast:
    """What a plan takes in a steady wind: durations in s, drift per line in rad, ground speed in m/s."""

    duration: float
    line_s: tuple[float, ...]
    turn_s: tuple[float, ...]
    drift: tuple[float, ...]
    ground_speed: tuple[float, ...]


@dataclass(frozen=True)
class FlightPlan:
    """Lines flown in their order, at one ellipsoidal height (m) and true airspeed (m/s).

    run_in_s: on the line's extension before its start; bank_max: rad.  Raises InputError for values that make
    no flight.
    """

    lines: Sequence[Line]
    height: float
    airspeed: float
    run_in_s: float = 60.0
    bank_max: float = math.radians(20.0)

    def __post_init__(self) -> None:
        if not self.lines:
            raise InputError("a flight plan without lines")
        if not 0.0 < self.airspeed < 400.0:
            raise InputError(f"airspeed of {self.airspeed:g} m/s", allowed="above 0, below 400 m/s")
        if not -500.0 <= self.height <= 20_000.0:
            raise InputError(f"height of {self.height:g} m above the ellipsoid", allowed="-500 to 20000 m")
        if not 0.0 <= self.run_in_s <= 1800.0:
            raise InputError(f"run-in of {self.run_in_s:g} s", allowed="0 to 1800 s")
        if not math.radians(5.0) <= self.bank_max <= math.radians(45.0):
            raise InputError(f"bank of {math.degrees(self.bank_max):g} deg", allowed="5 to 45 deg")

    @property
    def bank_turn(self) -> float:
        """Bank of the planned turns, rad: a tenth is kept to correct with."""
        return TURN_BANK * self.bank_max

    def run_in_distance(self, line: Line, wind_north: float, wind_east: float) -> float:
        """Length of a line's run-in over ground, m."""
        return self.run_in_s * wind_triangle(line.course, self.airspeed, wind_north, wind_east)[1]

    def turn(self, line: Line, position_e: Array, velocity_e: Array, wind: tuple[float, float]) -> Turn:
        """Turn onto a line's run-in from a position (m) and ground velocity (m/s) in e; wind north, east, m/s."""
        wind_along, wind_across = line.frame_wind(*wind)
        distance = self.run_in_distance(line, *wind)
        start = line.end_points(self.height)[0]
        along = float(line.forward_start @ (position_e - start)) + distance
        across = float(line.normal @ position_e) - line.offset
        velocity = (float(line.forward_start @ velocity_e), float(line.normal @ velocity_e))
        return plan_turn(
            (along, across),
            math.atan2(velocity[1] - wind_across, velocity[0] - wind_along),
            self.airspeed,
            (wind_along, wind_across),
            turn_radius(self.airspeed, self.bank_turn),
            self.bank_turn,
        )

    def forecast(self, wind_north: float = 0.0, wind_east: float = 0.0) -> Forecast:
        """Duration of the flight, run-ins and turns included, in a steady wind (m/s, where it goes to).

        Raises InputError for a wind in which a line cannot be flown.
        """
        line_s, turn_s, drift, speed = [], [], [], []
        for index, line in enumerate(self.lines):
            heading, ground_speed = wind_triangle(line.course, self.airspeed, wind_north, wind_east)
            speed.append(ground_speed)
            drift.append(line.course - heading)
            line_s.append(line.length_at(self.height) / ground_speed)
            if index + 1 < len(self.lines):
                _, exit_speed = wind_triangle(line.course_end, self.airspeed, wind_north, wind_east)
                end = line.end_points(self.height)[1]
                turn = self.turn(
                    self.lines[index + 1], end, exit_speed * line.forward_end, (wind_north, wind_east)
                )
                turn_s.append(turn.duration)
        duration = sum(line_s) + sum(turn_s) + self.run_in_s * len(self.lines)
        return Forecast(duration, tuple(line_s), tuple(turn_s), tuple(drift), tuple(speed))
