"""From recognised strips to drift and v/h: geometry of the rows, and two scalar filters."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from aerosim.estimation.fixed_point import FixedFilter
from aerosim.estimation.kalman import ScalarFilter, Series
from aerosim.signals import MotionEstimate, Reason, StripMatch, StripUse


@dataclass(frozen=True)
class MotionParameters:
    """What the estimator assumes of its rows and of the disturbances.

    spacing_px: d; focal_px: f; period: s between exposures.  on_camera: the rows turn with the mount and see
    the crab; otherwise they sit on the airframe and see the drift.  right_cosine: put the crab's cosine right in
    (1).  walk_drift: b2, rad^2/s; sigma_drift: sqrt(N0), rad; walk_vh: 1/s; sigma_vh: of n, as shares.
    gamma_*: given values override b2 T/N0.  strip_period: T, s; None: the strip's own duration.
    """

    spacing_px: float
    focal_px: float
    period: float
    on_camera: bool
    right_cosine: bool
    series: Series
    walk_drift: float
    sigma_drift: float
    gamma_drift: float | None
    walk_vh: float
    sigma_vh: float
    gamma_vh: float | None
    strip_period: float | None


class StripMotion(NamedTuple):
    """What one strip says: angle of the track against the rows' axis (rad), drift (rad), v/h (1/s)."""

    angle: float
    drift: float
    vh: float


SURE = 3  # strips
LOST = 10  # strips: more than gusts carry beyond the field one after the other
UNKNOWN = MotionEstimate(0.0, math.nan, math.nan, math.nan, math.nan, False)
UNUSED = StripUse(*[math.nan] * 6)


def strip_motion(match: StripMatch, par: MotionParameters) -> StripMotion:
    """Drift and v/h of one strip.

    mu > 0: the track lies to the right of the rows' axis by atan(mu/d).  (1): v/h = d/(f dt n), which is
    (v/h) cos(angle); divided by the cosine if `right_cosine`.  Rows on the camera were turned by the mount:
    drift = angle + mean of the mount's yaw at the two exposures (the two end values count, not the average).
    """
    angle = math.atan2(match.mu, par.spacing_px)
    vh = par.spacing_px / (par.focal_px * par.period * match.n)
    if par.right_cosine:
        vh /= math.cos(angle)
    drift = angle + (match.yaw1 + match.yaw2) / 2.0 if par.on_camera else angle
    return StripMotion(angle, drift, vh)


class MotionEstimator:
    """Drift and v/h now, out of all strips accepted so far."""

    def __init__(
        self,
        parameters: MotionParameters,
        filters: tuple[FixedFilter, FixedFilter] | None = None,
    ) -> None:
        """filters: of drift and n in whole numbers; None: in real ones.

        Without an accepted strip the estimate is not valid.
        """
        par = self._par = parameters
        self._drift: ScalarFilter | FixedFilter = ScalarFilter(0.0, par.sigma_drift**2, par.series)
        self._n: ScalarFilter | FixedFilter = ScalarFilter(0.0, 1.0, par.series)
        if filters is not None:
            self._drift, self._n = filters
        self._estimate = UNKNOWN
        self._beyond = 0

    def begin_line(self) -> None:
        """Another line: the course has changed, so what was known of drift and speed is void."""
        self._drift.restart()
        self._n.restart()
        self._estimate = UNKNOWN
        self._beyond = 0

    def add(self, match: StripMatch) -> StripUse:
        """Take one strip.  A refused one changes nothing, unless the track is still, or again, looked for."""
        if match.reason is not Reason.ACCEPTED:
            self._seek(match)
            return UNUSED
        par, self._beyond = self._par, 0
        seen = strip_motion(match, par)
        duration = par.strip_period if par.strip_period is not None else match.t_row2 - match.t_row1
        noise_n = (par.sigma_vh * match.n) ** 2
        self._drift.gamma = _gamma(par.gamma_drift, par.walk_drift, duration, par.sigma_drift)
        self._n.gamma = _gamma(par.gamma_vh, par.walk_vh, duration, par.sigma_vh)
        self._n.noise = noise_n
        innovation_drift = self._drift.update(seen.drift)
        # the filter runs on n, the paper's state; with the cosine put right it is the n of a rows' axis on track
        innovation_n = self._n.update(par.spacing_px / (par.focal_px * par.period * seen.vh))
        n = self._n.estimate
        vh = par.spacing_px / (par.focal_px * par.period * n)
        sigma_vh = vh * math.sqrt(self._n.variance) / n
        sigma_drift = math.sqrt(self._drift.variance)
        self._estimate = MotionEstimate(match.t_decided, self._drift.estimate, vh, sigma_drift, sigma_vh, True)
        return StripUse(
            self._drift.gain, self._n.gain, innovation_drift, innovation_n, self._drift.variance, sigma_vh**2
        )

    def _seek(self, match: StripMatch) -> None:
        """Strips whose minimum lies beyond the same end of the rows say where to turn.

        The rows' field is +-atan(max shift/d), 10 deg: a camera that starts along the airframe cannot see a
        larger drift.  Three strips in a row are asked for, since a single one may be a chance minimum; once
        there is an estimate, ten without one accepted between them: then it was wrong, and is void.
        """
        if not self._par.on_camera or match.reason is not Reason.BORDER_MU:
            return
        side = 1 if match.mu > 0.0 else -1
        self._beyond = self._beyond + side if self._beyond * side > 0 else side
        if abs(self._beyond) >= (LOST if self._estimate.valid else SURE):
            self._drift.restart()
            self._n.restart()
            angle = (match.yaw1 + match.yaw2) / 2.0 + math.atan2(match.mu, self._par.spacing_px)
            self._estimate = UNKNOWN._replace(t=match.t_decided, seek=angle)

    def now(self) -> MotionEstimate:
        """The present estimate; its time is that of the strip last taken."""
        return self._estimate


def _gamma(given: float | None, walk: float, duration: float, sigma: float) -> float:
    """gamma = b2 T/N0 below (14), unless it is given."""
    return given if given is not None else walk * duration / sigma**2
