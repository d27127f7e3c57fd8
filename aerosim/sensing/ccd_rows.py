"""The two CCD rows: row I looks ahead, row II behind, both across the flight (the 1988 camera, Fig. 1 and 2)."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from aerosim.frames import Array
from aerosim.sensing.row_kernel import expose_row
from aerosim.signals import Grey, RowExposure
from aerosim.truth import CameraPose

NOISE_BLOCK = 512
TARGET_GREY = 110.0 / 255.0  # automatic exposure brings the mean of a row here, as a share of full scale
REFERENCE_EXPOSURE = 0.01  # s; at this exposure a grey level of the orthophoto is one of 8 bits
EXPOSURE_RANGE = (0.001, 0.02)  # s
NEWTON = 30  # steps: also for optics that are about to fold at the rows' ends


class RowParameters(NamedTuple):
    """Optics and electronics of the rows.  px, s, grey levels.  exposure None: found anew each cycle.

    gain_difference: of row II against row I, as a part.  distortion: k1, see `pixel_rays`.
    """

    pixels: int
    max_shift: int
    spacing_px: float
    focal_px: float
    smear_along_px: float
    smear_across_px: float
    exposure: float | None
    noise_grey: float
    dark_drift_grey_per_s: float
    bits: int
    gain_difference: float = 0.0
    distortion: float = 0.0


def pixel_rays(parameters: RowParameters) -> tuple[Array, Array]:
    """Where the pixels of row I and of row II would lie in an image without distortion, px.

    Each (2, pixels): x ahead, y to the right.  The optics bring a point at the ideal radius r f from the middle to
    r f (1 + k1 r^2), Brown's first radial term; a pixel looks at the point whose image falls on it.
    """
    par = parameters
    out = []
    for pixels, ahead in ((par.pixels + 2 * par.max_shift, 0.5), (par.pixels, -0.5)):
        y = np.arange(pixels) - (pixels - 1) / 2.0
        image = np.stack([np.full(pixels, ahead * par.spacing_px), y])
        seen = np.hypot(*image) / par.focal_px
        ideal = seen.copy()
        for _ in range(NEWTON if par.distortion else 0):
            square = par.distortion * ideal**2
            ideal -= (ideal * (1.0 + square) - seen) / (1.0 + 3.0 * square)
        out.append(np.ascontiguousarray(image * (ideal / np.where(seen > 0.0, seen, 1.0))))
    return out[0], out[1]


class Spot(Protocol):
    """The ground around the camera, as `world.ground.Spot` has it."""

    @property
    def grid(self) -> Array:
        """Easting, northing and the map's Jacobian, (6,)."""

    @property
    def ortho(self) -> Grey:
        """Grey values of the orthophoto's window."""

    @property
    def ortho_place(self) -> Array:
        """Easting and northing of its first cell and its steps, (4,), m."""

    @property
    def relief(self) -> Grey:
        """Ellipsoidal heights of the elevation's window, m."""

    @property
    def relief_place(self) -> Array:
        """Easting and northing of its first cell and its steps, (4,), m."""

    @property
    def shade(self) -> Grey | None:
        """What the light is multiplied by, a window that repeats itself; None: no shadows."""

    @property
    def shade_place(self) -> Array | None:
        """Easting and northing of its first cell, its steps, m, and the least light, (5,)."""


class CcdRows:
    """Both rows of one camera; `expose` gives what the converter reads."""

    def __init__(self, parameters: RowParameters, start_height: float, rng: np.random.Generator) -> None:
        """start_height: of the ground, ellipsoidal, m (first guess)."""
        par = self._par = parameters
        self._rng = rng
        self._full = float(2**par.bits - 1)
        self._sensitivity = self._full / 255.0 / REFERENCE_EXPOSURE
        self._exposure = par.exposure or REFERENCE_EXPOSURE
        self._find_exposure = par.exposure is None
        self._sizes = (par.pixels + 2 * par.max_shift, par.pixels)
        self._noise = np.empty((0, sum(self._sizes)), np.float32)
        self._light = np.nan
        self._number = 0
        # the widest ray, and 15 deg of attitude on top: what the ground must cover, per metre above it
        wide, long = self._sizes[0] + par.smear_across_px, par.spacing_px + par.smear_along_px
        self._rays = pixel_rays(par)
        stretch = max(self._rays[0][1, -1] / ((self._sizes[0] - 1) / 2.0), 1.0)
        half_view = stretch * np.hypot(wide / 2.0 + 2.0, long / 2.0 + 2.0) / par.focal_px
        self._reach = float(np.tan(np.arctan(half_view) + np.radians(15.0)))
        self._height = start_height
        self._optics = np.array([par.focal_px, par.smear_along_px, par.smear_across_px, self._exposure])
        # grey per radiance, dark level, noise, full scale of either row
        self._converters = [np.array([0.0, 0.0, par.noise_grey, self._full]) for _ in self._sizes]
        self._amplify(1.0)
        self._blind = np.zeros(self._sizes[0], np.float32)

    def reach(self, height: float) -> float:
        """How far around the nadir the rows may look from an ellipsoidal height, m."""
        return self._reach * max(height - self._height + 500.0, 100.0)

    def _amplify(self, factor: float) -> None:
        """Set the gain of both rows, 1 for a sound amplifier."""
        self._gains = factor, factor * (1.0 + self._par.gain_difference)
        self._convert()

    def _convert(self) -> None:
        """Grey per radiance of both rows, at their gain and exposure time."""
        for converter, gain in zip(self._converters, self._gains, strict=True):
            converter[0] = self._sensitivity * self._exposure * gain

    def new_cycle(self) -> None:
        """Find the exposure time anew from the brightness last seen; it then holds for both rows."""
        if self._find_exposure and self._light > 0.0:
            wanted = TARGET_GREY * self._full / (self._sensitivity * self._light)
            self._exposure = min(max(wanted, EXPOSURE_RANGE[0]), EXPOSURE_RANGE[1])
            self._optics[3] = self._exposure
            self._convert()

    def expose(self, pose: CameraPose, spot: Spot, ahead: bool = True) -> RowExposure:
        """Row II around the time of the pose, and row I too if `ahead`; else row I reads zeros.

        Pixels without terrain read 0 and are counted.
        """
        par, k = self._par, self._number % NOISE_BLOCK
        if k == 0:
            self._noise = self._rng.standard_normal((NOISE_BLOCK, sum(self._sizes)), dtype=np.float32)
        noise, split = self._noise[k], self._sizes[0]
        row1, missing = self._blind, 0
        if ahead:
            row1 = np.empty(split, np.float32)
            missing = self._read(0, row1, noise[:split], pose, spot)
        # the dark level of the second row drifts against that of the first
        self._converters[1][1] = par.dark_drift_grey_per_s * pose.t
        row2 = np.empty(self._sizes[1], np.float32)
        missing += self._read(1, row2, noise[split:], pose, spot)
        self._number += 1
        return RowExposure(self._number - 1, pose.t, row1, row2, self._exposure, missing)

    def _read(self, row: int, grey: Grey, noise: Grey, pose: CameraPose, spot: Spot) -> int:
        height, light, missing = expose_row(
            grey, noise, self._rays[row], self._optics, self._converters[row], pose.height, pose.mat_nc,
            pose.vel_n, pose.omega_nc_c, spot.grid, spot.ortho, spot.ortho_place, spot.relief, spot.relief_place,
            self._height, spot.shade, spot.shade_place,
        )  # fmt: skip
        if missing == 0 and row == 1:
            self._height, self._light = height, light * self._gains[1]
        return int(missing)
