"""Rows and mount of a scenario, sound or with the faults that it declares."""

from __future__ import annotations

import math
from math import radians

import numpy as np

from aerosim.scenario.build.devices import mount_of, rows_of
from aerosim.scenario.scenario import Scenario
from aerosim.sensing.ccd_rows import CcdRows
from aerosim.sensing.faults import FaultyMount, FaultyRows, MountFaults, RowFaults
from aerosim.sensing.mount import Mount


def rows_device(scenario: Scenario, ground_height: float, rng: np.random.Generator) -> CcdRows:
    """The two rows.  ground_height: of the land, ellipsoidal, m, as a first guess."""
    parameters, faults = rows_of(scenario), scenario.ccd_rows.faults
    if faults is None:
        return CcdRows(parameters, ground_height, rng)
    wrong = RowFaults(
        gain_step=faults.gain_step_pct / 100.0,
        gain_step_at=faults.gain_step_at_s,
        dead=faults.dead_px,
        blind=faults.blind_row,
        blind_from=faults.blind_from_s,
        blind_until=_ever(faults.blind_until_s),
    )
    return FaultyRows(parameters, wrong, ground_height, rng)


def mount_device(scenario: Scenario, trim_pitch: float, dt: float, rng: np.random.Generator) -> Mount:
    """The mount.  trim_pitch: of the airframe in level flight, rad; dt: step, s."""
    parameters, faults = mount_of(scenario, trim_pitch), scenario.mount.faults
    if faults is None:
        return Mount(parameters, dt, rng)
    wrong = MountFaults(_ever(faults.stuck_from_s), _ever(faults.stuck_until_s), radians(faults.encoder_bias_deg))
    return FaultyMount(parameters, wrong, dt, rng)


def _ever(time: float | None) -> float:
    return math.inf if time is None else time
