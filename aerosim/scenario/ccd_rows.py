"""Section `ccd_rows`: the two sensor rows that see the track."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from aerosim.scenario.section import Section, wrong


def _kind_of_exposure(value: Any) -> str:
    return "<word>" if isinstance(value, str) else "<number>"


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
    bits: int = Field(default=8, ge=2, le=16, description="of the converter: grey levels 0 to 2^bits - 1")

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
        return self
