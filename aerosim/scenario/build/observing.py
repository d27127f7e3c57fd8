"""What a scenario's mode observes with: the observer and the devices that aid it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aerosim.estimation.motion import MotionEstimator
from aerosim.estimation.observer import Observer, RowObserver, ToldObserver
from aerosim.estimation.strips import StripRecogniser
from aerosim.scenario.build.devices import motion_of, strips_of
from aerosim.scenario.scenario import Scenario
from aerosim.sensing.aids import AidingDevices, NoAids
from aerosim.sensing.oracle import Oracle

Generators = Callable[[str], np.random.Generator]


def aids_of(scenario: Scenario, rng_of: Generators) -> AidingDevices | NoAids:
    """Devices that aid the observer.  rng_of: generator of a device by its name."""
    if scenario.control.mode == "ideal":
        return AidingDevices(telling=Oracle())
    return NoAids()


def observer_of(scenario: Scenario, vh: float) -> Observer:
    """Observer of the scenario's mode.  vh: planned, 1/s."""
    rows = RowObserver(StripRecogniser(strips_of(scenario, vh)), MotionEstimator(motion_of(scenario)))
    if scenario.control.mode == "ideal":
        return ToldObserver(rows)
    return rows
