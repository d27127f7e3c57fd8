"""From a scenario to the parts of a run: the only place that maps its keys to the stages' parameters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from aerosim.control.law import ControlParameters
from aerosim.estimation.motion import MotionEstimator, MotionParameters
from aerosim.estimation.strips import StripRecogniser
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.jsbsim_flight import JsbsimFlight
from aerosim.flight.plan import wind_triangle
from aerosim.rng import generator
from aerosim.scenario.build.air import air_of, mean_wind
from aerosim.scenario.build.devices import (
    camera_of,
    control_of,
    motion_of,
    mount_of,
    planned_n,
    rows_of,
    strips_of,
)
from aerosim.scenario.build.flight import aircraft_folder, planned_vh
from aerosim.scenario.build.land import terrain_of
from aerosim.scenario.build.placing import at
from aerosim.scenario.build.route import Route, route_of
from aerosim.scenario.scenario import Scenario
from aerosim.sensing.ccd_rows import CcdRows
from aerosim.sensing.frame_camera import FrameCamera, ShutterParameters
from aerosim.sensing.mount import Mount
from aerosim.world.air import AIR_RATE_HZ
from aerosim.world.ground import GroundView
from aerosim.world.terrain import Terrain

__all__ = [
    "Mission",
    "Route",
    "aircraft_folder",
    "at",
    "build",
    "camera_of",
    "mean_wind",
    "motion_of",
    "planned_n",
    "planned_vh",
    "route_of",
    "terrain_of",
]

# Beyond the last line's end, run-ins and turns stay within this of the lines, for the local map
MAP_MARGIN = 40_000.0


@dataclass(frozen=True)
class Mission:
    """The parts of one run, ready for the loop.  dt: step, s; *_every: steps between a device's turns."""

    dt: float
    duration: float
    terrain: Terrain
    route: Route
    ground: GroundView
    flight: JsbsimFlight
    mount: Mount
    rows: CcdRows
    rows_every: int
    rows_turn: bool
    recogniser: StripRecogniser
    estimator: MotionEstimator
    motion: MotionParameters
    control: ControlParameters
    told_truth: bool
    camera: FrameCamera
    record_every: int
    outside_fails: bool
    footprint: tuple[float, float]


def build(scenario: Scenario) -> Mission:
    """All parts of a run.  Raises InputError for whatever cannot be flown, with the place of its key."""
    terrain = terrain_of(scenario)
    route = route_of(scenario, terrain)
    plan, ground_height = route.plan, route.ground
    rate, rows = scenario.aircraft.step_rate_hz, scenario.ccd_rows
    dt = 1.0 / rate
    rng_of = partial(generator, scenario.seed)
    with at(scenario, "aircraft.fuel_kg"):
        aircraft = Aircraft(aircraft_folder(scenario), rate, scenario.aircraft.fuel_kg)
    with at(scenario, "flight.airspeed_m_s"):
        aircraft.check_speed(plan.height, plan.airspeed)
    hold = max(1, round(rate / AIR_RATE_HZ))
    air = air_of(scenario, plan, ground_height, aircraft.span, hold * dt)
    wind_north, wind_east, _ = mean_wind(scenario, plan, ground_height)
    with at(scenario, "air.wind"):
        for line in plan.lines:
            wind_triangle(line.course, plan.airspeed, wind_north, wind_east)
        flight = JsbsimFlight(aircraft, plan, air, hold)
        duration = plan.forecast(wind_north, wind_east).duration
    lat, lon = np.transpose([point for line in plan.lines for point in (line.start, line.end)])
    local = terrain.grid.local(lat, lon, MAP_MARGIN)
    agl = plan.height - ground_height
    ground = GroundView(terrain, local, agl / rows.focal_px)
    vh = planned_vh(plan, ground_height)
    return Mission(
        dt=dt,
        duration=duration,
        terrain=terrain,
        route=route,
        ground=ground,
        flight=flight,
        mount=Mount(mount_of(scenario, flight.state().pitch), dt, rng_of("mount.encoder")),
        rows=CcdRows(rows_of(scenario), ground_height, rng_of("ccd_rows.noise")),
        rows_every=round(rows.period_s * rate),
        rows_turn=rows.mounted_on == "camera",
        recogniser=StripRecogniser(strips_of(scenario, vh)),
        estimator=MotionEstimator(motion_of(scenario)),
        motion=motion_of(scenario),
        control=control_of(scenario, vh),
        told_truth=scenario.control.mode == "ideal",
        camera=FrameCamera(
            ShutterParameters(scenario.frame_camera.exposure_s, scenario.frame_camera.shutter_delay_s), dt
        ),
        record_every=round(scenario.record.period_s * rate),
        outside_fails=scenario.terrain.outside == "fail",
        footprint=(
            agl * rows.spacing_px / 2.0 / rows.focal_px,
            agl * rows.pixels_px / 2.0 / rows.focal_px,
        ),
    )
