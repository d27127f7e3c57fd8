"""Section `air`: mean wind, shear, slow wind, turbulence, single gusts, thermals."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from aerosim.scenario.section import Point, Section, wrong

FREE_ATMOSPHERE_M_S = 2.8
"""Root mean square difference of the wind over 100 km, from 3.6e-3 r^(2/3) m^2/s^2."""


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

    profile: tuple[WindLevel, ...] = Field(
        min_length=1, description="levels by rising height; north and east linear between, constant outside"
    )

    @model_validator(mode="before")
    @classmethod
    def _is_no_steady_wind(cls, value: Any) -> Any:
        for key in ("speed_m_s", "from_deg"):
            if isinstance(value, dict) and key in value:
                raise wrong("is given besides profile", "speed_m_s and from_deg, or profile", key)
        return value

    @model_validator(mode="after")
    def _rises(self) -> WindProfile:
        for index, (below, above) in enumerate(pairwise(self.profile), start=1):
            if not below.height_m < above.height_m:
                raise wrong(
                    f"{above.height_m:g} m is not above the level before it",
                    f"more than {below.height_m:g}",
                    f"profile.{index}.height_m",
                )
        return self


class Shear(Section):
    """Change of the steady wind with height."""

    exponent: float = Field(default=0.0, ge=0, le=1, description="of the power law of speed over height; 0: none")
    reference_agl_m: float = Field(
        default=3000.0, gt=0, le=20000, description="height above ground at which air.wind holds"
    )
    veer_deg_per_km: float = Field(
        default=0.0, ge=-90, le=90, description="turn of the wind with height; positive: clockwise upwards"
    )


def _refuse_others(section: Section, model: str, keys: tuple[str, ...]) -> None:
    """Keys of another model must stand at their defaults, where a resolved scenario has them."""
    for key in keys:
        if getattr(section, key) != type(section).model_fields[key].default:
            raise wrong(f"does not belong to model {model}", "another model, or leave it out", key)


class SlowWind(Section):
    """What makes drift wander: a wind that changes within minutes, or over kilometres."""

    model: Literal["gauss_markov", "mesoscale"] = Field(
        default="gauss_markov",
        description="gauss_markov: by time; mesoscale: a k^(-5/3) field that is flown through",
    )
    sigma_m_s: float = Field(default=0.0, ge=0, le=30, description="standard deviation of each level component")
    time_constant_s: float = Field(default=120.0, ge=1, le=36000, description="correlation time")
    change_100km_m_s: float = Field(
        default=FREE_ATMOSPHERE_M_S, gt=0, le=30, description="mesoscale: rms difference of the wind over 100 km"
    )
    longest_km: float = Field(default=400.0, ge=10, le=2000, description="mesoscale: longest wavelength")
    shortest_km: float = Field(default=1.0, ge=0.2, le=100, description="mesoscale: shortest wavelength")

    @model_validator(mode="after")
    def _fits(self) -> SlowWind:
        if self.model == "mesoscale":
            _refuse_others(self, self.model, ("sigma_m_s", "time_constant_s"))
        else:
            _refuse_others(self, self.model, ("change_100km_m_s", "longest_km", "shortest_km"))
        if not self.shortest_km < self.longest_km:
            raise wrong(f"{self.longest_km:g} km is too short", f"more than {self.shortest_km:g}", "longest_km")
        return self


class Turbulence(Section):
    """Continuous turbulence."""

    model: Literal["dryden", "von_karman", "mil_f_8785c"] = Field(
        default="dryden",
        description="spectrum of the gusts; mil_f_8785c: their sigma and length by that standard's rules",
    )
    sigma_m_s: float = Field(default=0.0, ge=0, le=20, description="standard deviation of u, v and w; 0: none")
    length_m: float = Field(
        default=533.4,
        ge=10,
        le=10000,
        description="scale length of u, v and w; the standard's are 533.4 for dryden and 762 for von_karman",
    )
    severity: Literal["light", "moderate", "severe"] | None = Field(
        default=None, description="mil_f_8785c: sets exceedance and wind_20ft_m_s where they are not given"
    )
    exceedance: float | None = Field(
        default=None, ge=1e-6, le=0.2, description="mil_f_8785c: probability that sigma is exceeded at this height"
    )
    wind_20ft_m_s: float | None = Field(
        default=None,
        ge=0,
        le=60,
        description="mil_f_8785c: wind 20 ft above ground; says all up to 1000 ft above ground, "
        "to 2000 ft by parts with severity or exceedance, above it nothing",
    )
    spectrum: Literal["dryden", "von_karman"] = Field(default="dryden", description="mil_f_8785c: spectrum")

    @model_validator(mode="after")
    def _fits(self) -> Turbulence:
        if self.model != "mil_f_8785c":
            _refuse_others(self, self.model, ("severity", "exceedance", "wind_20ft_m_s", "spectrum"))
            return self
        if self.sigma_m_s > 0.0:
            problem = f"{self.sigma_m_s:g} m/s is given, but model mil_f_8785c finds sigma by its rules"
            raise wrong(problem, "severity, or another model", "sigma_m_s")
        _refuse_others(self, self.model, ("length_m",))
        if self.severity is None and self.exceedance is None and self.wind_20ft_m_s is None:
            raise wrong("mil_f_8785c has no strength", "severity, exceedance or wind_20ft_m_s", "severity")
        if self.severity is not None and self.exceedance is not None:
            raise wrong(f"is given besides severity {self.severity}", "one of both", "exceedance")
        return self


class Gust(Section):
    """One gust of 1-cosine shape."""

    start_s: float = Field(ge=0, description="start, after the start of the flight")
    duration_s: float = Field(gt=0, le=3600, description="from nothing to nothing")
    north_m_s: float = Field(default=0.0, ge=-50, le=50, description="peak of the air's velocity northwards")
    east_m_s: float = Field(default=0.0, ge=-50, le=50, description="peak eastwards")
    down_m_s: float = Field(default=0.0, ge=-50, le=50, description="peak downwards")

    @model_validator(mode="after")
    def _blows(self) -> Gust:
        if self.north_m_s == self.east_m_s == self.down_m_s == 0.0:
            raise wrong("gust without strength", "one of north_m_s, east_m_s, down_m_s other than 0")
        return self


class Thermal(Section):
    """One updraft with its ring of sink."""

    center_deg: Point = Field(description="its centre at the start, [latitude, longitude], WGS-84")
    radius_m: float = Field(gt=0, le=20000, description="where the updraft turns into sink")
    strength_m_s: float = Field(ge=-20, le=20, description="updraft at the centre, at flying height")


class ThermalField(Section):
    """Updrafts strewn at random, without end; strength and radius within half of their means."""

    spacing_m: float = Field(ge=200, le=100000, description="one thermal in so large a square, on average")
    radius_m: float = Field(default=200.0, gt=0, le=20000, description="mean radius")
    strength_m_s: float = Field(default=2.0, ge=0, le=20, description="mean updraft at the centres")

    @model_validator(mode="after")
    def _fits(self) -> ThermalField:
        if self.radius_m > self.spacing_m:
            raise wrong(f"{self.radius_m:g} m is wider than spacing_m", f"at most {self.spacing_m:g}", "radius_m")
        return self


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
    thermals: tuple[Thermal, ...] = Field(default=(), description="single updrafts")
    thermal_field: ThermalField | None = Field(default=None, description="updrafts at random; null: none")
    thermals_drift: bool = Field(
        default=False, description="true: all thermals are carried along by the wind; false: they stand"
    )

    @model_validator(mode="after")
    def _fits(self) -> Air:
        levels = len(self.wind.profile) if isinstance(self.wind, WindProfile) else 1
        for key in ("exponent", "veer_deg_per_km"):
            if levels > 1 and getattr(self.shear, key):
                raise wrong("shear on top of a wind profile", "put it into the levels", f"shear.{key}")
        return self
