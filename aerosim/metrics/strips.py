"""What each strip said, and what it ought to have said."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aerosim.estimation.motion import MotionParameters, StripMotion, strip_motion
from aerosim.frames import Array, radii, wrap_pi
from aerosim.recorder import Columns, Samples
from aerosim.signals import Reason, StripMatch, StripUse


def strip_truth(t_row1: Array, t_row2: Array, samples: Samples, on_camera: bool) -> tuple[Array, Array]:
    """True angle of the track against the rows' axis (rad) and true v/h (1/s) of strips, NaN if never found.

    t_row1, t_row2: (n,), s.  The angle is the direction of the way from the first exposure to the second, less
    the mean of the rows' headings at the two (it is these end values that shift the rows).  v/h is that way's
    length over its time and over the height above the strip of ground that lies below at mid-time.
    """
    s = samples
    middle = (t_row1 + t_row2) / 2.0
    if len(s.t) < 2:
        return np.full(len(t_row1), np.nan), np.full(len(t_row1), np.nan)
    lat, height = np.interp(middle, s.t, s.lat), np.interp(middle, s.t, s.height)
    meridian, normal = radii(lat)
    north = (np.interp(t_row2, s.t, s.lat) - np.interp(t_row1, s.t, s.lat)) * (meridian + height)
    east = (np.interp(t_row2, s.t, s.lon) - np.interp(t_row1, s.t, s.lon)) * (normal + height) * np.cos(lat)
    axis = np.unwrap(s.heading) + (s.mount_yaw if on_camera else 0.0)
    ends = (np.interp(t_row1, s.t, axis) + np.interp(t_row2, s.t, axis)) / 2.0
    angle = wrap_pi(np.arctan2(east, north) - ends)
    vh = np.hypot(north, east) / (t_row2 - t_row1) / (height - np.interp(middle, s.t, s.strip))
    return np.where(np.isfinite(t_row2), angle, np.nan), vh


def _reading(match: StripMatch, motion: MotionParameters) -> StripMotion | None:
    """What a strip says by itself: with roll and pitch taken out if its estimator did so."""
    if not np.isfinite(match.n):
        return None
    if np.isfinite(match.angle):
        return StripMotion(match.angle, match.angle + (match.yaw1 + match.yaw2) / 2.0, match.vh)
    return strip_motion(match, motion)


def strip_table(
    strips: Sequence[tuple[StripMatch, StripUse]], samples: Samples, motion: MotionParameters
) -> Columns:
    """Columns of matches.parquet, one row per strip in the order of their decisions.

    crab_true_deg, vh_true_per_s: of the strip; n_true: the closed form d/(f dt (v/h) cos(angle)) of these.
    drift_deg, vh_per_s: what the strip itself says, before the filters.
    """
    matches, uses = [m for m, _ in strips], [u for _, u in strips]

    def column(name: str, scale: float = 1.0) -> Array:
        return np.array([getattr(m, name) for m in matches], float) * scale

    def use(name: str, scale: float = 1.0) -> Array:
        return np.array([getattr(u, name) for u in uses], float) * scale

    seen = [_reading(m, motion) for m in matches]
    angle, vh = strip_truth(column("t_row1"), column("t_row2"), samples, motion.on_camera)
    degree = float(np.degrees(1.0))
    return {
        "strip": np.array([m.strip for m in matches], np.int64),
        "t_row1_s": column("t_row1"),
        "t_row2_s": column("t_row2"),
        "t_decided_s": column("t_decided"),
        "n": column("n"),
        "mu_px": column("mu"),
        "mad_min_grey": column("mad_min"),
        "angle_deg": np.array([np.nan if x is None else x.angle for x in seen], float) * degree,
        "drift_deg": np.array([np.nan if x is None else x.drift for x in seen], float) * degree,
        "vh_per_s": np.array([np.nan if x is None else x.vh for x in seen], float),
        "variance_drift_deg2": use("variance_drift", degree**2),
        "variance_vh_per_s2": use("variance_vh"),
        "gain_drift": use("gain_drift"),
        "gain_vh": use("gain_vh"),
        "innovation_drift": use("innovation_drift"),
        "innovation_vh": use("innovation_vh"),
        "accepted": np.array([m.reason is Reason.ACCEPTED for m in matches], bool),
        "reason": np.array([str(m.reason) for m in matches], object),
        "crab_true_deg": angle * degree,
        "vh_true_per_s": vh,
        "n_true": motion.spacing_px / (motion.focal_px * motion.period * vh * np.cos(angle)),
    }
