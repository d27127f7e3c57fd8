"""Writes the survey twin: its XML model and limits.yaml from the tables of this file, and its README."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

FOLDER = Path(__file__).resolve().parent / "survey_twin"

FOOT = 0.3048
POUND = 0.45359237
LBF = 4.4482216152605

UIUC = "UIUC Smart Icing Systems, Twin Otter aircraft.dat of 23 May 2000 (FlightGear, Aircraft-uiuc/TwinOtter)"
OURS = "engineering value of this project, no source"

WING_FT2, SPAN_FT, CHORD_FT = 420.0, 65.0, 6.5
INERTIA_SLUG_FT2 = {"ixx": 16039.3, "iyy": 22841.6, "izz": 35807.4, "ixz": 1102.8}
MASS_KG, FUEL_KG = 4600.0, 540.0
RATED_W, EFFICIENCY, STATIC_LBF = 924_000.0, 0.84, 4000.0
FUEL_KG_PER_KWH = 0.38


class Term(NamedTuple):
    """One derivative: axis of b, what it multiplies (names of FACTORS, none for a constant), value per rad."""

    axis: str
    factors: tuple[str, ...]
    value: float


FACTORS = {
    "alpha": "aero/alpha-rad",
    "beta": "aero/beta-rad",
    "p^": "aero/p-hat",
    "q^": "aero/q-hat",
    "r^": "aero/r-hat",
    "de": "fcs/elevator-pos-rad",
    "da": "fcs/aileron-pos-rad",
    "dr": "fcs/rudder-pos-rad",
}

TERMS = [
    Term("X", (), -0.0488),
    Term("X", ("alpha",), 0.223),
    Term("X", ("alpha", "alpha"), 1.659),
    Term("Y", ("beta",), -0.6),
    Term("Y", ("p^",), -0.2),
    Term("Y", ("r^",), 0.4),
    Term("Y", ("dr",), 0.15),
    Term("Z", (), -0.360),
    Term("Z", ("alpha",), -5.66),
    Term("Z", ("q^",), -19.97),
    Term("Z", ("de",), -0.608),
    Term("ROLL", ("beta",), -0.08),
    Term("ROLL", ("p^",), -0.5),
    Term("ROLL", ("r^",), 0.06),
    Term("ROLL", ("da",), -0.15),
    Term("ROLL", ("dr",), 0.015),
    Term("PITCH", (), 0.040),
    Term("PITCH", ("alpha",), -1.31),
    Term("PITCH", ("q^",), -34.2),
    Term("PITCH", ("de",), -1.74),
    Term("YAW", ("beta",), 0.1),
    Term("YAW", ("p^",), -0.06),
    Term("YAW", ("r^",), -0.18),
    Term("YAW", ("da",), -0.001),
    Term("YAW", ("dr",), -0.125),
]

LENGTH = {"X": "", "Y": "", "Z": "", "ROLL": "metrics/bw-ft", "PITCH": "metrics/cbarw-ft", "YAW": "metrics/bw-ft"}
SYMBOL = {"X": "CX", "Y": "CY", "Z": "CZ", "ROLL": "Cl", "PITCH": "Cm", "YAW": "Cn"}

LIMITS = {
    "wing_area_m2": (WING_FT2 * FOOT**2, UIUC),
    "lift_max": (1.3, OURS + "; the linear set is taken as attached up to here (alpha 9.5 deg)"),
    "stall_margin": (1.15, OURS + "; the slowest airspeed is this much above the stall"),
    "equivalent_airspeed_max_m_s": (87.5, "170 kt, the class's operating limit, from memory"),
    "height_max_m": (7600.0, "25000 ft, the class's ceiling, from memory"),
    "height_min_m": (-400.0, "the standard atmosphere's lower part"),
    "alpha_max_deg": (20.0, OURS + "; a flight beyond it is lost: the set says nothing there"),
    "mass_empty_kg": (
        MASS_KG - FUEL_KG,
        "with crew, camera and mount; chosen so that 540 kg of fuel give 4600 kg",
    ),
    "fuel_kg": (FUEL_KG, OURS),
    "fuel_max_kg": (1100.0, OURS),
}


def prop(name: str) -> str:
    """A JSBSim property element."""
    return f"<property>{name}</property>"


def product(*parts: str) -> str:
    """A JSBSim product of the given elements."""
    return f"<product>{''.join(parts)}</product>" if len(parts) > 1 else parts[0]


def rate_function(rate: str, scale: str) -> str:
    """Non-dimensional rate of the body against the air."""
    turning = f"<difference>{prop(f'velocities/{rate}-rad_sec')}{prop(f'gust/{rate}-rad_sec')}</difference>"
    return f'    <function name="aero/{rate}-hat">{product(prop(scale), turning)}</function>'


def axis_block(axis: str) -> str:
    """Force or moment of one axis of b, a sum over its terms."""
    terms = [
        product(f"<value>{t.value}</value>", *(prop(FACTORS[f]) for f in t.factors))
        for t in TERMS
        if t.axis == axis
    ]
    reference = [prop("aero/qbar-psf"), prop("metrics/Sw-sqft")]
    if LENGTH[axis]:
        reference.append(prop(LENGTH[axis]))
    lines = "\n".join(f"        {term}" for term in terms)
    body = f"{''.join(reference)}\n      <sum>\n{lines}\n      </sum>"
    return (
        f'    <axis name="{axis}">\n      <function name="aero/force/{SYMBOL[axis]}"><product>{body}</product>'
        "</function>\n    </axis>"
    )


def thrust(name: str, y_ft: float) -> str:
    """Half of the thrust, shaft power times efficiency over airspeed, no more than the static thrust."""
    ratio = EFFICIENCY / (2.0 * FOOT * LBF)
    value = (
        f"<min><value>{STATIC_LBF / 2}</value><quotient>"
        f"{product(f'<value>{ratio!r}</value>', prop('power/shaft-w'))}"
        f"<max><value>30</value>{prop('velocities/vt-fps')}</max></quotient></min>"
    )
    return f"""    <force name="{name}" frame="BODY">
      <function>{value}</function>
      <location unit="FT"><x>0</x><y>{y_ft}</y><z>0</z></location>
      <direction><x>1</x><y>0</y><z>0</z></direction>
    </force>"""


def model_xml() -> str:
    """The whole JSBSim model."""
    origin = "<x>0</x><y>0</y><z>0</z>"
    # With "false" JSBSim takes ixz as published, the integral of x z; with "true", the default, it wants -ixz.
    inertia = "\n".join(f'    <{k} unit="SLUG*FT2">{v}</{k}>' for k, v in INERTIA_SLUG_FT2.items())
    rates = "\n".join(
        rate_function(r, s) for r, s in (("p", "aero/bi2vel"), ("q", "aero/ci2vel"), ("r", "aero/bi2vel"))
    )
    gusts = "\n".join(f'    <property value="0">gust/{r}-rad_sec</property>' for r in "pqr")
    axes = "\n".join(axis_block(axis) for axis in LENGTH)
    specific = FUEL_KG_PER_KWH / POUND / 3.6e6
    return f"""<?xml version="1.0"?>
<!-- Written by make_survey_twin.py; do not edit.  Sources and signs: README.md -->
<fdm_config name="survey_twin" version="2.0" release="BETA">
  <fileheader>
    <author>aerosim</author>
    <description>Survey twin, Twin-Otter class</description>
  </fileheader>
  <metrics>
    <wingarea unit="FT2">{WING_FT2}</wingarea>
    <wingspan unit="FT">{SPAN_FT}</wingspan>
    <chord unit="FT">{CHORD_FT}</chord>
    <location name="AERORP" unit="FT">{origin}</location>
  </metrics>
  <mass_balance negated_crossproduct_inertia="false">
{inertia}
    <emptywt unit="LBS">{(MASS_KG - FUEL_KG) / POUND!r}</emptywt>
    <location name="CG" unit="FT">{origin}</location>
    <pointmass name="fuel">
      <weight unit="LBS">{FUEL_KG / POUND!r}</weight>
      <location unit="FT">{origin}</location>
    </pointmass>
  </mass_balance>
  <ground_reactions/>
  <external_reactions>
{gusts}
    <property value="{RATED_W}">power/rated-w</property>
    <property value="0">power/shaft-w</property>
    <property value="{specific!r}">fuel/specific-lbs_sec_w</property>
{thrust("left", -8.0)}
{thrust("right", 8.0)}
  </external_reactions>
  <system file="autopilot"/>
  <aerodynamics>
{rates}
{axes}
  </aerodynamics>
</fdm_config>
"""


def limits_yaml() -> str:
    """Limits that the flight code reads."""
    head = "# Written by make_survey_twin.py; do not edit.\nmodel: survey_twin\n"
    return head + "".join(f"{key}: {value:.10g}  # {source}\n" for key, (value, source) in LIMITS.items())


def write_model() -> None:
    """Write the model, its limits and its README."""
    (FOLDER / "survey_twin.xml").write_text(model_xml(), encoding="utf-8")
    (FOLDER / "limits.yaml").write_text(limits_yaml(), encoding="utf-8")
    from survey_twin_readme import readme

    (FOLDER / "README.md").write_text(readme(), encoding="utf-8")


if __name__ == "__main__":
    write_model()
