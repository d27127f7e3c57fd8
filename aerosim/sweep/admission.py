"""Which workers of a cluster may fly runs: the same programs, one thread, the folders and files in reach."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import socket
from collections.abc import Mapping
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

from aerosim.assets import folder
from aerosim.sweep.inputs import is_file, leaves
from aerosim.sweep.work import ONE_THREAD, Task

# what the figures of a run depend on; the others may differ from machine to machine
PACKAGES = ("jsbsim", "numpy", "numba", "scipy", "rasterio", "pyproj")


class Demand(NamedTuple):
    """What a worker's machine must have for a sweep.

    mark: a file in the sweep directory, by which a worker knows that it sees that directory.
    shared: it must see it (runs keep their records there).  files: of the scenario, by key.
    """

    mark: str
    shared: bool
    files: Mapping[str, str]


class Facts(NamedTuple):
    """What a worker says of itself.  versions: by name.  lacks: what is demanded and not there, "" if nothing."""

    versions: Mapping[str, str]
    lacks: str


def facts(demand: Demand | None) -> Facts:
    """What a worker is, called there before it gets a run.

    From here on numerical libraries use one thread, if the process has not loaded them yet; one that did nothing
    else has not.
    """
    os.environ.update(ONE_THREAD)
    return Facts(versions_here(), lacking(demand) if demand else "")


def versions_here() -> dict[str, str]:
    """What the figures of a run depend on, in this process: versions by name."""
    versions = {name: metadata.version(name) for name in PACKAGES}
    return versions | {
        "python": ".".join(platform.python_version_tuple()[:2]),
        "aerosim": metadata.version("aerosim-survey"),
        "aerosim's source": _source(),
    }


@cache
def _source() -> str:
    """Digest of the program and of its aircraft: a version number does not tell two checkouts apart."""
    digest = hashlib.sha256()
    for root, pattern in ((Path(__file__).resolve().parents[1], "*.py"), (folder("aircraft"), "*.xml")):
        # the scripts that made the shipped data are in a wheel and not in a checkout's package
        found = (f for f in root.rglob(pattern) if "_data" not in f.relative_to(root).parts)
        for file in sorted(found, key=lambda f: f.relative_to(root).as_posix()):
            digest.update(file.relative_to(root).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:12]


def lacking(demand: Demand) -> str:
    """What of a demand is not on this machine, in words; "" if all is there."""
    host = socket.gethostname()
    if demand.shared and not Path(demand.mark).exists():
        out = Path(demand.mark).parent
        return f"{host} does not see {out}: --keep records needs a folder that all machines share, at one path"
    return missing(demand.files, host)


def missing(files: Mapping[str, str], host: str) -> str:
    """The first file that is not here, in words; "" if all are."""
    for key, file in files.items():
        if not Path(file).exists():
            return f"{key}: {file} is not on {host}: all machines need it at the same path"
    return ""


def scenario_files(task: Task) -> dict[str, str]:
    """Files of the user that a run reads, by key; paths are absolute."""
    values = {
        key: value for key, value in leaves(json.loads(task.scenario)) if not _replaced(key, task.parameters)
    }
    values |= dict(leaves(task.parameters))
    return {key: value for key, value in values.items() if is_file(key, value)}


def _replaced(key: str, parameters: Mapping[str, Any]) -> bool:
    return any(key == name or key.startswith(f"{name}.") for name in parameters)


def unfit(found: Facts | BaseException, threads: int, here: Mapping[str, str]) -> str:
    """Why a worker may not take part, in words; "" if it may.

    found: its facts, or how asking for them ended.  here: versions of the driver.
    """
    if isinstance(found, BaseException):
        said = f"{type(found).__name__}: {found}"
        # what went wrong before the call is told by Dask as the text of another exception
        if any(kind in said for kind in ("ModuleNotFoundError", "ImportError", "AttributeError")):
            return f"it has no aerosim, or another one ({said}); here it is {here['aerosim']}"
        return f"it does not say what it is ({said})"
    for name, version in here.items():
        if (there := found.versions.get(name, "missing")) != version:
            return f"{name} is {there} there and {version} here: the same programs give the same table"
    if threads != 1:
        return f"it has {threads} threads: start it with --nthreads 1, and with --nworkers for more cores"
    return found.lacks
