"""From a file with an area or lines, and settings, to a plan and its forecast.  For `aerosim plan`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from aerosim.errors import InputError
from aerosim.forecast.check import Outlook, outlook
from aerosim.formats.files import read
from aerosim.scenario import from_mapping


def plan_file(file: Path, settings: Mapping[str, Any], area: Mapping[str, Any]) -> Outlook:
    """Plan of a file with one polygon, or else with lines, and its forecast.

    settings: sections of a scenario without its lines; area: keys of flight.area besides the file, for a polygon.
    Raises InputError with the place in the file, or the key of a setting.
    """
    kinds = [each.kind for each in read(file)]
    areas = kinds.count("area")
    if areas > 1 and "line" not in kinds:
        raise InputError(f"holds {areas} areas", where=str(file), allowed="one area, or lines")
    course: dict[str, Any] = {"area": {"file": str(file), **area}} if areas == 1 else {"file": str(file)}
    return outlook(from_mapping({**settings, "flight": {**settings["flight"], **course}}))
