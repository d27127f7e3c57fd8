"""The air of a scenario."""

from __future__ import annotations

from functools import partial
from math import radians

from aerosim.flight.plan import FlightPlan
from aerosim.rng import generator
from aerosim.scenario.air import SlowWind, SteadyWind
from aerosim.scenario.air import Thermal as ThermalSection
from aerosim.scenario.air import Turbulence as TurbulenceSection
from aerosim.scenario.build.placing import at
from aerosim.scenario.scenario import Scenario
from aerosim.world.air import Air
from aerosim.world.atmosphere import GaussMarkov, make_air
from aerosim.world.gusts import CosineGust
from aerosim.world.mesoscale import Mesoscale
from aerosim.world.mil import mil_turbulence
from aerosim.world.thermals import Thermal, ThermalField
from aerosim.world.turbulence import Turbulence
from aerosim.world.wind import Level, Wind, WindField


def wind_field(scenario: Scenario, ground: float) -> WindField:
    """Mean wind by height.  ground: mean height of the land under the lines, ellipsoidal, m."""
    wind, shear = scenario.air.wind, scenario.air.shear
    if isinstance(wind, SteadyWind):
        levels = [Level(0.0, wind.speed_m_s, radians(wind.from_deg))]
    else:
        levels = [Level(each.height_m, each.speed_m_s, radians(each.from_deg)) for each in wind.profile]
    return WindField(
        levels,
        ground=ground,
        exponent=shear.exponent,
        reference_agl=shear.reference_agl_m,
        veer=radians(shear.veer_deg_per_km) / 1000.0,
    )


def mean_wind(scenario: Scenario, plan: FlightPlan, ground: float) -> Wind:
    """Mean velocity of the air in n at the planned height, m/s."""
    return wind_field(scenario, ground).at(plan.height)


def air_of(scenario: Scenario, plan: FlightPlan, ground: float, span: float, dt: float) -> Air:
    """The air of a flight.  ground: as in `wind_field`; span: of the wing, m; dt: air step, s.

    Raises InputError for what the rules of turbulence do not cover.
    """
    air, lat, lon = scenario.air, *plan.lines[0].start
    field = air.thermal_field
    with at(scenario, "air"):
        return make_air(
            wind=wind_field(scenario, ground),
            origin=(lat, lon),
            height=plan.height,
            airspeed=plan.airspeed,
            span=span,
            dt=dt,
            rng_of=partial(generator, scenario.seed),
            slow=_slow(air.slow_wind),
            turbulence=_turbulence(air.turbulence, plan.height, plan.height - ground),
            gusts=[CosineGust(g.start_s, g.duration_s, g.north_m_s, g.east_m_s, g.down_m_s) for g in air.gusts],
            thermals=[_thermal(each) for each in air.thermals],
            thermal_field=(
                None if field is None else ThermalField(field.spacing_m**-2, field.radius_m, field.strength_m_s)
            ),
            thermals_drift=air.thermals_drift,
        )


def turbulence_of(scenario: Scenario, plan: FlightPlan, ground: float) -> Turbulence:
    """Turbulence at the planned height.  ground: as in `wind_field`.  Raises InputError as `air_of`."""
    with at(scenario, "air"):
        return _turbulence(scenario.air.turbulence, plan.height, plan.height - ground)


def _thermal(thermal: ThermalSection) -> Thermal:
    lat, lon = thermal.center_deg
    return Thermal(radians(lat), radians(lon), thermal.radius_m, thermal.strength_m_s)


def _slow(slow: SlowWind) -> GaussMarkov | Mesoscale:
    if slow.model == "gauss_markov":
        return GaussMarkov(slow.sigma_m_s, slow.time_constant_s)
    structure = slow.change_100km_m_s**2 / 100e3 ** (2.0 / 3.0)
    return Mesoscale(structure, 1000.0 * slow.longest_km, 1000.0 * slow.shortest_km)


def _turbulence(turbulence: TurbulenceSection, height: float, agl: float) -> Turbulence:
    if turbulence.model != "mil_f_8785c":
        return Turbulence.equal(turbulence.model, turbulence.sigma_m_s, turbulence.length_m)
    return mil_turbulence(
        turbulence.spectrum,
        height=height,
        agl=agl,
        severity=turbulence.severity,
        exceedance=turbulence.exceedance,
        wind_20ft=turbulence.wind_20ft_m_s,
    )
