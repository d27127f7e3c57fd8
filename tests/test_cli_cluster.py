"""`aerosim sweep --dask`, as a user meets it: the same table whoever dies, exit codes, resuming."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from dask_cluster import HIDE, LIMIT_S, Cluster, wait_until
from sweeps import WIND, files, same, tiny_file

from aerosim.cli.app import call
from aerosim.sweep import driver
from aerosim.sweep.results import Sweep


class Command:
    """`aerosim sweep` in a process of its own, in two winds, six runs of a third of a second."""

    def __init__(self, folder: Path, out: Path) -> None:
        self.out = out
        varied = [f"--vary={WIND}=0,6", "--seeds=3"]
        self.args = ["sweep", str(tiny_file(folder)), *varied, "--out", str(out)]

    def start(self, *options: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "aerosim", *self.args, *options]
        return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def begun(self, process: subprocess.Popen[str], runs: int) -> None:
        """Wait until so many runs are done, and it goes on."""
        wait_until(lambda: len(files(self.out)) >= runs or process.poll() is not None, 2 * LIMIT_S)
        assert process.poll() is None, process.communicate()


def ended(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    """Exit code, what it printed, what it said."""
    try:
        told, said = process.communicate(timeout=2 * LIMIT_S)
    finally:
        process.kill()
    assert "Traceback" not in said
    return process.returncode, told, said


def whole(folder: Path) -> Sweep:
    """The same sweep, flown in this process."""
    local = Command(folder, folder / "local")
    assert call([*local.args, "--workers=0", "-q"]) == 0
    return Sweep(local.out)


def test_the_same_table_with_one_of_two_workers_killed_half_way(
    dask: Cluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(driver, "write_report", lambda *_: None)  # drawing it would double the time
    victim = dask.worker(fake="")
    dask.worker(fake="")
    args = ["sweep", str(tiny_file(tmp_path)), f"--vary={WIND}=0,6", "--seeds=3", "-q"]
    assert call([*args, "--out", str(tmp_path / "local"), "--workers=0"]) == 0  # while the workers start
    dask.crew(2)
    out = tmp_path / "cluster"

    def kill() -> None:
        wait_until(lambda: len(files(out)) >= 2, 2 * LIMIT_S)
        os.kill(victim.pid, signal.SIGSTOP)  # so that it is in the middle of a run whenever it dies
        wait_until(lambda: len(files(out)) >= 4)
        victim.kill()

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    assert call([*args, "--out", str(out), "--dask", dask.address]) == 0
    killer.join()
    assert "left in the middle of run" in (out / "sweep.log").read_text()
    there, local = Sweep(out), Sweep(tmp_path / "local")
    assert there.summary["done"] == 6
    assert same(there.table, local.table)


def test_an_address_at_which_nobody_answers_is_told_in_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("distributed")
    command = Command(tmp_path, tmp_path / "s")
    started = time.monotonic()
    assert call([*command.args, "--dask", "tcp://127.0.0.1:1"]) == 2
    # of the 10 s that a user is told, 4 s are for the start of the program, which is none here
    assert time.monotonic() - started < 6.0
    told, said = capsys.readouterr()
    assert told == ""
    assert said.startswith("--dask: no Dask scheduler answers at 'tcp://127.0.0.1:1' (")
    assert len(said.splitlines()) == 1
    assert not command.out.exists()


@pytest.mark.slow
def test_an_interrupt_leaves_a_directory_that_goes_on(dask: Cluster, tmp_path: Path) -> None:
    dask.worker(fake="")
    dask.crew(1)
    command = Command(tmp_path, tmp_path / "s")
    process = command.start("--dask", dask.address)
    command.begun(process, 3)
    process.send_signal(signal.SIGINT)
    code, told, said = ended(process)
    assert code == 130, said
    assert told.splitlines()[-1] == str(command.out)
    assert f"it goes on with: aerosim sweep {command.out} --resume" in said
    left = Sweep(command.out)
    assert (left.summary["status"], left.summary["reason"]) == ("interrupted", "interrupted by the user")
    assert 2 <= left.table.num_rows < 6  # the third may have been written and not told yet
    there = files(command.out)
    code, _, said = ended(command.start("--dask", dask.address, "--resume"))
    assert code == 0, said
    now = files(command.out)
    # one run may be written twice: by the worker that was in the middle of it when the driver left
    assert sum(now[name] != there[name] for name in there) <= 1
    assert Sweep(command.out).summary["flown_now"] >= 6 - len(there) - 1
    assert same(Sweep(command.out).table, whole(tmp_path).table)


@pytest.mark.slow
def test_interrupted_on_a_cluster_it_goes_on_without(dask: Cluster, tmp_path: Path) -> None:
    dask.worker(fake="")
    dask.crew(1)
    command = Command(tmp_path, tmp_path / "s")
    process = command.start("--dask", dask.address)
    command.begun(process, 3)
    process.send_signal(signal.SIGINT)
    assert ended(process)[0] == 130
    assert call(["sweep", str(command.out), "--resume", "--workers=0", "-q"]) == 0
    assert same(Sweep(command.out).table, whole(tmp_path).table)


@pytest.mark.slow
def test_a_scheduler_that_dies_and_another_one(dask: Cluster, tmp_path: Path) -> None:
    dask.worker(fake="")
    dask.crew(1)
    command = Command(tmp_path, tmp_path / "s")
    process = command.start("--dask", dask.address)
    command.begun(process, 3)
    dask.scheduler.kill()
    code, told, said = ended(process)
    assert code == 3, said
    assert told.splitlines()[-1] == str(command.out)
    assert f"run failed: the Dask scheduler at {dask.address} is lost" in said
    left = Sweep(command.out).summary
    assert left["status"] == "failed"
    assert left["reason"].startswith(f"the Dask scheduler at {dask.address} is lost")
    _, address = dask.schedule()
    dask.worker(fake="", to=address)
    dask.crew(1, at=address)
    code, _, said = ended(command.start("--dask", address, "--resume"))
    assert code == 0, said
    done = Sweep(command.out)
    assert done.summary["flown_now"] <= 6 - 3
    assert same(done.table, whole(tmp_path).table)


@pytest.mark.slow
def test_a_worker_that_cannot_take_part_is_wrong_input_and_leaves_a_record(dask: Cluster, tmp_path: Path) -> None:
    dask.worker(fake=HIDE.format(module="admission"))
    dask.crew(1)
    command = Command(tmp_path, tmp_path / "s")
    code, told, said = ended(command.start("--dask", dask.address, "--keep=records", "-q"))
    assert (code, told) == (2, "")
    assert len(said.splitlines()) == 1
    assert "--keep records needs a folder that all machines share" in said
    left = Sweep(command.out)
    assert (left.summary["status"], left.summary["done"], left.table.num_rows) == ("failed", 0, 0)
    assert left.summary["reason"] == said.strip()
