"""The flying aircraft: one JSBSim model behind SI units.  The only place of feet; property names: `properties`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from operator import call
from pathlib import Path
from typing import Any

import numpy as np

from aerosim.errors import InputError, RunFailure
from aerosim.flight import fdm, properties
from aerosim.flight.limits import Limits
from aerosim.flight.plan import wind_triangle
from aerosim.flight.trim import Trim, first_guess, solve
from aerosim.frames import GRAVITY, Array, mat_from_attitude, radii
from aerosim.truth import AircraftState, AirState

FOOT = 0.3048
PER_FOOT = 1.0 / FOOT
POUND = 0.45359237
LBF = 4.4482216152605
CHECK_EVERY = 24


class Aircraft:
    """One aircraft in flight.  Built, started once, then stepped; a second flight takes a second aircraft.

    command_roll(roll): the roll that the autopilot holds, rad.  bare_step(): a step of JSBSim and nothing else.
    """

    def __init__(self, folder: Path, step_rate_hz: float, fuel_kg: float | None = None) -> None:
        """folder: of the model, which bears its name.  fuel_kg: None takes what the limits file says.

        Raises InputError for a model that is missing, refused by JSBSim or without the properties used here.
        """
        self.limits = Limits.read(folder / "limits.yaml")
        fuel = self.limits.fuel_kg if fuel_kg is None else fuel_kg
        self.limits.check_fuel(fuel)
        self._fdm, self.warnings = fdm.load(folder, step_rate_hz)
        self.step_rate = float(step_rate_hz)
        self.step_period = 1.0 / self.step_rate
        self._nodes = fdm.nodes(self._fdm, properties.NAMES, folder)
        self._set("inertia/pointmass-weight-lbs", fuel / POUND)
        self._mass = self.limits.mass_empty_kg + fuel
        self._state = tuple(self._getter(name) for name in properties.STATE)
        self._ecef = tuple(self._getter(name) for name in properties.ECEF)
        self._kept = (*self._state, *self._ecef[:3])
        self._wind = tuple(self._setter(name) for name in properties.WIND)
        self._gust = tuple(self._setter(name) for name in properties.GUST)
        self._air = (*self._wind, *self._gust[3:])
        self.command_roll = self._setter("ap/roll-cmd-rad")
        self.bare_step = self._fdm.run
        self._wind_n = (0.0, 0.0, 0.0)
        self.steps = 0

    def _getter(self, name: str) -> Any:
        return self._nodes[name].get_double_value

    def _setter(self, name: str) -> Any:
        return self._nodes[name].set_double_value

    def _get(self, name: str) -> float:
        return float(self._nodes[name].get_double_value())

    def _set(self, name: str, value: float) -> None:
        self._nodes[name].set_double_value(value)

    def check_speed(self, height: float, airspeed: float) -> None:
        """Raise InputError for a height (m) or true airspeed (m/s) that this aircraft cannot fly."""
        self.limits.check_speed(height, airspeed, self._mass)

    @property
    def span(self) -> float:
        """Wing span, m."""
        return self._get("metrics/bw-ft") * FOOT

    @property
    def fuel(self) -> float:
        """Fuel left, kg."""
        return self._get("inertia/pointmass-weight-lbs") * POUND

    def start(
        self,
        lat: float,
        lon: float,
        height: float,
        course: float,
        airspeed: float,
        wind_n: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> Trim:
        """Put the aircraft into steady level flight along a course in the wind, ball centred (no side force).

        lat, lon: rad; height: ellipsoidal, m; course: of the ground track, rad; airspeed: true, m/s;
        wind_n: velocity of the air, north, east, down, m/s.  The autopilot holds height and airspeed from here on.
        Raises InputError for a speed outside the limits, wind above the airspeed, or too little power.
        """
        self.check_speed(height, airspeed)
        level = math.sqrt(max(airspeed**2 - wind_n[2] ** 2, 0.0))
        azimuth, _ = wind_triangle(course, level, wind_n[0], wind_n[1])
        air_n = np.array([level * math.cos(azimuth), level * math.sin(azimuth), -wind_n[2]])
        self._set("ap/on", 0.0)
        self._place(lat, lon, height, wind_n)
        vel_n = air_n + np.array(wind_n)
        weight = self._mass * GRAVITY
        guess = first_guess(weight, airspeed, self.limits.lift(height, airspeed, self._mass))
        x, iterations = solve(lambda x: self._trim_residual(x, azimuth, vel_n, lat, height), *guess)
        trim = self._read_trim(x, iterations, airspeed)
        if not 0.0 < trim.power <= trim.power_available:
            raise InputError(
                f"{self.limits.model} has too little power for {airspeed:g} m/s at {height:g} m",
                allowed=f"needs {trim.power / 1e3:.0f} kW, has {trim.power_available / 1e3:.0f} kW",
            )
        self._set("trim/theta-rad", trim.pitch)
        self._heading = trim.heading
        self._settle(wind_n)
        self.command(trim.roll, height, airspeed)
        self._set("ap/on", 1.0)
        return trim

    def _place(self, lat: float, lon: float, height: float, wind_n: tuple[float, float, float]) -> None:
        """Position and air.  JSBSim takes a height above its own sea level, centimetres off the ellipsoid's."""
        # The wind goes into the gust while trimming: a run of initial conditions would clear the wind itself.
        for setter, value in zip(self._gust, (*wind_n, 0.0, 0.0, 0.0), strict=True):
            setter(value * PER_FOOT)
        self._set("ic/lat-geod-rad", lat)
        self._set("ic/long-gc-rad", lon)
        level = height * PER_FOOT
        for _ in range(2):
            self._set("ic/h-sl-ft", level)
            self._fdm.run_ic()
            level += height * PER_FOOT - self._get("position/geod-alt-ft")

    def _pose(self, attitude: Array, vel_n: Array, omega_eb_b: Array) -> Array:
        """The six accelerations, SI, in b, at an attitude (heading, pitch, roll), ground velocity and rates."""
        values = (*attitude, *(vel_n * PER_FOOT), *omega_eb_b)
        for name, value in zip(properties.START, values, strict=True):
            self._set(name, value)
        self._fdm.run_ic()
        found = np.array([self._get(name) for name in properties.ACCELERATION])
        found[:3] *= FOOT
        return found

    def _trim_residual(self, x: Array, azimuth: float, vel_n: Array, lat: float, height: float) -> Array:
        pitch, elevator, power, roll, aileron, rudder, sideslip = x
        # A banked, pitched nose without sideslip lies beside the air's azimuth.
        heading = azimuth + math.atan(math.sin(pitch) * math.tan(roll)) - sideslip
        for name, value in zip(properties.TRIM[:4], (elevator, aileron, rudder, power), strict=True):
            self._set(name, value)
        meridian, normal = radii(lat)
        north, east = vel_n[0] / (meridian + height), vel_n[1] / (normal + height)
        omega_en_n = np.array([east, -north, -east * math.tan(lat)])
        omega_eb_b = mat_from_attitude(heading, pitch, roll).T @ omega_en_n
        accelerations = self._pose(np.array([heading, pitch, roll]), vel_n, omega_eb_b)
        return np.append(accelerations, self._get("forces/fby-total-lbs") * LBF / self._mass)

    def derivatives(self, x: Array) -> Array:
        """Time derivatives of a perturbed state with the controls of the trim, in still air; for linearisation.

        x: (8,), u, v, w (m/s), p, q, r (rad/s), roll, pitch (rad).  Returns (8,).  Ends the flight.
        """
        self._set("ap/on", 0.0)
        if any(self._wind_n):
            raise ValueError("derivatives are taken in still air")
        (p, q, r), (roll, pitch) = x[3:6], x[6:]
        heading = self._heading
        vel_n = mat_from_attitude(heading, pitch, roll) @ x[:3]
        # JSBSim takes the rates of alpha and beta from the accelerations before: once more makes them these.
        for _ in range(2):
            found = self._pose(np.array([heading, pitch, roll]), vel_n, x[3:6])
        turning = q * math.sin(roll) + r * math.cos(roll)
        return np.array([*found, p + turning * math.tan(pitch), q * math.cos(roll) - r * math.sin(roll)])

    def _read_trim(self, x: Array, iterations: int, airspeed: float) -> Trim:
        pitch, elevator, power, roll, aileron, rudder, _ = (float(v) for v in x)
        alpha = self._get("aero/alpha-rad")
        forward, down = self._get("forces/fbx-aero-lbs"), self._get("forces/fbz-aero-lbs")
        reference = self._get("aero/qbar-psf") * self.limits.wing_area_m2 * PER_FOOT**2
        return Trim(
            roll=roll,
            pitch=pitch,
            heading=self._get("attitude/psi-rad"),
            alpha=alpha,
            sideslip=self._get("aero/beta-rad"),
            elevator=elevator,
            aileron=aileron,
            rudder=rudder,
            power=power,
            power_available=self._get("power/available-w"),
            thrust=self._get("forces/fbx-external-lbs") * LBF,
            lift=(forward * math.sin(alpha) - down * math.cos(alpha)) / reference,
            iterations=iterations,
        )

    def _settle(self, wind_n: tuple[float, float, float]) -> None:
        """The trimmed state with the wind where it belongs."""
        self._wind_n = wind_n
        for setter, value in zip(self._wind, wind_n, strict=True):
            setter(value * PER_FOOT)
        for setter in self._gust:
            setter(0.0)
        self.steps = 0

    def command(self, roll: float, height: float, airspeed: float) -> None:
        """What the autopilot holds: roll (rad), ellipsoidal height (m), true airspeed (m/s)."""
        self.command_roll(roll)
        self._set("ap/h-cmd-ft", height * PER_FOOT)
        self._set("ap/v-cmd-fps", airspeed * PER_FOOT)

    def feel(self, air: AirState, mat_nb: tuple[float, ...]) -> None:
        """Put the aircraft into this air until it is put into another; mat_nb (row by row) turns gusts into n."""
        to_north, to_east, to_down, roll, pitch, yaw = self._air
        north, east, down, u, v, w, p, q, r = air
        nu, nv, nw, eu, ev, ew, du, dv, dw = mat_nb
        to_north(PER_FOOT * (north + nu * u + nv * v + nw * w))
        to_east(PER_FOOT * (east + eu * u + ev * v + ew * w))
        to_down(PER_FOOT * (down + du * u + dv * v + dw * w))
        roll(p)
        pitch(q)
        yaw(r)

    def advance(self, steps: int) -> None:
        """Fly so many steps.  Raises RunFailure when the aircraft is lost (looked at every 24 steps)."""
        run, until = self.bare_step, CHECK_EVERY - self.steps % CHECK_EVERY
        while steps >= until:  # at the same steps however a flight is cut
            for _ in range(until):
                run()
            self.steps += until
            self._check()
            steps, until = steps - until, CHECK_EVERY
        for _ in range(steps):
            run()
        self.steps += steps

    def _check(self) -> None:
        height, alpha = self._get("position/geod-alt-ft"), self._get("aero/alpha-rad")
        reason = ""
        if not (math.isfinite(height) and math.isfinite(alpha)):
            reason = "its state is not finite"
        elif abs(math.degrees(alpha)) > self.limits.alpha_max_deg:
            reason = f"angle of attack of {math.degrees(alpha):.1f} deg"
        elif self._get("inertia/pointmass-weight-lbs") <= 0.0:
            reason = "fuel used up"
        if reason:
            raise RunFailure(f"aircraft lost at {self.steps * self.step_period:.2f} s: {reason}")

    def state(self) -> AircraftState:
        """State now, SI."""
        lat, lon, h, vn, ve, vd, roll, pitch, heading, p, q, r, airspeed = [get() for get in self._state]
        return AircraftState(
            self.steps * self.step_period, lat, lon, h * FOOT, vn * FOOT, ve * FOOT, vd * FOOT,
            roll, pitch, heading, p, q, r, airspeed * FOOT,
        )  # fmt: skip

    def sample(self) -> Iterator[float]:
        """Numbers of now that `states` needs, as JSBSim has them, to be read at once."""
        return map(call, self._kept)

    def states(self, samples: Array, first: int) -> tuple[Array, Array]:
        """States (n, 14) and positions in e (n, 3), SI, of samples (n, 16) at steps `first` on: as told then."""
        t = np.arange(first, first + len(samples)) * self.step_period
        states = np.column_stack([t, samples[:, :13]])
        states[:, [3, 4, 5, 6, 13]] *= FOOT
        return states, samples[:, 13:] * FOOT

    def place(self) -> tuple[float, float, float]:
        """Latitude, longitude (rad), ellipsoidal height (m)."""
        return self._state[0](), self._state[1](), self._state[2]() * FOOT

    def attitude(self) -> tuple[float, float, float]:
        """Roll, pitch, heading, rad."""
        return self._state[6](), self._state[7](), self._state[8]()

    def place_e(self) -> tuple[float, float, float]:
        """Position in e, m."""
        x, y, z = self._ecef[:3]
        return x() * FOOT, y() * FOOT, z() * FOOT

    def ecef(self) -> tuple[float, float, float, float, float, float]:
        """Position (m) and velocity over ground (m/s) in e."""
        x, y, z, vx, vy, vz = self._ecef
        return x() * FOOT, y() * FOOT, z() * FOOT, vx() * FOOT, vy() * FOOT, vz() * FOOT
