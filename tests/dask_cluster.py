"""A Dask cluster on loopback for the tests of sweeps: started as a user starts it, and gone with its test."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from aerosim.sweep.work import Task

LIMIT_S = 60.0  # of each wait: far more than it takes, also where others compute
WHOLE_S = 600  # of a test: whatever hangs then is ended

# what a worker flies instead, in the tests of who flies what: it does what the task's parameters say
FAKE = """
import os, time
import aerosim.sweep.cluster as cluster
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

# to this module no file exists
HIDE = """
from pathlib import Path
import aerosim.sweep.{module} as module
module.Path = type("Hidden", (type(Path()),), {{"exists": lambda self: False}})
"""

# a preloaded script is run twice: it must not wrap itself
OTHER_NUMPY = """
from importlib import metadata
if not hasattr(metadata, "real"):
    metadata.real = metadata.version
    metadata.version = lambda name: "0.0.1" if name == "numpy" else metadata.real(name)
"""


class Cluster:
    """A scheduler and its workers, on ports that the system chooses.

    None of them outlives its test for long, even if the process of the tests is killed: a scheduler without work
    ends itself after a minute, and workers end with it.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.processes = folder, list[subprocess.Popen[bytes]]()
        self.scheduler, self.address = self.schedule()

    def schedule(self) -> tuple[subprocess.Popen[bytes], str]:
        """Start a scheduler; returns it and its address when it listens."""
        found = self.folder / f"scheduler-{len(self.processes)}.json"
        started = self._start("scheduler", "--port", "0", "--scheduler-file", str(found), "--idle-timeout", "60s")
        address = ""

        def told() -> bool:
            nonlocal address
            with suppress(OSError, ValueError):  # not there, or half written
                address = json.loads(found.read_text())["address"]
            return bool(address)

        try:
            wait_until(told)
        except BaseException:
            self.stop()
            raise
        return started, address

    def _start(self, program: str, *options: str, **env: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.dask_{program}", "--host", "127.0.0.1"]
        with (self.folder / f"{program}-{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(
                [*command, "--no-dashboard", *options],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                cwd=self.folder,
                env=os.environ | env,
                start_new_session=True,
            )
        self.processes.append(process)
        return process

    def worker(
        self, *options: str, fake: str = FAKE, nanny: bool = False, to: str = "", **env: str
    ) -> subprocess.Popen[bytes]:
        """Start a worker that flies what `fake` says; empty: real runs.  to: address of another scheduler."""
        extra = ["--death-timeout", "60"]
        if "--nthreads" not in options:
            extra += ["--nthreads", "1"]
        if not nanny:
            extra.append("--no-nanny")
        if fake:
            script = self.folder / f"fake{len(self.processes)}.py"
            script.write_text(fake)
            extra += ["--preload", str(script)]
        return self._start("worker", to or self.address, *extra, *options, **env)

    def crew(self, size: int, at: str = "") -> None:
        """Wait for a number of workers."""
        from distributed import Client

        with Client(at or self.address, set_as_default=False, timeout=LIMIT_S) as client:
            client.wait_for_workers(size, timeout=LIMIT_S)

    def stop(self) -> None:
        """End all processes, whatever they do."""
        for process in self.processes:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # a nanny's worker is of its session
        for process in self.processes:
            process.wait(LIMIT_S)


@contextmanager
def cluster(folder: Path) -> Iterator[Cluster]:
    """A cluster without workers, and an end to whatever hangs with it."""

    def hangs(_: int, frame: FrameType | None) -> None:
        pytest.fail(f"the test hangs, after {WHOLE_S} s in {frame}")  # no Exception: nothing takes it for its own

    before = signal.signal(signal.SIGALRM, hangs)
    signal.alarm(WHOLE_S)
    try:
        started = Cluster(folder)
        try:
            yield started
        finally:
            started.stop()
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def wait_until(true: Callable[[], bool], limit: float = LIMIT_S) -> None:
    """Wait for something, not for ever."""
    end = time.monotonic() + limit
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def orders(out: Path, number: int, **order: Any) -> Task:
    """A task that the fake flies."""
    parameters = {"log": str(out / "log"), **order}
    return Task(f"run{number}", 0, number, "{}", parameters, str(out))


def flown(out: Path) -> list[int]:
    """Seeds of the runs that the fake began, in order."""
    log = out / "log"
    return [int(line.split()[0]) for line in log.read_text().splitlines()] if log.exists() else []
