"""The README of an aircraft: its coefficients, and what the running model makes of them."""

from __future__ import annotations

import math
from dataclasses import fields
from pathlib import Path
from typing import NamedTuple

from aerosim.errors import InputError
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.modes import Modes, linearise, modes
from aerosim.flight.trim import Trim
from maker.flights import fly_line, summary
from maker.judges import judges
from maker.linear import Body, Motions, felt_gravity, jacobian, level_trim, motions, sides_apart, standard_density
from maker.table import SYMBOL, Piston, Table, Turboprops

LAT = math.radians(51.0)
SIGMAS = (0.35, 0.7, 1.4)
SECONDS = 1200.0


MODES = """
## Modes

Frequencies in rad/s / damping ratios, times in s; controls and power fixed, density constant.  First row:
numeric Jacobian of the running JSBSim model; second: the textbook's equations of motion on the same coefficients
in plain numpy (`maker/linear.py`), which share no code with it.  The sides are taken apart, as the books do; the
last row has them together.

| height_m | airspeed_m_s | from | short period | phugoid | dutch roll | roll | spiral | difference_pct |
|---|---|---|---|---|---|---|---|---|"""

LINES = """
## Lines in turbulence

{minutes:g} min on a line at 3000 m and {airspeed:g} m/s, 8 m/s of crosswind, Dryden turbulence of MIL-F-8785C,
length 533 m, one seed (`maker/flights.py`).  rms about the line, the height and the mean attitude; change of
roll over 10 s, rms and 95 %.  Normal survey turbulence is a sigma of 0.4 to 1.0 m/s.

| sigma_m_s | cross_track_m | height_m | airspeed_m_s | roll, pitch, heading_deg | p, q, r_deg_s \
| max p, q, r_deg_s | q/p, r/p | roll change_deg | fuel_kg_h |
|---|---|---|---|---|---|---|---|---|---|"""

RATES = """

Period figures (proceedings text on the Jena LMK cameras, aircraft of 3 to 6 t flown by hand): roll rates up to
1 deg/s in smooth air and at most 4 deg/s in medium turbulence, pitch and yaw 20 to 30 % of that, so up to
1.2 deg/s.  In the rows of 0.35 and 0.7 the amplitudes lie inside; at 1.4 the greatest pitch rate is above.
The ratios of the rms are above 0.3: an autopilot that holds the wings level takes out a third of the roll
rate, and what the height hold and the fin make of the gusts remains.  A softer roll hold would mend the ratio
and spoil the photos.
"""


class Point(NamedTuple):
    """A trim and its modes: of the running model and of the textbook's equations."""

    height: float
    airspeed: float
    trim: Trim
    model: Modes
    equations: Motions
    whole: Motions


def point(folder: Path, table: Table, height: float, airspeed: float) -> Point:
    """Trim and modes at a height (m) and true airspeed (m/s), flying east in still air.  Raises InputError."""
    aircraft = Aircraft(folder, 120.0)
    trim = aircraft.start(LAT, 0.2, height, math.radians(90.0), airspeed)
    found = modes(linearise(aircraft, trim, airspeed))
    body = Body(table, standard_density(height), felt_gravity(LAT, height, airspeed))
    matrix = jacobian(body, airspeed, level_trim(body, airspeed))
    return Point(height, airspeed, trim, found, motions(sides_apart(matrix)), motions(matrix))


def difference(at: Point) -> float:
    """Greatest relative difference between the two sets of modes."""
    return max(abs(a / b - 1.0) for a, b in zip(at.model, at.equations, strict=True))


def head(table: Table) -> str:
    """Title, description, conventions."""
    return f"""# {table.title}

Written by `make.py`; do not edit.  {table.text}

JSBSim flies it (`{table.name}.xml`); `Systems/autopilot.xml` holds height, true airspeed and a roll command, and
damps yaw.  No turbulence is built in: air comes from outside, wind and gusts through JSBSim's own properties,
the air's rotation through `gust/p-rad_sec`, `gust/q-rad_sec`, `gust/r-rad_sec`.

## Coefficients

{table.signs}

All per rad; p^ and r^ are times b/2V, and p, q, r are rates against the air.  This project counts the elevator de
positive trailing edge down, the aileron da positive when it rolls left, the rudder dr positive when it yaws left.
Source, where no other is named: {table.source}.
"""


def coefficients(table: Table) -> str:
    """Table of the derivatives, as printed and as flown."""
    lines = ["", "| coefficient | times | as printed | as flown | remark |", "|---|---|---|---|---|"]
    for term in table.terms:
        flown = "not flown" if set(term.factors) & set(table.zero) else f"{table.value(term):+.5g}"
        factors = " ".join(term.factors) or "1"
        symbol = SYMBOL.get(term.axis, f"{term.axis}, sum")
        lines.append(f"| {symbol} | {factors} | {term.value:+.5g} | {flown} | {term.note} |")
    return "\n".join(lines) + f"\n\nDoubts: {table.doubts}\n"


def masses(table: Table) -> str:
    """Reference sizes, inertia, engine, limits."""
    g, m = table.geometry, table.mass
    rows = [f"| {key} | {number:.6g} | {source} |" for key, (number, source) in table.limits.items()]
    unit = "slug ft2" if m.unit == "SLUG*FT2" else "kg m2"
    length = g.unit.lower()
    return f"""
## Masses, engine, limits

Reference: wing {g.area:g} {length}2, span {g.span:g} {length}, chord {g.chord:g} {length} (the source's).
Inertia: ixx {m.ixx:g}, iyy {m.iyy:g}, izz {m.izz:g}, ixz {m.ixz:g} {unit}: {m.note}; ixz is the integral of
x z, and JSBSim takes it so only with `negated_crossproduct_inertia="false"`; a test holds the sign.  Inertia
belongs to {m.total_kg:.6g} kg and does not change with the fuel, which sits at the centre of gravity.

{engine_text(table.engine)}

| limit | value | source |
|---|---|---|
{chr(10).join(rows)}
"""


def autopilot(table: Table) -> str:
    """Table of the autopilot's gains."""
    rows = [f"| {f.name} | {getattr(table.gains, f.name):g} |" for f in fields(table.gains)]
    return f"""
## Autopilot

Engineering values of this project, in ft, ft/s, rad and W: climb wanted for each ft of height error, pitch for
each ft/s of climb missing and its integral, elevator for pitch and its rate, power for airspeed and its integral,
aileron for roll, its integral and rate, rudder for the yaw rate beyond a coordinated turn's and for each g of side
force.
{table.autopilot_note}
| gain or limit | value |
|---|---|
{chr(10).join(rows)}
"""


def engine_text(engine: Turboprops | Piston) -> str:
    """What the engine gives and burns."""
    fuel = f"""Fuel: {engine.fuel_kg_per_kwh:g} kg/kWh (engineering value of the engine's class, from memory),
taken from the mass as it burns.  The engine's lag is 0.7 rad/s (engineering value)."""
    if isinstance(engine, Turboprops):
        return f"""Power: {engine.rated_w / 1e3:g} kW at sea level ({engine.rated_source}), times the
density ratio to the {engine.lapse:g} (engineering value).  Thrust is {engine.efficiency:g} of it over the airspeed
(engineering value), at most {engine.static_lbf:g} lbf, as two forces {engine.arm_ft:g} ft off the middle.
{fuel}"""
    full = engine.power_kw(36.5, 2300.0, 1.0)
    rated = engine.power_kw(engine.rated_inhg, engine.rated_rpm, 1.0)
    return f"""Power, kW, by the set's own formula: {engine.scale:g} ({engine.p0:g} + {engine.p1:g} (pz +
{engine.p2:g}) (n + {engine.p3:g}) + ({engine.p4:g} - {-engine.p5:g} n)(1 - rho/rho0)), pz manifold pressure in
inHg, n rpm.  At the take-off rating of the engine (R-985, 36.5 inHg, 2300 rpm, 450 hp = 336 kW; pressure from
memory) it gives {full:.0f} kW. Available is what it gives at {engine.rated_inhg:g} inHg and
{engine.rated_rpm:g} rpm, the rating of continuous use from memory (400 hp = 298 kW; formula {rated:.0f} kW),
up to {engine.critical_height_m:g} m; above, the manifold pressure falls with the air's (engineering rule).
{fuel}"""


def trims(table: Table, points: list[Point | str]) -> str:
    """Table of trims over height and airspeed, refusals among them."""
    lines = [
        "",
        "## Trim",
        "",
        "From the running model in still air, ball centred, the fuel of the limits above, latitude 51 deg north,",
        "flying east.",
        "",
        "| height_m | airspeed_m_s | alpha_deg | elevator_deg | rudder_deg | sideslip_deg | power_kW | of kW "
        "| fuel_kg_h |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for at in points:
        if isinstance(at, str):
            lines.append(at)
            continue
        t = at.trim
        angles = " | ".join(f"{math.degrees(v) + 0.0:.2f}" for v in (t.alpha, t.elevator, t.rudder, t.sideslip))
        fuel = table.engine.fuel_kg_per_kwh * t.power / 1e3
        lines.append(
            f"| {at.height:g} | {at.airspeed:g} | {angles} | {t.power / 1e3:.0f} | {t.power_available / 1e3:.0f} "
            f"| {fuel:.0f} |"
        )
    return "\n".join(lines) + "\n"


def cells(m: Modes | Motions) -> str:
    """Cells of a row of modes."""
    return (
        f"{m.short_period:.2f} / {m.short_period_damping:.3f} | {m.phugoid:.3f} / {m.phugoid_damping:.3f} "
        f"| {m.dutch_roll:.2f} / {m.dutch_roll_damping:.3f} | {m.roll_s:.3f} | {m.spiral_s:.1f}"
    )


def mode_table(points: list[Point | str], check: Point) -> str:
    """Table of modes: running model and equations."""
    lines = [MODES]
    flown = [at for at in points if not isinstance(at, str)]
    for at in flown if (check.height, check.airspeed) in {at[:2] for at in flown} else [*flown, check]:
        place = f"| {at.height:g} | {at.airspeed:g} |"
        lines.append(f"{place} JSBSim | {cells(at.model)} | {100.0 * difference(at):.2f} |")
        lines.append(f"{place} equations | {cells(at.equations)} | |")
    lines.append(f"| {check.height:g} | {check.airspeed:g} | whole matrix | {cells(check.whole)} | |")
    return "\n".join(lines) + "\n"


def lines_in_gusts(folder: Path, table: Table) -> str:
    """Table of what the autopilot makes of turbulence."""
    rows = [LINES.format(minutes=SECONDS / 60.0, airspeed=table.check_m_s)]
    for sigma in SIGMAS:
        m = summary(fly_line(folder, table.check_m_s, sigma, SECONDS))
        deg = [math.degrees(v) for v in m]
        rows.append(
            f"| {sigma:g} | {m.across:.1f} | {m.height:.1f} | {m.airspeed:.1f} "
            f"| {deg[2]:.2f}, {deg[3]:.2f}, {deg[4]:.2f} | {deg[5]:.2f}, {deg[6]:.2f}, {deg[7]:.2f} "
            f"| {deg[8]:.1f}, {deg[9]:.1f}, {deg[10]:.1f} "
            f"| {m.q / m.p:.2f}, {m.r / m.p:.2f} | {deg[11]:.2f}, {deg[12]:.2f} | {3600.0 * m.fuel:.0f} |"
        )
    return "\n".join(rows) + RATES


def quick(folder: Path, table: Table) -> str:
    """All of the README but the flights in turbulence."""
    points: list[Point | str] = []
    for height in table.heights_m:
        for airspeed in table.speeds_m_s:
            try:
                points.append(point(folder, table, height, airspeed))
            except InputError as refusal:
                points.append(f"| {height:g} | {airspeed:g} | {refusal} | | | | | | |")
    check = point(folder, table, 3000.0, table.check_m_s)
    return (
        head(table)
        + coefficients(table)
        + masses(table)
        + autopilot(table)
        + trims(table, points)
        + mode_table(points, check)
        + judges(check)
    )


def readme(folder: Path, table: Table) -> str:
    """The whole README."""
    return quick(folder, table) + lines_in_gusts(folder, table)
