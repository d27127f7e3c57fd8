"""Flown trajectories kept on disk: one serves all cameras, estimators and controllers that cannot influence it.

A file bears the digest of everything that its flight was made from: the plan, air, aircraft and seed, the program
with its libraries, and the machine.  So nothing is ever out of date; what is not asked for again is dropped.
"""

from __future__ import annotations

import hashlib
import logging
import os
import platform
import secrets
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import metadata
from pathlib import Path

from aerosim.flight.interface import Flight, Recordable, Sortie
from aerosim.flight.recorded import RecordedFlight, record
from aerosim.flight.recording import Recording, from_bytes, to_bytes

journal = logging.getLogger("aerosim")

BYTES_MAX = 2 << 30
"""Bytes of a folder of flights by default: some 200 of a quarter of an hour at 120 Hz."""
WAIT_S = 30.0  # for another process that flies the same flight; then this one flies it as well
STALE_S = 3600.0  # age at which a file half written is nobody's any more
ROOM_LOCK = ".room.lock"
_POLL_S = 0.02
_LIBRARIES = ("jsbsim", "numpy", "scipy", "numba", "llvmlite")


@cache
def program() -> str:
    """Digest of what makes a flight of its ingredients: aerosim's source, libraries, interpreter and machine.

    The processor counts: numerical libraries choose their code by it, and the last bit of a result follows.
    """
    from llvmlite import binding

    out = hashlib.sha256()
    package = Path(__file__).resolve().parents[1]
    for file in sorted(f for f in package.rglob("*.py") if "_data" not in f.parts):
        out.update(f"{file.relative_to(package).as_posix()} {file.stat().st_size};".encode() + file.read_bytes())
    versions = [f"{name} {metadata.version(name)}" for name in _LIBRARIES]
    machine = [platform.python_version(), platform.system(), platform.machine(), *platform.libc_ver()]
    processor = [binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten()]
    out.update("\n".join([*versions, *machine, *processor]).encode())
    return out.hexdigest()


class Flights:
    """A folder of flown trajectories, to be given to `simulate` and `run`.  Several processes may share it."""

    def __init__(self, folder: Path, bytes_max: int = BYTES_MAX) -> None:
        """folder: made if need be.  bytes_max: of all its files; what was not used for longest goes first.

        A folder that cannot be made or is full costs time and nothing else: each run flies its own flight.
        """
        self.folder, self.bytes_max = folder, bytes_max
        self.flown = self.found = 0
        self._writes = True
        self._last: tuple[str, Recording] | None = None
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        self._writes = False
        said = error.strerror or str(error)
        journal.warning("%s keeps no more flights, each run flies its own: %s", self.folder, said)

    def __call__(self, sortie: Sortie, fly: Callable[[], Recordable]) -> Flight:
        """The flight of a sortie: one that was flown before, or a new one, flown to its end and kept.

        Raises InputError if it cannot be flown.
        """
        key = hashlib.sha256(f"{program()} {sortie.content()}".encode()).hexdigest()
        recording = self._find(key)
        if recording is None and not self._writes:
            return fly()
        if recording is None:
            with _held(self.folder / f".{key}.lock"):
                recording = self._find(key) or self._fly(key, sortie, fly)
        self._last = key, recording
        return RecordedFlight(recording)

    def _file(self, key: str) -> Path:
        return self.folder / f"{key}.flight"

    def _find(self, key: str) -> Recording | None:
        """The flight of a key if it is there and whole.  A damaged file is removed."""
        if self._last is not None and self._last[0] == key:
            self.found += 1
            return self._last[1]
        file = self._file(key)
        try:
            found = from_bytes(file.read_bytes())
        except ValueError as error:
            journal.warning("flight %s is flown anew: %s", file, error)
            with suppress(OSError):
                file.unlink()
            return None
        except OSError:
            return None
        with suppress(OSError):
            os.utime(file)  # used now
        self.found += 1
        return found

    def _fly(self, key: str, sortie: Sortie, fly: Callable[[], Recordable]) -> Recording:
        recording = record(fly(), sortie)
        self.flown += 1
        try:
            self._keep(key, to_bytes(recording))
        except OSError as error:
            self._give_up(error)
        return recording

    def _keep(self, key: str, data: bytes) -> None:
        """Write a file so that it is there whole or not at all.  Raises OSError."""
        part = self.folder / f".{key}.{secrets.token_hex(4)}.part"
        if len(data) > self.bytes_max:
            journal.info("a flight of %d bytes is not kept: %d are the most", len(data), self.bytes_max)
            return
        with _held(self.folder / ROOM_LOCK):  # one makes room and writes at a time: the bound holds
            self._make_room(len(data))
            try:
                # not forced to the disk: a file that a power cut leaves cut off is found out by its checksum
                part.write_bytes(data)
                part.replace(self._file(key))
            finally:
                part.unlink(missing_ok=True)

    def _make_room(self, size: int) -> None:
        """Remove the files that were not used for longest until so many bytes more fit."""
        used, files = 0, []
        for entry in os.scandir(self.folder):
            with suppress(OSError):  # another process may have removed it
                status = entry.stat()
                old = time.time() - status.st_mtime > STALE_S
                if old and entry.name != ROOM_LOCK and entry.name.endswith((".part", ".lock")):
                    os.unlink(entry.path)
                    continue
                used += status.st_size
                if entry.name.endswith(".flight"):
                    files.append((status.st_mtime_ns, status.st_size, entry.path))
        for _, length, path in sorted(files):
            if used + size <= self.bytes_max:
                return
            with suppress(OSError):
                os.unlink(path)
            used -= length


@cache
def flights_in(folder: str, bytes_max: int = BYTES_MAX) -> Flights:
    """The flights in a folder, one object for each folder and process, so that the last flight stays in memory."""
    return Flights(Path(folder), bytes_max)


@contextmanager
def _held(lock: Path) -> Iterator[None]:
    """Hold a lock file meanwhile, if it is to be had within half a minute: it saves work, nothing depends on it.

    The system frees the lock of a process that dies.  A file system without locks, or a process that hangs with
    one, costs a flight that is flown twice.
    """
    try:
        import fcntl
    except ImportError:  # no such locks here
        yield
        return
    try:
        stream = lock.open("wb")
    except OSError:
        yield
        return
    with stream:
        until = time.monotonic() + WAIT_S
        while time.monotonic() < until:
            try:
                fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                time.sleep(_POLL_S)
            except OSError:
                break
        try:
            yield
        finally:
            if lock.name != ROOM_LOCK:
                with suppress(OSError):
                    lock.unlink()
