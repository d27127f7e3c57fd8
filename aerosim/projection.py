"""Pinhole camera: pixel to ray and ray to pixel (frame c).  The only projection code."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.frames import Array


@dataclass(frozen=True)
class Camera:
    """Ideal frame camera.  Row 0 is the front edge, columns grow to starboard.

    focal_px: principal distance, px; rows, cols: size of the picture; row0, col0: principal point, px, by default
    the middle of the picture, (rows - 1) / 2 and (cols - 1) / 2.
    Raises InputError for a camera without focal length or picture.
    """

    focal_px: float
    rows: int
    cols: int
    row0: float = np.nan
    col0: float = np.nan

    def __post_init__(self) -> None:
        if not (np.isfinite(self.focal_px) and self.focal_px > 0.0):
            raise InputError(f"camera with a focal length of {self.focal_px:g} px", allowed="above 0")
        if self.rows < 1 or self.cols < 1:
            raise InputError(f"camera with {self.rows} x {self.cols} pixels", allowed="1 or more each way")
        if np.isnan(self.row0):
            object.__setattr__(self, "row0", (self.rows - 1) / 2.0)
        if np.isnan(self.col0):
            object.__setattr__(self, "col0", (self.cols - 1) / 2.0)

    @classmethod
    def of_frame(cls, focal: float, frame: tuple[float, float], pixel: float) -> Camera:
        """Camera of a film or sensor.  focal, frame (along, across the track), pixel: m.  Whole pixels."""
        return cls(focal / pixel, max(1, round(frame[0] / pixel)), max(1, round(frame[1] / pixel)))

    @property
    def centre(self) -> Array:
        """Row and column of the picture's middle, px.  (2,)."""
        return np.array([(self.rows - 1) / 2.0, (self.cols - 1) / 2.0])

    @property
    def corners(self) -> Array:
        """Outer corners, half a pixel outside of the corner pixels' centres, px.

        (4, 2) row, column: front left, front right, rear right, rear left.
        """
        front, rear, left, right = -0.5, self.rows - 0.5, -0.5, self.cols - 0.5
        return np.array([[front, left], [front, right], [rear, right], [rear, left]])

    def rays(self, pixel: ArrayLike) -> Array:
        """Rays to what pixels show.  pixel: (..., 2) row, column, px.

        Returns los_c (..., 3) with z_c = focal_px: x_c = row0 - row, y_c = column - col0.
        """
        px = np.asarray(pixel, float)
        row, col = px[..., 0], px[..., 1]
        return np.stack([self.row0 - row, col - self.col0, np.full(row.shape, float(self.focal_px))], axis=-1)

    def pixels(self, los_c: ArrayLike) -> Array:
        """Where rays of any length meet the picture's plane.  los_c: (..., 3).

        Returns (..., 2) row, column, px, also outside of the picture; NaN for what is not in front of the camera.
        """
        los = np.asarray(los_c, float)
        ahead = np.where(los[..., 2] > 0.0, los[..., 2], np.nan)
        scale = self.focal_px / ahead
        return np.stack([self.row0 - los[..., 0] * scale, self.col0 + los[..., 1] * scale], axis=-1)
