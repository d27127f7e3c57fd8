"""Section `aircraft`: which aircraft flies, and how finely time is cut."""

from __future__ import annotations

import os

from pydantic import Field

from aerosim.scenario.section import Section


def is_path(model: str) -> bool:
    """Whether a model is named by the path of its folder."""
    return "/" in model or os.sep in model


class Aircraft(Section):
    """The JSBSim aircraft."""

    model: str = Field(
        default="survey_twin",
        min_length=1,
        description="shipped aircraft by name, or the path of a folder with one (with a / in it)",
    )
    step_rate_hz: int = Field(
        default=120, ge=60, le=1000, description="steps a second of flight and loop; every period is whole steps"
    )
    fuel_kg: float | None = Field(
        default=None, ge=0, le=100000, description="fuel on board at the start; null: as the aircraft's limits say"
    )
