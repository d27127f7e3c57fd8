"""From the pixel of an oblique camera to a line of sight, and back: principal point, gimbal, boresight, lever arm.

Chain (active, right-handed rotations), reconstructed from Li et al. 2020, (6) to (10):

    los_n = Rz(heading) Ry(pitch) Rx(roll)                          navigation, b to n
            Rz(yaw + d_yaw) Ry(pitch + d_pitch) Rx(roll + d_roll)   boresight: axes of b into the gimbal's
            Rx(alpha + d_alpha) T Ry(beta + d_beta) T^-1            gimbal, angles of the sight; T = Rz(d_tilt)
            Rz(d_twist) los_c                                       detector
    pos_e = antenna_e - mat_en mat_nb antenna_b

All zero looks straight down, row 0 to the nose; positive alpha looks left, positive beta forward.  n is the local
frame at the tabulated position of the antenna, for the lever arm and for the line of sight alike.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.frames import Array, ecef_from_geodetic
from aerosim.geolocation.refraction import Atmosphere, apparent
from aerosim.projection import Camera

# A lever arm as long as an aircraft; more is a mistaken unit.
LONGEST_LEVER_ARM = 100.0
Turn = tuple[int, Array]


class Corrections(NamedTuple):
    """What is added to the boresight and to the gimbal's angles, rad.

    roll and alpha turn about the same axis: only their sum acts.  tilt: of the axis of beta about z, out of the
    right angle to that of alpha; twist: of the detector about the optical axis.
    """

    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    alpha: float = 0.0
    beta: float = 0.0
    tilt: float = 0.0
    twist: float = 0.0


NO_CORRECTION = Corrections()


@dataclass(frozen=True)
class ObliqueCamera:
    """A camera behind a two-axis gimbal, fixed to the navigation system.

    optics: pixels to rays, with the principal point of the laboratory.  boresight: laboratory values yaw, pitch,
    roll, rad.  antenna_b: (3,) from the projection centre to the antenna, m, in b, the same at every gimbal angle.
    mirror_factor: 1 where beta is the angle of the line of sight, 2 where it is that of a mirror's shaft.
    boresight_on: "gimbal", as bolted; "navigation" turns n instead of b, the only order in which all five
    corrections of Li et al. 2020 can be told apart, kept to redo their figures.
    Raises InputError for what is not finite, a lever arm beyond 100 m, an unknown order.
    """

    optics: Camera
    boresight: tuple[float, float, float] = (0.0, 0.0, 0.0)
    antenna_b: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirror_factor: float = 1.0
    boresight_on: Literal["gimbal", "navigation"] = "gimbal"

    def __post_init__(self) -> None:
        if not np.isfinite([*self.boresight, *self.antenna_b, self.mirror_factor]).all():
            raise InputError("boresight, lever arm and mirror factor must be finite numbers")
        if np.linalg.norm(self.antenna_b) > LONGEST_LEVER_ARM:
            raise InputError("the antenna is too far from the camera", allowed=f"up to {LONGEST_LEVER_ARM:g} m")
        if self.mirror_factor <= 0.0:
            raise InputError(f"mirror factor {self.mirror_factor:g}", allowed="above 0: 1 for angles of the sight")
        if self.boresight_on not in ("gimbal", "navigation"):
            raise InputError(f"boresight on {self.boresight_on!r}", allowed="gimbal, navigation")


@dataclass(frozen=True)
class Poses:
    """What the navigation system and the gimbal say of n exposures, each (n,).

    lat, lon: rad, and height: ellipsoidal, m, of the antenna; heading, pitch, roll: of b in n; alpha, beta: of the
    gimbal, rad.  A single value stands for all.
    Raises InputError, with the row: not finite, latitude beyond the poles, lengths that differ.
    """

    lat: Array
    lon: Array
    height: Array
    heading: Array
    pitch: Array
    roll: Array
    alpha: Array
    beta: Array
    count: int = field(init=False)

    def __post_init__(self) -> None:
        names = ("lat", "lon", "height", "heading", "pitch", "roll", "alpha", "beta")
        try:
            columns = np.broadcast_arrays(*(np.atleast_1d(np.asarray(getattr(self, k), float)) for k in names))
        except ValueError as error:
            raise InputError("the columns of the poses differ in length") from error
        for name, column in zip(names, columns, strict=True):
            if not np.isfinite(column).all():
                raise InputError(f"row {int(np.argmin(np.isfinite(column)))} is not a finite number", key=name)
            object.__setattr__(self, name, column)
        if (beyond := np.abs(self.lat) > np.pi / 2.0).any():
            raise InputError(
                f"row {int(np.argmax(beyond))} lies beyond a pole: {np.degrees(self.lat[beyond][0]):g} deg",
                key="lat",
                allowed="-90 to 90 deg; are latitude and longitude swapped?",
            )
        object.__setattr__(self, "count", len(self.lat))

    def rows(self, index: ArrayLike) -> Poses:
        """Some of the exposures.  index: as numpy's."""
        at = np.asarray(index)
        return Poses(*(getattr(self, name)[at] for name in self.__dataclass_fields__ if name != "count"))


class Rays(NamedTuple):
    """Lines of sight.  pos_e: (n, 3) projection centres, m; los_e: (n, 3) unit, tangent to the ray there."""

    pos_e: Array
    los_e: Array


def turn(axis: int, angle: ArrayLike, vector: Array) -> Array:
    """Vectors turned about x, y or z (0, 1, 2), active and right-handed.  angle: (n,) rad; vector: (n, 3)."""
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    s, c = np.sin(angle), np.cos(angle)
    out = np.empty(np.broadcast_shapes(vector.shape, (*np.shape(angle), 3)))
    out[..., axis] = vector[..., axis]
    out[..., i] = c * vector[..., i] - s * vector[..., j]
    out[..., j] = s * vector[..., i] + c * vector[..., j]
    return out


def e_from_n(lat: Array, lon: Array, vector_n: Array) -> Array:
    """Vectors from the local frames n at lat, lon (n,), rad, into e.  (n, 3)."""
    sp, cp, sl, cl = np.sin(lat), np.cos(lat), np.sin(lon), np.cos(lon)
    north, east, down = np.moveaxis(vector_n, -1, 0)
    out = -sp * north - cp * down
    return np.stack([out * cl - sl * east, out * sl + cl * east, cp * north - sp * down], axis=-1)


def n_from_e(lat: Array, lon: Array, vector_e: Array) -> Array:
    """The way back of `e_from_n`."""
    sp, cp, sl, cl = np.sin(lat), np.cos(lat), np.sin(lon), np.cos(lon)
    x, y, z = np.moveaxis(vector_e, -1, 0)
    out = x * cl + y * sl
    return np.stack([-sp * out + cp * z, cl * y - sl * x, -cp * out - sp * z], axis=-1)


def places(camera: ObliqueCamera) -> dict[str, int]:
    """Where in `turns` each angle stands, by its name in Poses or, with d_ before it, in Corrections."""
    first, second = (3, 0) if camera.boresight_on == "navigation" else (0, 3)
    attitude = {"heading": first, "pitch": first + 1, "roll": first + 2}
    boresight = {"d_yaw": second, "d_pitch": second + 1, "d_roll": second + 2}
    return {**attitude, **boresight, "alpha": 6, "d_alpha": 6, "beta": 8, "d_beta": 8, "d_tilt": 7, "d_twist": 10}


def turns(camera: ObliqueCamera, poses: Poses, corrections: Corrections = NO_CORRECTION) -> list[Turn]:
    """Rotations c to n, as axis and angle (rad), outermost first."""
    c, (yaw, pitch, roll) = corrections, camera.boresight
    attitude = [(2, poses.heading), (1, poses.pitch), (0, poses.roll)]
    boresight = [(2, yaw + c.yaw), (1, pitch + c.pitch), (0, roll + c.roll)]
    gimbal = [
        (0, poses.alpha + c.alpha),
        (2, c.tilt),
        (1, camera.mirror_factor * poses.beta + c.beta),
        (2, -c.tilt),
    ]
    order = boresight + attitude if camera.boresight_on == "navigation" else attitude + boresight
    return [(axis, np.asarray(angle, float)) for axis, angle in [*order, *gimbal, (2, c.twist)]]


def n_from_c(way: list[Turn], vector_c: Array) -> Array:
    """Vectors of c in n.  way: of `turns`."""
    for axis, angle in reversed(way):
        vector_c = turn(axis, angle, vector_c)
    return vector_c


def c_from_n(way: list[Turn], vector_n: Array) -> Array:
    """Vectors of n in c.  way: of `turns`."""
    for axis, angle in way:
        vector_n = turn(axis, -angle, vector_n)
    return vector_n


def axes_in_n(way: list[Turn], count: int) -> list[Array]:
    """Axes of the rotations of `turns` in n, (count, 3) each: a small turn by d moves los_n by d axis x los_n."""
    columns = [np.broadcast_to(axis, (count, 3)) for axis in np.eye(3)]
    found = []
    for axis, angle in way:
        found.append(columns[axis])
        _turn_columns(columns, axis, angle)
    return found


def axes_in_c(way: list[Turn], count: int) -> tuple[list[Array], Array]:
    """Axes of the rotations of `turns` in c, (count, 3) each, and the matrices n to c, (count, 3, 3)."""
    columns = [np.broadcast_to(axis, (count, 3)) for axis in np.eye(3)]
    found = []
    for axis, angle in reversed(way):
        found.append(columns[axis])
        _turn_columns(columns, axis, -angle)
    return found[::-1], np.stack(columns, axis=-1)


def _turn_columns(columns: list[Array], axis: int, angle: Array) -> None:
    """Columns of a matrix M become those of M R, R about an axis."""
    i, j = ((1, 2), (2, 0), (0, 1))[axis]
    s, c = np.sin(angle)[..., None], np.cos(angle)[..., None]
    columns[i], columns[j] = c * columns[i] + s * columns[j], c * columns[j] - s * columns[i]


def projection_centres(camera: ObliqueCamera, poses: Poses) -> Array:
    """Projection centres in e, (n, 3), m: the antenna's place less the lever arm."""
    arm = np.broadcast_to(np.asarray(camera.antenna_b, float), (poses.count, 3))
    for axis, angle in ((0, poses.roll), (1, poses.pitch), (2, poses.heading)):
        arm = turn(axis, angle, arm)
    return np.asarray(ecef_from_geodetic(poses.lat, poses.lon, poses.height) - e_from_n(poses.lat, poses.lon, arm))


def rays(camera: ObliqueCamera, poses: Poses, pixel: ArrayLike, corrections: Corrections = NO_CORRECTION) -> Rays:
    """Lines of sight of pixels.  pixel: (n, 2) row, column, px, one of each exposure.

    Raises InputError for pixels outside of the picture or not finite.
    """
    px = check_pixels(camera, pixel, poses.count)
    los_c = camera.optics.rays(px)
    los_n = n_from_c(turns(camera, poses, corrections), los_c / np.linalg.norm(los_c, axis=-1, keepdims=True))
    return Rays(projection_centres(camera, poses), e_from_n(poses.lat, poses.lon, los_n))


def pixels(
    camera: ObliqueCamera,
    poses: Poses,
    target_e: ArrayLike,
    corrections: Corrections = NO_CORRECTION,
    atmosphere: Atmosphere | None = Atmosphere.STANDARD,
) -> Array:
    """Where exposures show ground points: the way back of `rays`, through the same atmosphere.

    target_e: (n, 3), m.  atmosphere: None for straight rays.  Returns (n, 2) row, column, px, also outside of the
    picture; NaN for what is not in front of the camera.
    """
    los_e = apparent(projection_centres(camera, poses), np.asarray(target_e, float), atmosphere)
    los_n = n_from_e(poses.lat, poses.lon, los_e)
    return camera.optics.pixels(c_from_n(turns(camera, poses, corrections), los_n))


def check_pixels(camera: ObliqueCamera, pixel: ArrayLike, count: int) -> Array:
    """Pixels as (count, 2).  Raises InputError, with the row, for what is no pixel of this camera."""
    px = np.atleast_2d(np.asarray(pixel, float))
    if px.shape != (count, 2):
        raise InputError(f"pixels of shape {px.shape} for {count} exposures", allowed=f"({count}, 2)")
    last = np.array([camera.optics.rows, camera.optics.cols]) - 0.5
    good = ((px >= -0.5) & (px <= last)).all(axis=1)
    if not good.all():
        row = int(np.argmin(good))
        raise InputError(
            f"row {row}: pixel {px[row, 0]:g}, {px[row, 1]:g} is not of the picture",
            key="pixel",
            allowed=f"rows -0.5 to {last[0]:g}, columns -0.5 to {last[1]:g}",
        )
    return px
