"""Sweeps on a Dask cluster: processes on loopback, killed, joined late, gone, and the same table."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import dask_cluster
import pytest
from dask_cluster import FAKE, HIDE, Cluster, flown, orders
from sweeps import MODES, files, same, tiny

import aerosim
from aerosim.errors import InputError, Interrupted, RunFailure
from aerosim.sweep.cluster import DaskExecutor
from aerosim.sweep.results import Sweep
from aerosim.sweep.work import Task, read_result, result_file

# clusters of processes, started and killed: one short one is in test_cli_cluster
pytestmark = pytest.mark.slow


@pytest.fixture
def out(tmp_path: Path) -> Path:
    path = tmp_path / "a sweep"
    path.mkdir()
    return path


def test_same_table_on_one_and_two_workers_one_killed_half_way(dask: Cluster, tmp_path: Path) -> None:
    """Through the public function; nothing of the cluster is left in the folder."""
    local = aerosim.sweep(tiny(), MODES, seeds=3, out=tmp_path / "local", workers=0)
    assert local.summary["done"] == 12
    first = dask.worker(fake="")
    dask.crew(1)
    one = aerosim.sweep(tiny(), MODES, seeds=3, out=tmp_path / "one", dask=dask.address)
    assert one.summary["workers"] == 1
    dask.worker(fake="")
    dask.crew(2)

    def half(ended: float, _: float) -> None:
        if ended == 4:
            first.kill()
        if ended == 5:
            dask.worker(fake="")

    two = aerosim.sweep(tiny(), MODES, seeds=3, out=tmp_path / "two", dask=dask.address, progress=half)
    assert same(one.table, local.table)
    assert same(two.table, local.table)
    assert {file.name for file in two.path.iterdir()} == {file.name for file in local.path.iterdir()}


def test_interrupted_it_goes_on_with_the_cluster_or_without(dask: Cluster, tmp_path: Path) -> None:
    dask.worker(fake="")
    dask.crew(1)

    def stop(ended: float, _: float) -> None:
        if ended >= 3:
            raise KeyboardInterrupt

    def part(**where: str | int) -> None:
        with pytest.raises(Interrupted) as found:
            aerosim.sweep(tiny(), MODES, seeds=3, out=tmp_path / "s", resume=True, progress=stop, **where)
        assert found.value.path == tmp_path / "s"

    part(dask=dask.address)
    assert Sweep(tmp_path / "s").table.num_rows == 3
    part(workers=0)
    there = files(tmp_path / "s")
    done = aerosim.sweep(tiny(), MODES, seeds=3, out=tmp_path / "s", resume=True, dask=dask.address)
    now = files(done.path)
    # the run in the middle of which the worker was when the driver left is ended by it, for nobody
    assert {name: now[name] for name in there}.keys() == there.keys()
    local = aerosim.sweep(tiny(), MODES, seeds=3, out=tmp_path / "local", workers=0)
    assert same(done.table, local.table)


def test_worker_that_cannot_take_part_leaves_a_record_of_it(dask: Cluster, tmp_path: Path) -> None:
    dask.worker(fake=HIDE.format(module="admission"))
    dask.crew(1)
    with pytest.raises(InputError, match="--keep records needs a folder"):
        aerosim.sweep(tiny(), MODES, keep="records", out=tmp_path / "s", dask=dask.address)
    left = Sweep(tmp_path / "s")
    assert (left.summary["status"], left.table.num_rows) == ("failed", 0)
    assert "--keep records needs a folder that all machines share" in left.summary["reason"]
    done = aerosim.sweep(tiny(), MODES, keep="records", out=tmp_path / "s", resume=True, workers=0)
    assert done.summary["done"] == 4
    assert "reason" not in done.summary


def test_killed_workers_run_is_flown_by_another_and_no_finished_run_twice(dask: Cluster, out: Path) -> None:
    victim = dask.worker()
    dask.worker()
    dask.crew(2)
    done = []
    for result in DaskExecutor(dask.address).run(orders(out, n, nap=0.1) for n in range(20)):
        done.append(result.seed)
        if len(done) == 8:
            victim.kill()
    assert sorted(done) == list(range(20))
    begun = flown(out)
    assert len(begun) <= 21, "only the run in the middle of which the worker died is begun again"


def test_a_worker_that_joins_late_gets_runs(dask: Cluster, out: Path) -> None:
    dask.worker()
    dask.crew(1)
    executor, pids = DaskExecutor(dask.address), []
    for result in executor.run(orders(out, n, nap=0.1) for n in range(40)):
        pids.append(result.summary["pid"])
        if len(pids) == 1:
            assert executor.workers == 1
            dask.worker()
    assert len(set(pids)) == 2
    assert len(pids) == 40


def test_waits_for_the_first_worker(dask: Cluster, out: Path) -> None:
    executor = DaskExecutor(dask.address)
    assert executor.workers == 0
    threading.Timer(0.5, dask.worker).start()
    assert [row.status for row in executor.run(iter([orders(out, 1)]))] == ["done"]


def test_a_run_that_kills_its_worker_twice_is_a_failed_row(dask: Cluster, out: Path) -> None:
    dask.worker(nanny=True)  # a nanny starts a new worker for the one that died
    dask.worker(nanny=True)
    dask.crew(2)
    tasks = [orders(out, n, nap=0.2, dies=n == 2) for n in range(12)]
    rows = {row.seed: row for row in DaskExecutor(dask.address).run(iter(tasks))}
    assert sorted(rows) == list(range(12))
    assert [seed for seed, row in rows.items() if row.status == "failed"] == [2]
    assert rows[2].reason == "the worker process died 2 times"
    assert rows[2].parameters == tasks[2].parameters
    begun = flown(out)
    assert sorted(begun) == sorted([*range(12), 2]), "twice, and nobody else twice"


def test_a_fault_of_the_worker_is_a_failed_row(dask: Cluster, out: Path) -> None:
    dask.worker()
    dask.crew(1)
    rows = list(DaskExecutor(dask.address).run(orders(out, n, fails=n == 0) for n in range(3)))
    assert [row.status for row in rows] == ["failed", "done", "done"]
    assert rows[0].reason == "internal error: ZeroDivisionError: a fault outside of the run"


def test_tasks_are_pulled_only_when_somebody_is_there_to_fly_them(dask: Cluster, out: Path) -> None:
    dask.worker()
    dask.worker()
    dask.crew(2)
    pulled = 0

    def endless() -> Iterator[Task]:
        nonlocal pulled
        while True:
            pulled += 1
            yield orders(out, pulled)

    runs = DaskExecutor(dask.address).run(endless())
    for done, _ in enumerate(runs, 1):
        assert pulled <= done + 2
        if done == 30:
            break
    runs.close()
    assert not list(out.glob(".cluster-*"))


def test_interrupt_leaves_the_cluster_and_results_for_the_next(dask: Cluster, out: Path) -> None:
    dask.worker()
    dask.crew(1)
    script = f"""
import sys
from pathlib import Path
sys.path.insert(0, {str(Path(dask_cluster.__file__).parent)!r})
from dask_cluster import orders
from aerosim.sweep.cluster import DaskExecutor
try:
    for row in DaskExecutor({dask.address!r}).run(orders(Path({str(out)!r}), n, nap=0.3) for n in range(100)):
        print(row.seed, flush=True)
except KeyboardInterrupt:
    print("interrupted", flush=True)
"""
    driver = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True)
    assert driver.stdout is not None
    assert [driver.stdout.readline() for _ in range(3)] == ["0\n", "1\n", "2\n"]
    driver.send_signal(signal.SIGINT)
    said, _ = driver.communicate(timeout=10)
    assert said.splitlines()[-1] == "interrupted"
    assert driver.returncode == 0
    kept = [n for n in range(100) if read_result(result_file(out, f"run{n}"))]
    assert 3 <= len(kept) <= 5
    rest = [row.seed for row in DaskExecutor(dask.address).run(orders(out, n) for n in range(5, 8))]
    assert rest == [5, 6, 7]


def test_scheduler_that_dies_ends_the_sweep_with_what_is_done(dask: Cluster, out: Path) -> None:
    dask.worker()
    dask.crew(1)
    runs = DaskExecutor(dask.address).run(orders(out, n, nap=0.1) for n in range(1000))
    for done, _ in enumerate(runs, 1):
        if done == 3:
            break
    dask.scheduler.kill()
    started = time.monotonic()
    with pytest.raises(RunFailure, match=r"the Dask scheduler at tcp://127\.0\.0\.1:\d+ is lost .*--resume"):
        list(runs)
    assert time.monotonic() - started < 5.0
    assert all(read_result(result_file(out, f"run{n}")) for n in range(3))


def test_worker_that_does_not_see_the_folder_sends_its_result(dask: Cluster, out: Path) -> None:
    # the worker looks for the mark where it is not, as on a machine that does not share the disk
    dask.worker(fake=FAKE + HIDE.format(module="cluster"))
    dask.crew(1)
    rows = list(DaskExecutor(dask.address).run(iter([orders(out, 1)])))
    assert [row.status for row in rows] == ["done"]
    assert not result_file(out, "run1").exists()


def test_no_tasks_is_no_table(dask: Cluster) -> None:
    assert list(DaskExecutor(dask.address).run(iter([]))) == []
