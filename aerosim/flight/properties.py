"""JSBSim's properties that the aircraft reads and writes, by name.  Feet, pounds and rad, as JSBSim has them."""

from __future__ import annotations

# fmt: off
STATE = (
    "position/lat-geod-rad", "position/long-gc-rad", "position/geod-alt-ft", "velocities/v-north-fps",
    "velocities/v-east-fps", "velocities/v-down-fps", "attitude/phi-rad", "attitude/theta-rad",
    "attitude/psi-rad", "velocities/p-rad_sec", "velocities/q-rad_sec", "velocities/r-rad_sec",
    "velocities/vt-fps",
)
ECEF = (
    "position/ecef-x-ft", "position/ecef-y-ft", "position/ecef-z-ft", "velocities/ecef-x-fps",
    "velocities/ecef-y-fps", "velocities/ecef-z-fps",
)
ACCELERATION = (
    "accelerations/udot-ft_sec2", "accelerations/vdot-ft_sec2", "accelerations/wdot-ft_sec2",
    "accelerations/pdot-rad_sec2", "accelerations/qdot-rad_sec2", "accelerations/rdot-rad_sec2",
)
WIND = ("atmosphere/wind-north-fps", "atmosphere/wind-east-fps", "atmosphere/wind-down-fps")
GUST = (
    "atmosphere/gust-north-fps", "atmosphere/gust-east-fps", "atmosphere/gust-down-fps", "gust/p-rad_sec",
    "gust/q-rad_sec", "gust/r-rad_sec",
)
START = (
    "ic/psi-true-rad", "ic/theta-rad", "ic/phi-rad", "ic/vn-fps", "ic/ve-fps", "ic/vd-fps", "ic/p-rad_sec",
    "ic/q-rad_sec", "ic/r-rad_sec",
)
TRIM = ("trim/elevator-rad", "trim/aileron-rad", "trim/rudder-rad", "trim/power-w", "trim/theta-rad")
COMMAND = ("ap/roll-cmd-rad", "ap/h-cmd-ft", "ap/v-cmd-fps", "ap/on")
OTHER = (
    "metrics/bw-ft", "aero/alpha-rad", "aero/qbar-psf", "power/available-w", "inertia/pointmass-weight-lbs",
    "ic/lat-geod-rad", "ic/long-gc-rad", "ic/h-sl-ft", "forces/fbx-external-lbs", "forces/fbx-aero-lbs",
    "forces/fbz-aero-lbs", "forces/fby-total-lbs", "aero/beta-rad",
)
# fmt: on
NAMES = (*STATE, *ECEF, *ACCELERATION, *WIND, *GUST, *START, *TRIM, *COMMAND, *OTHER)
