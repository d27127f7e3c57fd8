"""Where the runs of a sweep are flown: in processes of this machine, or in this process."""

from __future__ import annotations

import json
import os
import pickle
import queue
import signal
import struct
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Generator, Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, Protocol

from aerosim.errors import RunFailure
from aerosim.sweep.work import ONE_THREAD, Result, Task, read_result, result_file, run_one

AHEAD = 2  # tasks a worker holds: the one it flies and the next, so that it never waits
LIVES = 2  # a task whose worker died so often is a failed run
_LENGTH = struct.Struct("<Q")
# not multiprocessing: its workers import the user's script again, which then needs a main guard
_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from aerosim.sweep.executor import serve; serve()"
)


class Executor(Protocol):
    """Flies tasks somewhere."""

    @property
    def workers(self) -> int:
        """How many runs are flown at the same time."""

    def run(self, tasks: Iterator[Task]) -> Generator[Result, None, None]:
        """Results in the order in which they end.

        Tasks are pulled when there is somebody to fly them (at most a few for each worker), so that whoever
        makes them may stop.  A worker that dies gives its task to another; the second time it is a failed result.
        Every task pulled gives one result.  close() of the generator ends what is being flown, at once.
        Raises RunFailure if nothing can be flown.
        """


class SerialExecutor:
    """Flies in this process, one run after the other: for debugging."""

    workers = 1

    def run(self, tasks: Iterator[Task]) -> Generator[Result, None, None]:
        """Results in the tasks' order."""
        for task in tasks:
            yield run_one(task)


def send(pipe: IO[bytes], message: Any) -> None:
    """Write one message to a pipe.  Raises OSError."""
    data = pickle.dumps(message)
    pipe.write(_LENGTH.pack(len(data)) + data)
    pipe.flush()


def receive(pipe: IO[bytes]) -> Any:
    """Next message of a pipe.  Raises EOFError when the other side is gone."""
    head = pipe.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        raise EOFError
    size = _LENGTH.unpack(head)[0]
    data = pipe.read(size)
    if len(data) < size:
        raise EOFError
    return pickle.loads(data)


def serve() -> None:
    """A worker process: flies what comes on stdin, tells results on stdout, ends with the one who started it."""
    told = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a library prints is no result
    waiting: queue.SimpleQueue[Task | None] = queue.SimpleQueue()

    def listen() -> None:
        while True:
            try:
                waiting.put(receive(sys.stdin.buffer))
            except (EOFError, OSError):
                os._exit(1)  # the driver is gone: a run that ended now would be flown twice

    threading.Thread(target=listen, daemon=True).start()
    send(told, "ready")
    while (task := waiting.get()) is not None:
        send(told, run_one(task))
    os._exit(0)  # the listening thread still reads


class _Worker:
    """A worker process and what it holds."""

    def __init__(self, number: int, heard: queue.SimpleQueue[tuple[int, Any]], log: Path | None) -> None:
        self.number, self.ready, self.holds = number, False, deque[Task]()
        errors = log.open("ab") if log is not None else None
        self.process = subprocess.Popen(
            [sys.executable, "-c", _START, json.dumps(sys.path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env={**os.environ, **ONE_THREAD},
            start_new_session=True,  # Ctrl-C is the driver's
        )
        if errors is not None:
            errors.close()
        threading.Thread(target=self._listen, args=(heard,), daemon=True).start()

    def _listen(self, heard: queue.SimpleQueue[tuple[int, Any]]) -> None:
        assert self.process.stdout is not None
        try:
            while True:
                heard.put((self.number, receive(self.process.stdout)))
        except (EOFError, OSError, ValueError, pickle.UnpicklingError):
            heard.put((self.number, None))

    def give(self, task: Task) -> None:
        """Hand a task over; if the process is dead, its end will be heard."""
        assert self.process.stdin is not None
        self.holds.append(task)
        with suppress(OSError):
            send(self.process.stdin, task)

    def end(self) -> None:
        """End the process, whatever it does."""
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout):
            if pipe is not None:
                with suppress(OSError):
                    pipe.close()


class LocalExecutor:
    """Flies in processes of this machine, each a fresh interpreter with one thread per library.

    They do not import the program that started them: it needs no main guard, and may be a notebook.
    """

    def __init__(self, workers: int, log: Path | None = None) -> None:
        """workers: processes.  log: file that takes what they say on stderr, None: the driver's."""
        self.workers, self.log = workers, log

    def run(self, tasks: Iterator[Task]) -> Generator[Result, None, None]:
        """Results in the order in which they end.  Raises RunFailure if worker processes do not start."""
        pool = _Pool(tasks, self.workers, self.log)
        try:
            yield from pool.results()
        finally:
            pool.end()


class _Pool:
    """The workers of one sweep and the tasks under way."""

    def __init__(self, tasks: Iterator[Task], size: int, log: Path | None) -> None:
        self.tasks, self.size, self.log = tasks, size, log
        self.heard: queue.SimpleQueue[tuple[int, Any]] = queue.SimpleQueue()
        self.workers: dict[int, _Worker] = {}
        self.again: deque[Task] = deque()
        self.deaths: dict[str, int] = {}
        self.started = 0

    def next_task(self) -> Task | None:
        return self.again.popleft() if self.again else next(self.tasks, None)

    def feed(self) -> None:
        """Give every worker what it can hold, and start workers while there are tasks for them."""
        for depth in range(1, AHEAD + 1):
            for number in range(self.size):
                self._feed_one(number, depth)

    def _feed_one(self, place: int, depth: int) -> None:
        worker = list(self.workers.values())[place] if place < len(self.workers) else None
        if worker is not None and len(worker.holds) >= depth:
            return
        task = self.next_task()
        if task is None:
            return
        if worker is None:
            worker = _Worker(self.started, self.heard, self.log)
            self.workers[self.started] = worker
            self.started += 1
        worker.give(task)

    def results(self) -> Iterator[Result]:
        self.feed()
        while any(worker.holds for worker in self.workers.values()):
            number, message = self.heard.get()
            worker = self.workers[number]
            if isinstance(message, Result):
                worker.holds.popleft()
                yield message
            elif message is None:
                if (lost := self.died(worker)) is not None:
                    yield lost
            else:
                worker.ready = True
            self.feed()

    def died(self, worker: _Worker) -> Result | None:
        """What follows from a worker's death: its tasks go to others, the one it flew at most so often."""
        worker.end()
        del self.workers[worker.number]
        if not worker.ready:
            where = f", see {self.log}" if self.log else ""
            raise RunFailure(f"worker processes do not start ({_ending(worker.process.returncode)}{where})")
        flown, *others = worker.holds or [None]
        self.again.extend(task for task in others if task is not None)
        if flown is None:
            return None
        if (ended := read_result(result_file(Path(flown.out), flown.id))) is not None:
            return ended
        self.deaths[flown.id] = self.deaths.get(flown.id, 0) + 1
        if self.deaths[flown.id] < LIVES:
            self.again.appendleft(flown)
            return None
        reason = f"the worker process died {LIVES} times ({_ending(worker.process.returncode)})"
        return lost_result(flown, reason)

    def end(self) -> None:
        for worker in self.workers.values():
            worker.end()


def lost_result(task: Task, reason: str) -> Result:
    """Failed result of a task that no worker could bring to an end."""
    return Result(task.id, task.point, task.seed, "failed", reason, dict(task.parameters))


def _ending(code: int) -> str:
    """How a process ended, in words."""
    if code < 0:
        return signal.Signals(-code).name
    return f"exit code {code}"
