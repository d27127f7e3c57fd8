"""A commented scenario to start from."""

from __future__ import annotations

from aerosim.scenario.emit import to_yaml
from aerosim.scenario.load import Override, load

_HEAD = """\
# Scenario of aerosim.  Keys carry their unit.  All values but name, terrain.source and flight.lines have a
# default: what is not changed may be deleted.  Own terrain: source: {orthophoto: a.tif, elevation: b.tif},
# relative to this file.
"""


def template(name: str) -> str:
    """YAML text of a scenario of that name: the crosswind flight, each key explained.  Raises InputError."""
    values = {"name": name, "purpose": "", "verifies": []}
    scenario = load("crosswind", [Override(key, value, "NAME") for key, value in values.items()])
    return _HEAD + to_yaml(scenario, comments=True)
