"""From the keys of devices and their faults to SI parameters, and to the devices that a mode has."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pytest
from flights import scenario

from aerosim.estimation.observer import RowObserver, ToldObserver
from aerosim.estimation.tracking.rays import Rays
from aerosim.rng import generator
from aerosim.scenario.build.aiding import aids_of, compass_of, inertial_of, sight_of, telling_of
from aerosim.scenario.build.devices import rows_of
from aerosim.scenario.build.instruments import mount_device, rows_device
from aerosim.scenario.build.observing import observer_of
from aerosim.scenario.build.tracking import believed_rays
from aerosim.scenario.estimation import Estimation
from aerosim.scenario.navigation import Navigation
from aerosim.scenario.scenario import Scenario
from aerosim.sensing.aids import AidingDevices, NoAids
from aerosim.sensing.ccd_rows import CcdRows, pixel_rays
from aerosim.sensing.faults import FaultyMount, FaultyRows, MountFaults, RowFaults
from aerosim.sensing.fix import FixParameters, SatelliteCompass
from aerosim.sensing.inertial import InertialParameters
from aerosim.sensing.mount import Mount
from aerosim.sensing.oracle import Oracle
from aerosim.sensing.sight import DriftSight, SightParameters
from aerosim.truth import AircraftState

RNG_OF = partial(generator, 1)
STATE = AircraftState(0.0, 0.6, -1.4, 3300.0, 70.0, 0.0, 0.0, 0.01, 0.02, 0.0, 0.0, 0.0, 0.0, 70.0)


def deg(*values: float) -> list[float]:
    return [math.radians(value) for value in values]


def aided(aiding: str, **imu: Any) -> Scenario:
    """A scenario with a unit, not checked: which modes use it is not asked here."""
    navigation = Navigation.model_validate({"gnss": None, "ins": None, "imu": imu})
    return scenario().model_copy(update={"estimation": Estimation(aiding=aiding), "navigation": navigation})


def test_inertial_unit() -> None:
    made = inertial_of(
        aided(
            "bank", gyro_noise_deg=0.1, gyro_bias_deg_per_h=36.0, level_error_deg=0.2, level_time_s=30.0,
            accel_noise_m_s2=0.3, accel_bias_m_s2=0.4,
        ),
        RNG_OF("x"),
    )  # fmt: skip
    assert made is not None
    assert made._par == pytest.approx((*InertialParameters(*deg(0.1, 0.01, 0.2), 30.0, 0.3, 0.4)[:6], "bank"))
    # read with the rows: correlation over 0.05 s of 30 s
    assert made._keep == pytest.approx(math.exp(-0.05 / 30.0))


def test_only_what_is_aided_has_a_unit() -> None:
    assert inertial_of(aided("none"), RNG_OF("x")) is None
    assert isinstance(aids_of(aided("none"), RNG_OF, 300.0), NoAids)
    for aiding, given in (("gyro", 3), ("bank", 5), ("imu", 8)):
        devices = aids_of(aided(aiding), RNG_OF, 300.0)
        assert isinstance(devices, AidingDevices)
        reading = devices.read(STATE, 300.0, 0.0).inertial
        assert reading is not None
        assert sum(math.isfinite(value) for value in reading[1:]) == given
        assert devices.read(STATE, 300.0, 0.0).told is None


def test_navigator_at_the_sight() -> None:
    keys = {
        "look_s": 20.0, "look_scatter_pct": 10.0, "settle_s": 7.0, "track_sigma_deg": 0.3, "average_s": 4.0,
        "least_deg": 3, "reaction_s": 2.0, "vh_sigma_pct": 5.0, "vh_weight_pct": 25.0,
    }  # fmt: skip
    made = sight_of(scenario(control={"mode": "navigator", "navigator": keys}), RNG_OF("x"))
    assert made._p == SightParameters(
        look=20.0, look_scatter=0.1, settle=7.0, track_sigma=math.radians(0.3), average=4.0, least=3, reaction=2.0,
        vh_sigma=0.05, vh_weight=0.25,
    )  # fmt: skip


def test_satellites_and_compass() -> None:
    gnss = {"period_s": 0.2, "delay_s": 0.1, "velocity_sigma_m_s": 0.05, "sigma_m": [1.0, 2.0, 3.0]}
    ins = {"period_s": 0.05, "sigma_deg": 0.1, "drift_deg_per_h": 36.0, "boresight_deg": [1.0, 2.0, 3.0]}
    made = compass_of(
        scenario(control={"mode": "gnss_ins"}, navigation={"gnss": gnss, "ins": ins}), 300.0, RNG_OF("x")
    )
    assert made is not None
    assert made._par == pytest.approx(FixParameters(0.2, 0.1, 0.05, 3.0, 0.05, *deg(0.1, 0.01, 3.0)))
    told = made.tell(STATE._replace(t=1.0), 0.0, 0.0)
    assert told is None  # the fix has not arrived
    told = made.tell(STATE._replace(t=1.1), 0.0, 0.0)
    assert told is not None
    assert told.vh == pytest.approx(70.0 / 3000.0, rel=0.01)


@pytest.mark.parametrize(
    ("mode", "device"),
    [("ideal", Oracle), ("navigator", DriftSight), ("gnss_ins", SatelliteCompass), ("pipelined", type(None))],
)
def test_mode_has_its_telling_device(mode: str, device: type) -> None:
    made = scenario(control={"mode": mode})
    assert isinstance(telling_of(made, RNG_OF, 300.0), device)
    assert isinstance(observer_of(made, 0.023, 3000.0, 0.0), RowObserver if mode == "pipelined" else ToldObserver)


def test_sound_devices_are_the_plain_ones() -> None:
    assert type(rows_device(scenario(), 300.0, RNG_OF("x"))) is CcdRows
    assert type(mount_device(scenario(), 0.0, 1.0 / 120.0, RNG_OF("x"))) is Mount


def test_faults() -> None:
    rows = {
        "gain_step_pct": 20.0,
        "gain_step_at_s": 30.0,
        "dead_px": [3, 5],
        "blind_row": "row1",
        "blind_from_s": 4.0,
    }
    made = rows_device(scenario(ccd_rows={"faults": rows}), 300.0, RNG_OF("x"))
    assert isinstance(made, FaultyRows)
    assert made._faults == RowFaults(0.2, 30.0, (3, 5), "row1", 4.0, math.inf)
    until = rows_device(scenario(ccd_rows={"faults": {"blind_until_s": 9.0}}), 300.0, RNG_OF("x"))
    assert isinstance(until, FaultyRows)
    assert until._faults == RowFaults(blind_until=9.0)
    mount = mount_device(
        scenario(mount={"faults": {"stuck_from_s": 1.0, "encoder_bias_deg": 2.0}}), 0.0, 1.0 / 120.0, RNG_OF("x")
    )
    assert isinstance(mount, FaultyMount)
    assert mount._sticks == (120, math.inf)
    assert mount.read(0.0).yaw == pytest.approx(math.radians(2.0), abs=6.0 * math.radians(0.02))
    assert MountFaults() == (math.inf, math.inf, 0.0)


def test_errors_of_the_rows() -> None:
    made = rows_of(scenario(ccd_rows={"gain_difference_pct": 5.0, "distortion": -0.1}))
    assert (made.gain_difference, made.distortion) == (0.05, -0.1)


def test_rays_are_those_of_the_device_unless_they_are_believed_otherwise() -> None:
    def believed(**estimation: float) -> Rays:
        return believed_rays(
            scenario(control={"mode": "best"}, ccd_rows={"distortion": -0.1}, estimation=estimation)
        )

    device = pixel_rays(rows_of(scenario(ccd_rows={"distortion": -0.1})))
    assert all(np.array_equal(a, b) for a, b in zip(believed(), device, strict=True))
    ideal = Rays.straight(96, 7, 39.7)
    assert all(np.allclose(a, b, atol=1e-12) for a, b in zip(believed(distortion=0.0), ideal, strict=True))
    assert believed(distortion=0.1).apart < ideal.apart < believed().apart
