"""Section `record`: what is kept of a run."""

from __future__ import annotations

from pydantic import Field

from aerosim.scenario.section import Section


class Record(Section):
    """What the run directory holds."""

    period_s: float = Field(default=0.05, gt=0, le=60, description="time between rows of telemetry.parquet")
    exclude_first_s: float = Field(
        default=60.0, ge=0, le=3600, description="start of each line that the summary leaves out"
    )
    rrd: bool = Field(default=True, description="write run.rrd for the viewer")
    report: bool = Field(default=True, description="write report.html")
