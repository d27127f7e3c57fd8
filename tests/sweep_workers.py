"""A worker process whose runs do as they are told, for the tests of the executor."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

from aerosim.sweep import executor
from aerosim.sweep.work import Result, Task

START = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); import sweep_workers; sweep_workers.main()"


def obey(task: Task) -> Result:
    """Do what the task's parameters say: sleep (s), die, die_once (a file that remembers), print."""
    told = task.parameters
    with (Path(task.out) / "flown.log").open("a") as log:
        log.write(f"{task.id} {os.getpid()}\n")
    if "die" in told:
        os.kill(os.getpid(), signal.SIGKILL)
    if "die_once" in told and not Path(told["die_once"]).exists():
        Path(told["die_once"]).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    if "print" in told:
        print("a library says something")
        os.write(1, b"and so does a C library\n")
    time.sleep(told.get("sleep", 0))
    threads = {name: os.environ.get(name, "") for name in told.get("threads", ())}
    return Result(task.id, task.point, task.seed, "done", "", told, {"pid": os.getpid(), **threads})


def main() -> None:
    executor.run_one = obey
    executor.serve()


def broken() -> None:
    print("no module named physics", file=sys.stderr)
    sys.exit(7)
