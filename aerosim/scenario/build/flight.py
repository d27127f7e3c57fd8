"""The aircraft of a scenario, and what its crew expects."""

from __future__ import annotations

from pathlib import Path

from aerosim import assets
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.own.probe import check_model
from aerosim.flight.plan import FlightPlan
from aerosim.scenario.aircraft import is_path
from aerosim.scenario.build.placing import at
from aerosim.scenario.scenario import Scenario


def planned_vh(plan: FlightPlan, ground: float) -> float:
    """Speed-to-height ratio that the crew expects without knowing the wind, 1/s."""
    return plan.airspeed / (plan.height - ground)


def aircraft_folder(scenario: Scenario) -> Path:
    """Folder of the aircraft that a scenario names: a shipped one, or a path.  Raises InputError."""
    root, name = assets.folder("aircraft"), scenario.aircraft.model
    if is_path(name):
        return Path(name)
    names = sorted(p.parent.name for p in root.glob("*/limits.yaml"))
    if name not in names:
        allowed = f"allowed: {', '.join(names)}, or the path of a folder, as ./{name}"
        raise scenario.error("aircraft.model", f"no aircraft {name!r} ships", allowed)
    return root / name


def aircraft_of(scenario: Scenario) -> Aircraft:
    """The aircraft of a scenario, not yet started.  Raises InputError; a user's own one is tried apart first."""
    wanted, folder = scenario.aircraft, aircraft_folder(scenario)
    if is_path(wanted.model):
        with at(scenario, "aircraft.model"):
            check_model(folder, wanted.step_rate_hz, wanted.fuel_kg)
    with at(scenario, "aircraft.fuel_kg"):
        return Aircraft(folder, wanted.step_rate_hz, wanted.fuel_kg)


def input_files(scenario: Scenario) -> dict[str, Path]:
    """Files besides the terrain that a scenario's flight is made from, by their part in it."""
    flight, area = scenario.flight, scenario.flight.area
    replay = flight.replay if flight.replay is None or isinstance(flight.replay, str) else flight.replay.file
    found = {
        "lines": flight.file,
        "area": None if area is None else area.file,
        "replay": replay,
        "disturbances": scenario.estimation.table,
    }
    files = {name: Path(file) for name, file in found.items() if file is not None}
    if replay is None:
        folder = aircraft_folder(scenario)
        parts = (file for file in sorted(folder.rglob("*")) if file.suffix in (".xml", ".yaml"))
        files.update({f"aircraft/{file.relative_to(folder).as_posix()}": file for file in parts})
    return files
