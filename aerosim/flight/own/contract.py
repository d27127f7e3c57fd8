"""What a JSBSim model must offer to fly here: its properties, their units, and who writes them."""

from __future__ import annotations

from typing import NamedTuple


class Property(NamedTuple):
    """One property of the contract.

    unit: as JSBSim has it.  made_by: `jsbsim`, there in every model, or `model`, which has to declare it.
    written: by this program, else only read.  meaning: with its sign.
    """

    name: str
    unit: str
    made_by: str
    written: bool
    meaning: str


def _built_in(written: bool, unit: str, meaning: str, *names: str) -> tuple[Property, ...]:
    return tuple(Property(name, unit, "jsbsim", written, meaning) for name in names)


def _own(written: bool, unit: str, meaning: str, *names: str) -> tuple[Property, ...]:
    return tuple(Property(name, unit, "model", written, meaning) for name in names)


# What a model has to declare, apart from what JSBSim makes by itself.
OWN = (
    *_own(True, "1", "1: the autopilot flies; 0: surfaces and power rest at their trim values", "ap/on"),
    *_own(True, "rad", "roll that the autopilot holds, right wing down positive", "ap/roll-cmd-rad"),
    *_own(True, "ft", "ellipsoidal height that the autopilot holds", "ap/h-cmd-ft"),
    *_own(True, "ft/s", "true airspeed that the autopilot holds", "ap/v-cmd-fps"),
    *_own(True, "rad", "elevator of the trim, trailing edge down positive", "trim/elevator-rad"),
    *_own(True, "rad", "aileron of the trim, positive rolls left", "trim/aileron-rad"),
    *_own(True, "rad", "rudder of the trim, positive yaws left", "trim/rudder-rad"),
    *_own(True, "W", "shaft power of the trim; more of it is more thrust", "trim/power-w"),
    *_own(True, "rad", "pitch of the trim, nose up positive, which the autopilot deviates from", "trim/theta-rad"),
    *_own(
        True,
        "rad/s",
        "rotation of the air about a body axis, to be taken off the aircraft's own in the aerodynamics",
        "gust/p-rad_sec",
        "gust/q-rad_sec",
        "gust/r-rad_sec",
    ),
    *_own(False, "W", "shaft power that there is at this height", "power/available-w"),
    *_own(
        True,
        "lb",
        "fuel on board, the weight of the only point mass; written at the start, burnt by the model",
        "inertia/pointmass-weight-lbs",
    ),
)

BUILT_IN = (
    *_built_in(False, "rad", "geodetic latitude; longitude", "position/lat-geod-rad", "position/long-gc-rad"),
    *_built_in(False, "ft", "height above the ellipsoid", "position/geod-alt-ft"),
    *_built_in(
        False,
        "ft/s",
        "velocity over ground in n",
        "velocities/v-north-fps",
        "velocities/v-east-fps",
        "velocities/v-down-fps",
    ),
    *_built_in(
        False,
        "rad",
        "roll, pitch, heading",
        "attitude/phi-rad",
        "attitude/theta-rad",
        "attitude/psi-rad",
    ),
    *_built_in(
        False,
        "rad/s",
        "rates of the body",
        "velocities/p-rad_sec",
        "velocities/q-rad_sec",
        "velocities/r-rad_sec",
    ),
    *_built_in(False, "ft/s", "true airspeed", "velocities/vt-fps"),
    *_built_in(False, "ft", "position in e", "position/ecef-x-ft", "position/ecef-y-ft", "position/ecef-z-ft"),
    *_built_in(
        False,
        "ft/s",
        "velocity over ground in e",
        "velocities/ecef-x-fps",
        "velocities/ecef-y-fps",
        "velocities/ecef-z-fps",
    ),
    *_built_in(
        False,
        "ft/s2",
        "acceleration along the axes of b",
        "accelerations/udot-ft_sec2",
        "accelerations/vdot-ft_sec2",
        "accelerations/wdot-ft_sec2",
    ),
    *_built_in(
        False,
        "rad/s2",
        "angular acceleration about the axes of b",
        "accelerations/pdot-rad_sec2",
        "accelerations/qdot-rad_sec2",
        "accelerations/rdot-rad_sec2",
    ),
    *_built_in(
        True,
        "ft/s",
        "velocity of the air in n, gusts included, where it goes to",
        "atmosphere/wind-north-fps",
        "atmosphere/wind-east-fps",
        "atmosphere/wind-down-fps",
    ),
    *_built_in(
        True,
        "ft/s",
        "velocity of the air in n while trimming",
        "atmosphere/gust-north-fps",
        "atmosphere/gust-east-fps",
        "atmosphere/gust-down-fps",
    ),
    *_built_in(True, "rad", "attitude at the start", "ic/psi-true-rad", "ic/theta-rad", "ic/phi-rad"),
    *_built_in(True, "ft/s", "velocity over ground at the start, in n", "ic/vn-fps", "ic/ve-fps", "ic/vd-fps"),
    *_built_in(True, "rad/s", "rates at the start", "ic/p-rad_sec", "ic/q-rad_sec", "ic/r-rad_sec"),
    *_built_in(True, "rad", "place of the start", "ic/lat-geod-rad", "ic/long-gc-rad"),
    *_built_in(True, "ft", "height of the start above sea level", "ic/h-sl-ft"),
    *_built_in(False, "ft", "wing span", "metrics/bw-ft"),
    *_built_in(False, "rad", "angle of attack", "aero/alpha-rad"),
    *_built_in(False, "rad", "sideslip, air from the right positive", "aero/beta-rad"),
    *_built_in(False, "lb/ft2", "dynamic pressure", "aero/qbar-psf"),
    *_built_in(False, "lb", "thrust, the external forces along x of b", "forces/fbx-external-lbs"),
    *_built_in(False, "lb", "force of the air along x and z of b", "forces/fbx-aero-lbs", "forces/fbz-aero-lbs"),
    *_built_in(False, "lb", "all forces but gravity along y of b", "forces/fby-total-lbs"),
)

PROPERTIES = (*OWN, *BUILT_IN)
