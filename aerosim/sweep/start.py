"""From what a user says of a sweep, in Python or on the command line, to its start."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from aerosim.errors import InputError
from aerosim.scenario import Override, Scenario, load, variants
from aerosim.sweep.driver import drive
from aerosim.sweep.executor import Executor, LocalExecutor, SerialExecutor
from aerosim.sweep.folder import FLIGHTS, LOG, SPEC
from aerosim.sweep.results import Sweep
from aerosim.sweep.spec import OPTION, SweepSpec, make_spec
from aerosim.sweep.specfile import find_sweep, load_sweep
from aerosim.sweep.stoprule import StopRule
from aerosim.sweep.vary import varied

WORKERS_MAX = 512


class Asked(NamedTuple):
    """A sweep that was asked for.  out: its directory, unless the user says another."""

    spec: SweepSpec
    out: Path


def asked_for(
    source: str | Path | Scenario | SweepSpec,
    vary: Mapping[str, Any],
    settings: Mapping[str, Any],
    overrides: Mapping[str, object] | list[Override],
    option: str = "",
) -> Asked:
    """The sweep that is meant, checked.

    settings: fields of SweepSpec.  option: before the names of the varied keys in messages, as ``--vary``;
    settings are then named as options too.  Raises InputError.
    """
    if isinstance(source, SweepSpec):
        if vary or settings or overrides:
            raise InputError("a checked sweep is taken as it is", key="scenario", allowed="dataclasses.replace")
        return Asked(source, Path("sweeps") / source.scenario.name)
    places = dict.fromkeys(vary, f"{option or 'vary'} ")
    places |= dict.fromkeys(settings, OPTION if option else "")
    values = {key: _varied(key, each, places[key]) for key, each in vary.items()}
    fields = _fields(settings)
    changes = overrides if isinstance(overrides, list) else [Override(*item) for item in overrides.items()]
    if isinstance(source, Scenario):
        scenario = next(variants(source, [changes])) if changes else source
        return Asked(make_spec(scenario, values, places=places, **fields), Path("sweeps") / scenario.name)
    if (file := find_sweep(source)) is not None:
        spec = load_sweep(file, fields, values, changes, places)
        return Asked(spec, file.parent if file.name == SPEC else Path("sweeps") / file.stem)
    scenario = load(source, changes)
    places |= {"vary": OPTION} if option else {}
    return Asked(make_spec(scenario, values, places=places, **fields), Path("sweeps") / scenario.name)


def _varied(key: str, values: Any, place: str) -> Any:
    try:
        return varied(values)
    except InputError as error:
        raise InputError(error.problem, key=f"{place}{key}", allowed=error.allowed) from error


def _fields(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of SweepSpec; the rule for stopping may be text."""
    fields = dict(settings)
    if isinstance(rule := fields.get("stop_when"), str):
        fields["stop_when"] = StopRule.parse(rule)
    if "samples" in fields:
        fields.setdefault("sampling", "latin_hypercube")
    return fields


def executor_of(workers: int | None, dask: str | None, log: Path | None) -> Executor:
    """Where the runs are flown.  Raises InputError."""
    if dask is not None:
        if workers is not None:
            raise InputError("is of no use with --dask", key="--workers", allowed="the cluster's workers fly")
        from aerosim.sweep.cluster import DaskExecutor

        return DaskExecutor(dask)
    if workers is None:
        workers = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not 0 <= workers <= WORKERS_MAX:
        raise InputError(
            f"{workers} processes", key="--workers", allowed=f"1 to {WORKERS_MAX}, or 0: in this process"
        )
    return LocalExecutor(workers, log) if workers else SerialExecutor()


def start(
    source: str | Path | Scenario | SweepSpec,
    vary: Mapping[str, Any],
    settings: Mapping[str, Any],
    overrides: Mapping[str, object] | list[Override],
    *,
    out: Path | None,
    workers: int | None,
    dask: str | None,
    resume: bool,
    retry_failed: bool,
    progress: Callable[[float, float], None] | None,
    option: str = "",
) -> Sweep:
    """Check a sweep and fly it; see `aerosim.sweep`."""
    asked = asked_for(source, vary, settings, overrides, option)
    where = (out if out is not None else asked.out).absolute()
    if retry_failed and not where.exists():
        raise InputError(f"{where} is not there", key="--retry-failed", allowed="the directory of a sweep")
    executor = executor_of(workers, dask, where / LOG)
    return drive(
        asked.spec,
        where,
        executor,
        resume=resume or retry_failed,
        retry_failed=retry_failed,
        cache=where / FLIGHTS,
        progress=progress,
    )
