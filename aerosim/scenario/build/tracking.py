"""What mode `best` assumes, by the aiding that the scenario has."""

from __future__ import annotations

from math import radians

from aerosim.estimation.tracking.lag_filter import WalkModel
from aerosim.estimation.tracking.rays import Rays
from aerosim.estimation.tracking.strips import StripSetup
from aerosim.estimation.tracking.tracker import TrackerParameters
from aerosim.frames import GRAVITY
from aerosim.scenario.build.devices import planned_n, rows_of
from aerosim.scenario.scenario import Scenario
from aerosim.sensing.ccd_rows import pixel_rays

DEGREE = radians(1.0)
BLOCK_S = 0.5  # strips are taken together over so long
# How far strips that agree may scatter, deg and %, before anything is known.
SCATTER_TRACK = {"none": 2.0, "gyro": 0.5, "bank": 0.5, "imu": 0.5}
SCATTER_VH = {"none": 3.0, "gyro": 1.0, "bank": 1.0, "imu": 1.0}
# deg and %: a block is not believed to be better; unaided, sway comes on top
FLOOR_TRACK = {"none": 0.1, "gyro": 0.01, "bank": 0.01, "imu": 0.01}
FLOOR_VH = {"none": 0.1, "gyro": 0.03, "bank": 0.03, "imu": 0.03}
LEVEL_DEG, LEVEL_S, GYRO_DEG_PER_H = 0.1, 60.0, 10.0  # a small unit's data sheet
START_DEG = 0.3  # by which a gyro without a vertical may have been started aslant
SLOPE_S = 10000.0  # what a held gyro misses of the level changes with its drift only, which is a state of its own
RELIEF_PCT2_PER_S = 0.3  # walk of v/h over mountains, to which the filter may go


def believed_rays(scenario: Scenario) -> Rays:
    """Rays of the rows' pixels with the distortion that the calibration says, which may not be the device's."""
    known = scenario.estimation.distortion
    rows = rows_of(scenario)
    return Rays(*pixel_rays(rows if known is None else rows._replace(distortion=known)))


def tracker_of(scenario: Scenario, vh: float, height: float, level: float) -> TrackerParameters:
    """Parameters of mode `best`.

    vh: planned, 1/s; height: planned above the mean land, m; level: pitch that the mount was set to, rad.
    """
    rows, est = scenario.ccd_rows, scenario.estimation
    aiding = est.aiding
    # what a roll or pitch does to an acceleration, and a gyro's drift to the two looks of a strip (docs/best.md)
    share, lever = GRAVITY / (vh * height), height / GRAVITY
    oblique = 1.0 + rows.pixels_px**2 / (12.0 * rows.focal_px**2)
    drift = radians(GYRO_DEG_PER_H) / 3600.0
    wrong = share * radians(LEVEL_DEG if aiding in ("bank", "imu") else START_DEG)
    along = share * radians(LEVEL_DEG) if aiding == "imu" else 0.0
    return TrackerParameters(
        strips=StripSetup(
            pixels=rows.pixels_px,
            max_shift=rows.max_shift_px,
            spacing_px=rows.spacing_px,
            focal_px=rows.focal_px,
            period=rows.period_s,
            level=0.0 if aiding == "none" else level,
            planned_n=planned_n(scenario, vh),
            search=est.search_n,
            every=round((est.strip_period_s or rows.period_s) / rows.period_s),
            rays=believed_rays(scenario),
        ),
        planned_vh=vh,
        planned_height=height,
        aiding=aiding,
        track=WalkModel(
            walk=est.crab.walk_deg2_per_s * DEGREE**2,
            slope_sigma=wrong,
            slope_time=SLOPE_S,
            rate_sigma=share * drift,
            lever=oblique * lever,
        ),
        vh=WalkModel(
            walk=est.vh.walk_pct2_per_s * 1e-4,
            slope_sigma=max(along, 1e-5),
            slope_time=SLOPE_S,
            rate_sigma=share * drift if along else 0.0,
            lever=lever if along else 0.0,
            walk_most=RELIEF_PCT2_PER_S * 1e-4,
        ),
        block=BLOCK_S,
        floor_track=(FLOOR_TRACK[aiding] * DEGREE) ** 2,
        floor_vh=(FLOOR_VH[aiding] * 1e-2) ** 2,
        noise_track=(est.crab.sigma_deg * DEGREE) ** 2,
        noise_vh=(est.vh.sigma_pct * 1e-2) ** 2,
        scatter_track=(SCATTER_TRACK[aiding] * DEGREE) ** 2,
        scatter_vh=(SCATTER_VH[aiding] * 1e-2) ** 2,
        gyro_drift=radians(GYRO_DEG_PER_H) / 3600.0,
        level_sigma=radians(LEVEL_DEG),
        level_time=LEVEL_S,
    )
