"""Fixtures that several parts of the tests share."""

from __future__ import annotations

import pytest

import aerosim
from aerosim.record import Run


@pytest.fixture(scope="session")
def crosswind(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The shipped scenario `crosswind`, flown once, with everything that a run writes."""
    return aerosim.run(aerosim.load_scenario("crosswind"), tmp_path_factory.mktemp("crosswind") / "run")
