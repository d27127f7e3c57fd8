"""What the filters assume at the planned height, where a scenario names a table."""

from __future__ import annotations

import logging
from pathlib import Path

from aerosim.scenario.disturbances import at_height, read_table
from aerosim.scenario.scenario import Scenario

journal = logging.getLogger("aerosim")


def with_table(scenario: Scenario, agl: float) -> Scenario:
    """The scenario with estimation.crab and .vh as its table has them; itself without a table.

    agl: planned height above ground, m.  Raises InputError.
    """
    if scenario.estimation.table is None:
        return scenario
    file = Path(scenario.estimation.table)
    if not file.is_file():
        raise scenario.error("estimation.table", f"no such file: {file}", "a table that `aerosim tune` wrote")
    found = at_height(read_table(file), agl)
    journal.info("disturbances at %.0f m above ground: crab %s, vh %s", agl, found.crab, found.vh)
    estimation = scenario.estimation.model_copy(update=found._asdict())
    return scenario.model_copy(update={"estimation": estimation})
