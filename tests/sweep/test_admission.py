"""Who may fly runs of a sweep on a cluster: workers that differ or lack something are named."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest
from dask_cluster import FAKE, HIDE, OTHER_NUMPY, Cluster, flown, orders

from aerosim.errors import InputError
from aerosim.sweep import admission
from aerosim.sweep.admission import Facts, unfit, versions_here
from aerosim.sweep.cluster import DaskExecutor


@pytest.fixture
def out(tmp_path: Path) -> Path:
    path = tmp_path / "a sweep"
    path.mkdir()
    return path


def test_what_makes_a_worker_unfit() -> None:
    here = versions_here()
    assert unfit(Facts(here, ""), 1, here) == ""
    assert set(here) == {*admission.PACKAGES, "python", "aerosim", "aerosim's source"}
    for name in here:
        assert unfit(Facts(here | {name: "0"}, ""), 1, here).startswith(f"{name} is 0 there and {here[name]} here")
    assert unfit(Facts(here, "no folder"), 1, here) == "no folder"
    assert "OSError: gone" in unfit(OSError("gone"), 1, here)


def blind(dask: Cluster) -> None:
    """A worker to which no file of the driver exists."""
    dask.worker(fake=FAKE + HIDE.format(module="admission"))
    dask.crew(1)


@pytest.mark.slow
def test_records_need_a_shared_folder(dask: Cluster, out: Path) -> None:
    blind(dask)
    runs = DaskExecutor(dask.address).run(iter([replace(orders(out, 1), keep="records")]))
    with pytest.raises(
        InputError, match=r"does not see .*a sweep: --keep records needs a folder that all machines"
    ):
        list(runs)
    assert flown(out) == []
    assert list(out.iterdir()) == []


@pytest.mark.slow
def test_files_of_the_scenario_are_looked_for_on_the_worker(dask: Cluster, out: Path) -> None:
    land = out.parent / "land.tif"
    land.touch()
    task = replace(orders(out, 1), scenario=json.dumps({"terrain": {"source": {"elevation": str(land)}}}))
    blind(dask)
    with pytest.raises(InputError, match=r"worker tcp.*: terrain.source.elevation: .*land.tif is not on "):
        list(DaskExecutor(dask.address).run(iter([task])))
    # the first task needs nothing, a later one does: its row says what is missing
    rows = list(DaskExecutor(dask.address).run(iter([orders(out, 2), task])))
    assert [row.status for row in rows] == ["done", "failed"]
    assert "land.tif is not on" in rows[1].reason
    assert flown(out) == [2]


@pytest.mark.slow
def test_worker_with_another_numpy_is_named(dask: Cluster) -> None:
    dask.worker(fake=OTHER_NUMPY)
    dask.crew(1)
    with pytest.raises(InputError, match=r"worker tcp://127.* cannot take part: numpy is 0\.0\.1 there and "):
        DaskExecutor(dask.address)


@pytest.mark.slow
def test_worker_with_threads_is_named(dask: Cluster) -> None:
    dask.worker("--nthreads", "3")
    dask.crew(1)
    with pytest.raises(InputError, match=r"it has 3 threads: start it with --nthreads 1"):
        DaskExecutor(dask.address)


@pytest.mark.slow
def test_worker_without_aerosim_is_named(dask: Cluster, tmp_path: Path) -> None:
    (tmp_path / "other" / "aerosim").mkdir(parents=True)
    (tmp_path / "other" / "aerosim" / "__init__.py").touch()
    dask.worker(fake="", PYTHONPATH=str(tmp_path / "other"))
    dask.crew(1)
    with pytest.raises(InputError, match=r"cannot take part: it has no aerosim, or another one"):
        DaskExecutor(dask.address)


@pytest.mark.slow
def test_worker_that_cannot_take_part_and_comes_late_is_left_alone(
    dask: Cluster, out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    dask.worker()
    dask.crew(1)
    tasks = (orders(out, n, nap=0.1) for n in range(10**6))
    runs, pids = DaskExecutor(dask.address).run(tasks), set()
    for done, row in enumerate(runs):
        pids.add(row.summary["pid"])
        if done == 0:
            dask.worker(fake=FAKE + OTHER_NUMPY)
        if "does not take part: numpy is 0.0.1 there" in caplog.text:
            break
    for _ in range(5):
        pids.add(next(runs).summary["pid"])
    runs.close()
    assert len(pids) == 1


@pytest.mark.slow
def test_libraries_of_a_worker_use_one_thread(dask: Cluster) -> None:
    from distributed import Client

    dask.worker(fake="", OMP_NUM_THREADS="7")
    dask.crew(1)
    DaskExecutor(dask.address).close()
    with Client(dask.address, set_as_default=False) as client:
        (value,) = client.run(os.getenv, "OMP_NUM_THREADS").values()
    assert value == "1"
