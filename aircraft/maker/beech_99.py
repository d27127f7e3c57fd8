"""Beech 99."""

from __future__ import annotations

from maker.table import FOOT, OURS, POUND, Gains, Geometry, Mass, Table, Term, Turboprops

ROSKAM = (
    "Roskam, Airplane Flight Dynamics, p. 508-510 (5000 ft, 201 kt, c.g. 16 %), as in UIUC "
    "models/beech99/linear.html and FlightGear, Aircraft-uiuc/Beech99/aircraft.dat"
)
DRAG = "fitted: Roskam's CD .027 at alpha 0 and his high-cruise point (CL .306, CD .0298)"

TERMS = (
    Term("CL", (), 0.201),
    Term("CL", ("alpha",), 5.48),
    Term("CL", ("de",), 0.60),
    Term("LIFT", ("CL",), 1.0, "CL is the sum above"),
    Term("LIFT", ("alpha'^",), 2.5),
    Term("LIFT", ("q^",), 8.1),
    Term("DRAG", (), 0.0249, DRAG),
    Term("DRAG", ("CL", "CL"), 0.0526, DRAG),
    Term("Y", ("beta",), -0.59),
    Term("Y", ("p^",), -0.19),
    Term("Y", ("r^",), 0.39),
    Term("Y", ("dr",), 0.148),
    Term("ROLL", ("beta",), -0.13),
    Term("ROLL", ("p^",), -0.50),
    Term("ROLL", ("r^",), 0.14),
    Term("ROLL", ("da",), 0.156),
    Term("ROLL", ("dr",), 0.0109),
    Term("PITCH", (), 0.05),
    Term("PITCH", ("alpha",), -1.89),
    Term("PITCH", ("alpha'^",), -9.1),
    Term("PITCH", ("q^",), -34.0),
    Term("PITCH", ("de",), -2.0),
    Term("YAW", ("beta",), 0.080),
    Term("YAW", ("p^",), 0.019, "sign open, see below"),
    Term("YAW", ("r^",), -0.197),
    Term("YAW", ("da",), -0.0012),
    Term("YAW", ("dr",), -0.0772),
)

TOTAL_KG = 7000.0 * POUND

TABLE = Table(
    name="beech_99",
    title="Beech 99",
    source=ROSKAM,
    geometry=Geometry("FT", area=280.0, span=46.0, chord=6.5),
    mass=Mass(
        TOTAL_KG, 400.0, "SLUG*FT2", 10085.0, 15148.0, 23046.0, 1600.0, "the source's, whose mass is 7000 lb"
    ),
    engine=Turboprops(
        rated_w=1_106_000.0,
        rated_source="2 x 553 kW: the coefficients' source; static thrust in proportion to the Twin Otter's",
        efficiency=0.84,
        static_lbf=4790.0,
        lapse=0.7,
        arm_ft=6.5,
        fuel_kg_per_kwh=0.38,
    ),
    terms=TERMS,
    gains=Gains(
        climb=0.06,
        climb_most=10.0,
        pitch_proportional=0.0025,
        pitch_integral=0.0016,
        pitch_most=0.16,
        elevator_pitch=0.9,
        elevator_rate=0.45,
        elevator_low=-0.4538,
        elevator_high=0.2443,
        power_proportional=8300.0,
        power_integral=250.0,
        power_most=500_000.0,
        aileron_roll=0.9,
        aileron_integral=0.04,
        aileron_rate=0.25,
        aileron_most=0.30,
        rudder_rate=1.1,
        rudder_most=0.2793,
    ),
    limits={
        "wing_area_m2": (280.0 * FOOT**2, ROSKAM),
        "lift_max": (1.3, OURS + "; the linear set is taken as attached up to here (alpha 11.5 deg)"),
        "stall_margin": (1.15, OURS + "; the slowest airspeed is this much above the stall"),
        "equivalent_airspeed_max_m_s": (116.0, "226 kt, the type's operating limit, from memory"),
        "height_max_m": (7600.0, "25000 ft, the type's ceiling, from memory"),
        "height_min_m": (-400.0, "the standard atmosphere's lower part"),
        "alpha_max_deg": (20.0, OURS + "; a flight beyond it is lost: the set says nothing there"),
        "mass_empty_kg": (
            TOTAL_KG - 400.0,
            "with crew, camera and mount; chosen so that 400 kg of fuel give 7000 lb",
        ),
        "fuel_kg": (400.0, OURS),
        "fuel_max_kg": (1100.0, "374 US gal, the type's tanks, from memory"),
    },
    text="""A twin turboprop of 3175 kg with the textbook's derivatives.  69.4 m/s is slow for it.""",
    signs="""Forces in stability axes: lift and drag across and along the air's path in the plane of symmetry,
side force along y.  Moments about the axes of the body: the source's stability axes lie 3.8 deg from them at
69.4 m/s, and turning the lateral derivatives by that moves the dutch roll from 1.51 / 0.171 to 1.47 / 0.154
(study of this project).  alpha'^ and q^ are times c/2V.  The source counts an aileron positive that rolls right;
the model turns that round.""",
    doubts="""Cnp is printed as +.019 in one transcription, as -.019 in a second (Roskam's high-cruise set) and
as .0109 in a third, where it repeats Cldr by a slip.  Flown is +.019; the other sign gives a dutch roll of
1.57 / 0.150.  Roskam's .027 is the drag at alpha 0 and not the parabola's floor.  Mass and inertia are the
7000 lb ones; the type is flown at up to 10900 lb.  The set is linear in lift and knows no stall.""",
    speeds_m_s=(55.0, 62.0, 69.4, 80.0, 95.0, 120.0),
    check_m_s=69.4,
    force_frame="STABILITY",
    sums=("CL",),
    reversed=("da",),
)
