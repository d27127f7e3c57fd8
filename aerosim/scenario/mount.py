"""Section `mount`: what turns the camera against the airframe."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from aerosim.scenario.section import Section


class MountFaults(Section):
    """What is wrong with the mount, at times of the simulation."""

    stuck_from_s: float | None = Field(default=None, ge=0, description="from when it does not turn; null: never")
    stuck_until_s: float | None = Field(default=None, ge=0, description="until when; null: for good")
    encoder_bias_deg: float = Field(
        default=0.0, ge=-180, le=180, description="added to every yaw reading, clockwise"
    )


class Mount(Section):
    """The camera mount: one axis driven (yaw), levelled or not."""

    yaw_limit_deg: float = Field(default=30.0, gt=0, le=180, description="largest turn to either side")
    rate_limit_deg_s: float = Field(default=10.0, gt=0, le=360, description="fastest turn")
    time_constant_s: float = Field(default=0.1, ge=0, le=10, description="first-order lag of the drive; 0: none")
    delay_s: float = Field(default=0.05, ge=0, le=10, description="from the command to the start of the turn")
    encoder_sigma_deg: float = Field(
        default=0.02, ge=0, le=10, description="standard deviation of the yaw reading"
    )
    level: Literal["none", "static", "stabilised"] = Field(
        default="static",
        description="none: as the airframe; static: trim pitch taken out once; stabilised: levelled",
    )
    faults: MountFaults | None = Field(default=None, description="what is wrong with the mount; null: nothing")
