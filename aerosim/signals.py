"""What devices and estimators pass on.  No pose and no truth in it: this is all that an estimator may see."""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Grey = NDArray[np.float32]


class RowExposure(NamedTuple):
    """Both CCD rows at one exposure.

    number: of the exposure, from 0; t: its middle, s.  row1: (pixels + 2 max_shift,), ahead;
    row2: (pixels,), behind; grey values, whole numbers from the converter.  exposure: s.
    missing: pixels that saw no terrain and read 0: the edge of the simulated world, not a signal.
    """

    number: int
    t: float
    row1: Grey
    row2: Grey
    exposure: float
    missing: int


class MountReading(NamedTuple):
    """The mount's encoder: yaw of the camera against the airframe, clockwise from above, rad, at time t (s)."""

    t: float
    yaw: float


class InertialReading(NamedTuple):
    """A strapped-down inertial unit at time t (s), its axes those of b.  NaN: what it does not give.

    roll, pitch, yaw: integrated rates, rad: smooth, with white noise and a drift; yaw counts from an unknown
    direction and is not wrapped.  level_roll, level_pitch: against the vertical, rad, without drift but wrong by
    the levelling error.  accel: specific force averaged since the last reading, x, y, z of b, m/s^2.
    Earth's rotation is taken out of all of it, as such units do.
    """

    t: float
    roll: float
    pitch: float
    yaw: float
    level_roll: float
    level_pitch: float
    accel_x: float
    accel_y: float
    accel_z: float


class Aids(NamedTuple):
    """What an observer is given besides the rows, each None if there is no such device or nothing new.

    inertial: see there.  told: drift and v/h from elsewhere (a sight, satellites and compass, the oracle).
    """

    inertial: InertialReading | None = None
    told: MotionEstimate | None = None


NO_AIDS = Aids()


class Reason(StrEnum):
    """Why a strip was accepted or not."""

    ACCEPTED = "accepted"
    BORDER_MU = "border_mu"
    BORDER_N = "border_n"
    DEGENERATE = "degenerate"
    AMBIGUOUS = "ambiguous"
    OUTSIDE_TERRAIN = "outside_terrain"
    TIMEOUT = "timeout"
    WEAK = "weak"
    UNLIKE = "unlike"
    UNEXPECTED = "unexpected"
    SKIPPED = "skipped"


class StripMatch(NamedTuple):
    """A strip of row I recognised (or not) by row II.

    number1: exposure at which row I was kept.  t_row1, t_row2, t_decided: s; t_row2 is where the minimum lies.
    n: exposures between the two (fraction if sub-step).  mu: shift, px; mu > 0: track to the right of the
    row's axis.  mad_min: grey levels a pixel.  yaw1, yaw2: mount readings at the two exposures, rad.
    surface: (steps, shifts) MAD, grey levels, its first row at n = first_n, its middle column at the shift centre
    (px); infinite where it was not formed.  A strip given up has NaN.
    angle (rad, track against the rows' axis), vh (1/s), track (rad, in the gyro's frame): its reading with roll
    and pitch taken out; NaN where mu and n say all there is.
    """

    strip: int
    number1: int
    t_row1: float
    t_row2: float
    t_decided: float
    n: float
    mu: float
    mad_min: float
    yaw1: float
    yaw2: float
    reason: Reason
    first_n: int
    surface: Grey
    angle: float = float("nan")
    vh: float = float("nan")
    track: float = float("nan")
    centre: int = 0


class StripUse(NamedTuple):
    """How the filters took a strip: gains and standardised innovations, NaN for a refused or first strip."""

    gain_drift: float
    gain_vh: float
    innovation_drift: float
    innovation_vh: float
    variance_drift: float
    variance_vh: float


class MotionEstimate(NamedTuple):
    """What the estimator believes now.  drift: track - aircraft heading, rad; vh: speed-to-height ratio, 1/s.

    sigma_*: standard deviations of the filter (rad, 1/s).  valid: False before the first accepted strip; until
    then seek (rad) is the mount yaw at which the track is looked for.  held: carried on without strips.  pitch: of
    the camera, rad; yaw_rate: of the airframe, rad/s; both 0 if nobody has told.
    """

    t: float
    drift: float
    vh: float
    sigma_drift: float
    sigma_vh: float
    valid: bool
    seek: float = 0.0
    held: bool = False
    pitch: float = 0.0
    yaw_rate: float = 0.0


class CameraCommand(NamedTuple):
    """What the controller asks for: mount yaw (rad, against the airframe), time between photos (s) and
    forward-motion compensation as the image's angular rate (rad/s, v/h for a level camera).

    lead: by how much of the wanted base the pitch brings a photo taken now forward; left: by how much it brings
    forward where the photo after that is wanted.  0 if the trigger does not know the pitch."""

    mount_yaw: float
    interval: float
    fmc_rate: float
    lead: float = 0.0
    left: float = 0.0
