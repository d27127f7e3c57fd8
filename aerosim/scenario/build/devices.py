"""Parameters of a scenario's devices, estimators and controller."""

from __future__ import annotations

from math import radians

from aerosim.control.law import ControlParameters
from aerosim.estimation.motion import MotionParameters
from aerosim.estimation.strips import StripParameters
from aerosim.projection import Camera
from aerosim.scenario.scenario import Scenario
from aerosim.sensing.ccd_rows import RowParameters
from aerosim.sensing.frame_camera import ShutterParameters
from aerosim.sensing.mount import MountParameters


def planned_n(scenario: Scenario, vh: float) -> float:
    """Exposures in which the ground passes from row I to row II at this v/h (1/s), equation (1)."""
    rows = scenario.ccd_rows
    return rows.spacing_px / (rows.focal_px * rows.period_s * vh)


def camera_of(scenario: Scenario) -> Camera:
    """The frame camera's geometry."""
    frame = scenario.frame_camera
    along, across = (side * 1e-3 for side in frame.format_mm)
    return Camera.of_frame(frame.focal_mm * 1e-3, (along, across), frame.pixel_um * 1e-6)


def shutter_of(scenario: Scenario) -> ShutterParameters:
    """Parameters of the frame camera's shutter."""
    frame = scenario.frame_camera
    return ShutterParameters(frame.exposure_s, frame.shutter_delay_s, frame.min_interval_s, frame.fmc_limit)


def mount_of(scenario: Scenario, trim_pitch: float) -> MountParameters:
    """Parameters of the mount.  trim_pitch: of the airframe in level flight, rad; `static` takes it out once."""
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


def rows_of(scenario: Scenario) -> RowParameters:
    """Parameters of the two CCD rows."""
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
        gain_difference=r.gain_difference_pct / 100.0,
        distortion=r.distortion,
    )


def strips_of(scenario: Scenario, vh: float) -> StripParameters:
    """Parameters of the recognition of strips.  vh: planned, 1/s."""
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


def control_of(scenario: Scenario, vh: float) -> ControlParameters:
    """Parameters of the controller.  vh: planned, 1/s."""
    frame, control, mount = scenario.frame_camera, scenario.control, scenario.mount
    follow = control.mode != "fixed"
    late = mount.time_constant_s + mount.delay_s
    return ControlParameters(
        base_ratio=(1.0 - control.end_lap_pct / 100.0) * frame.format_mm[0] / frame.focal_mm,
        half_format=0.5 * frame.format_mm[0] / frame.focal_mm,
        planned_vh=vh,
        min_interval=frame.min_interval_s,
        follow_drift=follow,
        follow_vh=follow,
        fmc=control.fmc,
        yaw_lead=late if control.yaw_lead_s is None else control.yaw_lead_s,
        dead_band=radians(control.yaw_dead_band_deg),
    )
