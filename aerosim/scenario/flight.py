"""Section `flight`: lines, height, speed, pilot."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from aerosim.scenario.section import Point, Section


class Line(Section):
    """One survey line."""

    start_deg: Point = Field(description="first point, [latitude, longitude], WGS-84")
    end_deg: Point = Field(description="last point, [latitude, longitude], WGS-84")


class Area(Section):
    """An area to be covered by parallel lines."""

    corners_deg: tuple[Point, ...] = Field(
        min_length=3, description="corners in order, each [latitude, longitude]"
    )
    side_lap_pct: float = Field(default=30.0, ge=0, le=90, description="overlap of neighbouring lines")


class Flight(Section):
    """The flight along the lines."""

    replay: str | None = Field(
        default=None, description="trajectory file to follow instead of flying; aircraft is unused"
    )
    height_m: float = Field(default=3000.0, gt=0, le=20000, description="flying height above `height_above`")
    height_above: Literal["mean_terrain", "ellipsoid"] = Field(
        default="mean_terrain", description="what height_m is above: the mean terrain under the lines, or WGS-84"
    )
    airspeed_m_s: float = Field(default=69.44, gt=0, le=400, description="true airspeed")
    run_in_s: float = Field(
        default=60.0, ge=0, le=1800, description="straight flight before each line's first point"
    )
    bank_max_deg: float = Field(default=20.0, ge=5, le=45, description="steepest bank in the turns")
    pilot: Literal["tracking", "navigator"] = Field(
        default="tracking",
        description="tracking: autopilot on the line; navigator: wind correction by word of mouth",
    )
    lines: tuple[Line, ...] = Field(min_length=1, description="survey lines in the order they are flown")
    area: Area | None = Field(default=None, description="area to be covered, instead of lines")
    file: str | None = Field(default=None, description="file with the lines, instead of lines")
