"""Section `flight.area`: an area to be covered by parallel lines."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from aerosim.scenario.section import Point, Section, wrong


def _kind_of_course(value: Any) -> str:
    return "<word>" if isinstance(value, str) else "<number>"


class Area(Section):
    """An area to be covered by parallel lines; the end lap is that of `control`."""

    corners_deg: tuple[Point, ...] | None = Field(
        default=None, min_length=3, description="corners in order around the area, each [latitude, longitude]"
    )
    file: str | None = Field(
        default=None, min_length=1, description="GeoJSON, KML or CSV with one polygon, instead of corners_deg"
    )
    course_deg: Annotated[
        Annotated[Literal["auto"], Tag("<word>")] | Annotated[float, Field(ge=0, le=360), Tag("<number>")],
        Discriminator(_kind_of_course),
    ] = Field(default="auto", description="of the lines in the area's middle; auto: the least number of lines")
    side_lap_pct: float = Field(
        default=30.0, ge=0, le=90, description="overlap of neighbouring lines over the area's mean ground"
    )
    side_lap_min_pct: float = Field(
        default=10.0, ge=0, le=90, description="nowhere less: lines lie nearer where the ground is high"
    )
    photos_beyond: int = Field(default=1, ge=0, le=20, description="photos before and after the area on each line")
    order: Literal["sequential", "race_track", "shortest"] = Field(
        default="sequential",
        description="there and back; leaving lines out so that turns need no loop; the quicker of both",
    )

    @model_validator(mode="after")
    def _fits(self) -> Area:
        if (self.corners_deg is None) == (self.file is None):
            raise wrong("needs corners_deg or file, and not both", "corners_deg: [[latitude, longitude], ...]")
        if self.side_lap_min_pct > self.side_lap_pct:
            raise wrong(
                f"{self.side_lap_min_pct:g} % is more than side_lap_pct",
                f"at most {self.side_lap_pct:g}",
                "side_lap_min_pct",
            )
        return self
