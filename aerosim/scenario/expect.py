"""Section `expect`: what the summary must show, by path."""

from __future__ import annotations

from difflib import get_close_matches
from typing import Annotated

from pydantic import AfterValidator, Field, model_validator

from aerosim.scenario.section import Section, wrong

_SUMMARY = {
    "flight": "duration_s lines cross_track_rms_m height_rms_m airspeed_rms_m_s roll_rms_deg pitch_rms_deg "
    "roll_rate_rms_deg_s pitch_rate_rms_deg_s yaw_rate_rms_deg_s drift_mean_deg",
    "crab": "residual_rms_deg residual_mean_deg residual_max_deg estimate_error_rms_deg settle_s strips "
    "accepted_pct bad_pct silent_max_s silent_end_s split_deg.fast_yaw split_deg.lag split_deg.noise "
    "split_deg.convergence split_deg.mount split_deg.rest",
    "vh": "error_rms_pct error_mean_pct strip_error_rms_pct split_pct.fast_speed split_pct.lag split_pct.relief "
    "split_pct.noise split_pct.convergence split_pct.rest",
    "consistency": "drift.mean drift.variance drift.lag1 vh.mean vh.variance vh.lag1",
    "photos": "count end_lap_mean_pct end_lap_error_rms_pct end_lap_min_pct side_lap_min_pct blur_rms_px "
    "out_of_tolerance",
    "speed": "wall_s fdm_wall_s real_time_factor",
}
SUMMARY_PATHS = tuple(f"{part}.{name}" for part, names in _SUMMARY.items() for name in names.split())
"""Numbers of summary.json that can be asked for (design of the run directory)."""


class Limit(Section):
    """Closed range of a number; what was not measured (null) is outside."""

    min: float | None = Field(default=None, description="least value that meets it")
    max: float | None = Field(default=None, description="greatest value that meets it")

    @model_validator(mode="after")
    def _says_something(self) -> Limit:
        if self.min is None and self.max is None:
            raise wrong("asks for nothing", "allowed: {min: NUMBER}, {max: NUMBER} or both")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise wrong(f"min {self.min:g} is above max {self.max:g}", "min at most max")
        return self


def _known_paths(limits: dict[str, Limit]) -> dict[str, Limit]:
    for path in limits:
        if path not in SUMMARY_PATHS:
            part, _, name = path.partition(".")
            near = [each for each in SUMMARY_PATHS if name and each.startswith(f"{part}.") and name in each]
            near = near or get_close_matches(path, SUMMARY_PATHS, 1, 0.4)
            hint = f"did you mean {near[0]}?" if near else f"for example {SUMMARY_PATHS[-1]}"
            raise wrong("is no number of summary.json", hint, path)
    return limits


Expect = Annotated[dict[str, Limit], AfterValidator(_known_paths)]
