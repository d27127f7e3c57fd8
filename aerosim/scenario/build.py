"""From a scenario to the parts of a run: the only place that maps its keys to the stages' parameters."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from math import radians
from pathlib import Path

import numpy as np

from aerosim import assets
from aerosim.control.law import ControlParameters
from aerosim.errors import InputError
from aerosim.estimation.motion import MotionEstimator, MotionParameters
from aerosim.estimation.strips import StripParameters, StripRecogniser
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.jsbsim_flight import JsbsimFlight
from aerosim.flight.plan import FlightPlan, Line, wind_triangle
from aerosim.projection import Camera
from aerosim.rng import generator
from aerosim.scenario.air import SteadyWind
from aerosim.scenario.scenario import Scenario
from aerosim.scenario.terrain import TerrainFiles, Undulation
from aerosim.sensing.ccd_rows import CcdRows, RowParameters
from aerosim.sensing.frame_camera import FrameCamera, ShutterParameters
from aerosim.sensing.mount import Mount, MountParameters
from aerosim.world.air import Air, make_air, wind_n
from aerosim.world.ground import GroundView
from aerosim.world.terrain import Terrain, find_terrain

# Beyond the last line's end, run-ins and turns stay within this of the lines, for the local map
MAP_MARGIN = 40_000.0
CLEARANCE = 150.0  # m, least height above the ground under a line: the legal one over open land
CORRIDOR = 1000.0  # m, half width of the ground whose mean height the flying height is above


@dataclass(frozen=True)
class Mission:
    """The parts of one run, ready for the loop.  dt: step, s; *_every: steps between a device's turns."""

    dt: float
    duration: float
    terrain: Terrain
    ground: GroundView
    air: Air
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


@contextmanager
def at(scenario: Scenario, key: str) -> Iterator[None]:
    """Errors raised inside are about this key, unless they name another; they get its file and line."""
    try:
        yield
    except InputError as error:
        raise scenario.place(
            error if "." in error.key else InputError(error.problem, key, error.allowed)
        ) from error


def terrain_of(scenario: Scenario) -> Terrain:
    """The terrain that a scenario names.  Raises InputError."""
    source, vertical = scenario.terrain.source, scenario.terrain.vertical_datum
    with at(scenario, "terrain.source"):
        if isinstance(source, TerrainFiles):
            files = Path(source.orthophoto), Path(source.elevation)
        else:
            files = find_terrain(source)
        return Terrain.open(*files, vertical.undulation_m if isinstance(vertical, Undulation) else vertical)


def steady_wind(scenario: Scenario) -> tuple[float, float, float]:
    """Velocity of the steady wind in n, m/s."""
    wind = scenario.air.wind
    assert isinstance(wind, SteadyWind)
    return wind_n(wind.speed_m_s, radians(wind.from_deg))


def plan_of(scenario: Scenario, terrain: Terrain) -> tuple[FlightPlan, float]:
    """The flight plan, and the mean height of the ground under its lines (ellipsoidal, m).  Raises InputError."""
    flight = scenario.flight
    lines = []
    for index, wanted in enumerate(flight.lines):
        with at(scenario, f"flight.lines.{index}"):
            start, end = wanted.start_deg, wanted.end_deg
            lines.append(Line((radians(start[0]), radians(start[1])), (radians(end[0]), radians(end[1]))))
    under = []
    for index, line in enumerate(lines):
        with at(scenario, f"flight.lines.{index}"):
            lat, lon = np.transpose([line.start, line.end])
            east, north = terrain.grid.from_geodetic(lat, lon)
            outside = float(terrain.shortfall(east, north).max())
            if outside > 0.0 and scenario.terrain.outside == "fail":
                raise InputError(
                    f"line {index} leaves the terrain by {outside:.0f} m", allowed="terrain.outside: mask flies it"
                )
            under.append(terrain.mean_height(east, north, CORRIDOR))
    ground = float(np.average([heights.mean for heights in under], weights=[line.length for line in lines]))
    height = flight.height_m + (ground if flight.height_above == "mean_terrain" else 0.0)
    with at(scenario, "flight.height_m"):
        for index, heights in enumerate(under):
            if height - heights.high < CLEARANCE:
                raise InputError(
                    f"{height:.0f} m above the ellipsoid is {height - heights.high:.0f} m "
                    f"above the highest ground under line {index}",
                    allowed=f"{CLEARANCE:.0f} m and more: flight.height_m from "
                    f"{np.ceil(flight.height_m + CLEARANCE - height + heights.high):.0f} on",
                )
        plan = FlightPlan(lines, height, flight.airspeed_m_s, flight.run_in_s, radians(flight.bank_max_deg))
    return plan, ground


def planned_vh(plan: FlightPlan, ground: float) -> float:
    """Speed-to-height ratio that the crew expects without knowing the wind, 1/s."""
    return plan.airspeed / (plan.height - ground)


def planned_n(scenario: Scenario, vh: float) -> float:
    """Exposures in which the ground passes from row I to row II at this v/h (1/s), equation (1)."""
    rows = scenario.ccd_rows
    return rows.spacing_px / (rows.focal_px * rows.period_s * vh)


def camera_of(scenario: Scenario) -> Camera:
    """The frame camera's geometry."""
    frame = scenario.frame_camera
    along, across = (side * 1e-3 for side in frame.format_mm)
    return Camera.of_frame(frame.focal_mm * 1e-3, (along, across), frame.pixel_um * 1e-6)


def build(scenario: Scenario) -> Mission:
    """All parts of a run.  Raises InputError for whatever cannot be flown, with the place of its key."""
    terrain = terrain_of(scenario)
    plan, ground_height = plan_of(scenario, terrain)
    rate, rows = scenario.aircraft.step_rate_hz, scenario.ccd_rows
    dt = 1.0 / rate
    rng_of = partial(generator, scenario.seed)
    with at(scenario, "aircraft.fuel_kg"):
        aircraft = Aircraft(aircraft_folder(scenario), rate, scenario.aircraft.fuel_kg)
    with at(scenario, "flight.airspeed_m_s"):
        aircraft.check_speed(plan.height, plan.airspeed)
    air = make_air(
        steady_wind(scenario),
        scenario.air.slow_wind.sigma_m_s,
        scenario.air.slow_wind.time_constant_s,
        scenario.air.turbulence.sigma_m_s,
        scenario.air.turbulence.length_m,
        plan.airspeed,
        aircraft.span,
        dt,
        rng_of,
    )
    with at(scenario, "air.wind"):
        for line in plan.lines:
            wind_triangle(line.course, plan.airspeed, *steady_wind(scenario)[:2])
        flight = JsbsimFlight(aircraft, plan, air.at(0)[:3])
        duration = plan.forecast(*steady_wind(scenario)[:2]).duration
    lat, lon = np.transpose([point for line in plan.lines for point in (line.start, line.end)])
    local = terrain.grid.local(lat, lon, MAP_MARGIN)
    agl = plan.height - ground_height
    ground = GroundView(terrain, local, agl / rows.focal_px)
    vh = planned_vh(plan, ground_height)
    return Mission(
        dt=dt,
        duration=duration,
        terrain=terrain,
        ground=ground,
        air=air,
        flight=flight,
        mount=Mount(_mount(scenario, flight.state().pitch), dt, rng_of("mount.encoder")),
        rows=CcdRows(_rows(scenario), ground_height, rng_of("ccd_rows.noise")),
        rows_every=round(rows.period_s * rate),
        rows_turn=rows.mounted_on == "camera",
        recogniser=StripRecogniser(_strips(scenario, vh)),
        estimator=MotionEstimator(motion_of(scenario)),
        motion=motion_of(scenario),
        control=_control(scenario, vh),
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


def aircraft_folder(scenario: Scenario) -> Path:
    """Folder of the shipped aircraft that a scenario names.  Raises InputError."""
    root, name = assets.folder("aircraft"), scenario.aircraft.model
    names = sorted(p.parent.name for p in root.glob("*/limits.yaml"))
    if name not in names:
        raise scenario.error("aircraft.model", f"no aircraft {name!r} ships", f"allowed: {', '.join(names)}")
    return root / name


def _mount(scenario: Scenario, trim_pitch: float) -> MountParameters:
    m = scenario.mount
    level = -trim_pitch if m.level == "static" else 0.0
    return MountParameters(
        radians(m.yaw_limit_deg),
        radians(m.rate_limit_deg_s),
        m.time_constant_s,
        m.delay_s,
        radians(m.encoder_sigma_deg),
        level,
    )


def _rows(scenario: Scenario) -> RowParameters:
    r = scenario.ccd_rows
    return RowParameters(
        pixels=r.pixels_px,
        max_shift=r.max_shift_px,
        spacing_px=r.spacing_px,
        focal_px=r.focal_px,
        smear_along_px=r.smear_along_px,
        smear_across_px=r.smear_across_px,
        exposure=None if r.exposure_s == "auto" else r.exposure_s,
        noise_grey=r.noise_grey,
        dark_drift_grey_per_s=r.dark_drift_grey_per_s,
        bits=r.bits,
    )


def _strips(scenario: Scenario, vh: float) -> StripParameters:
    rows, est = scenario.ccd_rows, scenario.estimation
    return StripParameters(
        pixels=rows.pixels_px,
        max_shift=rows.max_shift_px,
        spacing_px=rows.spacing_px,
        planned_n=planned_n(scenario, vh),
        search=est.search_n,
        period=None if est.strip_period_s is None else round(est.strip_period_s / rows.period_s),
        mean_subtracted=est.mean_subtracted,
        subpixel=est.subpixel,
        padded=rows.extension == "padded",
    )


def motion_of(scenario: Scenario) -> MotionParameters:
    """What the estimator assumes, as the scenario's section `estimation` says."""
    rows, est = scenario.ccd_rows, scenario.estimation
    return MotionParameters(
        spacing_px=rows.spacing_px,
        focal_px=rows.focal_px,
        period=rows.period_s,
        on_camera=rows.mounted_on == "camera",
        right_cosine=scenario.control.mode != "schmelovsky_1988",
        series=est.gain,
        walk_drift=est.crab.walk_deg2_per_s * radians(1.0) ** 2,
        sigma_drift=radians(est.crab.sigma_deg),
        gamma_drift=est.crab.gamma,
        walk_vh=est.vh.walk_pct2_per_s * 1e-4,
        sigma_vh=est.vh.sigma_pct * 1e-2,
        gamma_vh=est.vh.gamma,
        strip_period=est.strip_period_s,
    )


def _control(scenario: Scenario, vh: float) -> ControlParameters:
    frame, control = scenario.frame_camera, scenario.control
    follow = control.mode != "fixed"
    return ControlParameters(
        base_ratio=(1.0 - control.end_lap_pct / 100.0) * frame.format_mm[0] / frame.focal_mm,
        planned_vh=vh,
        min_interval=frame.min_interval_s,
        follow_drift=follow,
        follow_vh=follow,
        fmc=control.fmc,
    )
