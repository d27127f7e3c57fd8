"""The whole scenario, and where each of its keys was written."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import ConfigDict, Field, PrivateAttr, model_validator
from pydantic_core import PydanticCustomError

from aerosim.errors import InputError
from aerosim.scenario.aiding import unaided
from aerosim.scenario.air import Air
from aerosim.scenario.aircraft import Aircraft
from aerosim.scenario.available import unavailable
from aerosim.scenario.ccd_rows import CcdRows
from aerosim.scenario.checks import problems
from aerosim.scenario.control import Control
from aerosim.scenario.estimation import Estimation
from aerosim.scenario.expect import Expect
from aerosim.scenario.flight import Flight
from aerosim.scenario.frame_camera import FrameCamera
from aerosim.scenario.mount import Mount
from aerosim.scenario.navigation import Navigation
from aerosim.scenario.places import Places
from aerosim.scenario.presets import with_mode_defaults
from aerosim.scenario.record import Record
from aerosim.scenario.section import Section
from aerosim.scenario.terrain import Terrain


class Scenario(Section):
    """One photo mission: everything that a run needs, every default filled in."""

    model_config = ConfigDict(title="aerosim scenario")

    schema_version: Literal[1] = Field(default=1, alias="schema", description="version of this file's layout")
    name: str = Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$",
        description="letters, digits, _ . -; the run directory is named after it",
    )
    purpose: str = Field(default="", description="one sentence; shown by `aerosim list`")
    verifies: tuple[str, ...] = Field(default=(), description="what an expert learns from it")
    seed: int = Field(default=1, ge=0, le=2**53, description="of all random numbers; the same seed, the same run")
    terrain: Terrain = Field(description="which land is flown over")
    air: Air = Field(default=Air(), description="wind and turbulence")
    aircraft: Aircraft = Field(default=Aircraft(), description="the JSBSim aircraft")
    flight: Flight = Field(description="lines, height, speed, pilot")
    mount: Mount = Field(default=Mount(), description="what turns the camera against the airframe")
    ccd_rows: CcdRows = Field(default=CcdRows(), description="the two sensor rows that see the track")
    estimation: Estimation = Field(default=Estimation(), description="matching of strips and filters")
    control: Control = Field(default=Control(), description="camera yaw and time between photos")
    frame_camera: FrameCamera = Field(default=FrameCamera(), description="the photo camera")
    navigation: Navigation | None = Field(default=None, description="satellite and inertial devices; null: none")
    record: Record = Field(default=Record(), description="what is kept of a run")
    expect: Expect = Field(default={}, description="path in summary.json: {min: , max: }; not measured fails")

    _places: Places = PrivateAttr(default_factory=Places)
    # as read, before any default: what a change of control.mode starts from
    _given: dict[str, Any] = PrivateAttr(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _mode_defaults(cls, data: Any) -> Any:
        return with_mode_defaults(data)

    @model_validator(mode="after")
    def _fits_together(self) -> Scenario:
        found = unavailable(self) + problems(self) + unaided(self)
        if found:
            raise PydanticCustomError("aerosim", "wrong value", {"problems": tuple(found)})
        return self

    def __eq__(self, other: object) -> bool:
        """Equal contents; where they were read from makes no difference."""
        return isinstance(other, Scenario) and self.__dict__ == other.__dict__

    __hash__ = None  # type: ignore[assignment]

    def where(self, key: str) -> str:
        """Place of a dotted key as ``file:line``: the nearest section written there, "" if made in Python."""
        return self._places.where(key)

    def error(self, key: str, problem: str, allowed: str = "") -> InputError:
        """Error about a key of this scenario, pointing at its place in the file or at its ``--set``."""
        return self._places.error(key, problem, allowed)

    def place(self, error: InputError, key: str = "") -> InputError:
        """The same error with the place of its key (or of `key`, if it has none) filled in."""
        if error.where:
            return error
        return self._places.error(error.key or key, error.problem, error.allowed)
