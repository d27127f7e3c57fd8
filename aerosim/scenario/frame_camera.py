"""Section `frame_camera`: the photo camera."""

from __future__ import annotations

from math import inf
from typing import Annotated

from pydantic import Field, model_validator

from aerosim.scenario.section import Section, wrong

Format = Annotated[float, Field(gt=0, le=1000)]


class FrameCamera(Section):
    """The frame camera, looking down."""

    focal_mm: float = Field(default=152.0, ge=5, le=5000, description="focal length")
    format_mm: tuple[Format, Format] = Field(
        default=(230.0, 230.0), description="picture: along, across the track"
    )
    pixel_um: float = Field(default=12.0, ge=0.5, le=1000, description="size of a picture's pixel")
    exposure_s: float = Field(default=0.003, gt=0, le=1, description="exposure time")
    min_interval_s: float = Field(default=2.0, gt=0, le=600, description="shortest time between two photos")
    shutter_delay_s: float = Field(
        default=0.05, ge=0, le=10, description="from the trigger to the exposure's start"
    )
    fmc_limit_mm_s: float | None = Field(
        default=64.0,
        ge=0,
        le=10000,
        description="fastest motion compensation, as motion of the film; null: no limit",
    )
    write: bool = Field(default=False, description="write the pictures (grey, 8 bits), not only their geometry")
    render_pixel_um: float | None = Field(
        default=None, ge=0.5, le=10000, description="pixel of the written pictures; null: pixel_um"
    )

    @property
    def fmc_limit(self) -> float:
        """Fastest motion compensation as an angular rate, rad/s."""
        return inf if self.fmc_limit_mm_s is None else self.fmc_limit_mm_s / self.focal_mm

    @model_validator(mode="after")
    def _can_be_built(self) -> FrameCamera:
        if max(self.format_mm) > 7 * self.focal_mm:
            widest = 7 * self.focal_mm
            raise wrong(
                f"{max(self.format_mm):g} mm before a focal length of {self.focal_mm:g} mm sees the horizon",
                f"at most {widest:g}",
                "format_mm",
            )
        if min(self.format_mm) * 1000 < 16 * self.pixel_um:
            raise wrong(
                "is wider than a sixteenth of the picture", f"at most {min(self.format_mm) * 62.5:g}", "pixel_um"
            )
        return self
