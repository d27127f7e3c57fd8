"""Sweeps: many runs of one scenario, some values varied, the same seeds for all; resumable."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from aerosim.scenario import Scenario
    from aerosim.sweep.results import Sweep
    from aerosim.sweep.spec import SweepSpec

__all__ = ["sweep"]


def sweep(
    scenario: str | Path | Scenario | SweepSpec,
    vary: Mapping[str, Any] | None = None,
    *,
    out: str | Path | None = None,
    seeds: int | None = None,
    sampling: str | None = None,
    samples: int | None = None,
    sampling_seed: int | None = None,
    overrides: Mapping[str, object] | None = None,
    keep: str | None = None,
    stop_when: str | None = None,
    workers: int | None = None,
    dask: str | None = None,
    resume: bool = False,
    retry_failed: bool = False,
    progress: Callable[[float, float], None] | None = None,
) -> Sweep:
    """Fly a scenario many times, some values varied, and give the tables.

    scenario: a scenario, its file or shipped name; or a sweep, its file, shipped name or directory.  vary: by
    dotted key a list of values, ``{"from": low, "to": high, "step": step}``, or ``{"from": low, "to": high}`` for
    a Latin hypercube; added to the file's.  seeds: 1 ... seeds are flown at every point [1].  sampling: grid
    [default], list or latin_hypercube of `samples` points drawn by `sampling_seed`.  overrides: by dotted key, of
    all points.  keep: summaries [default] or records, a run directory each.  stop_when: ``METRIC:HALFWIDTH`` or
    ``METRIC:5%``.  out: the sweep directory [sweeps/<name>].  workers: processes [one a core]; 0 flies in this
    process.  dask: address of a scheduler instead.  resume: go on with a directory that is there.  retry_failed:
    fly failed runs again.  progress: told (runs ended, runs to fly).

    Raises InputError before anything is flown.  Runs that fail are rows of the table.  A sweep that is
    interrupted or cannot write raises Interrupted or RunFailure, its `path` resumes.
    """
    from aerosim.sweep.start import start

    wanted = {
        "seeds": seeds, "sampling": sampling, "samples": samples, "sampling_seed": sampling_seed, "keep": keep,
        "stop_when": stop_when,
    }  # fmt: skip
    return start(
        scenario,
        vary or {},
        {key: value for key, value in wanted.items() if value is not None},
        overrides or {},
        out=Path(out) if out is not None else None,
        workers=workers,
        dask=dask,
        resume=resume,
        retry_failed=retry_failed,
        progress=progress,
    )


class _Callable(ModuleType):
    """The import system binds this package to `aerosim.sweep`, the name of the public function: it is both."""

    def __call__(self, *args: Any, **settings: Any) -> Sweep:
        """The same as the function `sweep`."""
        return sweep(*args, **settings)


sys.modules[__name__].__class__ = _Callable
