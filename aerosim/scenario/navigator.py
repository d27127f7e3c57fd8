"""Sections `flight.navigator` and `control.navigator`: crews who work by eye and word of mouth."""

from __future__ import annotations

from pydantic import Field

from aerosim.scenario.section import Section


class Looks(Section):
    """How a navigator looks through his sight and speaks."""

    look_s: float = Field(default=16.0, gt=0, le=600, description="mean time between looks through the sight")
    look_scatter_pct: float = Field(
        default=30.0, ge=0, le=100, description="standard deviation of that time, of its mean"
    )
    settle_s: float = Field(default=10.0, ge=0, le=600, description="longer wait after a correction")
    track_sigma_deg: float = Field(default=0.7, ge=0, le=20, description="error of a look: angle of the track")
    average_s: float = Field(default=5.0, gt=0, le=60, description="time over which a look takes the track")
    least_deg: int = Field(default=2, ge=1, le=10, description="smallest correction that is spoken, whole degrees")
    reaction_s: float = Field(default=3.0, ge=0, le=60, description="from the word to the hand")


class Navigator(Looks):
    """Crew of `pilot: navigator`.

    Chosen so that lines of 12 km at 250 km/h take three to four corrections of 2 to 3 deg (Schmelovsky 1988) in a
    wind that wanders by 1.5 m/s in 120 s.
    """

    offset_sigma_m: float = Field(
        default=25.0, ge=0, le=2000, description="error of a look: distance off the line"
    )
    closing_m: float = Field(
        default=4000.0, ge=500, le=1e6, description="distance ahead at which the line is to be met again"
    )
    hold_sigma_deg: float = Field(
        default=0.5, ge=0, le=10, description="wander of the heading that the pilot holds, standard deviation"
    )
    hold_time_s: float = Field(default=20.0, gt=0, le=600, description="time constant of that wander")


class SightNavigator(Looks):
    """The navigator of `control.mode: navigator`, who turns the camera and sets the time between photos.

    Chosen, as those of `flight.navigator`, so that lines of 12 km at 250 km/h take three to four corrections of 2
    to 3 deg in a wind that wanders by 1.5 m/s in 120 s.
    """

    settle_s: float = Field(default=5.0, ge=0, le=600, description="longer wait after a correction")
    track_sigma_deg: float = Field(default=1.0, ge=0, le=20, description="error of a look: angle of the track")
    vh_sigma_pct: float = Field(default=3.0, ge=0, le=50, description="error of one reading of v/h over the grid")
    vh_weight_pct: float = Field(
        default=50.0, gt=0, le=100, description="weight of a new reading of v/h against what is set"
    )
