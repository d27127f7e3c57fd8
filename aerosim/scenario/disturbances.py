"""The table of disturbances over height that `estimation.table` names: the ROM of the 1988 paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field, ValidationError, model_validator

from aerosim.scenario.estimation import CrabFilter, VhFilter
from aerosim.scenario.places import Places
from aerosim.scenario.reader import read
from aerosim.scenario.section import Section, wrong
from aerosim.scenario.translate import translated


class HeightRow(Section):
    """What the filters assume at one height above ground."""

    height_agl_m: float = Field(gt=0, le=20000, description="height above ground")
    crab: CrabFilter = Field(description="filter of the angle")
    vh: VhFilter = Field(description="filter of v/h")


class DisturbanceTable(Section):
    """Rows by height, in ascending order."""

    rows: tuple[HeightRow, ...] = Field(min_length=1, description="one for each height")

    @model_validator(mode="after")
    def _in_order(self) -> DisturbanceTable:
        heights = [row.height_agl_m for row in self.rows]
        for i in range(1, len(heights)):
            if heights[i] <= heights[i - 1]:
                problem = f"{heights[i]:g} follows {heights[i - 1]:g}"
                raise wrong(problem, "heights in ascending order", f"rows.{i}.height_agl_m")
        for part in ("crab", "vh"):
            given = [getattr(row, part).gamma is not None for row in self.rows]
            if any(given) and not all(given):
                key = f"rows.{given.index(not given[0])}.{part}.gamma"
                raise wrong("a number in some rows and null in others", "the same in all rows", key)
        return self


class Believed(NamedTuple):
    """What the filters of angle and v/h assume."""

    crab: CrabFilter
    vh: VhFilter


def read_table(file: Path) -> DisturbanceTable:
    """Table of a YAML file.  Raises InputError with the line of what is wrong."""
    data, lines = read(file, str(file), "a table of disturbances", "`aerosim tune` writes one")
    places = Places(str(file), lines)
    try:
        return DisturbanceTable.model_validate(data)
    except ValidationError as error:
        found = translated(error.errors(include_url=False), DisturbanceTable)
        key, problem, allowed = min(found, key=lambda each: places.line(each[0]))
        raise places.error(key, problem, allowed) from error


def at_height(table: DisturbanceTable, height: float) -> Believed:
    """What holds at a height above ground, m: linear between two rows, the nearest row's beyond the ends."""
    heights = [row.height_agl_m for row in table.rows]
    above = next((i for i, each in enumerate(heights) if each >= height), len(heights) - 1)
    below = max(above - 1, 0)
    span = heights[above] - heights[below]
    share = min(max((height - heights[below]) / span, 0.0), 1.0) if span > 0.0 else 0.0
    low, high = table.rows[below], table.rows[above]
    return Believed(_between(low.crab, high.crab, share), _between(low.vh, high.vh, share))


def _between(low: Any, high: Any, share: float) -> Any:
    values = {}
    for name in type(low).model_fields:
        a, b = getattr(low, name), getattr(high, name)
        values[name] = None if a is None else (1.0 - share) * a + share * b
    return type(low)(**values)
