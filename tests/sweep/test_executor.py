"""Worker processes: every task gives one result, whatever dies; nothing outlives its driver."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest
import sweep_workers

from aerosim.errors import RunFailure
from aerosim.sweep import executor
from aerosim.sweep.executor import AHEAD, LocalExecutor, SerialExecutor
from aerosim.sweep.work import ONE_THREAD, Result, Task, write_result


@pytest.fixture(autouse=True)
def obedient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executor, "_START", sweep_workers.START)


def order(out: Path, number: int, **told: Any) -> Task:
    return Task(f"run{number}", 0, number, "{}", told, str(out))


def flown(out: Path) -> list[str]:
    file = out / "flown.log"
    return [line.split()[0] for line in file.read_text().splitlines()] if file.exists() else []


def pids(out: Path) -> set[int]:
    return {int(line.split()[1]) for line in (out / "flown.log").read_text().splitlines()}


def wait_until(true: Callable[[], bool], limit: float = 20.0) -> None:
    until = time.monotonic() + limit
    while not true():
        assert time.monotonic() < until, "waited in vain"
        time.sleep(0.02)


def gone(pid: int) -> bool:
    return not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_every_task_gives_one_result(tmp_path: Path, workers: int) -> None:
    found = list(LocalExecutor(workers).run(order(tmp_path, k) for k in range(20)))
    assert sorted(result.seed for result in found) == list(range(20))
    assert len(flown(tmp_path)) == 20
    assert os.getpid() not in pids(tmp_path)
    assert len(pids(tmp_path)) <= workers


def test_no_tasks_start_no_process(tmp_path: Path) -> None:
    assert list(LocalExecutor(2).run(iter(()))) == []
    assert flown(tmp_path) == []


def test_what_a_library_prints_is_no_result(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (found,) = LocalExecutor(1).run(iter([order(tmp_path, 1, print=True)]))
    assert found.status == "done"
    shown = capfd.readouterr()
    assert shown.out == ""
    assert "and so does a C library" in shown.err


def test_a_worker_that_dies_gives_its_task_to_another(tmp_path: Path) -> None:
    tasks = [order(tmp_path, 0, die_once=str(tmp_path / "died")), *(order(tmp_path, k) for k in range(1, 8))]
    found = list(LocalExecutor(2).run(iter(tasks)))
    assert sorted(result.seed for result in found) == list(range(8))
    assert {result.status for result in found} == {"done"}
    # only what died was begun twice: what its worker held besides went to others unbegun
    assert Counter(flown(tmp_path)) == {"run0": 2, **{f"run{k}": 1 for k in range(1, 8)}}


def test_a_task_that_kills_two_workers_is_a_failed_result(tmp_path: Path) -> None:
    tasks = [order(tmp_path, 0, die=True), *(order(tmp_path, k) for k in range(1, 8))]
    found = {result.seed: result for result in LocalExecutor(2).run(iter(tasks))}
    assert found[0].status == "failed"
    assert found[0].reason == "the worker process died 2 times (SIGKILL)"
    assert {found[k].status for k in range(1, 8)} == {"done"}
    assert flown(tmp_path).count("run0") == 2


def test_a_run_whose_file_is_there_is_not_flown_again_after_a_death(tmp_path: Path) -> None:
    """A worker that was killed between writing its result and telling it."""
    (tmp_path / "runs").mkdir()
    write_result(tmp_path, Result("run0", 0, 0, "done", "", {}, {"a": 1.5}))
    (found,) = LocalExecutor(1).run(iter([order(tmp_path, 0, die=True)]))
    assert (found.status, found.summary) == ("done", {"a": 1.5})
    assert flown(tmp_path) == ["run0"]


def test_tasks_are_pulled_a_few_ahead_only(tmp_path: Path) -> None:
    pulled = 0

    def endless() -> Iterator[Task]:
        nonlocal pulled
        while True:
            yield order(tmp_path, pulled)
            pulled += 1

    running = LocalExecutor(2).run(endless())
    for ended in range(1, 10):
        next(running)
        assert pulled <= ended + 2 * AHEAD
    running.close()


def test_close_ends_what_is_flown_at_once(tmp_path: Path) -> None:
    tasks = [order(tmp_path, 0), *(order(tmp_path, k, sleep=60) for k in range(1, 5))]
    running = LocalExecutor(2).run(iter(tasks))
    next(running)
    wait_until(lambda: len(flown(tmp_path)) >= 3)
    started = time.monotonic()
    running.close()
    assert time.monotonic() - started < 10
    assert all(gone(pid) for pid in pids(tmp_path))


def test_workers_end_with_a_driver_that_is_killed(tmp_path: Path) -> None:
    program = (
        f"import sys; sys.path[:] = {sys.path!r}\n"
        "from pathlib import Path\n"
        "import sweep_workers\n"
        "from aerosim.sweep import executor, work\n"
        "executor._START = sweep_workers.START\n"
        f"tasks = [work.Task(f'run{{k}}', 0, k, '', {{'sleep': 60}}, {str(tmp_path)!r}) for k in range(4)]\n"
        "list(executor.LocalExecutor(2).run(iter(tasks)))\n"
    )
    driver = subprocess.Popen([sys.executable, "-c", program])
    wait_until(lambda: len(flown(tmp_path)) >= 2)
    driver.send_signal(signal.SIGKILL)
    driver.wait()
    wait_until(lambda: all(gone(pid) for pid in pids(tmp_path)), 5.0)


def test_processes_that_do_not_start_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    start = sweep_workers.START.replace(".main()", ".broken()")
    monkeypatch.setattr(executor, "_START", start)
    log = tmp_path / "sweep.log"
    with pytest.raises(RunFailure, match=r"worker processes do not start \(exit code 7, see .*sweep\.log\)"):
        list(LocalExecutor(2, log).run(order(tmp_path, k) for k in range(4)))
    assert "no module named physics" in log.read_text()


def test_libraries_use_one_thread_each(tmp_path: Path) -> None:
    (found,) = LocalExecutor(1).run(iter([order(tmp_path, 0, threads=tuple(ONE_THREAD))]))
    assert {found.summary[name] for name in ONE_THREAD} == {"1"}


def test_serially_in_this_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(executor, "run_one", sweep_workers.obey)
    found = list(SerialExecutor().run(order(tmp_path, k) for k in range(3)))
    assert [result.seed for result in found] == [0, 1, 2]
    assert pids(tmp_path) == {os.getpid()}
