"""De Havilland DHC-2 Beaver."""

from __future__ import annotations

from maker.table import OURS, Gains, Geometry, Mass, Piston, Table, Term

LR_556 = "Tjee and Mulder, TU Delft LR-556 (1988), flight-identified, as in Rauw's FDC 1.2"

TERMS = (
    Term("X", (), -0.03554),
    Term("X", ("alpha",), 0.00292),
    Term("X", ("alpha", "alpha"), 5.459),
    Term("X", ("alpha", "alpha", "alpha"), -5.162),
    Term("X", ("q^",), -0.6748),
    Term("X", ("dr",), 0.03412),
    Term("X", ("df",), -0.09447),
    Term("X", ("alpha", "df"), 1.106),
    Term("X", ("t",), 0.1161),
    Term("X", ("alpha", "t", "t"), 0.1453),
    Term("Y", (), -0.002226),
    Term("Y", ("beta",), -0.7678),
    Term("Y", ("p^",), -0.1240),
    Term("Y", ("r^",), 0.3666),
    Term("Y", ("da",), -0.02956),
    Term("Y", ("dr",), 0.1158),
    Term("Y", ("alpha", "dr"), 0.5238),
    Term("Y", ("beta'^",), -0.1600),
    Term("Z", (), -0.05504),
    Term("Z", ("alpha",), -5.578),
    Term("Z", ("alpha", "alpha", "alpha"), 3.442),
    Term("Z", ("q^",), -2.988),
    Term("Z", ("de",), -0.3980),
    Term("Z", ("de", "beta", "beta"), -15.93),
    Term("Z", ("df",), -1.377),
    Term("Z", ("alpha", "df"), -1.261),
    Term("Z", ("t",), -0.1563),
    Term("ROLL", (), 0.0005910),
    Term("ROLL", ("beta",), -0.06180),
    Term("ROLL", ("p^",), -0.5045),
    Term("ROLL", ("r^",), 0.1695),
    Term("ROLL", ("da",), -0.09917),
    Term("ROLL", ("dr",), 0.006934),
    Term("ROLL", ("alpha", "da"), -0.08269),
    Term("ROLL", ("alpha", "alpha", "t"), -0.01406),
    Term("PITCH", (), 0.09448),
    Term("PITCH", ("alpha",), -0.6028),
    Term("PITCH", ("alpha", "alpha"), -2.140),
    Term("PITCH", ("q^",), -15.56),
    Term("PITCH", ("de",), -1.921),
    Term("PITCH", ("beta", "beta"), 0.6921),
    Term("PITCH", ("r^",), -0.3118),
    Term("PITCH", ("df",), 0.4072),
    Term("PITCH", ("t",), -0.07895),
    Term("YAW", (), -0.003117),
    Term("YAW", ("beta",), 0.006719),
    Term("YAW", ("beta", "beta", "beta"), 0.1373),
    Term("YAW", ("p^",), -0.1585),
    Term("YAW", ("r^",), -0.1112),
    Term("YAW", ("da",), -0.003872),
    Term("YAW", ("dr",), -0.08265),
    Term("YAW", ("q^",), 0.1595),
    Term("YAW", ("t", "t", "t"), -0.003026),
)

TABLE = Table(
    name="beaver",
    title="De Havilland DHC-2 Beaver",
    source=LR_556,
    geometry=Geometry("M", area=23.23, span=14.63, chord=1.5875),
    mass=Mass(
        2288.231, 180.0, "KG*M2", 5368.39, 6928.93, 11158.75, 117.64, "the source's, about the c.g. of its flights"
    ),
    engine=Piston(
        constant=0.08696,
        slope=191.18,
        scale=0.7355,
        p0=-326.5,
        p1=0.00412,
        p2=7.4,
        p3=2010.0,
        p4=408.0,
        p5=-0.0965,
        rated_inhg=34.5,
        rated_rpm=2200.0,
        critical_height_m=1524.0,
        fuel_kg_per_kwh=0.31,
    ),
    terms=TERMS,
    gains=Gains(
        climb=0.06,
        climb_most=8.0,
        pitch_proportional=0.0025,
        pitch_integral=0.0017,
        pitch_most=0.16,
        elevator_pitch=0.55,
        elevator_rate=0.28,
        elevator_low=-0.40,
        elevator_high=0.30,
        power_proportional=5000.0,
        power_integral=150.0,
        power_most=250_000.0,
        aileron_roll=1.2,
        aileron_integral=0.05,
        aileron_rate=0.3,
        aileron_most=0.30,
        rudder_rate=1.2,
        rudder_most=0.30,
        rudder_side=0.5,
    ),
    limits={
        "wing_area_m2": (23.23, LR_556),
        "lift_max": (1.6, OURS + "; with power, below what the identified flights reached at 30 m/s"),
        "stall_margin": (1.1, OURS + "; the slowest airspeed is this much above the stall"),
        "equivalent_airspeed_max_m_s": (
            55.1,
            "55 m/s, upper end of the identified flights (LR-556), so that 63.9 m/s at 3000 m is in",
        ),
        "height_max_m": (5000.0, OURS + "; the engine gives out before the type's ceiling of 5500 m"),
        "height_min_m": (-400.0, "the standard atmosphere's lower part"),
        "alpha_max_deg": (20.0, OURS + "; a flight beyond it is lost: the set says nothing there"),
        "mass_empty_kg": (2108.231, "with crew, camera and mount; chosen so that 180 kg of fuel give 2288.231 kg"),
        "fuel_kg": (180.0, OURS),
        "fuel_max_kg": (259.0, "95 US gal, the type's fuselage tanks, from memory"),
    },
    text="""A single-engined high-wing aircraft of 2288 kg with a radial engine: the only one here whose
coefficients were identified from its own flights.  Nonlinear, with the propeller's slipstream; valid at 30 to
55 m/s of indicated airspeed, flow attached.""",
    signs="""Forces and moments along the axes of the body (x forward, y right, z down), about the centre of
gravity.  q^ = q c/V, the whole chord; beta'^ = b/2V times the rate of beta.  t is the pressure rise across the
propeller over the dynamic pressure, t = 0.08696 + 191.18 P/(rho V3/2) with the power P at the shaft in kW:
there is no other thrust.  The flaps df are up in all flights here.""",
    doubts="""The propeller's torque and slipstream turn the aircraft: it flies straight with some rudder,
aileron and sideslip, as the real one does.  Nothing is known of a stall beyond the identified flights.
Cnda has the sign of Clda: by this set the aileron yaws into its roll (proverse), where most yaw against it.""",
    speeds_m_s=(35.0, 40.0, 45.0, 50.0, 55.0, 63.9),
    check_m_s=63.9,
    q_chords=1.0,
    zero=("df",),
    autopilot_note="""The fin is weak near the middle (Cnb 0.0067), so that a side gust would push the aircraft
off its line instead of turning it into the wind; the rudder therefore answers the side force, as feet that keep
the ball in the middle do.  Without that the line is held to 11 m rms at a sigma of 1.4 m/s.
""",
    heights_m=(0.0, 1500.0, 3000.0, 4500.0),
)
