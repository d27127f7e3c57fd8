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


class RowParameters(NamedTuple):
    """Optics and electronics of the rows.  px, s, grey levels.  exposure None: found anew each cycle."""

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
        half_view = np.hypot(wide / 2.0 + 2.0, long / 2.0 + 2.0) / par.focal_px
        self._reach = float(np.tan(np.arctan(half_view) + np.radians(15.0)))
        self._height = start_height
        self._optics = np.array([par.focal_px, par.smear_along_px, par.smear_across_px, self._exposure])
        self._converter = np.array([self._sensitivity * self._exposure, 0.0, par.noise_grey, self._full])
        self._blind = np.zeros(self._sizes[0], np.float32)

    def reach(self, height: float) -> float:
        """How far around the nadir the rows may look from an ellipsoidal height, m."""
        return self._reach * max(height - self._height + 500.0, 100.0)

    def new_cycle(self) -> None:
        """Find the exposure time anew from the brightness last seen; it then holds for both rows."""
        if self._find_exposure and self._light > 0.0:
            wanted = TARGET_GREY * self._full / (self._sensitivity * self._light)
            self._exposure = min(max(wanted, EXPOSURE_RANGE[0]), EXPOSURE_RANGE[1])
            self._optics[3] = self._exposure
            self._converter[0] = self._sensitivity * self._exposure

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
            self._converter[1] = 0.0
            missing = self._read(row1, noise[:split], par.spacing_px / 2.0, pose, spot)
        # the dark level of the second row drifts against that of the first
        self._converter[1] = par.dark_drift_grey_per_s * pose.t
        row2 = np.empty(self._sizes[1], np.float32)
        missing += self._read(row2, noise[split:], -par.spacing_px / 2.0, pose, spot)
        self._number += 1
        return RowExposure(self._number - 1, pose.t, row1, row2, self._exposure, missing)

    def _read(self, grey: Grey, noise: Grey, ahead: float, pose: CameraPose, spot: Spot) -> int:
        height, light, missing = expose_row(
            grey, noise, ahead, self._optics, self._converter, pose.height, pose.mat_nc, pose.vel_n,
            pose.omega_nc_c, spot.grid, spot.ortho, spot.ortho_place, spot.relief, spot.relief_place, self._height,
        )  # fmt: skip
        if missing == 0 and ahead < 0.0:
            self._height, self._light = height, light
        return int(missing)
