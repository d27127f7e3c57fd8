"""What a sweep is: a scenario, what is varied, how often; its points and its tasks."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

from aerosim.errors import InputError
from aerosim.scenario import Override, Scenario, absolute, given, variants
from aerosim.sweep.inputs import content, files_in, leaves, may_name_file
from aerosim.sweep.stoprule import StopRule
from aerosim.sweep.vary import SAMPLINGS, Range, Varied, combined, together
from aerosim.sweep.work import Task, version

RUNS_MAX = 1_000_000
KEEPS = ("summaries", "records")
OPTION = "--"  # place of a setting that is given as the option of the same name
NOT_VARIED = {
    "seed": "seeds, which are shared by all points",
    "name": "another scenario",
    "schema": "another scenario",
    "expect": "another scenario",
}


class Point(NamedTuple):
    """One combination of the varied values.  number: from 0, in the order of the sweep; values: by dotted key."""

    number: int
    values: dict[str, Any]


@dataclass(frozen=True)
class SweepSpec:
    """A sweep, checked: every point is a scenario that can be flown as far as its values say.

    scenario: what all points have in common.  vary: values by dotted key.  grids: several grids one after the
    other, whose points have the keys of their own grid only; `vary` is then what they vary together.  sampling:
    grid, list or latin_hypercube (`samples` points drawn by `sampling_seed`).  seeds: 1 ... seeds are flown at
    every point, so that points differ by their values and not by their weather.  keep: records (a run directory
    each) or summaries.  stop_when: rule that may end the sweep earlier.  places: where each key was varied, for
    messages.
    """

    scenario: Scenario
    vary: Mapping[str, Varied]
    sampling: str = "grid"
    samples: int | None = None
    sampling_seed: int = 1
    seeds: int = 1
    keep: str = "summaries"
    stop_when: StopRule | None = None
    places: Mapping[str, str] = field(default_factory=dict, compare=False)
    grids: tuple[Mapping[str, Varied], ...] = ()

    @cached_property
    def points(self) -> list[Point]:
        """All points, in order.  Raises InputError."""
        try:
            each = self.grids or (self.vary,)
            ways = chain.from_iterable(
                [combined(vary, self.sampling, self.samples, self.sampling_seed) for vary in each]
            )
        except InputError as error:
            raise self.placed(error) from error
        return [Point(number, values) for number, values in enumerate(ways)]

    @cached_property
    def base(self) -> str:
        """What is written of the scenario, as JSON: the tasks carry it."""
        return json.dumps(canonical(given(self.scenario)))

    @property
    def is_grid(self) -> bool:
        """Whether all combinations of the varied values are flown."""
        return self.sampling == "grid" and len(self.grids) < 2

    @property
    def size(self) -> int:
        """Number of runs, if nothing stops them earlier."""
        return len(self.points) * self.seeds

    def placed(self, error: InputError) -> InputError:
        """The error with the place at which its key is varied."""
        if error.where or error.key not in self.places:
            return error
        place = self.places[error.key]
        name = error.key.replace("_", "-") if place == OPTION else error.key
        return replace(error, key=f"{place}{name}")

    def overrides(self, point: Point) -> list[Override]:
        """The point's values, each with the place at which it is varied."""
        return [Override(key, value, self.places.get(key, "vary ")) for key, value in point.values.items()]

    @cached_property
    def inputs(self) -> dict[str, str | None]:
        """Digests of the user's files that any point reads, by path; None where there is none to be read."""
        varied = {
            key: each for key, each in self.vary.items() if not isinstance(each, Range) and may_name_file(key)
        }
        of_points = [name for key, each in varied.items() for value in each for name in files_in({key: value})]
        return {name: content(Path(name)) for name in dict.fromkeys([*self._common_files, *of_points])}

    @cached_property
    def _common_files(self) -> list[str]:
        """Files of the scenario that any point reads."""
        replaced = set.intersection(*(set(vary) for vary in self.grids or (self.vary,)))
        kept = {
            key: value
            for key, value in leaves(json.loads(self.base))
            if not any(key == name or key.startswith(f"{name}.") for name in replaced)
        }
        return files_in(kept)

    @cached_property
    def _names(self) -> list[Any]:
        """By point, what the names of its runs start from, before the seed."""
        of_files = [key for key in self.vary if may_name_file(key)]
        common = "".join(f"{self.inputs[name]}\n" for name in self._common_files)
        start = hashlib.sha256(f"{version()}\n{self.base}\n{common}".encode())
        out = []
        for point in self.points:
            own = files_in({key: point.values[key] for key in of_files if key in point.values})
            read = "".join(f"{self.inputs[name]}\n" for name in own)
            each = start.copy()
            each.update(f"{json.dumps(point.values)}\n{read}".encode())
            out.append(each)
        return out

    def run_id(self, point: Point, seed: int) -> str:
        """Name of a run.

        A digest of all that decides the outcome: aerosim's version, what is written of the scenario, the values,
        the contents of the files that they name, and the seed.  Two points that come to the same scenario have
        runs of their own.
        """
        out = self._names[point.number].copy()
        out.update(str(seed).encode())
        return str(out.hexdigest()[:24])

    def runs(self) -> Iterator[tuple[int, Point]]:
        """All runs (seed, point): every point with seed 1, then every point with seed 2, ..."""
        return ((seed, point) for seed in range(1, self.seeds + 1) for point in self.points)

    def tasks(
        self, out: Path, cache: str = "", order: Iterable[tuple[int, Point]] | None = None
    ) -> Iterator[Task]:
        """All runs, as they travel to whoever flies them.  order: by default that of `runs`."""
        for seed, point in self.runs() if order is None else order:
            name = self.run_id(point, seed)
            yield Task(name, point.number, seed, self.base, point.values, str(out), self.keep, cache)


def canonical(value: Any) -> Any:
    """The value as YAML gives it back: whole numbers without a point, lists for tuples."""
    if isinstance(value, Mapping):
        return {key: canonical(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [canonical(each) for each in value]
    whole = isinstance(value, float) and value.is_integer() and abs(value) < 1e15
    return int(value) if whole else value


def make_spec(
    scenario: Scenario,
    vary: Mapping[str, Varied] | Sequence[Mapping[str, Varied]],
    *,
    base: Path | None = None,
    places: Mapping[str, str] | None = None,
    **settings: Any,
) -> SweepSpec:
    """A sweep whose every point was checked.  settings: the other fields of SweepSpec.

    vary: values by dotted key, or several such grids, one after the other.  base: folder that paths of files
    among the varied values are relative to, by default the current one.
    Raises InputError for the first thing that is wrong, before anything is flown.
    """
    here = base or Path.cwd()
    several = [vary] if isinstance(vary, Mapping) else vary
    grids = tuple({key: _absolute(values, key, here) for key, values in each.items()} for each in several)
    known = together(grids)
    own = () if len(grids) == 1 else grids
    spec = SweepSpec(scenario, known, places=dict(places or {}), grids=own, **settings)
    _check_settings(spec)
    if own and spec.sampling != "grid":
        problem, allowed = f"{spec.sampling} does not go with several grids", "grid, or one mapping in vary"
        raise spec.placed(InputError(problem, key="sampling", allowed=allowed))
    for key in spec.vary:
        if key in NOT_VARIED:
            raise spec.placed(InputError("cannot be varied", key=key, allowed=NOT_VARIED[key]))
    if spec.size > RUNS_MAX:
        problem = f"{len(spec.points)} points with {spec.seeds} seeds are {spec.size} runs"
        raise spec.placed(InputError(problem, key="seeds", allowed=f"at most {RUNS_MAX}"))
    _check_points(spec, spec.points)
    return spec


def _absolute(values: Varied, key: str, base: Path) -> Varied:
    """Values as YAML gives them, paths of files from the folder `base`."""
    if isinstance(values, Range):
        return values
    return tuple(canonical(absolute(each, key, base)) for each in values)


def _check_settings(spec: SweepSpec) -> None:
    for key, value, allowed in (("sampling", spec.sampling, SAMPLINGS), ("keep", spec.keep, KEEPS)):
        if value not in allowed:
            raise spec.placed(InputError(f"{value!r} is not known", key=key, allowed=" | ".join(allowed)))
    for key, number, least in (
        ("seeds", spec.seeds, 1),
        ("samples", spec.samples, 1),
        ("sampling_seed", spec.sampling_seed, 0),
    ):
        if number is None and key == "samples":
            continue
        if not isinstance(number, int) or isinstance(number, bool) or not least <= number <= RUNS_MAX:
            problem = f"{number!r} is no number of {key}" if key != "sampling_seed" else f"{number!r} is no seed"
            raise spec.placed(InputError(problem, key=key, allowed=f"a whole number, {least} to {RUNS_MAX}"))


def _check_points(spec: SweepSpec, points: Iterable[Point]) -> None:
    """Every point is a scenario, and no two have the same values.  Raises InputError."""
    seen: dict[str, int] = {}
    for point in points:
        first = seen.setdefault(json.dumps(point.values), point.number)
        if first != point.number:
            told = ", ".join(f"{key}={value}" for key, value in point.values.items())
            raise spec.placed(InputError(f"points {first} and {point.number} are the same: {told}", key="vary"))
    checked = variants(spec.scenario, (spec.overrides(point) for point in points))
    number = 0
    try:
        for _ in checked:
            number += 1
    except InputError as error:
        values = spec.points[number].values
        named = error.key.rpartition(" ")[2]
        if any(f"{key}.".startswith(f"{named}.") or named.startswith(f"{key}.") for key in values):
            raise
        told = ", ".join(f"{key}={value}" for key, value in values.items())
        raise replace(error, problem=f"{error.problem}, at {told}") from error
