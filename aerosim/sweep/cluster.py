"""Runs on more than one machine: workers of a Dask cluster, which may come and go."""

from __future__ import annotations

import logging
import queue
import secrets
import socket
import time
from collections import deque
from collections.abc import Generator, Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from aerosim.errors import RunFailure
from aerosim.sweep.admission import Demand, missing, scenario_files, unfit
from aerosim.sweep.cluster_link import Admission, Crew, End, Link, Silence
from aerosim.sweep.executor import LIVES, lost_result
from aerosim.sweep.work import Result, Task, fly, run_one, write_whole

journal = logging.getLogger("aerosim")

REMIND_S = 30.0  # between two words to a user whose cluster has no workers


class _Flight(NamedTuple):
    """A task under way.  future: holds the result on the worker until it is fetched."""

    task: Task
    worker: str
    future: Any


class DaskExecutor:
    """Flies on the workers of a Dask cluster: processes with one thread each, on any number of machines.

    Each worker holds one run at a time.  Its result comes back through the scheduler; a worker that sees the
    sweep directory also writes the run's file there.  Workers may come and go; the first look is strict (a worker
    that cannot take part is an error), later ones that cannot take part are left alone, with a warning.
    """

    def __init__(self, address: str) -> None:
        """address: of the scheduler, as ``tcp://host:8786``.

        Raises InputError, within 10 s, if the extra is not installed, nobody answers there, or a worker differs.
        """
        self.address = address
        self._left = 0
        self._link: Link | None = Link(address)
        try:
            self._link.check(None)
        except BaseException:
            self.close()
            raise

    @property
    def workers(self) -> int:
        """Workers there now; after the sweep, those at its end."""
        return len(self._link.threads) if self._link else self._left

    def close(self) -> None:
        """Leave the cluster; what is still flown there is not fetched."""
        if self._link:
            self._left = len(self._link.threads)
            self._link.close()
        self._link = None

    def run(self, tasks: Iterator[Task]) -> Generator[Result, None, None]:
        """Results in the order in which they end.

        A worker in the middle of a run cannot be stopped from here: after close() it ends that run for nobody.
        Raises InputError if a worker lacks a file or the shared folder, RunFailure if the scheduler is lost.
        """
        first = next(tasks, None)
        if first is None:
            return
        self._link = self._link or Link(self.address)
        mark = Path(first.out) / f".cluster-{secrets.token_hex(8)}"
        try:
            write_whole(mark, "by this file a worker knows that it sees this folder\n")
            demand = Demand(str(mark), first.keep == "records", scenario_files(first))
            fit = self._link.check(demand)
            yield from _Fleet(self._link, fit, first, tasks, demand).results()
        finally:
            self.close()
            with suppress(OSError):
                mark.unlink()


def fly_there(task: Task, mark: str) -> Result:
    """Fly a run on a worker of a cluster.  mark: file by which it knows that it sees the sweep directory."""
    if said := missing(scenario_files(task), socket.gethostname()):
        return lost_result(task, said)
    if Path(mark).exists():
        return run_one(task)
    return fly(replace(task, cache=_own_cache()) if task.cache else task)


def _own_cache() -> str:
    """Folder of flown trajectories of a worker on a machine that does not see the driver's."""
    from distributed import get_worker

    return str(Path(get_worker().local_directory) / "flights")


class _Fleet:
    """The workers of one sweep and the tasks under way."""

    def __init__(self, link: Link, fit: list[str], first: Task, tasks: Iterator[Task], demand: Demand) -> None:
        """fit: workers that may take part at once.  first: task that was pulled before the others."""
        self.link, self.tasks, self.demand = link, tasks, demand
        self.again = deque([first])
        self.there = set(fit)  # on the cluster, taking part or not
        self.idle = deque(fit)
        self.under_way: dict[int, _Flight] = {}
        self.deaths: dict[str, int] = {}
        self.tickets = 0
        self.reminded = time.monotonic()

    def results(self) -> Iterator[Result]:
        while self._hand_out():
            try:
                message = self.link.heard.get(timeout=1.0)
            except queue.Empty:
                self._remind()
                continue
            match message:
                case End():
                    yield from self._ended(message)
                case Crew():
                    yield from self._changed(message.threads)
                case Admission():
                    self._admit(message)
                case Silence():
                    self._lost(message.why)

    def _hand_out(self) -> bool:
        """Give every idle worker a task.  Returns whether there is anything left to wait for."""
        while self.idle and (task := self._next_task()) is not None:
            worker = self.idle.popleft()
            self.tickets += 1
            future = self.link.submit(self.tickets, fly_there, (task, self.demand.mark), worker)
            self.under_way[self.tickets] = _Flight(task, worker, future)
        if not self.under_way and (task := self._next_task()) is not None:
            self.again.appendleft(task)  # all workers left; there is work for the next who comes
        return bool(self.under_way or self.again)

    def _next_task(self) -> Task | None:
        return self.again.popleft() if self.again else next(self.tasks, None)

    def _ended(self, end: End) -> Iterator[Result]:
        flight = self.under_way.pop(end.ticket, None)
        if flight is None:
            return  # of a worker that was given up before
        flight.future.release()
        if isinstance(end.found, Result):
            self.idle.append(flight.worker)
            yield end.found
            return
        if self.link.client.status != "running":
            self._lost(str(end.found))
        self.link.ask(flight.worker, self.demand)
        kind = type(end.found).__name__
        if kind == "FutureCancelledError":  # somebody restarted the workers
            yield from self._died(flight)
        elif kind == "KilledWorker":  # Dask's own count: the worker came back under its address each time
            yield lost_result(flight.task, f"the worker process died {LIVES} times or more")
        else:
            said = f"internal error: {kind}: {end.found}"
            yield lost_result(flight.task, " ".join(said.split()))

    def _changed(self, threads: dict[str, int]) -> Iterator[Result]:
        """Ask new workers what they are; give the tasks of those that left to others."""
        came, left = threads.keys() - self.there, self.there - threads.keys()
        self.there = set(threads)
        for worker in sorted(came):
            self.link.ask(worker, self.demand)
        self.idle = deque(worker for worker in self.idle if worker not in left)
        for ticket, flight in list(self.under_way.items()):
            if flight.worker in left:
                del self.under_way[ticket]
                flight.future.release()
                yield from self._died(flight)

    def _died(self, flight: _Flight) -> Iterator[Result]:
        """A task whose worker left in the middle of it goes to another, or is a failed result at last."""
        task = flight.task
        self.deaths[task.id] = self.deaths.get(task.id, 0) + 1
        journal.warning("worker %s left in the middle of run %s", flight.worker, task.id)
        if self.deaths[task.id] < LIVES:
            self.again.appendleft(task)
        else:
            yield lost_result(task, f"the worker process died {LIVES} times")

    def _admit(self, said: Admission) -> None:
        if said.worker not in self.there:
            return
        why = unfit(said.found, self.link.threads.get(said.worker, 1), self.link.here)
        if why:
            journal.warning("worker %s does not take part: %s", said.worker, why)
        else:
            self.idle.append(said.worker)

    def _remind(self) -> None:
        if not self.under_way and time.monotonic() - self.reminded > REMIND_S:
            self.reminded = time.monotonic()
            journal.warning("no worker at %s can take a run; waiting for one", self.link.address)

    def _lost(self, why: str) -> None:
        said = " ".join(why.partition("\n")[0].split())
        raise RunFailure(f"the Dask scheduler at {self.link.address} is lost ({said}); --resume goes on from here")
