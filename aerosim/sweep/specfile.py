"""The sweep file: YAML for a sweep, read strictly, and written into the sweep's directory."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from aerosim.assets import folder
from aerosim.errors import InputError
from aerosim.scenario import Override, Scenario, absolute, find_scenario, from_mapping, load, text_of, variants
from aerosim.scenario.reader import read
from aerosim.sweep.spec import SweepSpec, make_spec
from aerosim.sweep.stoprule import StopRule
from aerosim.sweep.vary import Varied, as_written, varied
from aerosim.sweep.work import version

KEYS = (
    "sweep", "aerosim", "scenario", "set", "vary", "sampling", "samples", "sampling_seed", "seeds", "keep",
    "stop_when", "inputs",
)  # fmt: skip
FORMAT = 1


def shipped_sweeps() -> dict[str, Path]:
    """Sweeps that ship with the package, by name."""
    return {file.stem: file for file in sorted((folder("scenarios") / "sweeps").glob("*.yaml"))}


def find_sweep(source: str | Path) -> Path | None:
    """Sweep file behind a path or shipped name; None if the source is a scenario.  Raises InputError."""
    path = Path(source)
    if not path.exists() and str(source) in shipped_sweeps():
        return shipped_sweeps()[str(source)]
    if path.is_dir() and (path / "sweep.yaml").is_file():
        return path / "sweep.yaml"
    file = find_scenario(source)
    data, _ = read(file, str(source))
    return file if "vary" in data or "sweep" in data else None


class _File:
    """A sweep file that was read: its values, and errors that name file, line and key."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.data, self.lines = read(file, str(file))

    def where(self, key: str) -> str:
        return f"{self.file}:{self.lines.get(key, 1)}"

    def error(self, key: str, problem: str, allowed: str = "") -> InputError:
        return InputError(problem, key=key, allowed=allowed, where=self.where(key))

    def mapping(self, key: str) -> dict[str, Any]:
        found = self.data.get(key)
        if found is None:
            return {}
        if not isinstance(found, dict):
            raise self.error(key, "is no mapping", "DOTTED.KEY: VALUE lines")
        return found

    def check_keys(self) -> None:
        for key in self.data:
            if key not in KEYS:
                near = get_close_matches(key, KEYS, 1, 0.5)
                hint = f"did you mean {near[0]}?" if near else f"keys: {', '.join(KEYS)}"
                raise self.error(key, "unknown key", hint)
        if self.data.get("sweep", FORMAT) != FORMAT:
            raise self.error("sweep", f"{self.data['sweep']!r} is no known layout", f"{FORMAT}")

    def scenario(self) -> Scenario:
        """The scenario named or written out, with `set` put in."""
        here, source = self.file.resolve().parent, self.data.get("scenario")
        overrides = [
            Override(key, absolute(value, key, here), f"{self.where(f'set.{key}')}: ")
            for key, value in self.mapping("set").items()
        ]
        if isinstance(source, dict):
            return next(variants(from_mapping(source, base=here), [overrides]))
        if not isinstance(source, str) or not source:
            raise self.error("scenario", "no scenario is named", "a file, beside this one, or a shipped name")
        file = here / Path(source).expanduser()
        try:
            return load(file if file.is_file() else source, overrides)
        except InputError as error:
            raise (
                error
                if error.where != source
                else self.error("scenario", f"{source}: {error.problem}", error.allowed)
            ) from error

    def vary(self) -> list[dict[str, Varied]]:
        """Values of each grid."""
        found = self.data.get("vary")
        if not isinstance(found, tuple):
            return [self._grid("vary")]
        if not found:
            raise self.error("vary", "is an empty list", "one grid, or a list of grids")
        return [self._grid(f"vary.{k}") for k in range(len(found))]

    def _grid(self, at: str) -> dict[str, Varied]:
        out = {}
        for key, values in self.grid_keys(at).items():
            try:
                out[key] = varied(values)
            except InputError as error:
                raise self.error(f"{at}.{key}", error.problem, error.allowed) from error
        return out

    def grid_keys(self, at: str) -> dict[str, Any]:
        """The mapping of `vary`, or of an element of its list as `vary.1`."""
        if at == "vary":
            return self.mapping("vary")
        found = self.data["vary"][int(at.partition(".")[2])]
        if not isinstance(found, dict) or not found:
            raise self.error(at, "is no grid", "DOTTED.KEY: VALUES lines")
        return found

    def places(self) -> dict[str, str]:
        """Where the file has each setting and each varied key, first places first."""
        out = {key: f"{self.where(key)}: " for key in KEYS if key in self.data}
        found = self.data.get("vary")
        grids = [f"vary.{k}" for k in range(len(found))] if isinstance(found, tuple) else ["vary"]
        for at in grids:
            for key in self.grid_keys(at):
                out.setdefault(key, f"{self.where(f'{at}.{key}')}: ")
        return out

    def stop_when(self) -> StopRule | None:
        text = self.data.get("stop_when")
        if text is None:
            return None
        if not isinstance(text, str):
            raise self.error("stop_when", f"{text!r} is no rule", "METRIC:HALFWIDTH or METRIC:5%")
        try:
            return StopRule.parse(text)
        except InputError as error:
            raise self.error("stop_when", error.problem, error.allowed) from error


def load_sweep(
    file: Path,
    changes: Mapping[str, Any] | None = None,
    more: Mapping[str, Varied] | None = None,
    overrides: Sequence[Override] = (),
    places: Mapping[str, str] | None = None,
) -> SweepSpec:
    """Sweep of a file.

    changes: fields of SweepSpec that replace the file's.  more: varied keys that replace or join the file's.
    overrides: of the scenario.  places: of what is not in the file, for messages.  Raises InputError.
    """  # fmt: skip
    found = _File(file)
    found.check_keys()
    settings = {
        key: found.data[key]
        for key in ("sampling", "samples", "sampling_seed", "seeds", "keep")
        if found.data.get(key) is not None
    }
    if (rule := found.stop_when()) is not None:
        settings["stop_when"] = rule
    where = {"vary": f"{file}: "} | found.places()
    scenario = found.scenario()
    if overrides:
        scenario = next(variants(scenario, [overrides]))
    grids, here = [each | dict(more or {}) for each in found.vary()], file.resolve().parent
    settings |= changes or {}
    return make_spec(scenario, grids, base=here, places=where | dict(places or {}), **settings)


def _written(vary: Mapping[str, Varied]) -> dict[str, Any]:
    return {key: as_written(values) for key, values in vary.items()}


def sweep_text(spec: SweepSpec) -> str:
    """Sweep file with everything in it: it needs no other file but those that it names.

    inputs: digests of these, for telling whether they have changed; who loads the file takes them anew.
    """
    data: dict[str, Any] = {
        "sweep": FORMAT,
        "aerosim": version(),
        "vary": [_written(each) for each in spec.grids] if spec.grids else _written(spec.vary),
        "sampling": spec.sampling,
        **({"samples": spec.samples, "sampling_seed": spec.sampling_seed} if spec.samples else {}),
        "seeds": spec.seeds,
        "keep": spec.keep,
        "stop_when": str(spec.stop_when) if spec.stop_when else None,
        "scenario": json.loads(spec.base),
        **({"inputs": spec.inputs} if spec.inputs else {}),
    }
    return text_of(data)
