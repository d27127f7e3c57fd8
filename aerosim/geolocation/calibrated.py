"""What a calibration is given and what it says: sigmas, control points, corrections and how well they are
known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.geolocation.chain import (
    Corrections,
    ObliqueCamera,
    Poses,
    axes_in_n,
    check_pixels,
    n_from_c,
    places,
    turns,
)

DEG = np.pi / 180.0
# Parameter -> field of Corrections.
GIMBAL = {"boresight_yaw": "yaw", "boresight_pitch": "pitch", "roll_plus_alpha": "alpha", "beta": "beta"}
NAVIGATION = {
    "boresight_yaw": "yaw",
    "boresight_pitch": "pitch",
    "boresight_roll": "roll",
    "alpha": "alpha",
    "beta": "beta",
}
OPTIONAL = {"axis_tilt": "tilt", "detector_twist": "twist"}
# A geometry is unseen where the corrections leave its sight this much worse known than the worst one that was
# seen, and by this part of what a picture's own errors do.
UNSEEN_FACTOR, UNSEEN_PART = 3.0, 0.5


class Sigmas(NamedTuple):
    """Standard deviations of the measured: rad, px, m.

    gimbal: of alpha and of beta, line of sight; pixel: of row and of column; position: north, east, down;
    elevation: of the ground; correction: what each correction may be before a control point was seen.
    """

    heading: float = 0.03 * DEG
    pitch: float = 0.01 * DEG
    roll: float = 0.01 * DEG
    gimbal: float = 0.003 * DEG
    pixel: float = 0.5
    position: tuple[float, float, float] = (3.0, 3.0, 5.0)
    elevation: float = 8.0
    correction: float = 0.03 * DEG

    def checked(self) -> Sigmas:
        """The same.  Raises InputError for what is negative, not finite, or a correction or pixel of zero."""
        values = [*self[:5], *self.position, self.elevation, self.correction]
        if not (np.isfinite(values).all() and min(values) >= 0.0):
            raise InputError("a standard deviation is negative or not finite", key="sigma", allowed="0 or above")
        if self.correction == 0.0 or self.pixel == 0.0:
            raise InputError("a standard deviation of zero", key="sigma", allowed="pixel, correction above 0")
        return self


class ControlPoints(NamedTuple):
    """pos_e: (g, 3), m; sigma: (g,) of each of north, east, up, m, shared by all pictures of the point."""

    pos_e: Array
    sigma: Array


@dataclass(frozen=True)
class Calibration:
    """Corrections that control points show, and how well.

    names: of the k parameters; values, covariance: rad, after the fit, prior included; observable: "yes",
    "weak" or "no" by name: what the pictures alone say; alone: (k,) their sigma without the prior, rad, inf
    where they leave it open.  directions: (k, k) rows, combinations from best to least known by the pictures
    alone, direction_sigmas their sigmas, rad.  rejected: rows judged blunders; used: rows in the fit;
    line_share: variance of the navigation that rows of a line share, and that they do not, over what sigma
    says.  seen: largest sigma, rad, that the covariance leaves in the lines of sight of its own pictures.
    """

    names: tuple[str, ...]
    values: Array
    covariance: Array
    observable: tuple[str, ...]
    alone: Array
    directions: Array
    direction_sigmas: Array
    rejected: NDArray[np.int64]
    used: int
    line_share: tuple[float, float]
    seen: float
    not_observable: tuple[str, ...]

    @property
    def sigma(self) -> Array:
        """(k,), rad, prior included."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def fields(self) -> tuple[str, ...]:
        """Fields of Corrections, one a parameter."""
        named = {**NAVIGATION, **GIMBAL, **OPTIONAL}
        return tuple(named[name] for name in self.names)

    @property
    def corrections(self) -> Corrections:
        """To be handed to the chain."""
        return Corrections(**{name: float(v) for name, v in zip(self.fields, self.values, strict=True)})

    def report(self) -> str:
        """A line a parameter: what is known, and from what; no number for what the data cannot say."""
        lines = []
        for k, name in enumerate(self.names):
            if self.observable[k] == "no":
                lines.append(f"{name}: not observable, sigma = prior sigma {self.sigma[k] / DEG:.4f} deg")
                continue
            alone = f"{self.alone[k] / DEG:.4f} deg" if np.isfinite(self.alone[k]) else "open"
            lines.append(
                f"{name}: {self.values[k] / DEG:.5f} deg, sigma {self.sigma[k] / DEG:.5f} deg, "
                f"{'observed' if self.observable[k] == 'yes' else 'weak'} (pictures alone: {alone})"
            )
        lines += [f"{name}: not observable" for name in self.not_observable]
        return "\n".join(lines)


class Sights(NamedTuple):
    """Lines of sight and what moves them, in n at the tabulated position.

    los_n: (n, 3) unit.  own: (n, 3, 7) by 1 sigma of heading, pitch, roll, alpha, beta, row, column.
    of_corrections: (n, 3, k) by the corrections, rad.
    """

    los_n: Array
    own: Array
    of_corrections: Array


def sights(
    camera: ObliqueCamera,
    poses: Poses,
    pixel: ArrayLike,
    sigmas: Sigmas,
    corrections: Corrections,
    fields: tuple[str, ...],
) -> Sights:
    """Lines of sight of pixels with their errors.  fields: of Corrections.  Raises InputError as `chain.rays`."""
    px = check_pixels(camera, pixel, poses.count)
    way = turns(camera, poses, corrections)
    los_c = camera.optics.rays(px)
    length = np.linalg.norm(los_c, axis=-1, keepdims=True)
    los_n = n_from_c(way, los_c / length)
    axes, at = axes_in_n(way, poses.count), places(camera)
    angles = [
        np.cross(axes[at[name]], los_n) * sigma
        for name, sigma in (
            ("heading", sigmas.heading), ("pitch", sigmas.pitch), ("roll", sigmas.roll),
            ("alpha", sigmas.gimbal), ("beta", sigmas.gimbal),
        )
    ]  # fmt: skip
    for axis_c, sign in ((0, -1.0), (1, 1.0)):
        step = np.zeros(los_c.shape)
        step[:, axis_c] = sign * sigmas.pixel
        step -= los_c * (step * los_c).sum(axis=-1, keepdims=True) / length**2
        angles.append(n_from_c(way, step / length))
    of_corrections = [np.cross(axes[at["d_" + name]], los_n) for name in fields]
    return Sights(los_n, np.stack(angles, axis=-1), np.stack(of_corrections, axis=-1))


class Guard(NamedTuple):
    """How well the corrections are known along lines of sight.

    across, elevation: (n,), sigma, rad, level and in the vertical plane; unseen: (n,) True where the
    calibration has not seen such a geometry and its correction is not to be trusted.
    """

    across: Array
    elevation: Array
    unseen: NDArray[np.bool_]


def guard(
    calibration: Calibration, camera: ObliqueCamera, poses: Poses, pixel: ArrayLike, sigmas: Sigmas
) -> Guard:
    """Propagate a calibration's covariance to other lines of sight.  pixel: (n, 2)."""
    found = sights(camera, poses, pixel, sigmas, calibration.corrections, calibration.fields)
    level = np.stack([-found.los_n[:, 1], found.los_n[:, 0], np.zeros(poses.count)], axis=-1)
    length = np.linalg.norm(level, axis=-1, keepdims=True)
    level = np.where(length > 1e-9, level / np.maximum(length, 1e-9), [0.0, 1.0, 0.0])
    plane = np.stack([level, np.cross(found.los_n, level)], axis=1)
    moved = plane @ found.of_corrections
    left = moved @ calibration.covariance @ np.swapaxes(moved, 1, 2)
    own = plane @ found.own
    own = own @ np.swapaxes(own, 1, 2)
    worst = np.sqrt(np.maximum(np.linalg.eigvalsh(left)[:, -1], 0.0))
    part = np.sqrt(np.maximum(np.linalg.eigvals(np.linalg.solve(own, left)).real.max(axis=-1), 0.0))
    unseen = (worst > UNSEEN_FACTOR * calibration.seen) & (part > UNSEEN_PART)
    return Guard(np.sqrt(left[:, 0, 0]), np.sqrt(left[:, 1, 1]), unseen)
