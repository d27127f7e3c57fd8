"""Second solution of a table: the textbook's equations of motion over a flat Earth, in plain numpy.

It shares neither code nor engine with the flying model: what the two agree on follows from the coefficients.
Sources: Etkin, Dynamics of Flight; Rauw, FDC 1.2 (both for the rates of alpha and beta).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maker.table import LBF, Table, Turboprops

Vector = NDArray[np.float64]

EARTH_RATE = 7.292115e-5


class Controls(NamedTuple):
    """Surfaces (rad, this project's signs) and power at the shaft (W)."""

    elevator: float
    aileron: float
    rudder: float
    power: float


class Steady(NamedTuple):
    """Straight flight with level wings: rad, W."""

    alpha: float
    beta: float
    pitch: float
    controls: Controls


class Motions(NamedTuple):
    """Natural frequencies (rad/s), damping ratios, time constants (s; negative: unstable)."""

    short_period: float
    short_period_damping: float
    phugoid: float
    phugoid_damping: float
    dutch_roll: float
    dutch_roll_damping: float
    roll_s: float
    spiral_s: float


def standard_density(height: float) -> float:
    """Density of the standard atmosphere, kg/m3.  height: m."""
    return 1.225 * float((1.0 - 2.25577e-5 * height) ** 4.255880)


def felt_gravity(lat: float, height: float, airspeed: float) -> float:
    """Weight of a kilogram in level flight to the east, N: gravity, less what the round, turning Earth takes off.

    lat: rad; height: m; airspeed: m/s.  Normal gravity of WGS-84 (Somigliana) and its fall with height.
    """
    sin2 = math.sin(lat) ** 2
    normal = 9.7803253359 * (1.0 + 0.00193185265241 * sin2) / math.sqrt(1.0 - 0.00669437999014 * sin2)
    normal *= 1.0 - 2.0 * height / 6378137.0 * (1.00670 - 0.0067056 * sin2) + 3.0 * (height / 6378137.0) ** 2
    radius = 6378137.0 / math.sqrt(1.0 - 0.00669437999014 * sin2) + height
    return normal - 2.0 * EARTH_RATE * airspeed * math.cos(lat) - airspeed**2 / radius


class Body:
    """Equations of motion of a table at one density (kg/m3), weight of a kilogram (N) and mass (kg)."""

    def __init__(self, table: Table, rho: float, gravity: float, mass: float | None = None) -> None:
        self.table = table
        self.rho = rho
        self.gravity = gravity
        self.mass = table.mass.total_kg if mass is None else mass
        length, inertia = table.geometry.metre, table.mass
        self.area = table.geometry.area * length**2
        self.span, self.chord = table.geometry.span * length, table.geometry.chord * length
        ixx, iyy, izz, ixz = (inertia.kg_m2 * v for v in (inertia.ixx, inertia.iyy, inertia.izz, inertia.ixz))
        self.inertia = np.array([[ixx, 0.0, -ixz], [0.0, iyy, 0.0], [-ixz, 0.0, izz]])

    def coefficients(self, values: dict[str, float]) -> dict[str, float]:
        """Sums of the table's terms, axis by axis, for values of their factors."""
        found = dict(values)
        for axis in (*self.table.sums, "X", "Y", "Z", "LIFT", "DRAG", "ROLL", "PITCH", "YAW"):
            found[axis] = sum(
                self.table.value(term) * math.prod(found[factor] for factor in term.factors)
                for term in self.table.terms
                if term.axis == axis
            )
        return found

    def loads(self, x: Vector, rates: tuple[float, float], controls: Controls) -> tuple[Vector, Vector]:
        """Forces (N) and moments (Nm) of air and engine in b.  rates: of alpha and beta, rad/s."""
        u, v, w, p, q, r = x[:6]
        speed = math.sqrt(u * u + v * v + w * w)
        alpha, beta = math.atan2(w, u), math.asin(v / speed)
        pressure = 0.5 * self.rho * speed**2
        half_span, half_chord = self.span / (2.0 * speed), self.chord / (2.0 * speed)
        values = {
            "alpha": alpha,
            "beta": beta,
            "p^": p * half_span,
            "q^": 2.0 * self.table.q_chords * q * half_chord,
            "r^": r * half_span,
            "alpha'^": rates[0] * half_chord,
            "beta'^": rates[1] * half_span,
            "de": controls.elevator,
            "da": controls.aileron,
            "dr": controls.rudder,
            "df": 0.0,
        }
        engine, push = self.table.engine, 0.0
        if isinstance(engine, Turboprops):
            push = min(engine.efficiency * controls.power / speed, engine.static_lbf * LBF)
        else:
            values["t"] = engine.constant + engine.slope * controls.power / 1e3 / (pressure * speed)
        c = self.coefficients(values)
        forward, down = c["X"], c["Z"]
        if self.table.force_frame == "STABILITY":
            forward = c["LIFT"] * math.sin(alpha) - c["DRAG"] * math.cos(alpha)
            down = -c["LIFT"] * math.cos(alpha) - c["DRAG"] * math.sin(alpha)
        force = pressure * self.area * np.array([forward, c["Y"], down]) + np.array([push, 0.0, 0.0])
        moment = (
            pressure * self.area * np.array([c["ROLL"] * self.span, c["PITCH"] * self.chord, c["YAW"] * self.span])
        )
        return force, moment

    def derivatives(self, x: Vector, controls: Controls) -> Vector:
        """Rates of u, v, w (m/s), p, q, r (rad/s), roll, pitch (rad).  x: (8,).  Returns (8,)."""
        vel, omega, roll, pitch = x[:3], x[3:6], x[6], x[7]
        weight = self.gravity * np.array(
            [-math.sin(pitch), math.sin(roll) * math.cos(pitch), math.cos(roll) * math.cos(pitch)]
        )
        level2, speed2 = vel[0] ** 2 + vel[2] ** 2, float(vel @ vel)
        rates = (0.0, 0.0)
        for _ in range(12):  # the forces depend on the rates of alpha and beta, by about 1 %
            force, moment = self.loads(x, rates, controls)
            dot = force / self.mass + weight - np.cross(omega, vel)
            along = float(vel @ dot) / math.sqrt(speed2)
            rates = (
                float(vel[0] * dot[2] - vel[2] * dot[0]) / level2,
                float(math.sqrt(speed2) * dot[1] - vel[1] * along) / (math.sqrt(speed2) * math.sqrt(level2)),
            )
        spin = np.linalg.solve(self.inertia, moment - np.cross(omega, self.inertia @ omega))
        turn = omega[1] * math.sin(roll) + omega[2] * math.cos(roll)
        angles = (omega[0] + turn * math.tan(pitch), omega[1] * math.cos(roll) - omega[2] * math.sin(roll))
        return np.array([*dot, *spin, *angles])


def state(airspeed: float, alpha: float, beta: float, pitch: float) -> Vector:
    """State of straight flight with level wings.  m/s, rad.  (8,)."""
    u, v, w = math.cos(alpha) * math.cos(beta), math.sin(beta), math.sin(alpha) * math.cos(beta)
    return np.array([airspeed * u, airspeed * v, airspeed * w, 0.0, 0.0, 0.0, 0.0, pitch])


def root(residual: Callable[[Vector], Vector], x: Vector) -> Vector:
    """Newton's method with forward differences."""
    for _ in range(40):
        r = residual(x)
        if np.abs(r).max() < 1e-11:
            return x
        jacobian = np.column_stack([(residual(x + d) - r) / 1e-6 for d in 1e-6 * np.eye(len(x))])
        move = np.linalg.solve(jacobian, -r)
        x = x + move * min(1.0, 0.3 / np.abs(move).max())
    raise ArithmeticError("no trim")


def level_trim(body: Body, airspeed: float) -> Steady:
    """Level flight with level wings, so without side force.  airspeed: m/s."""
    scale = body.mass * body.gravity * airspeed / 9.0

    def residual(x: Vector) -> Vector:
        alpha, beta, de, da, dr, power = x
        return body.derivatives(state(airspeed, alpha, beta, alpha), Controls(de, da, dr, power * scale))[:6]

    alpha, beta, de, da, dr, power = root(residual, np.array([0.08, 0.0, 0.0, 0.0, 0.0, 1.0]))
    return Steady(alpha, beta, alpha, Controls(de, da, dr, power * scale))


def powered_trim(body: Body, airspeed: float, power: float) -> Steady:
    """Straight flight with level wings at a given power (W): it climbs or sinks as it must.  airspeed: m/s."""

    def residual(x: Vector) -> Vector:
        alpha, beta, de, da, dr, pitch = x
        return body.derivatives(state(airspeed, alpha, beta, pitch), Controls(de, da, dr, power))[:6]

    alpha, beta, de, da, dr, pitch = root(residual, np.array([0.08, 0.0, 0.0, 0.0, 0.0, 0.08]))
    return Steady(alpha, beta, pitch, Controls(de, da, dr, power))


def jacobian(body: Body, airspeed: float, trim: Steady) -> Vector:
    """Derivatives of the eight rates to the eight states, central differences.  (8, 8)."""
    x = state(airspeed, trim.alpha, trim.beta, trim.pitch)
    steps = np.diag([1e-3, 1e-3, 1e-3, 1e-5, 1e-5, 1e-5, 1e-5, 1e-5])
    columns = [
        (body.derivatives(x + d, trim.controls) - body.derivatives(x - d, trim.controls)) / (2.0 * d.sum())
        for d in steps
    ]
    return np.column_stack(columns)


def sides_apart(matrix: Vector) -> Vector:
    """The matrix without what couples the motion in the plane of symmetry to the other.  (8, 8)."""
    side = np.array([0, 1, 0, 1, 0, 1, 1, 0])
    return np.where(side[:, None] == side, matrix, 0.0)


def motions(matrix: Vector) -> Motions:
    """Natural motions of a matrix of the eight states: pairs by frequency, then the two real roots.

    A pair is the dutch roll when sideslip moves more in it than the airspeed's direction up and down.
    """
    roots, vectors = np.linalg.eig(matrix)
    pairs = [k for k in range(len(roots)) if roots[k].imag > 1e-9]
    real = sorted((roots[k].real for k in range(len(roots)) if abs(roots[k].imag) <= 1e-9), key=abs)
    sideways = [abs(vectors[1, k]) / abs(vectors[2, k]) for k in pairs]
    dutch = pairs.pop(int(np.argmax(sideways)))
    slow, fast = sorted(pairs, key=lambda k: abs(roots[k]))
    found: list[float] = []
    for k in (fast, slow, dutch):
        found += [float(abs(roots[k])), float(-roots[k].real / abs(roots[k]))]
    return Motions._make([*found, -1.0 / real[1], -1.0 / real[0]])
