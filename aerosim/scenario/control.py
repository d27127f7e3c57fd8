"""Section `control`: what turns the camera and sets the time between photos."""

from __future__ import annotations

import re
from difflib import get_close_matches
from typing import Annotated

from pydantic import AfterValidator, Field

from aerosim.scenario.available import AVAILABLE
from aerosim.scenario.navigator import SightNavigator
from aerosim.scenario.section import Section, wrong

MODES = ("fixed", "ideal", "navigator", "schmelovsky_1988", "pipelined", "best", "gnss_ins")


def _known_mode(mode: str) -> str:
    if mode in MODES or re.fullmatch(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*", mode):
        return mode
    modes = AVAILABLE.get("control.mode", (*MODES, "module:Class"))
    near = get_close_matches(mode, modes, 1)
    hint = f"; did you mean {near[0]}?" if near else ""
    raise wrong(f"unknown mode {mode!r}", f"allowed: {', '.join(modes)}{hint}")


class Control(Section):
    """The controller of camera yaw and frame interval."""

    mode: Annotated[str, AfterValidator(_known_mode)] = Field(
        default="pipelined", description=f"{', '.join(MODES)}, or module:Class"
    )
    navigator: SightNavigator = Field(
        default=SightNavigator(), description="who turns the camera in mode navigator"
    )
    end_lap_pct: float = Field(default=60.0, ge=0, le=95, description="wanted overlap of successive photos")
    fmc: bool = Field(default=True, description="forward-motion compensation by the measured v/h")
    yaw_lead_s: float | None = Field(
        default=0.0,
        ge=0,
        le=10,
        description="feed-forward of the gyro's yaw rate over this time; null: the mount's lag and delay; 0: none",
    )
    yaw_dead_band_deg: float = Field(
        default=0.0, ge=0, le=30, description="smaller changes of the yaw are not commanded"
    )
