"""The terrain that a scenario names."""

from __future__ import annotations

from math import cos, radians, sin
from pathlib import Path

import numpy as np

from aerosim.frames import LocalMap
from aerosim.rng import generator
from aerosim.scenario.build.placing import at
from aerosim.scenario.scenario import Scenario
from aerosim.scenario.terrain import TerrainFiles, Undulation
from aerosim.world.clouds import CloudShadows
from aerosim.world.terrain import Terrain, find_terrain


def terrain_of(scenario: Scenario) -> Terrain:
    """The terrain that a scenario names.  Raises InputError."""
    source, vertical = scenario.terrain.source, scenario.terrain.vertical_datum
    with at(scenario, "terrain.source"):
        if isinstance(source, TerrainFiles):
            files = Path(source.orthophoto), Path(source.elevation)
        else:
            files = find_terrain(source)
        above = vertical.undulation_m if isinstance(vertical, Undulation) else vertical
        return Terrain.open(*files, above, scenario.terrain.relief_factor)


def clouds_of(scenario: Scenario, local: LocalMap) -> CloudShadows | None:
    """Cloud shadows of a scenario.  local: map grid around the flight; it turns their course into the map's."""
    clouds = scenario.terrain.cloud_shadows
    if clouds is None:
        return None
    grid = local(*np.asarray(local.origin).tolist())
    north, east = (-clouds.speed_m_s * part(radians(clouds.from_deg)) for part in (cos, sin))
    velocity = grid[2] * north + grid[3] * east, grid[4] * north + grid[5] * east
    return CloudShadows(
        generator(scenario.seed, "terrain.cloud_shadows"),
        clouds.cover_pct / 100.0,
        clouds.cell_m,
        velocity,
        clouds.darkness_pct / 100.0,
    )
