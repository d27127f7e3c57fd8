"""Survey twin, Twin-Otter class."""

from __future__ import annotations

from maker.table import FOOT, OURS, Gains, Geometry, Mass, Table, Term, Turboprops

UIUC = "UIUC Smart Icing Systems, Twin Otter aircraft.dat of 23 May 2000 (FlightGear, Aircraft-uiuc/TwinOtter)"

TERMS = (
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
)

TABLE = Table(
    name="survey_twin",
    title="Survey twin, Twin-Otter class",
    source=UIUC,
    geometry=Geometry("FT", area=420.0, span=65.0, chord=6.5),
    mass=Mass(
        4600.0,
        540.0,
        "SLUG*FT2",
        16039.3,
        22841.6,
        35807.4,
        1102.8,
        "the source's, whose mass is 10141 lb (4600 kg)",
    ),
    engine=Turboprops(
        rated_w=924_000.0,
        rated_source="2 x 462 kW, about 2000 lb of static thrust each: the coefficients' source",
        efficiency=0.84,
        static_lbf=4000.0,
        lapse=0.7,
        arm_ft=8.0,
        fuel_kg_per_kwh=0.38,
    ),
    terms=TERMS,
    gains=Gains(
        climb=0.06,
        climb_most=10.0,
        pitch_proportional=0.002,
        pitch_integral=0.0016,
        pitch_most=0.16,
        elevator_pitch=0.8,
        elevator_rate=0.45,
        elevator_low=-0.4538,
        elevator_high=0.2443,
        power_proportional=12000.0,
        power_integral=360.0,
        power_most=500_000.0,
        aileron_roll=0.8,
        aileron_integral=0.04,
        aileron_rate=0.2,
        aileron_most=0.30,
        rudder_rate=0.9,
        rudder_most=0.2793,
    ),
    limits={
        "wing_area_m2": (420.0 * FOOT**2, UIUC),
        "lift_max": (1.3, OURS + "; the linear set is taken as attached up to here (alpha 9.5 deg)"),
        "stall_margin": (1.15, OURS + "; the slowest airspeed is this much above the stall"),
        "equivalent_airspeed_max_m_s": (87.5, "170 kt, the class's operating limit, from memory"),
        "height_max_m": (7600.0, "25000 ft, the class's ceiling, from memory"),
        "height_min_m": (-400.0, "the standard atmosphere's lower part"),
        "alpha_max_deg": (20.0, OURS + "; a flight beyond it is lost: the set says nothing there"),
        "mass_empty_kg": (4060.0, "with crew, camera and mount; chosen so that 540 kg of fuel give 4600 kg"),
        "fuel_kg": (540.0, OURS),
        "fuel_max_kg": (1100.0, OURS),
    },
    text="""A twin turboprop of 4600 kg, made for photo flights at about 250 km/h.  "Class", because the
coefficients come from one public file whose origin in flight test is not known: the model is exact for its
coefficients, and as real as they are.""",
    signs="""Forces and moments along the axes of the body (x forward, y right, z down).  q^ = q c/2V.
No terms in the rate of alpha.""",
    doubts="""The lateral values are round, so this is one file's word.  Cndr over CYdr is too long an arm, so
the yaw damper is kept gentle.  Clr is low for this lift; at 0.13 the spiral would be neutral.  The set is
linear in lift and knows no stall: `limits.yaml` keeps a flight away from there.  CZq is about twice its class;
halving it moves the short period by 1 %.  Cnda has the sign of Clda: this aileron yaws into its roll (proverse),
where most yaw against it; it is small.""",
    speeds_m_s=(50.0, 55.0, 62.0, 69.4, 80.0, 95.0),
    check_m_s=69.4,
    autopilot_note="""The yaw damper takes the source's rudder power at its word; with half of it, it still damps.
""",
)
