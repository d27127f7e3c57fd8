"""The connection to a Dask scheduler: who is there, what is handed out, what is heard."""

from __future__ import annotations

import asyncio
import logging
import queue
import secrets
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NamedTuple

from aerosim.errors import InputError
from aerosim.sweep.admission import Demand, Facts, facts, unfit, versions_here
from aerosim.sweep.work import Result

GREET_S = 3.0  # a user is told within 10 s that nobody answers, the start of the program included
CONNECT_S = 7.0
LOOK_S = 0.5  # between two looks at who is there
SILENCE_S = 30.0  # after which a scheduler counts as gone
ADDRESS = "the address that `dask scheduler` prints"
TALKERS = ("distributed.client", "distributed.batched", "distributed.comm.tcp", "distributed.core")
INSTALL = 'pip install "aerosim-survey[cluster]"'


class Crew(NamedTuple):
    """Who is there.  threads: of each worker, by address."""

    threads: dict[str, int]


class Admission(NamedTuple):
    """What a worker said of itself."""

    worker: str
    found: Facts | BaseException


class End(NamedTuple):
    """How a task ended.  ticket: its number when it was handed out."""

    ticket: int
    found: Result | BaseException


class Silence(NamedTuple):
    """The scheduler is gone, or does not answer."""

    why: str


class Link:
    """The connection to a scheduler.  What happens there is put into `heard`, in the order in which it happens.

    threads: of each worker there now, by address.  here: what this process is, which the workers must be too.
    """

    def __init__(self, address: str) -> None:
        """Connect.  Raises InputError."""
        self.address = address
        self.heard: queue.SimpleQueue[Crew | Admission | End | Silence] = queue.SimpleQueue()
        self.threads: dict[str, int] = {}
        self.here = versions_here()
        self.client = _connect(address)
        self.client.loop.add_callback(self._look)

    def check(self, demand: Demand | None) -> list[str]:
        """Workers there now.  Raises InputError that names one of them which cannot take part."""
        try:
            self.threads, found = self.client.sync(self._ask_all, demand, callback_timeout=SILENCE_S)
        except (OSError, TimeoutError) as error:
            problem = f"the workers at {self.address} do not answer ({error or type(error).__name__})"
            raise InputError(problem, key="--dask") from error
        for worker, each in sorted(found.items()):
            if why := unfit(each, self.threads.get(worker, 1), self.here):
                raise InputError(f"worker {worker} cannot take part: {why}", key="--dask")
        return sorted(found)

    def submit(self, ticket: int, call: Any, arguments: tuple[Any, ...], worker: str) -> Any:
        """Have one worker call a function; its end will be heard.  Returns the future that holds the result."""
        key = f"aerosim-{ticket}-{secrets.token_hex(8)}"
        future = self.client.submit(call, *arguments, key=key, workers=[worker], pure=False)
        self.client.loop.add_callback(self._await, ticket, future)
        return future

    def ask(self, worker: str, demand: Demand) -> None:
        """Ask a worker what it is; its answer will be heard."""
        self.client.loop.add_callback(self._ask, worker, demand)

    def close(self) -> None:
        """Close the connection; the scheduler forgets what was asked of it."""
        for name in TALKERS:  # what is cut off in the middle is known, and told in our words
            logging.getLogger(name).setLevel(logging.CRITICAL)
        with suppress(OSError, TimeoutError, RuntimeError):
            self.client.close(timeout=2)

    async def _await(self, ticket: int, future: Any) -> None:
        try:
            found = await self.client.gather(future, asynchronous=True)
        except (Exception, asyncio.CancelledError) as error:
            self.heard.put(End(ticket, error))
        else:
            self.heard.put(End(ticket, found))

    async def _ask_all(self, demand: Demand | None) -> tuple[dict[str, int], dict[str, Any]]:
        threads = await self.client.nthreads(asynchronous=True)
        if not threads:  # to ask nobody in particular is an error of Dask's
            return threads, {}
        asked = self.client.run(facts, demand, workers=list(threads), asynchronous=True, on_error="return")
        return threads, await asked

    async def _ask(self, worker: str, demand: Demand) -> None:
        try:
            asked = self.client.run(facts, demand, workers=[worker], asynchronous=True, on_error="return")
            found = (await asyncio.wait_for(asked, SILENCE_S))[worker]
        except Exception as error:
            found = error
        self.heard.put(Admission(worker, found))

    async def _look(self) -> None:
        """Tell who is there, each time that it changes, until the connection ends."""
        told: dict[str, int] | None = None
        while self.client.status == "running":
            try:
                threads = await asyncio.wait_for(self.client.nthreads(asynchronous=True), SILENCE_S)
            except Exception as error:
                self.heard.put(Silence(str(error) or type(error).__name__))
                return
            if threads != told:
                told = self.threads = threads
                self.heard.put(Crew(threads))
            await asyncio.sleep(LOOK_S)
        self.heard.put(Silence("the connection is closed"))


def _connect(address: str) -> Any:
    """Client of a scheduler.  Raises InputError."""
    try:
        import distributed
    except ImportError as error:
        raise InputError("Dask is not installed", key="--dask", allowed=INSTALL) from error
    if not address.strip():  # Dask would start workers of its own
        raise InputError("no address is given", key="--dask", allowed=ADDRESS)
    make: Any = distributed.Client
    try:
        _in_time(lambda: asyncio.run(_greet(address)), GREET_S + 0.5)
        return _in_time(lambda: make(address, timeout=CONNECT_S, set_as_default=False), CONNECT_S + 1.0)
    except Exception as error:  # whatever Dask makes of what is said there, it is no scheduler's greeting
        problem = f"no Dask scheduler answers at {address!r} ({_said(error)})"
        raise InputError(problem, key="--dask", allowed=ADDRESS) from error


async def _greet(address: str) -> None:
    """Ask who is there.  A Client that finds no scheduler would keep on trying, and complain of it at the end."""
    from distributed import core, security

    made: Any = security.Security
    dial: Any = core.rpc
    keys = made().get_connection_args("client")
    async with dial(address, timeout=GREET_S, connection_args=keys) as there:
        found = await asyncio.wait_for(there.identity(), GREET_S)
    if found["type"] != "Scheduler":
        raise ValueError(f"it is the address of a {found['type'].lower()}")


def _said(error: Exception) -> str:
    """An error of the connection in a few words."""
    if isinstance(error, MemoryError):  # what is read as lengths of a message is something else
        return "something else answers"
    return str(error) or ("no greeting in time" if isinstance(error, TimeoutError) else type(error).__name__)


def _in_time(make: Callable[[], Any], seconds: float) -> Any:
    """What `make` returns or raises.  Raises TimeoutError: Dask waits without end for one who never greets."""
    ended: queue.SimpleQueue[tuple[Any, Exception | None]] = queue.SimpleQueue()

    def attempt() -> None:
        try:
            ended.put((make(), None))
        except Exception as error:
            ended.put((None, error))

    threading.Thread(target=attempt, daemon=True).start()
    try:
        made, error = ended.get(timeout=seconds)
    except queue.Empty:
        raise TimeoutError(f"no greeting within {seconds:g} s") from None
    if error is not None:
        raise error
    return made
