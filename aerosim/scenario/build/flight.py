"""The aircraft of a scenario, and what its crew expects."""

from __future__ import annotations

from pathlib import Path

from aerosim import assets
from aerosim.flight.plan import FlightPlan
from aerosim.scenario.scenario import Scenario


def planned_vh(plan: FlightPlan, ground: float) -> float:
    """Speed-to-height ratio that the crew expects without knowing the wind, 1/s."""
    return plan.airspeed / (plan.height - ground)


def aircraft_folder(scenario: Scenario) -> Path:
    """Folder of the shipped aircraft that a scenario names.  Raises InputError."""
    root, name = assets.folder("aircraft"), scenario.aircraft.model
    names = sorted(p.parent.name for p in root.glob("*/limits.yaml"))
    if name not in names:
        raise scenario.error("aircraft.model", f"no aircraft {name!r} ships", f"allowed: {', '.join(names)}")
    return root / name
