"""Section `estimation`: how strips are matched and filtered."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, model_validator

from aerosim.scenario.section import Positive, Section, wrong


class CrabFilter(Section):
    """What the filter of crab assumes."""

    walk_deg2_per_s: float = Field(
        default=0.225, ge=0, le=1000, description="intensity of the angle's random walk"
    )
    sigma_deg: float = Field(default=5.0, gt=0, le=180, description="standard deviation of one strip's angle")
    gamma: float | None = Field(
        default=None, ge=0, le=1000, description="walk over noise per strip; null: from walk, sigma and duration"
    )


class VhFilter(Section):
    """What the filter of v/h assumes."""

    walk_pct2_per_s: float = Field(default=0.5, ge=0, le=10000, description="intensity of the random walk of v/h")
    sigma_pct: float = Field(default=5.0, gt=0, le=100, description="standard deviation of one strip's v/h")
    gamma: float | None = Field(
        default=None, ge=0, le=1000, description="walk over noise per strip; null: from walk, sigma and duration"
    )


class Estimation(Section):
    """Matching of strips (MAD) and the filters behind it."""

    mean_subtracted: bool = Field(default=True, description="row means are subtracted before the differences")
    subpixel: bool = Field(default=True, description="minimum between pixels and between exposures")
    search_n: tuple[Positive, Positive] = Field(
        default=(0.6, 1.6), description="from, to: exposures searched, as parts of the planned n"
    )
    strip_period_s: float | None = Field(
        default=1.0,
        gt=0,
        le=3600,
        description="a new strip so often; null: one strip at a time, as the 1988 paper",
    )
    gain: Literal["riccati", "halving"] = Field(
        default="riccati", description="gain series: riccati, the paper's (15), or halving, its (17)"
    )
    arithmetic: Literal["real", "integer"] = Field(
        default="real", description="real numbers, or the whole ones of the instrument of 1988"
    )
    crab: CrabFilter = Field(default=CrabFilter(), description="filter of the angle")
    vh: VhFilter = Field(default=VhFilter(), description="filter of v/h")
    table: str | None = Field(
        default=None,
        min_length=1,
        description="YAML file with crab and vh by height above ground; null: those here",
    )
    aiding: Literal["none", "gyro", "bank", "imu"] = Field(
        default="none", description="what the estimator is given besides the rows"
    )

    distortion: float | None = Field(
        default=None,
        ge=-1,
        le=1,
        description="k1 of the rows' optics as calibrated, for mode best; null: ccd_rows.distortion itself",
    )

    @model_validator(mode="after")
    def _table_alone(self) -> Estimation:
        """What the table has is not given twice; the defaults, as a resolved scenario has them, may stand."""
        for part in ("crab", "vh") if self.table is not None else ():
            section = getattr(self, part)
            for name, info in type(section).model_fields.items():
                if getattr(section, name) != info.default:
                    raise wrong("is given besides table", "one of the two", f"{part}.{name}")
        return self

    @model_validator(mode="after")
    def _ordered(self) -> Estimation:
        low, high = self.search_n
        if not low < 1 < high or high > 10:
            raise wrong(
                f"[{low:g}, {high:g}] does not hold the planned n", "from < 1 < to, to at most 10", "search_n"
            )
        return self
