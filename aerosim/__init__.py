"""aerosim: simulator of airborne photo missions.

Conventions, for all modules.  If code and this page disagree, the code is wrong.

Units: SI and radians inside, without suffix; every scenario key, option, column and message carries its unit.
Time: one integer step counter at the flight's rate; a device runs each k-th step.

Frames, by letter:
    e  ECEF, WGS-84
    n  north, east, down at the aircraft, on the ellipsoid
    b  body: x forward, y right, z down
    m  mount
    c  camera: x to the front edge of the picture, y right, z along the optical axis
    g  map grid: easting, northing, ellipsoidal height
`mat_nb` takes b to n, so `mat_nb @ mat_bm @ mat_mc @ los_c` reads as it multiplies; `pos_e`, `omega_nb_b`.
Rotations are active and right-handed: mat_nb = Rz(heading) Ry(pitch) Rx(roll), and of the mount
mat_bm = Rx(roll) Ry(pitch) Rz(yaw), yaw innermost.

Signs:
    Heading, track and yaw grow clockwise from true north, seen from above.
    drift = track - aircraft heading: what the wind does; wind from the left makes it positive.
    crab = track - camera heading = drift - mount yaw for a level camera: what the controller leaves.
    Wind in scenarios is given by where it comes FROM; `wind_n` is the velocity of the air, where it goes to.
    Gusts u, v, w are velocities of the air along x, y, z of b; p, q, r its rotation as the aircraft feels it.
    cross_track is positive to the right of the line.
    mu > 0: index in row I = index in row II + mu; the track lies to the right of the rows' axis.

Arrays: vectors on the last axis.  Pixels are (row, column), the centre of the first at (0, 0); row 0 is the front
edge, columns grow to starboard.  Row I looks ahead, row II behind.
Heights are ellipsoidal.  v/h: horizontal ground speed over the camera's height above the mean terrain of the
footprint of the rows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aerosim.record import Record, Run, open_run
    from aerosim.scenario import Scenario, load_scenario
    from aerosim.simulate import run, simulate
    from aerosim.sweep import sweep
    from aerosim.sweep.results import Sweep, open_sweep

__all__ = [
    "Record",
    "Run",
    "Scenario",
    "Sweep",
    "load_scenario",
    "open_run",
    "open_sweep",
    "run",
    "simulate",
    "sweep",
]

_HOME = {
    "Record": "aerosim.record",
    "Run": "aerosim.record",
    "open_run": "aerosim.record",
    "Scenario": "aerosim.scenario",
    "load_scenario": "aerosim.scenario",
    "run": "aerosim.simulate",
    "simulate": "aerosim.simulate",
    "sweep": "aerosim.sweep",
    "Sweep": "aerosim.sweep.results",
    "open_sweep": "aerosim.sweep.results",
}


def __getattr__(name: str) -> Any:
    """Public names, imported when first asked for: the command line starts without the simulator."""
    if name not in _HOME:
        raise AttributeError(f"module 'aerosim' has no attribute {name!r}")
    import importlib

    return getattr(importlib.import_module(_HOME[name]), name)
