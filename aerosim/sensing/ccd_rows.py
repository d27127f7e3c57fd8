"""The two CCD rows: row I looks ahead, row II behind, both across the flight (the 1988 camera, Fig. 1 and 2)."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from aerosim.frames import Array, LocalMap
from aerosim.sensing.row_kernel import convert, radiance
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


Grid5 = tuple[Grey, float, float, float, float]


class Ground(Protocol):
    """The terrain as the rows need it: windows around a place, in the map grid."""

    def windows(self, easting: float, northing: float, reach: float) -> tuple[Grid5, Grid5]:
        """Orthophoto (grey) and ellipsoidal elevation covering +-reach (m) around a point (m): values,
        easting and northing of the first cell, steps."""


class CcdRows:
    """Both rows of one camera; `expose` gives what the converter reads."""

    def __init__(
        self,
        parameters: RowParameters,
        ground: Ground,
        local: LocalMap,
        start_height: float,
        rng: np.random.Generator,
    ) -> None:
        """local: map grid around the flight.  start_height: of the ground, ellipsoidal, m (first guess)."""
        par = parameters
        self._par = par
        self._ground = ground
        self._local = local
        self._rng = rng
        self._height = start_height
        self._full = float(2**par.bits - 1)
        self._sensitivity = self._full / 255.0 / REFERENCE_EXPOSURE
        self._exposure = par.exposure or REFERENCE_EXPOSURE
        self._find_exposure = par.exposure is None
        self._sizes = (par.pixels + 2 * par.max_shift, par.pixels)
        self._noise = np.empty((0, sum(self._sizes)), np.float32)
        self._mean = 0.0
        self._number = 0
        # the widest ray, and 30 deg of attitude on top: what a window must cover, per metre above the ground
        half_view = np.hypot(self._sizes[0] / 2.0 + 2.0, par.spacing_px / 2.0 + 2.0) / par.focal_px
        self._reach = float(np.tan(np.arctan(half_view) + np.radians(15.0)))

    def new_cycle(self) -> None:
        """Find the exposure time anew from the brightness last seen; it then holds for both rows."""
        if self._find_exposure and self._mean > 0.0:
            wanted = TARGET_GREY * self._full / (self._sensitivity * self._mean)
            self._exposure = float(np.clip(wanted, *EXPOSURE_RANGE))

    def expose(self, pose: CameraPose) -> RowExposure:
        """Both rows around the time of the pose.  Pixels without terrain read 0 and are counted."""
        par = self._par
        grid = np.array(self._local(pose.lat, pose.lon))
        reach = self._reach * max(pose.height - self._height + 500.0, 100.0)
        ortho, relief = self._ground.windows(grid[0], grid[1], reach)
        light = (np.empty(self._sizes[0]), np.empty(self._sizes[1]))
        for row, ahead in zip(light, (par.spacing_px / 2.0, -par.spacing_px / 2.0), strict=True):
            mean_height = radiance(
                row, ahead, par.focal_px, par.smear_along_px, par.smear_across_px, self._exposure,
                pose.height, pose.mat_nc, pose.vel_n, pose.omega_nc_c, grid, *ortho, *relief, self._height,
            )  # fmt: skip
            if np.isfinite(mean_height):
                self._height = mean_height
        return self._read(pose.t, light)

    def _read(self, t: float, light: tuple[Array, Array]) -> RowExposure:
        par = self._par
        k = self._number % NOISE_BLOCK
        if k == 0:
            self._noise = self._rng.standard_normal((NOISE_BLOCK, sum(self._sizes)), dtype=np.float32)
        noise = self._noise[k]
        gain = self._sensitivity * self._exposure
        rows = (np.empty(self._sizes[0], np.float32), np.empty(self._sizes[1], np.float32))
        # the dark level is common at the start; the second row's drifts against the first's
        missing = convert(light[0], gain, 0.0, noise[: self._sizes[0]], par.noise_grey, self._full, rows[0])
        dark = par.dark_drift_grey_per_s * t
        missing += convert(light[1], gain, dark, noise[self._sizes[0] :], par.noise_grey, self._full, rows[1])
        if missing == 0:
            self._mean = float(light[0].mean())
        exposure = RowExposure(self._number, t, rows[0], rows[1], self._exposure, missing)
        self._number += 1
        return exposure
