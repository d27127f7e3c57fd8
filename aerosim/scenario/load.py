"""From a scenario file, or a shipped name, and overriding options to a checked Scenario."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import ValidationError

from aerosim.assets import folder
from aerosim.errors import InputError
from aerosim.scenario.aircraft import is_path
from aerosim.scenario.places import Places
from aerosim.scenario.reader import parse, read
from aerosim.scenario.scenario import Scenario
from aerosim.scenario.section import Section
from aerosim.scenario.translate import translated

# keys that hold the path of a file
FILE_KEYS = (
    "terrain.source.orthophoto",
    "terrain.source.elevation",
    "aircraft.model",
    "flight.replay",
    "flight.replay.file",
    "flight.file",
    "flight.area.file",
    "estimation.table",
)


class Override(NamedTuple):
    """A value that replaces the file's.  option: as shown in messages, with a blank if the key follows it."""

    key: str
    value: Any
    option: str = "override "


def shipped() -> dict[str, Path]:
    """Scenarios that ship with the package, by name."""
    return {file.stem: file for file in sorted(folder("scenarios").glob("*.yaml"))}


def find_scenario(source: str | Path) -> Path:
    """File of a scenario: a path, or the name of a shipped one.  Raises InputError with the nearest names."""
    path, names = Path(source), shipped()
    try:
        is_folder, exists = path.is_dir(), path.exists()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=str(source)) from error
    if exists and not is_folder:
        return path
    if str(source) in names:
        return names[str(source)]
    if is_folder:
        allowed = "a scenario file, or a name from `aerosim list`"
        raise InputError("is a folder", allowed=allowed, where=str(source))
    near = get_close_matches(path.stem, names, 3, 0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"shipped: {', '.join(names)}"
    raise InputError("no such scenario file or shipped name", allowed=hint, where=str(source) or "''")


def parse_setting(text: str, option: str = "--set") -> Override:
    """Override from ``key.path=value``; the value is read as YAML.  Raises InputError."""
    key, equals, value = text.partition("=")
    key = key.strip()
    if not equals or not key or not all(key.split(".")):
        raise InputError(f"{text!r} sets nothing", key=option, allowed="KEY.PATH=VALUE, as air.wind.speed_m_s=5")
    try:
        return Override(key, parse(value, "value")[0], f"{option} ")
    except InputError as error:
        raise InputError(error.problem, key=f"{option} {key}", allowed=error.allowed) from error


def _plain(value: Any) -> Any:
    """Value as the reader would have given it."""
    if isinstance(value, Section):
        return _plain(value.model_dump(by_alias=True))
    if isinstance(value, Mapping):
        return {str(key): _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return tuple(_plain(each) for each in value)
    return str(value) if isinstance(value, Path) else value


def _parts(key: str) -> list[str]:
    """Parts of a dotted key; those of `expect` are themselves dotted (crab.split_deg.lag), before min or max."""
    parts = key.split(".")
    if parts[0] != "expect" or len(parts) < 3:
        return parts
    end = len(parts) - 1 if parts[-1] in ("min", "max") else len(parts)
    return [parts[0], ".".join(parts[1:end]), *parts[end:]]


def _replaced(tree: Any, parts: Sequence[str], value: Any, override: Override) -> Any:
    """Copy of the tree with the value put at the path; sections are made on the way."""
    if not parts:
        return value
    head, *rest = parts
    if isinstance(tree, tuple):
        if not head.isdigit() or int(head) >= len(tree):
            problem, allowed = f"the list has no element {head!r}", f"allowed: 0 to {len(tree) - 1}"
            raise Places(options={override.key: override.option}).error(override.key, problem, allowed)
        at = int(head)
        return (*tree[:at], _replaced(tree[at], rest, value, override), *tree[at + 1 :])
    below = tree if isinstance(tree, dict) else {}
    return {**below, head: _replaced(below.get(head), rest, value, override)}


def _overridden(data: dict[str, Any], overrides: Sequence[Override], places: Places) -> dict[str, Any]:
    here = Path.cwd()
    for override in overrides:
        value = _absolute(_plain(override.value), override.key, here)
        data = _replaced(data, _parts(override.key), value, override)
        places.options[override.key] = override.option
    return data


def _absolute(value: Any, key: str, base: Path) -> Any:
    """The value with the paths of files in it made absolute."""
    if key == "aircraft.model" and not (isinstance(value, str) and is_path(value)):
        return value
    if key in FILE_KEYS and isinstance(value, str) and value:
        return str((base / Path(value).expanduser()).resolve())
    if isinstance(value, dict):
        return {name: _absolute(each, f"{key}.{name}" if key else name, base) for name, each in value.items()}
    return value


def absolute(value: Any, key: str, base: Path) -> Any:
    """A value of a dotted key, plain, with the paths of files in it made absolute from the folder `base`."""
    return _absolute(_plain(value), key, base)


def _validated(data: dict[str, Any], places: Places) -> Scenario:
    """Checked scenario; of several errors the one in the lowest line is raised."""
    try:
        scenario = Scenario.model_validate(data)
    except ValidationError as error:
        found = translated(error.errors(include_url=False), Scenario)
        key, problem, allowed = min(found, key=lambda each: places.line(each[0]))
        raise places.error(key, problem, allowed) from error
    scenario._places, scenario._given = places, data
    return scenario


def from_mapping(data: Mapping[str, Any], *, base: Path | None = None) -> Scenario:
    """Scenario from a mapping as the YAML file has it.

    base: folder that paths are relative to, by default the current one.  Raises InputError.
    """
    return _validated(_absolute(_plain(data), "", base or Path.cwd()), Places())


def load(source: str | Path, overrides: Sequence[Override] = ()) -> Scenario:
    """Scenario from a file or shipped name, with options that replace its values.  Raises InputError."""
    file = find_scenario(source)
    data, lines = read(file, str(file))
    places = Places(file=str(file), lines=lines)
    data = _absolute(data, "", file.resolve().parent)
    return _validated(_overridden(data, overrides, places), places)


def load_scenario(source: str | Path, overrides: Mapping[str, object] | None = None) -> Scenario:
    """Scenario from a file or shipped name.

    overrides: values by dotted key, as ``{"air.wind.speed_m_s": 5}``, replacing the file's.  Raises InputError.
    """
    return load(source, [Override(key, value) for key, value in (overrides or {}).items()])


def given(scenario: Scenario) -> dict[str, Any]:
    """What was written of a scenario, before any default, with the paths of files made absolute."""
    data = dict(scenario._given)
    if not data or Scenario.model_validate(data) != scenario:  # made or changed in Python
        data = _plain(scenario.model_dump(by_alias=True, exclude_unset=True))
    return data


def variants(scenario: Scenario, each: Iterable[Sequence[Override]]) -> Iterator[Scenario]:
    """Other scenarios, one for each set of values to replace, checked anew.

    Defaults that follow from control.mode follow the new mode.  Raises InputError.
    """
    data = given(scenario)
    for overrides in each:
        places = Places(scenario._places.file, scenario._places.lines, dict(scenario._places.options))
        yield _validated(_overridden(dict(data), overrides, places), places)


def with_overrides(scenario: Scenario, overrides: Mapping[str, object]) -> Scenario:
    """Another scenario with some values replaced, by dotted key, checked anew.

    Defaults that follow from control.mode follow the new mode.  Raises InputError.
    """
    return next(variants(scenario, [[Override(*item) for item in overrides.items()]]))
