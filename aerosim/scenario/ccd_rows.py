"""Section `ccd_rows`: the two sensor rows that see the track."""

from __future__ import annotations

from math import hypot
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from aerosim.scenario.section import NotNegativeInt, Section, wrong


def _kind_of_exposure(value: Any) -> str:
    return "<word>" if isinstance(value, str) else "<number>"


class RowFaults(Section):
    """What is wrong with the rows, at times of the simulation."""

    gain_step_pct: float = Field(
        default=0.0, gt=-100, le=1000, description="sudden change of the gain of both rows; 0: none"
    )
    gain_step_at_s: float = Field(default=0.0, ge=0, description="time of that change")
    dead_px: tuple[NotNegativeInt, ...] = Field(
        default=(), description="pixels of row II that read 0, from 0 on the left"
    )
    blind_row: Literal["none", "row1", "row2"] = Field(default="none", description="row that reads 0")
    blind_from_s: float = Field(default=0.0, ge=0, description="from when")
    blind_until_s: float | None = Field(default=None, ge=0, description="until when; null: for good")


class CcdRows(Section):
    """Two CCD rows across the track: row I looks ahead, row II behind."""

    mounted_on: Literal["camera", "airframe"] = Field(
        default="camera", description="camera: the rows turn with it and see crab; airframe: they see drift"
    )
    period_s: float = Field(default=0.05, gt=0, le=10, description="time between exposures")
    spacing_px: float = Field(default=39.7, gt=0, le=100000, description="row I ahead of row II in the image")
    focal_px: float = Field(default=132.6, gt=0, le=1000000, description="focal length")
    pixels_px: int = Field(
        default=96, ge=8, le=4096, description="length of row II; row I is longer by 2 max_shift_px"
    )
    max_shift_px: int = Field(default=7, ge=1, le=512, description="largest shift searched to either side")
    extension: Literal["imaged", "padded"] = Field(
        default="imaged", description="row I's extra pixels: imaged ground, or padding that cannot correlate"
    )
    smear_along_px: float = Field(default=1.0, ge=0, le=100, description="optical smear along the track; 0: none")
    smear_across_px: float = Field(
        default=1.0, ge=0, le=100, description="optical smear across the track; 0: none"
    )
    exposure_s: Annotated[
        Annotated[Literal["auto"], Tag("<word>")] | Annotated[float, Field(gt=0, le=10), Tag("<number>")],
        Discriminator(_kind_of_exposure),
    ] = Field(default="auto", description="auto: found anew each cycle and kept for both rows; or a fixed time")
    noise_grey: float = Field(default=1.5, ge=0, le=1000, description="standard deviation of the noise of a pixel")
    dark_drift_grey_per_s: float = Field(
        default=0.0, ge=-100, le=100, description="growth of the dark level; positive: brighter with time"
    )
    gain_difference_pct: float = Field(
        default=0.0, gt=-100, le=1000, description="gain of row II against that of row I"
    )
    distortion: float = Field(
        default=0.0,
        ge=-1,
        le=1,
        description="k1 of the optics: image radius = ideal one (1 + k1 r^2), r its part of focal_px",
    )
    bits: int = Field(default=8, ge=2, le=16, description="of the converter: grey levels 0 to 2^bits - 1")
    faults: RowFaults | None = Field(default=None, description="what is wrong with the rows; null: nothing")

    @model_validator(mode="after")
    def _fits(self) -> CcdRows:
        if isinstance(self.exposure_s, float) and self.exposure_s > self.period_s:
            raise wrong(
                f"{self.exposure_s:g} s is longer than period_s", f"at most {self.period_s:g}", "exposure_s"
            )
        if 2 * self.max_shift_px >= self.pixels_px:
            raise wrong(
                f"{self.max_shift_px} is too much for rows of {self.pixels_px} px",
                f"less than {(self.pixels_px + 1) // 2}",
                "max_shift_px",
            )
        if self.faults and (beyond := [px for px in self.faults.dead_px if px >= self.pixels_px]):
            raise wrong(f"row II has no pixel {beyond[0]}", f"0 to {self.pixels_px - 1}", "faults.dead_px")
        if self.distortion < self.least_distortion:
            problem = f"{self.distortion:g} folds the picture at the rows' ends"
            raise wrong(problem, f"at least {self.least_distortion:.3g}", "distortion")
        return self

    @property
    def least_distortion(self) -> float:
        """k1 at which the picture begins to fold at the rows' ends."""
        furthest = hypot(self.pixels_px / 2 + self.max_shift_px, self.spacing_px / 2) / self.focal_px
        return -4.0 / (27.0 * furthest**2)
