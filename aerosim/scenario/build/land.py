"""The terrain that a scenario names."""

from __future__ import annotations

from pathlib import Path

from aerosim.scenario.build.placing import at
from aerosim.scenario.scenario import Scenario
from aerosim.scenario.terrain import TerrainFiles, Undulation
from aerosim.world.terrain import Terrain, find_terrain


def terrain_of(scenario: Scenario) -> Terrain:
    """The terrain that a scenario names.  Raises InputError."""
    source, vertical = scenario.terrain.source, scenario.terrain.vertical_datum
    with at(scenario, "terrain.source"):
        if isinstance(source, TerrainFiles):
            files = Path(source.orthophoto), Path(source.elevation)
        else:
            files = find_terrain(source)
        return Terrain.open(*files, vertical.undulation_m if isinstance(vertical, Undulation) else vertical)
