"""Corrections of boresight and gimbal from ground control points: weighted, robust, over what can be estimated.

The outer gimbal axis is fixed in the boresight's frame, so its zero offset is a combination of the three boresight
angles: d_roll and d_alpha are one parameter, whatever is flown.  Estimated are yaw, pitch, the sum of roll and
alpha, and beta, all with a prior; the pictures' errors are carried from pose, gimbal and pixel into the
picture, errors of a control point are shared by its pictures, errors of the navigation by the rows of a line as
far as the spread between lines says.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerosim.errors import InputError, RunFailure
from aerosim.frames import Array
from aerosim.geolocation.adjust import Equations, Fit, adjust, variance_factors
from aerosim.geolocation.calibrated import DEG, GIMBAL, NAVIGATION, OPTIONAL, Calibration, ControlPoints, Sigmas
from aerosim.geolocation.chain import (
    Corrections,
    ObliqueCamera,
    Poses,
    axes_in_c,
    c_from_n,
    check_pixels,
    n_from_e,
    places,
    projection_centres,
    turns,
)
from aerosim.geolocation.refraction import Atmosphere, apparent

# Weak: what the pictures alone leave of the prior's sigma is more than this.
WEAK = 0.5
# A row further off than this probability of chi-square of 2 is a blunder: 1 - 0.9973.
REJECT = 11.83
FARTHEST = 1_000_000.0
IMPLAUSIBLE = 5.0 * DEG
MOST_ROUNDS = 30


def calibrate(
    camera: ObliqueCamera,
    poses: Poses,
    pixel: ArrayLike,
    points: ControlPoints,
    point: ArrayLike,
    sigmas: Sigmas,
    *,
    line: ArrayLike | None = None,
    atmosphere: Atmosphere | None = Atmosphere.STANDARD,
    extra: tuple[str, ...] = (),
    robust: bool = True,
) -> Calibration:
    """Gauss-Newton over the estimable combinations.

    pixel: (n, 2) row, column, px, of point (n,), index into points.  line: (n,) number of the flight line, whose
    rows share an error of the navigation; None: errors are independent.  extra: of "axis_tilt", "detector_twist".
    robust: blunders are found and left out.
    Raises InputError: nothing to fit, a control point in no picture, rows that no picture can show; RunFailure: no
    convergence.
    """
    sigmas = sigmas.checked()
    px, which = check_pixels(camera, pixel, poses.count), np.asarray(point, np.int64)
    fields = _fields(camera, extra)
    _check_points(points, which, poses.count)
    pos_e, target = projection_centres(camera, poses), points.pos_e[which]
    distance = np.linalg.norm(target - pos_e, axis=-1)
    if (far := distance > FARTHEST).any():
        raise InputError(
            f"row {int(np.argmax(far))}: the control point is {distance[far][0] / 1e3:.0f} km away",
            allowed=f"up to {FARTHEST / 1e3:.0f} km; are latitude and longitude swapped?",
        )
    los_n = n_from_e(poses.lat, poses.lon, apparent(pos_e, target, atmosphere))
    lines = None if line is None else np.unique(np.asarray(line), return_inverse=True)[1]
    problem = _Problem(camera, poses, px, los_n, distance, which, points, sigmas, lines, list(fields.values()))
    fit, factors, keep = _solve(problem, robust)
    return _calibration(camera, list(fields), problem, fit, factors, keep)


def _fields(camera: ObliqueCamera, extra: tuple[str, ...]) -> dict[str, str]:
    if unknown := [name for name in extra if name not in OPTIONAL]:
        raise InputError(f"unknown parameter {unknown[0]!r}", key="extra", allowed=", ".join(OPTIONAL))
    base = NAVIGATION if camera.boresight_on == "navigation" else GIMBAL
    return {**base, **{name: OPTIONAL[name] for name in extra}}


def _check_points(points: ControlPoints, which: NDArray[np.int64], count: int) -> None:
    if which.shape != (count,) or count == 0:
        raise InputError(
            f"{len(which)} control points of {count} rows", allowed="one of each row, one row or more"
        )
    if not (np.isfinite(points.pos_e).all() and np.isfinite(points.sigma).all() and (points.sigma >= 0.0).all()):
        raise InputError("a control point or its sigma is not a finite number, or sigma is below 0")
    if which.min() < 0 or which.max() >= len(points.pos_e):
        raise InputError(f"no control point {int(which.max())}", allowed=f"0 to {len(points.pos_e) - 1}")
    if len(unseen := np.setdiff1d(np.arange(len(points.pos_e)), which)):
        raise InputError(f"control point {int(unseen[0])} is in no picture")


class _Problem(NamedTuple):
    """What the fit is made of; see `calibrate`."""

    camera: ObliqueCamera
    poses: Poses
    pixel: Array
    los_n: Array
    distance: Array
    point: NDArray[np.int64]
    points: ControlPoints
    sigmas: Sigmas
    lines: NDArray[np.int64] | None
    fields: list[str]

    def equations(self, values: Array) -> Equations:
        """Misfit in the picture (n, 2), px, and what moves it, at given corrections (k,), rad."""
        c, poses, s = Corrections(**dict(zip(self.fields, values, strict=True))), self.poses, self.sigmas
        way = turns(self.camera, poses, c)
        axes, mat_cn = axes_in_c(way, poses.count)
        u = c_from_n(way, self.los_n)
        focal, ahead = self.camera.optics.focal_px, np.where(u[:, 2] > 0.0, u[:, 2], np.nan)
        to_px = np.zeros((poses.count, 2, 3))
        to_px[:, 0, 0], to_px[:, 0, 2] = -focal / ahead, focal * u[:, 0] / ahead**2
        to_px[:, 1, 1], to_px[:, 1, 2] = focal / ahead, -focal * u[:, 1] / ahead**2
        at = places(self.camera)

        def turned(name: str) -> Array:
            # the picture turns, so what it shows turns the other way
            moved = -_cross(axes[at[name]], u)
            return np.asarray((to_px @ moved[..., None])[..., 0])

        moved = (to_px @ mat_cn) / self.distance[:, None, None]  # across the sight; along it to_px is blind
        shared = np.stack(
            [turned("heading") * s.heading, turned("pitch") * s.pitch, turned("roll") * s.roll], axis=-1
        )
        shared = np.concatenate([shared, moved * np.asarray(s.position)], axis=-1)
        own = np.stack([turned("alpha") * s.gimbal, turned("beta") * s.gimbal], axis=-1)
        design = np.stack([turned("d_" + name) for name in self.fields], axis=-1)
        # a point's error along the axes of e, common to its pictures
        lat, lon = (angle[:, None] for angle in (poses.lat, poses.lon))
        of_point = n_from_e(lat, lon, np.broadcast_to(np.eye(3), (poses.count, 3, 3)))
        of_point = moved @ np.swapaxes(of_point, 1, 2) * self.points.sigma[self.point, None, None]
        return Equations(self.pixel - self.camera.optics.pixels(u), design, shared, own, of_point, s.pixel)


def _cross(a: Array, b: Array) -> Array:
    out = np.empty(b.shape)
    out[:, 0] = a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]
    out[:, 1] = a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2]
    out[:, 2] = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return out


def _plausible(problem: _Problem, misfit: Array) -> None:
    """Raise InputError where poses and control points cannot belong together."""
    off = np.linalg.norm(misfit, axis=-1) / problem.camera.optics.focal_px
    if not np.nanmedian(np.where(np.isfinite(off), off, np.inf)) < IMPLAUSIBLE:
        raise InputError(
            "the pictures do not look at their control points: half of them are more than 5 deg off",
            allowed="check signs, units, the order of latitude and longitude",
        )


def _solve(problem: _Problem, robust: bool) -> tuple[Fit, tuple[float, float], NDArray[np.bool_]]:
    """Rounds of Gauss-Newton and reweighting.  Returns the last fit, the shares of lines, the rows kept."""
    prior = np.full(len(problem.fields), problem.sigmas.correction)
    values = np.zeros(len(prior))
    factors = (0.0, 1.0) if problem.lines is None else (0.7, 0.3)
    equations = problem.equations(values)
    _plausible(problem, equations.misfit)
    usable: NDArray[np.bool_] = np.asarray(np.isfinite(equations.misfit).all(axis=1))
    weight = usable.astype(float)
    keep = usable
    changed = False
    for turn in range(MOST_ROUNDS):
        fit = adjust(equations, values, prior, problem.point, problem.lines, factors, weight)
        step = np.abs(fit.values - values) / np.sqrt(np.diag(fit.covariance))
        values = fit.values
        if turn >= (6 if robust else 1) and step.max() < 1e-3 and not changed:
            return fit, factors, keep
        equations = problem.equations(values)
        changed = False
        if robust and turn < 4:
            weight = usable * _soft(fit.distance, hard=turn >= 2)
        elif robust:
            now = np.logical_and(usable, fit.distance < REJECT)
            changed = bool((now != keep).any()) and turn < MOST_ROUNDS // 2
            keep = now if turn < MOST_ROUNDS // 2 else keep
            weight = keep.astype(float)
        if problem.lines is not None and turn in ((4, 6) if robust else (0, 1)):
            factors = variance_factors(equations, values, prior, problem.point, problem.lines, weight)
            changed = True
    raise RunFailure("the calibration did not converge")


def _soft(distance: Array, hard: bool) -> Array:
    """Weights by the whitened distance squared: Huber, then Cauchy, both of 2.5."""
    if hard:
        return np.asarray(1.0 / (1.0 + distance / 2.5**2))
    return np.minimum(1.0, 2.5 / np.sqrt(np.maximum(distance, 1e-12)))


def _calibration(
    camera: ObliqueCamera,
    names: list[str],
    problem: _Problem,
    fit: Fit,
    factors: tuple[float, float],
    keep: NDArray[np.bool_],
) -> Calibration:
    prior = problem.sigmas.correction
    scaled = fit.information * prior**2
    spread, vectors = np.linalg.eigh(scaled)
    spread, vectors = spread[::-1], vectors[:, ::-1]
    null = spread < 1e-12 * max(spread[0], 1.0)
    with np.errstate(divide="ignore"):
        variances = np.where(null, np.inf, 1.0 / np.maximum(spread, 1e-300))
    part = np.where(vectors**2 < 1e-12, 0.0, vectors**2)
    alone = prior * np.sqrt((part * np.where(part > 0.0, variances, 0.0)).sum(axis=1))
    said = np.diag(scaled) > 1e-6
    observable = tuple(
        "no" if not s else "weak" if a > WEAK * prior else "yes" for s, a in zip(said, alone, strict=True)
    )
    hidden = () if camera.boresight_on == "navigation" else ("roll_minus_alpha",)
    return Calibration(
        names=tuple(names),
        values=fit.values,
        covariance=fit.covariance,
        observable=observable,
        alone=np.where(said, alone, np.inf),
        directions=vectors.T,
        direction_sigmas=prior * np.sqrt(variances),
        rejected=np.flatnonzero(~keep),
        used=int(keep.sum()),
        line_share=factors,
        seen=float(np.max(sight_sigma(fit.covariance, problem.equations(fit.values).design[keep], camera))),
        not_observable=hidden,
    )


def sight_sigma(covariance: Array, design: Array, camera: ObliqueCamera) -> Array:
    """Largest sigma, rad, that the corrections' covariance leaves in lines of sight.  design: (n, 2, k),
    px/rad."""
    left = design @ covariance @ np.swapaxes(design, -1, -2)
    return np.asarray(np.sqrt(np.linalg.eigvalsh(left)[:, -1]) / camera.optics.focal_px)
