"""What a table of an aircraft holds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

FOOT = 0.3048
POUND = 0.45359237
LBF = 4.4482216152605
SLUG_FT2 = POUND * 9.80665 / FOOT * FOOT**2
OURS = "engineering value of this project, no source"

AXES = ("X", "Y", "Z", "ROLL", "PITCH", "YAW")
SYMBOL = {"X": "CX", "Y": "CY", "Z": "CZ", "ROLL": "Cl", "PITCH": "Cm", "YAW": "Cn", "LIFT": "CL", "DRAG": "CD"}


class Term(NamedTuple):
    """One coefficient as its source prints it, per rad.

    axis: of force or moment, or the name of a sum that other terms use.  factors: what it multiplies, none for
    a constant: alpha, beta, rates (p^, q^, r^, alpha'^, beta'^), surfaces (de, da, dr, df), names of sums.
    note: a source of its own, or a doubt.
    """

    axis: str
    factors: tuple[str, ...]
    value: float
    note: str = ""


@dataclass(frozen=True)
class Geometry:
    """Reference area, span and chord in ft or m (unit), as the source has them."""

    unit: Literal["FT", "M"]
    area: float
    span: float
    chord: float

    @property
    def metre(self) -> float:
        """Metres in the unit of length."""
        return FOOT if self.unit == "FT" else 1.0


@dataclass(frozen=True)
class Mass:
    """Mass of the flying aircraft, of which fuel, kg; moments of inertia in slug ft2 or kg m2 (unit).

    ixz is the integral of x z.
    """

    total_kg: float
    fuel_kg: float
    unit: Literal["SLUG*FT2", "KG*M2"]
    ixx: float
    iyy: float
    izz: float
    ixz: float
    note: str

    @property
    def kg_m2(self) -> float:
        """kg m2 in the unit of inertia."""
        return SLUG_FT2 if self.unit == "SLUG*FT2" else 1.0


@dataclass(frozen=True)
class Turboprops:
    """Two turboprops: thrust is power at the shaft times efficiency over airspeed, at most the static thrust.

    rated_w, static_lbf: of both.  Available power: rated, times density ratio to the power of lapse.
    """

    rated_w: float
    rated_source: str
    efficiency: float
    static_lbf: float
    lapse: float
    arm_ft: float
    fuel_kg_per_kwh: float


@dataclass(frozen=True)
class Piston:
    """A supercharged piston engine whose propeller acts through the pressure rise t of the aerodynamic set.

    t = constant + slope P/(rho V3/2), P in kW.  P = scale (p0 + p1 (pz + p2)(n + p3) + (p4 + p5 n)(1 - rho/rho0)),
    pz: manifold pressure, inHg, n: rpm.  rated: of continuous use, at full throttle above the critical height.
    """

    constant: float
    slope: float
    scale: float
    p0: float
    p1: float
    p2: float
    p3: float
    p4: float
    p5: float
    rated_inhg: float
    rated_rpm: float
    critical_height_m: float
    fuel_kg_per_kwh: float

    def power_kw(self, manifold_inhg: float, rpm: float, density_ratio: float) -> float:
        """Power at the shaft by the set's own formula."""
        return self.scale * (
            self.p0
            + self.p1 * (manifold_inhg + self.p2) * (rpm + self.p3)
            + (self.p4 + self.p5 * rpm) * (1.0 - density_ratio)
        )


@dataclass(frozen=True)
class Gains:
    """Autopilot: ft, ft/s, rad, W.  *_most: limits of surfaces and deviations, rad.

    rudder_side: rudder for each g of side force felt, rad: what a weak fin leaves to the feet.
    """

    climb: float
    climb_most: float
    pitch_proportional: float
    pitch_integral: float
    pitch_most: float
    elevator_pitch: float
    elevator_rate: float
    elevator_low: float
    elevator_high: float
    power_proportional: float
    power_integral: float
    power_most: float
    aileron_roll: float
    aileron_integral: float
    aileron_rate: float
    aileron_most: float
    rudder_rate: float
    rudder_most: float
    rudder_side: float = 0.0


@dataclass(frozen=True)
class Table:
    """One aircraft.  source: of all coefficients without a note.  sums: named sums that terms may use.

    force_frame: frame of the forces; moments are in b.  q_chords: q^ is q times this many chords over V.
    reversed: surfaces that the source counts the other way round than this project (elevator + trailing edge
    down, aileron + rolls left, rudder + yaws left).  zero: factors that are always 0 here (flaps up).
    check_m_s: airspeed at which modes and autopilot are judged, at 3000 m.  text, doubts: for the README.
    """

    name: str
    title: str
    source: str
    geometry: Geometry
    mass: Mass
    engine: Turboprops | Piston
    terms: tuple[Term, ...]
    gains: Gains
    limits: dict[str, tuple[float, str]]
    text: str
    signs: str
    doubts: str
    speeds_m_s: tuple[float, ...]
    check_m_s: float
    force_frame: Literal["BODY", "STABILITY"] = "BODY"
    q_chords: float = 0.5
    sums: tuple[str, ...] = ()
    reversed: tuple[str, ...] = ()
    zero: tuple[str, ...] = ()
    autopilot_note: str = ""
    heights_m: tuple[float, ...] = field(default=(500.0, 3000.0, 6000.0))

    def value(self, term: Term) -> float:
        """A term's value for this project's signs of the surfaces."""
        flips = sum(factor in self.reversed for factor in term.factors)
        return term.value * (-1.0) ** flips

    def flown(self, axis: str) -> list[Term]:
        """Terms of an axis or sum that are not always zero."""
        return [t for t in self.terms if t.axis == axis and not set(t.factors) & set(self.zero)]
