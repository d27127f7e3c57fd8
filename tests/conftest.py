"""Fixtures that several parts of the tests share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from dask_cluster import Cluster, cluster

import aerosim
from aerosim.record import Run


@pytest.fixture(scope="session")
def crosswind(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """The shipped scenario `crosswind`, flown once, with everything that a run writes."""
    return aerosim.run(aerosim.load_scenario("crosswind"), tmp_path_factory.mktemp("crosswind") / "run")


@pytest.fixture
def dask(tmp_path: Path) -> Iterator[Cluster]:
    """A scheduler of a Dask cluster on loopback; workers are for the test to start."""
    pytest.importorskip("distributed")
    from aerosim.sweep import admission

    admission._source.cache_clear()  # the program may have been edited since another test asked
    with cluster(tmp_path) as started:
        yield started
