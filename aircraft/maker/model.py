"""The JSBSim model of a table."""

from __future__ import annotations

from maker.table import AXES, FOOT, LBF, POUND, SYMBOL, Piston, Table, Term, Turboprops

FACTORS = {
    "alpha": "aero/alpha-rad",
    "beta": "aero/beta-rad",
    "p^": "aero/p-hat",
    "q^": "aero/q-hat",
    "r^": "aero/r-hat",
    "alpha'^": "aero/alphadot-hat",
    "beta'^": "aero/betadot-hat",
    "t": "aero/pressure-t",
    "CL": "aero/lift-static",
    "de": "fcs/elevator-pos-rad",
    "da": "fcs/aileron-pos-rad",
    "dr": "fcs/rudder-pos-rad",
}
LENGTH = {"ROLL": "metrics/bw-ft", "PITCH": "metrics/cbarw-ft", "YAW": "metrics/bw-ft"}
# In stability axes JSBSim counts x backwards and z upwards: drag and lift.
STABILITY = {"X": "DRAG", "Z": "LIFT"}
SLOWEST_FPS = 30
PSF_PA = LBF / FOOT**2


def prop(name: str) -> str:
    """A JSBSim property element."""
    return f"<property>{name}</property>"


def value(number: float) -> str:
    """A JSBSim number."""
    return f"<value>{number!r}</value>"


def product(*parts: str) -> str:
    """A JSBSim product of the given elements."""
    return f"<product>{''.join(parts)}</product>" if len(parts) > 1 else parts[0]


def function(name: str, body: str) -> str:
    """A JSBSim function of the aerodynamics."""
    return f'    <function name="{name}">{body}</function>'


def term_element(table: Table, term: Term) -> str:
    """One coefficient times its factors."""
    return product(value(table.value(term)), *(prop(FACTORS[factor]) for factor in term.factors))


def hat_functions(table: Table) -> list[str]:
    """Non-dimensional rates; those of the body are against the air."""
    used = {factor for axis in ("LIFT", "DRAG", *AXES) for t in table.flown(axis) for factor in t.factors}
    chords = [] if table.q_chords == 0.5 else [value(2.0 * table.q_chords)]
    found = []
    for rate, scale in (("p", "aero/bi2vel"), ("q", "aero/ci2vel"), ("r", "aero/bi2vel")):
        turning = f"<difference>{prop(f'velocities/{rate}-rad_sec')}{prop(f'gust/{rate}-rad_sec')}</difference>"
        extra = chords if rate == "q" else []
        found.append(function(f"aero/{rate}-hat", product(*extra, prop(scale), turning)))
    for factor, rate, scale in (("alpha'^", "alphadot", "aero/ci2vel"), ("beta'^", "betadot", "aero/bi2vel")):
        if factor in used:
            found.append(function(FACTORS[factor], product(prop(scale), finite(f"aero/{rate}-rad_sec", 1e3))))
    if isinstance(table.engine, Piston):
        found.append(function("aero/pressure-t", pressure_rise(table.engine)))
    for name in table.sums:
        lines = "".join(term_element(table, t) for t in table.flown(name))
        found.append(function(FACTORS[name], f"<sum>{lines}</sum>"))
    return found


def finite(name: str, below: float) -> str:
    """A property, or 0 while it is not a number: JSBSim's first pass has no accelerations, and a force that
    followed them would never recover."""
    return f"<ifthen><lt>{prop(name)}{value(below)}</lt>{prop(name)}{value(0.0)}</ifthen>"


def pressure_rise(engine: Piston) -> str:
    """Pressure rise across the propeller: dynamic pressure times airspeed is rho V3/2, here in psf ft/s."""
    ratio = engine.slope / 1e3 / (PSF_PA * FOOT)
    speed = f"<max>{value(SLOWEST_FPS)}{prop('velocities/vt-fps')}</max>"
    # Without air flowing (JSBSim evaluates once before a start) the quotient would not be finite.
    flow = product(f"<max>{value(1.0)}{prop('aero/qbar-psf')}</max>", speed)
    quotient = f"<quotient>{product(value(ratio), prop('power/shaft-w'))}{flow}</quotient>"
    return f"<sum>{value(engine.constant)}{quotient}</sum>"


def axis_block(table: Table, axis: str) -> str:
    """Force or moment of one axis, a sum over its terms."""
    frame, source = "", axis
    if axis not in LENGTH and table.force_frame == "STABILITY":
        frame, source = ' frame="STABILITY"', STABILITY.get(axis, axis)
    reference = [prop("aero/qbar-psf"), prop("metrics/Sw-sqft")]
    if axis in LENGTH:
        reference.append(prop(LENGTH[axis]))
    lines = "\n".join(f"        {term_element(table, term)}" for term in table.flown(source))
    body = f"{''.join(reference)}\n      <sum>\n{lines}\n      </sum>"
    return (
        f'    <axis name="{axis}"{frame}>\n      <function name="aero/force/{SYMBOL[source]}">'
        f"<product>{body}</product></function>\n    </axis>"
    )


def thrust(engine: Turboprops, name: str, y_ft: float) -> str:
    """Half of the thrust: power at the shaft times efficiency over airspeed, no more than the static thrust."""
    ratio = engine.efficiency / (2.0 * FOOT * LBF)
    force = (
        f"<min>{value(engine.static_lbf / 2)}<quotient>"
        f"{product(value(ratio), prop('power/shaft-w'))}"
        f"<max>{value(SLOWEST_FPS)}{prop('velocities/vt-fps')}</max></quotient></min>"
    )
    return f"""    <force name="{name}" frame="BODY">
      <function>{force}</function>
      <location unit="FT"><x>0</x><y>{y_ft}</y><z>0</z></location>
      <direction><x>1</x><y>0</y><z>0</z></direction>
    </force>"""


def external(table: Table) -> str:
    """Properties of air and power, and the thrust if it is a force of its own."""
    engine = table.engine
    lines = [f'    <property value="0">gust/{rate}-rad_sec</property>' for rate in "pqr"]
    specific = engine.fuel_kg_per_kwh / POUND / 3.6e6
    lines += [
        '    <property value="0">power/shaft-w</property>',
        f'    <property value="{specific!r}">fuel/specific-lbs_sec_w</property>',
    ]
    if isinstance(engine, Turboprops):
        lines += [thrust(engine, "left", -engine.arm_ft), thrust(engine, "right", engine.arm_ft)]
    return "\n".join(lines)


def model_xml(table: Table) -> str:
    """The whole JSBSim model."""
    origin = "<x>0</x><y>0</y><z>0</z>"
    g, m = table.geometry, table.mass
    # With "false" JSBSim takes ixz as published, the integral of x z; with "true", the default, it wants -ixz.
    inertia = "\n".join(
        f'    <{name} unit="{m.unit}">{getattr(m, name)}</{name}>' for name in ("ixx", "iyy", "izz", "ixz")
    )
    hats = "\n".join(hat_functions(table))
    axes = "\n".join(axis_block(table, axis) for axis in AXES)
    return f"""<?xml version="1.0"?>
<!-- Written by make.py; do not edit.  Sources and signs: README.md -->
<fdm_config name="{table.name}" version="2.0" release="BETA">
  <fileheader>
    <author>aerosim</author>
    <description>{table.title}</description>
  </fileheader>
  <metrics>
    <wingarea unit="{g.unit}2">{g.area}</wingarea>
    <wingspan unit="{g.unit}">{g.span}</wingspan>
    <chord unit="{g.unit}">{g.chord}</chord>
    <location name="AERORP" unit="FT">{origin}</location>
  </metrics>
  <mass_balance negated_crossproduct_inertia="false">
{inertia}
    <emptywt unit="LBS">{(m.total_kg - m.fuel_kg) / POUND!r}</emptywt>
    <location name="CG" unit="FT">{origin}</location>
    <pointmass name="fuel">
      <weight unit="LBS">{m.fuel_kg / POUND!r}</weight>
      <location unit="FT">{origin}</location>
    </pointmass>
  </mass_balance>
  <ground_reactions/>
  <external_reactions>
{external(table)}
  </external_reactions>
  <system file="autopilot"/>
  <aerodynamics>
{hats}
{axes}
  </aerodynamics>
</fdm_config>
"""


def limits_yaml(table: Table) -> str:
    """Limits that the flight code reads."""
    head = f"# Written by make.py; do not edit.\nmodel: {table.name}\n"
    return head + "".join(f"{key}: {number:.10g}  # {source}\n" for key, (number, source) in table.limits.items())
