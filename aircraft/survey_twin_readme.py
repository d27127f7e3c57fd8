"""The survey twin's README: its coefficients, and what the running model makes of them."""

from __future__ import annotations

import math

from make_survey_twin import (
    CHORD_FT,
    EFFICIENCY,
    FOLDER,
    FUEL_KG_PER_KWH,
    INERTIA_SLUG_FT2,
    LIMITS,
    MASS_KG,
    RATED_W,
    SPAN_FT,
    STATIC_LBF,
    SYMBOL,
    TERMS,
    UIUC,
    WING_FT2,
)

from aerosim.errors import InputError
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.modes import linearise, modes

HEAD = """# Survey twin, Twin-Otter class

Written by `make_survey_twin.py`; do not edit.  A twin turboprop of 4600 kg, made for photo flights at
about 250 km/h. "Class", because the coefficients come from one public file whose origin in flight test
is not known: the model is exact for its coefficients, and as real as they are.  `Systems/autopilot.xml`
(written by hand) holds height, true airspeed and a roll command, and damps yaw.  No turbulence is built
in: air comes from outside, wind and gusts through JSBSim's own properties, the air's rotation through
`gust/p-rad_sec`, `gust/q-rad_sec`, `gust/r-rad_sec`.

## Coefficients

Body axes (x forward, y right, z down), per rad; p^ and r^ are times b/2V, q^ is times c/2V, and all
three are rates against the air.  Elevator de is positive trailing edge down, aileron da positive rolls
left, rudder dr positive yaws left.  No terms in the rate of alpha.
"""

DOUBTS = """
Doubts: the lateral values are round, so this is one file's word.  Cndr over CYdr is too long an arm, so
the yaw damper is kept gentle.  Clr is low for this lift; at 0.13 the spiral would be neutral.  The set
is linear in lift and knows no stall: `limits.yaml` keeps a flight away from there.  CZq is about twice
its class; halving it moves the short period by 1 %.

## Masses and limits

| key | value | source |
|---|---|---|
"""


def coefficients() -> str:
    """Table of the derivatives."""
    rows = [f"| {SYMBOL[t.axis]} | {' '.join(t.factors) or '1'} | {t.value:+g} | {UIUC} |" for t in TERMS]
    return "\n".join(["| coefficient | times | value | source |", "|---|---|---|---|", *rows, ""])


def masses() -> str:
    """Table of limits, and what else the model is made of."""
    rows = [f"| {key} | {value:.6g} | {source} |" for key, (value, source) in LIMITS.items()]
    inertia = ", ".join(f"{k} {v}" for k, v in INERTIA_SLUG_FT2.items())
    text = f"""
Reference: wing {WING_FT2} ft2, span {SPAN_FT} ft, chord {CHORD_FT} ft.  Inertia {inertia} slug ft2
({UIUC}); ixz is the integral of x z.  JSBSim takes it so only with
`negated_crossproduct_inertia="false"`; a test holds the sign. Inertia belongs to {MASS_KG:g} kg and does
not change with the fuel, which sits at the centre of gravity.

Power: {RATED_W / 1e3:g} kW at sea level ({UIUC}: 2 x 462 kW), times density ratio to the 0.7
(engineering value), with a lag of 0.7 rad/s (engineering value).  Thrust is {EFFICIENCY} of it over the
airspeed (engineering value), at most {STATIC_LBF:g} lbf, as two forces 8 ft off the middle.  Fuel:
{FUEL_KG_PER_KWH} kg/kWh (engineering value of the engine's class, from memory), taken from the mass as
it burns.
"""
    return "\n".join(rows) + "\n" + text


def trims() -> str:
    """Table of trims and modes over height and airspeed, from the running model."""
    lines = [
        "\n## Trim and modes\n",
        "From the running model, still air, 540 kg of fuel, latitude 51 deg north, flying east; modes from a",
        "numeric Jacobian, controls and power fixed.  Frequencies in rad/s / damping ratios, times in s.\n",
        "| height_m | airspeed_m_s | alpha_deg | elevator_deg | power_kW | of kW | fuel_kg_h | short period "
        "| phugoid | dutch roll | roll | spiral |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for height in (500.0, 3000.0, 6000.0):
        lines.extend(trim_row(height, speed) for speed in (55.0, 62.0, 69.44, 80.0, 95.0))
    return "\n".join(lines) + "\n"


def trim_row(height: float, airspeed: float) -> str:
    """One row of the table of trims."""
    aircraft = Aircraft(FOLDER, 120.0)
    head = f"| {height:g} | {airspeed:g} |"
    try:
        trim = aircraft.start(math.radians(51.0), 0.2, height, math.radians(90.0), airspeed)
    except InputError as refusal:
        return f"{head} {refusal.problem} " + "| " * 9 + "|"
    m = modes(linearise(aircraft, trim, airspeed))
    fuel = FUEL_KG_PER_KWH * trim.power / 1e3
    return (
        f"{head} {math.degrees(trim.alpha):.2f} | {math.degrees(trim.elevator):.2f} | {trim.power / 1e3:.0f} "
        f"| {trim.power_available / 1e3:.0f} | {fuel:.0f} | {m.short_period:.2f} / {m.short_period_damping:.3f} "
        f"| {m.phugoid:.3f} / {m.phugoid_damping:.3f} | {m.dutch_roll:.2f} / {m.dutch_roll_damping:.3f} "
        f"| {m.roll_s:.3f} | {m.spiral_s:.1f} |"
    )


JUDGES = """
Judged at 3000 m and 69.4 m/s: the full nonlinear equations on the same coefficients, solved by other
code, give short period 3.27 / 0.641, phugoid 0.163 / 0.116, dutch roll 2.00 / 0.244, roll 0.178 s,
spiral 60.6 s; a test holds 1 %. MIL-F-8785C, class II, category B, level 1 (quoted by heli-air.net):
roll below 1.4 s, dutch roll damping above 0.08, damping times frequency above 0.15, frequency above 0.4:
met.  Public derivative sets of a comparable twin are good to about 8 % in dutch-roll period, 20 % in
phugoid period and a factor of two in damping and spiral against its measured flights (TU Delft, course
AE3212): read the table with that in mind.
"""


def readme() -> str:
    """The whole README."""
    return HEAD + "\n" + coefficients() + DOUBTS + masses() + trims() + JUDGES
