"""Sweeps on a Dask cluster: processes on loopback, killed, joined late, refused, and the same table."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import flights
import pytest

from aerosim.errors import InputError, RunFailure
from aerosim.sweep import admission, cluster_link
from aerosim.sweep.admission import Facts, unfit, versions_here
from aerosim.sweep.cluster import DaskExecutor
from aerosim.sweep.executor import SerialExecutor
from aerosim.sweep.spec import make_spec
from aerosim.sweep.work import Result, Task, read_result, result_file

# clusters of processes, started and killed: with the long proofs
pytestmark = pytest.mark.slow

pytest.importorskip("distributed")

# what a worker flies instead, in the tests of who flies what: it does what the task's parameters say
FAKE = """
import os, time
import aerosim.sweep.cluster as cluster
from aerosim.sweep.spec import make_spec
from aerosim.sweep.work import Result, write_result
from pathlib import Path

def fake(task):
    orders = task.parameters
    with open(orders["log"], "a") as log:
        log.write(f"{task.seed} {os.getpid()}\\n")
    time.sleep(orders.get("nap", 0.0))
    if orders.get("dies"):
        os.kill(os.getpid(), 9)
    if orders.get("fails"):
        raise ZeroDivisionError("a fault outside of the run")
    return Result(task.id, task.point, task.seed, "done", "", dict(orders), {"pid": os.getpid()}, 0.0)

def written(task):
    result = fake(task)
    write_result(Path(task.out), result)
    return result

cluster.fly, cluster.run_one = fake, written
"""


class Cluster:
    """A scheduler and its workers, as a user starts them, on ports that the system chooses."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.processes = folder, list[subprocess.Popen[bytes]]()
        found = folder / "scheduler.json"
        self.scheduler = self._start("scheduler", "--port", "0", "--scheduler-file", str(found))
        self.address = ""
        wait_until(found.exists)
        while not self.address:
            try:
                self.address = json.loads(found.read_text())["address"]
            except ValueError:  # half written
                time.sleep(0.02)

    def _start(self, program: str, *options: str, **env: str) -> subprocess.Popen[bytes]:
        command = [
            sys.executable,
            "-m",
            f"distributed.cli.dask_{program}",
            "--host",
            "127.0.0.1",
            "--no-dashboard",
        ]
        with (self.folder / f"{program}-{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(
                [*command, *options],
                stdout=log,
                stderr=log,
                cwd=self.folder,
                env=os.environ | env,
                start_new_session=True,
            )
        self.processes.append(process)
        return process

    def worker(self, *options: str, fake: str = FAKE, nanny: bool = False, **env: str) -> subprocess.Popen[bytes]:
        """Start a worker that flies what `fake` says; empty: real runs."""
        extra = ["--nthreads", "1"] if "--nthreads" not in options else []
        if not nanny:
            extra.append("--no-nanny")
        if fake:
            script = self.folder / f"fake{len(self.processes)}.py"
            script.write_text(fake)
            extra += ["--preload", str(script)]
        return self._start("worker", self.address, *extra, *options, **env)

    def crew(self, size: int) -> None:
        """Wait for a number of workers."""
        from distributed import Client

        with Client(self.address, set_as_default=False) as client:
            client.wait_for_workers(size, timeout=20)

    def stop(self) -> None:
        for process in self.processes:
            os.killpg(process.pid, signal.SIGKILL)  # a nanny's worker is of its session
        for process in self.processes:
            process.wait()


def wait_until(true: Callable[[], bool], limit: float = 20.0) -> None:
    end = time.monotonic() + limit
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture
def dask(tmp_path: Path) -> Iterator[Cluster]:
    admission._source.cache_clear()  # the program may have been edited since another test asked
    started = Cluster(tmp_path)
    yield started
    started.stop()


@pytest.fixture
def out(tmp_path: Path) -> Path:
    path = tmp_path / "a sweep"
    path.mkdir()
    return path


def orders(out: Path, number: int, **order: Any) -> Task:
    """A task that the fake flies."""
    parameters = {"log": str(out / "log"), **order}
    return Task(f"run{number}", 0, number, "{}", parameters, str(out))


def flown(out: Path) -> list[int]:
    """Seeds of the runs that were begun, in order."""
    log = out / "log"
    return [int(line.split()[0]) for line in log.read_text().splitlines()] if log.exists() else []


def real_tasks(out: Path, seeds: int) -> list[Task]:
    """Short flights in rough air, at two strengths."""
    scenario = flights.scenario(
        2, flight={"run_in_s": 5}, record={"exclude_first_s": 0}, air=flights.air(8.0, 0.0)
    )
    spec = make_spec(scenario, {"air.turbulence.sigma_m_s": (0.5, 1.5)}, seeds=seeds)
    return list(spec.tasks(out))


def table(results: list[Result]) -> list[Result]:
    """Rows as runs.parquet has them, without wall times."""
    rows = sorted(results, key=lambda row: (row.point, row.seed))
    return [
        replace(row, wall_s=0.0, summary={k: v for k, v in row.summary.items() if not k.startswith("speed.")})
        for row in rows
    ]


def test_same_table_on_one_and_two_workers_one_killed_half_way(dask: Cluster, tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("serial", "one", "two")]
    for folder in folders:
        folder.mkdir()
    local = list(SerialExecutor().run(iter(real_tasks(folders[0], 3))))
    assert [row.status for row in local] == ["done"] * 6

    first = dask.worker(fake="")
    dask.crew(1)
    one = list(DaskExecutor(dask.address).run(iter(real_tasks(folders[1], 3))))

    dask.worker(fake="")
    dask.crew(2)
    two = []
    for result in DaskExecutor(dask.address).run(iter(real_tasks(folders[2], 3))):
        two.append(result)
        if len(two) == 2:
            first.kill()
        if len(two) == 3:
            dask.worker(fake="")
    assert table(local) == table(one) == table(two)
    for folder, rows in zip(folders, (local, one, two), strict=True):
        assert {file.name for file in folder.iterdir()} == {"runs"}
        assert [read_result(result_file(folder, row.id)) for row in rows] == rows


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


@pytest.mark.slow
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
sys.path.insert(0, {str(Path(__file__).parent)!r})
sys.path.insert(0, {str(Path(flights.__file__).parent)!r})
from test_cluster import DaskExecutor, orders
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


# to this module no file exists
HIDE = """
import aerosim.sweep.{module} as module
module.Path = type("Hidden", (type(Path()),), {{"exists": lambda self: False}})
"""


def blind(dask: Cluster) -> None:
    """A worker to which no file of the driver exists."""
    dask.worker(fake=FAKE + HIDE.format(module="admission"))
    dask.crew(1)


def test_records_need_a_shared_folder(dask: Cluster, out: Path) -> None:
    blind(dask)
    runs = DaskExecutor(dask.address).run(iter([replace(orders(out, 1), keep="records")]))
    with pytest.raises(
        InputError, match=r"does not see .*a sweep: --keep records needs a folder that all machines"
    ):
        list(runs)
    assert flown(out) == []
    assert list(out.iterdir()) == []


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


# a preloaded script is run twice: it must not wrap itself
OTHER_NUMPY = """
from importlib import metadata
if not hasattr(metadata, "real"):
    metadata.real = metadata.version
    metadata.version = lambda name: "0.0.1" if name == "numpy" else metadata.real(name)
"""


def test_worker_with_another_numpy_is_named(dask: Cluster) -> None:
    dask.worker(fake=OTHER_NUMPY)
    dask.crew(1)
    with pytest.raises(InputError, match=r"worker tcp://127.* cannot take part: numpy is 0\.0\.1 there and "):
        DaskExecutor(dask.address)


def test_worker_with_threads_is_named(dask: Cluster) -> None:
    dask.worker("--nthreads", "3")
    dask.crew(1)
    with pytest.raises(InputError, match=r"it has 3 threads: start it with --nthreads 1"):
        DaskExecutor(dask.address)


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


def test_libraries_of_a_worker_use_one_thread(dask: Cluster) -> None:
    from distributed import Client

    dask.worker(fake="", OMP_NUM_THREADS="7")
    dask.crew(1)
    DaskExecutor(dask.address).close()
    with Client(dask.address, set_as_default=False) as client:
        (value,) = client.run(os.getenv, "OMP_NUM_THREADS").values()
    assert value == "1"


@pytest.mark.parametrize("address", ["nowhere", "tcp://127.0.0.1:{free}", "foo://127.0.0.1:1", "127.0.0.1:{deaf}"])
def test_unreachable_address(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cluster_link.CONNECT_S + 1.0 < 9.0, "10 s is what a user is told"
    monkeypatch.setattr(cluster_link, "CONNECT_S", 1.0)
    with socket.socket() as free, socket.socket() as deaf:
        for each in (free, deaf):
            each.bind(("127.0.0.1", 0))
        deaf.listen()  # answers the phone and says nothing
        full = address.format(free=free.getsockname()[1], deaf=deaf.getsockname()[1])
        started = time.monotonic()
        with pytest.raises(InputError, match="no Dask scheduler answers at") as caught:
            DaskExecutor(full)
    assert time.monotonic() - started < 4.0
    assert caught.value.key == "--dask"


def test_empty_address() -> None:
    with pytest.raises(InputError, match="--dask: no address is given"):
        DaskExecutor("")


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(
        InputError, match=r'--dask: Dask is not installed \(pip install "aerosim-survey\[cluster\]"\)'
    ):
        DaskExecutor("tcp://127.0.0.1:1")


def test_no_tasks_is_no_table(dask: Cluster) -> None:
    assert list(DaskExecutor(dask.address).run(iter([]))) == []


def test_what_makes_a_worker_unfit() -> None:
    here = versions_here()
    assert unfit(Facts(here, ""), 1, here) == ""
    assert set(here) == {*admission.PACKAGES, "python", "aerosim", "aerosim's source"}
    for name in here:
        assert unfit(Facts(here | {name: "0"}, ""), 1, here).startswith(f"{name} is 0 there and {here[name]} here")
    assert unfit(Facts(here, "no folder"), 1, here) == "no folder"
    assert "OSError: gone" in unfit(OSError("gone"), 1, here)
