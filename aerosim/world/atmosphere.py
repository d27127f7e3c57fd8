"""The air of a flight, put together from its components, one generator each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from aerosim.world.air import Air, PlaceWind, Source
from aerosim.world.dryden import dryden_processes
from aerosim.world.gusts import CosineGust
from aerosim.world.local import LocalPlane
from aerosim.world.mesoscale import Mesoscale, MesoscaleWind
from aerosim.world.process import GaussProcess
from aerosim.world.thermals import Thermal, ThermalCells, ThermalField, Thermals
from aerosim.world.turbulence import RngOf, Turbulence
from aerosim.world.von_karman import von_karman_processes
from aerosim.world.wind import WindField


class GaussMarkov(NamedTuple):
    """Slow wind by time: standard deviation of north and east (m/s) and correlation time (s)."""

    sigma: float
    time_constant: float


def make_air(
    *,
    wind: WindField,
    origin: tuple[float, float],
    height: float,
    airspeed: float,
    span: float,
    dt: float,
    rng_of: RngOf,
    slow: GaussMarkov | Mesoscale | None = None,
    turbulence: Turbulence | None = None,
    gusts: Sequence[CosineGust] = (),
    thermals: Sequence[Thermal] = (),
    thermal_field: ThermalField | None = None,
    thermals_drift: bool = False,
) -> Air:
    """The air of a flight.

    wind: mean wind by height.  origin: latitude, longitude (rad) and height: ellipsoidal (m), of the first line's
    start and the plan: mesoscale wind and drifting thermals are carried along by the mean wind of that height.
    airspeed: true, m/s; span: of the wing, for the rate gusts, m; dt: air step, s; rng_of: generator by component
    name.  thermals_drift: with the mean wind, else they stand over their places.
    Components that are None, empty or of no strength draw nothing.  Raises InputError.
    """
    north, east, _ = wind.at(height)
    carried = LocalPlane(*origin, height, (north, east))
    standing = carried if thermals_drift else LocalPlane(*origin, height)
    places: list[PlaceWind] = []
    if not wind.uniform:
        places.append(_MeanWind(wind))
    if isinstance(slow, Mesoscale) and slow.structure > 0.0:
        places.append(MesoscaleWind(slow, carried, rng_of("air.slow_wind.mesoscale")))
    if thermals:
        places.append(Thermals(thermals, standing))
    if thermal_field is not None and thermal_field.density > 0.0:
        places.append(ThermalCells(thermal_field, standing, rng_of("air.thermal_field")))
    return Air(
        dt,
        wind.at(height) if wind.uniform else (0.0, 0.0, 0.0),
        slow=_gauss_markov(slow, dt, rng_of) if isinstance(slow, GaussMarkov) else (),
        turbulence=_turbulence(turbulence, airspeed, span, dt, rng_of),
        times=gusts,
        places=places,
    )


class _MeanWind:
    """The mean wind at the aircraft's height."""

    def __init__(self, field: WindField) -> None:
        self._field = field

    def at(self, t: float, lat: float, lon: float, height: float) -> tuple[float, float, float]:
        return self._field.at(height)


def _gauss_markov(slow: GaussMarkov, dt: float, rng_of: RngOf) -> list[Source]:
    if slow.sigma == 0.0:
        return []
    names = ("air.slow_wind.north", "air.slow_wind.east")
    return [slow_wind_process(slow, dt, rng_of(name)) for name in names]


def slow_wind_process(slow: GaussMarkov, dt: float, rng: np.random.Generator) -> GaussProcess:
    """One component of the slow wind: first-order Gauss-Markov.  m/s, s; it starts in its stationary state."""
    sigma, time_constant = slow
    return GaussProcess([[-1.0 / time_constant]], [[sigma * np.sqrt(2.0 / time_constant)]], [[1.0]], dt, rng)


def _turbulence(
    turbulence: Turbulence | None, airspeed: float, span: float, dt: float, rng_of: RngOf
) -> Sequence[Source]:
    if turbulence is None or turbulence.sigma_u == turbulence.sigma_w == 0.0:
        return ()
    processes = dryden_processes if turbulence.spectrum == "dryden" else von_karman_processes
    return processes(turbulence, airspeed, span, dt, rng_of)
