"""Section `air`: steady wind, shear, slow wind, turbulence, single gusts."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from aerosim.scenario.section import Section


def _kind_of_wind(value: Any) -> str:
    profile = "profile" in value if isinstance(value, dict) else isinstance(value, WindProfile)
    return "<profile>" if profile else "<steady>"


class SteadyWind(Section):
    """The same wind everywhere."""

    speed_m_s: float = Field(default=0.0, ge=0, le=100, description="wind speed")
    from_deg: float = Field(default=0.0, ge=0, le=360, description="where it comes from, clockwise from north")


class WindLevel(Section):
    """Wind at one height."""

    height_m: float = Field(ge=-500, le=30000, description="ellipsoidal height of the level")
    speed_m_s: float = Field(ge=0, le=100, description="wind speed")
    from_deg: float = Field(ge=0, le=360, description="where it comes from, clockwise from north")


class WindProfile(Section):
    """Wind by height."""

    profile: tuple[WindLevel, ...] = Field(min_length=1, description="levels by rising height, linear between")


class Shear(Section):
    """Change of the steady wind with height."""

    exponent: float = Field(default=0.0, ge=0, le=1, description="of the power law of speed over height; 0: none")
    reference_agl_m: float = Field(
        default=3000.0, gt=0, le=20000, description="height above ground at which air.wind holds"
    )
    veer_deg_per_km: float = Field(
        default=0.0, ge=-90, le=90, description="turn of the wind with height; positive: clockwise upwards"
    )


class SlowWind(Section):
    """What makes drift wander: a Gauss-Markov wind, minutes long."""

    sigma_m_s: float = Field(default=0.0, ge=0, le=30, description="standard deviation of each level component")
    time_constant_s: float = Field(default=120.0, ge=1, le=36000, description="correlation time")


class Turbulence(Section):
    """Continuous turbulence."""

    model: Literal["dryden", "von_karman", "mil_f_8785c"] = Field(
        default="dryden", description="spectrum of the gusts"
    )
    sigma_m_s: float = Field(default=0.0, ge=0, le=20, description="standard deviation of u, v and w; 0: none")
    length_m: float = Field(default=533.4, ge=10, le=10000, description="scale length of u, v and w")


class Gust(Section):
    """One gust of 1-cosine shape."""

    start_s: float = Field(ge=0, description="start, after the start of the flight")
    duration_s: float = Field(gt=0, le=3600, description="from nothing to nothing")
    north_m_s: float = Field(default=0.0, ge=-50, le=50, description="peak of the air's velocity northwards")
    east_m_s: float = Field(default=0.0, ge=-50, le=50, description="peak eastwards")
    down_m_s: float = Field(default=0.0, ge=-50, le=50, description="peak downwards")


class Air(Section):
    """The air that the aircraft flies in."""

    wind: Annotated[
        Annotated[SteadyWind, Tag("<steady>")] | Annotated[WindProfile, Tag("<profile>")],
        Discriminator(_kind_of_wind),
    ] = Field(default=SteadyWind(), description="steady wind {speed_m_s, from_deg}, or {profile: [...]} by height")
    shear: Shear = Field(default=Shear(), description="change of the steady wind with height")
    slow_wind: SlowWind = Field(default=SlowWind(), description="wind that wanders within minutes")
    turbulence: Turbulence = Field(default=Turbulence(), description="continuous turbulence")
    gusts: tuple[Gust, ...] = Field(default=(), description="single gusts of 1-cosine shape")
