"""From a scenario to the parts of a run: the only place that maps its keys to the stages' parameters."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from aerosim.control.law import ControlParameters
from aerosim.estimation.motion import MotionParameters
from aerosim.estimation.observer import Observer
from aerosim.flight.interface import Flight, FlightSource, fresh
from aerosim.rng import generator
from aerosim.scenario.build.aiding import aids_of
from aerosim.scenario.build.air import mean_wind
from aerosim.scenario.build.devices import (
    camera_of,
    control_of,
    motion_of,
    mount_of,
    planned_n,
    shutter_of,
)
from aerosim.scenario.build.disturbances import with_table
from aerosim.scenario.build.flight import aircraft_folder, aircraft_of, input_files, planned_vh
from aerosim.scenario.build.instruments import mount_device, rows_device
from aerosim.scenario.build.journey import journey_of
from aerosim.scenario.build.land import clouds_of, terrain_of
from aerosim.scenario.build.observing import observer_of
from aerosim.scenario.build.placing import at
from aerosim.scenario.build.replay import replayed
from aerosim.scenario.build.route import Route, route_of
from aerosim.scenario.scenario import Scenario
from aerosim.sensing.aids import AidingDevices, NoAids
from aerosim.sensing.ccd_rows import CcdRows
from aerosim.sensing.frame_camera import FrameCamera
from aerosim.sensing.mount import Mount
from aerosim.world.ground import GroundView
from aerosim.world.terrain import Terrain

__all__ = [
    "Mission",
    "Route",
    "aircraft_folder",
    "aircraft_of",
    "at",
    "build",
    "camera_of",
    "input_files",
    "mean_wind",
    "motion_of",
    "planned_n",
    "planned_vh",
    "replayed",
    "route_of",
    "terrain_of",
    "with_table",
]


@dataclass(frozen=True)
class Mission:
    """The parts of one run, ready for the loop.  dt: step, s; *_every: steps between a device's turns."""

    dt: float
    duration: float
    terrain: Terrain
    route: Route
    ground: GroundView
    flight: Flight
    mount: Mount
    rows: CcdRows
    rows_every: int
    rows_turn: bool
    aids: AidingDevices | NoAids
    observer: Observer
    motion: MotionParameters
    control: ControlParameters
    camera: FrameCamera
    record_every: int
    outside_fails: bool
    footprint: tuple[float, float]


def build(scenario: Scenario, flights: FlightSource = fresh) -> Mission:
    """All parts of a run.  flights: where its flight comes from.

    Raises InputError for whatever cannot be flown, with the place of its key.
    """
    terrain = terrain_of(scenario)
    journey = journey_of(scenario, terrain, flights)
    plan, ground_height = journey.route.plan, journey.route.ground
    rate, rows = scenario.aircraft.step_rate_hz, scenario.ccd_rows
    dt = 1.0 / rate
    rng_of = partial(generator, scenario.seed)
    with at(scenario, "flight"):
        local = terrain.grid.local(journey.around[0], journey.around[1], journey.margin)
    agl = plan.height - ground_height
    scenario = with_table(scenario, agl)
    ground = GroundView(terrain, local, agl / rows.focal_px, clouds_of(scenario, local))
    vh = planned_vh(plan, ground_height)
    return Mission(
        dt=dt,
        duration=journey.duration,
        terrain=terrain,
        route=journey.route,
        ground=ground,
        flight=journey.flight,
        mount=mount_device(scenario, journey.level_pitch, dt, rng_of("mount.encoder")),
        rows=rows_device(scenario, ground_height, rng_of("ccd_rows.noise")),
        rows_every=round(rows.period_s * rate),
        rows_turn=rows.mounted_on == "camera",
        aids=aids_of(scenario, rng_of, ground_height),
        observer=observer_of(scenario, vh, agl, mount_of(scenario, journey.level_pitch).level_pitch),
        motion=motion_of(scenario),
        control=control_of(scenario, vh),
        camera=FrameCamera(shutter_of(scenario), dt),
        record_every=round(scenario.record.period_s * rate),
        outside_fails=scenario.terrain.outside == "fail",
        footprint=(
            agl * rows.spacing_px / 2.0 / rows.focal_px,
            agl * rows.pixels_px / 2.0 / rows.focal_px,
        ),
    )
