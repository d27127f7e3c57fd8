"""Section `aircraft`: which aircraft flies, and how finely time is cut."""

from __future__ import annotations

from pydantic import Field

from aerosim.scenario.section import Section


class Aircraft(Section):
    """The JSBSim aircraft."""

    model: str = Field(default="survey_twin", min_length=1, description="shipped aircraft, by name")
    step_rate_hz: int = Field(
        default=120, ge=60, le=1000, description="steps a second of flight and loop; every period is whole steps"
    )
    fuel_kg: float = Field(default=540.0, ge=0, le=100000, description="fuel on board at the start")
