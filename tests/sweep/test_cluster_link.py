"""The connection to a scheduler: who does not answer, or is none, is told in one line and in time."""

from __future__ import annotations

import re
import socket
import sys
import threading
import time
from collections.abc import Iterator

import pytest
from dask_cluster import Cluster, wait_until

from aerosim.errors import InputError
from aerosim.sweep import cluster_link
from aerosim.sweep.cluster import DaskExecutor


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half a second instead of what users are given."""
    pytest.importorskip("distributed")
    monkeypatch.setattr(cluster_link, "GREET_S", 0.5)


@pytest.fixture
def free() -> Iterator[int]:
    """A port at which nobody listens."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        yield one.getsockname()[1]


@pytest.fixture
def talker() -> Iterator[tuple[int, list[bytes]]]:
    """A port at which somebody listens and says what is put into the list."""
    says: list[bytes] = []
    kept = []
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        one.listen()

        def answer() -> None:
            while True:
                try:
                    caller, _ = one.accept()
                    kept.append(caller)
                    caller.sendall(b"".join(says))
                except OSError:  # closed by the test
                    return

        threading.Thread(target=answer, daemon=True).start()
        yield one.getsockname()[1], says
        one.shutdown(socket.SHUT_RDWR)
    for caller in kept:
        caller.close()


def refused(address: str) -> str:
    """What is said of an address at which no scheduler is, in one line and in time."""
    started = time.monotonic()
    with pytest.raises(InputError, match="no Dask scheduler answers at") as caught:
        DaskExecutor(address)
    assert time.monotonic() - started < 3.0
    assert caught.value.key == "--dask"
    assert len(str(caught.value).splitlines()) == 1
    return str(caught.value)


@pytest.mark.parametrize("address", ["nowhere", "tcp://127.0.0.1:{free}", "foo://127.0.0.1:1"])
def test_unreachable_address(hasty: None, free: int, address: str) -> None:
    assert address.partition("{")[0] in refused(address.format(free=free))


@pytest.mark.parametrize(
    "words",
    [b"", b"SSH-2.0-OpenSSH_9.2p1 Debian-2\r\n", b"HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\nno"],
    ids=["nothing", "ssh", "http"],
)
def test_somebody_who_is_no_scheduler(hasty: None, talker: tuple[int, list[bytes]], words: bytes) -> None:
    """Who answers the phone and says nothing, or something else: read as lengths of messages it is exabytes."""
    port, says = talker
    says.append(words)
    said = refused(f"127.0.0.1:{port}")
    assert "Unable to allocate" not in said


@pytest.mark.slow
def test_the_address_of_a_worker(dask: Cluster, hasty: None) -> None:
    dask.worker(fake="")
    dask.crew(1)
    log = dask.folder / "worker-1.log"
    wait_until(lambda: "Start worker at" in log.read_text())
    found = re.search(r"Start worker at:\s+(tcp:\S+)", log.read_text())
    assert found
    assert "it is the address of a worker" in refused(found[1])


def test_empty_address() -> None:
    with pytest.raises(InputError, match="--dask: no address is given"):
        DaskExecutor("")


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(
        InputError, match=r'--dask: Dask is not installed \(pip install "aerosim-survey\[cluster\]"\)'
    ):
        DaskExecutor("tcp://127.0.0.1:1")
