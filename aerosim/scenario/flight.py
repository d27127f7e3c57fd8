"""Section `flight`: lines, height, speed, pilot."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from aerosim.scenario.area import Area
from aerosim.scenario.navigator import Navigator
from aerosim.scenario.replay import ReplayOrFile
from aerosim.scenario.section import Point, Section, wrong


class Line(Section):
    """One survey line."""

    start_deg: Point = Field(description="first point, [latitude, longitude], WGS-84")
    end_deg: Point = Field(description="last point, [latitude, longitude], WGS-84")


class Flight(Section):
    """The flight along the lines."""

    replay: ReplayOrFile = Field(
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
    navigator: Navigator = Field(default=Navigator(), description="the crew of pilot navigator")
    lines: tuple[Line, ...] | None = Field(
        default=None, min_length=1, description="survey lines in the order they are flown"
    )
    area: Area | None = Field(default=None, description="area to be covered by parallel lines, instead of lines")
    file: str | None = Field(
        default=None, min_length=1, description="GeoJSON, KML or CSV file with the lines, instead of lines"
    )

    @model_validator(mode="after")
    def _has_lines(self) -> Flight:
        given = [name for name in ("lines", "area", "file") if getattr(self, name) is not None]
        if not given and self.replay is None:
            raise wrong("has no lines", "lines, area or file", "lines")
        if self.area is not None and self.replay is not None:
            raise wrong("a replay covers no area", "lines that it flies, or nothing", "area")
        if len(given) > 1:
            raise wrong(f"is given besides {given[0]}", "one of lines, area and file", given[1])
        return self
