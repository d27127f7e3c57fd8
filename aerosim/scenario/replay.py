"""Section `flight.replay`: a trajectory file that is flown again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Discriminator, Field, Tag, model_validator

from aerosim.scenario.section import NotNegative, Point, Positive, Section, wrong

if TYPE_CHECKING:
    from aerosim.scenario.scenario import Scenario

# Keys that say how an aircraft is flown: none of it happens in a replay.
UNUSED = {
    "flight": ("height_m", "height_above", "airspeed_m_s", "bank_max_deg", "pilot", "navigator"),
    "aircraft": ("model", "fuel_kg"),
}


def kind_of(value: Any) -> str | None:
    """Tag of the union of null, a file name and a section."""
    if value is None:
        return "<null>"
    if isinstance(value, str):
        return "<word>"
    return "<section>" if isinstance(value, (dict, Section)) else None


class Replay(Section):
    """A trajectory file, and how it is flown again."""

    file: str = Field(min_length=1, description="trajectory, CSV or Parquet, relative to the scenario file")
    from_s: float | None = Field(default=None, description="part of the file to fly, in its own time; null: all")
    to_s: float | None = Field(default=None, description="end of that part; null: all")
    move_to_deg: Point | None = Field(
        default=None,
        description="[latitude, longitude] to which the path is carried: the start of its first straight part",
    )
    height_offset_m: float = Field(
        default=0.0,
        ge=-2000,
        le=2000,
        description="added to the file's heights; for barometric ones what the day's pressure makes of them",
    )
    gap_max_s: Annotated[float, Field(ge=1, le=600)] = Field(
        default=120.0, description="longest gap that is bridged; a longer one breaks the flight"
    )
    steady_deg: Annotated[float, Field(gt=0, le=20)] = Field(
        default=3.0, description="a straight part keeps its course within this; only without flight.lines"
    )
    line_min_m: Positive = Field(
        default=4000.0, description="straight and level parts of this length are lines; only without flight.lines"
    )
    pass_within_m: NotNegative = Field(
        default=300.0, description="a line of flight.lines is flown if the path stays this near to it"
    )
    angle_of_attack_deg: float = Field(
        default=0.0, ge=-10, le=20, description="pitch above the path through the air where the file has no pitch"
    )

    @model_validator(mode="after")
    def _in_order(self) -> Replay:
        if self.from_s is not None and self.to_s is not None and self.to_s <= self.from_s:
            raise wrong(f"{self.to_s:g} s is not after from_s", f"above {self.from_s:g}", "to_s")
        return self


# What `flight.replay` may be: null, a file's name, or the section.
ReplayOrFile = Annotated[
    Annotated[None, Tag("<null>")]
    | Annotated[str, Tag("<word>"), Field(min_length=1)]
    | Annotated[Replay, Tag("<section>")],
    Discriminator(
        kind_of,
        custom_error_type="aerosim",
        custom_error_message="wrong value",
        custom_error_context={
            "problems": (
                ("", "is neither a file nor a section", "allowed: a trajectory file, or {file: FILE, ...}"),
            )
        },
    ),
]


def unused(scenario: Scenario) -> list[tuple[str, str, str]]:
    """Keys beside flight.replay that would have no effect, unless they say what they say by default."""
    parts = [(name, getattr(scenario, name), key) for name, keys in UNUSED.items() for key in keys]
    return [
        (f"{name}.{key}", "has no effect beside flight.replay", "leave it out, or no replay")
        for name, part, key in parts
        if getattr(part, key) != type(part).model_fields[key].default
    ]
