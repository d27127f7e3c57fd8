"""`view` and `report`: look at runs."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Annotated
from urllib.parse import quote

import typer

from aerosim.cli.console import Debug, Quiet, Verbose, say
from aerosim.errors import InputError

Runs = Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run directories.")]
LOOPBACK = "127.0.0.1"
WEB_PORT, DATA_PORT = 9090, 9876
_STDERR = 2  # its file descriptor
# the viewer's own entry point drops the exit code
_VIEWER = (sys.executable, "-c", "import sys; from rerun_cli.__main__ import main; sys.exit(main())")


def recording(run: Path) -> Path:
    """Recording of a run for the viewer.  Raises InputError if there is none."""
    if run.is_file() and run.suffix == ".rrd":
        return run
    if not run.is_dir():
        raise InputError("no such run directory", where=str(run))
    file = run / "run.rrd"
    if not file.is_file():
        raise InputError("the run has no run.rrd", where=str(run), allowed="fly it with record.rrd: true")
    return file


def free_port(wanted: int) -> int:
    """The wanted port of the loopback interface, or another free one if it is taken."""
    for port in (wanted, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((LOOPBACK, port))
            except OSError:
                continue
            return int(probe.getsockname()[1])
    raise InputError("no free port", key="--web")


def _can_show() -> bool:
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _serve(files: list[str]) -> int:
    web, data = free_port(WEB_PORT), free_port(DATA_PORT)
    source = quote(f"rerun+http://{LOOPBACK}:{data}/proxy", safe="")
    say("served on this machine only, until Ctrl-C:")
    print(f"http://{LOOPBACK}:{web}/?url={source}", flush=True)
    command = [*_VIEWER, *files, "--serve-web", "--bind", LOOPBACK]
    try:
        # stdout holds the address and nothing else
        return subprocess.call([*command, "--web-viewer-port", str(web), "--port", str(data)], stdout=_STDERR)
    except KeyboardInterrupt:
        return 0  # the way to end a server


def view(
    runs: Runs,
    web: Annotated[
        bool,
        typer.Option("--web", help="Serve a viewer for the browser, on this machine only, and print its address."),
    ] = False,
    quiet: Quiet = False,
    verbose: Verbose = 0,
    debug: Debug = False,
) -> int:
    """Open runs in the rerun viewer."""
    files = [str(recording(run)) for run in runs]
    if web:
        code = _serve(files)
    elif _can_show():
        code = subprocess.call([*_VIEWER, *files, "--port", "auto"])
    else:
        raise InputError("no display for the viewer", key="view", allowed="--web serves it for a browser")
    if code not in (0, 130):
        raise InputError(f"the viewer ended with status {code}", key="view")
    return 0


def report(runs: Runs, quiet: Quiet = False, verbose: Verbose = 0, debug: Debug = False) -> int:
    """Make report.html of runs anew and print its path."""
    for run in runs:
        if not run.is_dir():
            raise InputError("no such run directory", where=str(run))
    from aerosim.report.page import write_report

    for run in runs:
        print(write_report(run))
    return 0
