"""The devices that aid the observer or tell it: inertial unit, navigator at his sight, satellites and compass."""

from __future__ import annotations

from collections.abc import Callable
from math import radians

import numpy as np

from aerosim.scenario.scenario import Scenario
from aerosim.sensing.aids import AidingDevices, NoAids, TellingDevice
from aerosim.sensing.fix import FixParameters, SatelliteCompass
from aerosim.sensing.inertial import InertialParameters, InertialUnit
from aerosim.sensing.oracle import Oracle
from aerosim.sensing.sight import DriftSight, SightParameters

Generators = Callable[[str], np.random.Generator]

PER_HOUR = 1.0 / 3600.0
TOLD = ("ideal", "navigator", "gnss_ins")
"""Modes whose observer believes what it is told."""


def aids_of(scenario: Scenario, rng_of: Generators, ground_height: float) -> AidingDevices | NoAids:
    """Devices that aid the observer.

    rng_of: generator of a device by its name.  ground_height: mean of the land as planned, ellipsoidal, m.
    """
    inertial = inertial_of(scenario, rng_of("navigation.imu"))
    telling = telling_of(scenario, rng_of, ground_height)
    return NoAids() if inertial is None and telling is None else AidingDevices(inertial, telling)


def inertial_of(scenario: Scenario, rng: np.random.Generator) -> InertialUnit | None:
    """The inertial unit, None if nothing of it is given to the observer.  It is read with the rows."""
    aiding, navigation = scenario.estimation.aiding, scenario.navigation
    if aiding == "none" or navigation is None or navigation.imu is None:
        return None
    imu = navigation.imu
    parameters = InertialParameters(
        gyro_noise=radians(imu.gyro_noise_deg),
        gyro_bias=radians(imu.gyro_bias_deg_per_h) * PER_HOUR,
        level_sigma=radians(imu.level_error_deg),
        level_time=imu.level_time_s,
        accel_noise=imu.accel_noise_m_s2,
        accel_bias=imu.accel_bias_m_s2,
        gives=aiding,
    )
    return InertialUnit(parameters, scenario.ccd_rows.period_s, rng)


def telling_of(scenario: Scenario, rng_of: Generators, ground_height: float) -> TellingDevice | None:
    """The device that tells drift and v/h, None if the mode has none.  ground_height: see aids_of."""
    mode = scenario.control.mode
    if mode == "ideal":
        return Oracle()
    if mode == "navigator":
        return sight_of(scenario, rng_of("control.navigator"))
    return compass_of(scenario, ground_height, rng_of("navigation.fix")) if mode == "gnss_ins" else None


def sight_of(scenario: Scenario, rng: np.random.Generator) -> DriftSight:
    """The navigator at the drift sight."""
    crew = scenario.control.navigator
    parameters = SightParameters(
        look=crew.look_s,
        look_scatter=crew.look_scatter_pct / 100.0,
        settle=crew.settle_s,
        track_sigma=radians(crew.track_sigma_deg),
        average=crew.average_s,
        least=crew.least_deg,
        reaction=crew.reaction_s,
        vh_sigma=crew.vh_sigma_pct / 100.0,
        vh_weight=crew.vh_weight_pct / 100.0,
    )
    return DriftSight(parameters, scenario.ccd_rows.period_s, rng)


def compass_of(scenario: Scenario, ground_height: float, rng: np.random.Generator) -> SatelliteCompass | None:
    """Satellite track less inertial heading; None without these devices.  ground_height: see aids_of."""
    navigation = scenario.navigation
    if navigation is None or navigation.gnss is None or navigation.ins is None:
        return None
    gnss, ins = navigation.gnss, navigation.ins
    parameters = FixParameters(
        period=gnss.period_s,
        delay=gnss.delay_s,
        velocity_sigma=gnss.velocity_sigma_m_s,
        height_sigma=gnss.sigma_m[2],
        heading_period=ins.period_s,
        heading_sigma=radians(ins.sigma_deg),
        heading_drift=radians(ins.drift_deg_per_h) * PER_HOUR,
        boresight_yaw=radians(ins.boresight_deg[2]),
    )
    return SatelliteCompass(parameters, ground_height, rng)
