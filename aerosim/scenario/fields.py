"""Walk through the section models: fields by dotted path, their ranges, names near to a misspelt one."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any, get_args

from pydantic.fields import FieldInfo

from aerosim.scenario.section import Section

# longest first, so that _m_s is not read as _s
_UNIT_WORDS = (
    "_deg2_per_s _pct2_per_s _grey_per_s _deg_per_km _deg_per_h _m_s2 _m_s _deg_s _agl_m _per_s _grey _deg _pct "
    "_mm _um _px _kg _hz _km _kn _kt _kts _ft _min _ms _s _m _h"
)
UNITS = _UNIT_WORDS.split()


def stem(name: str) -> str:
    """Name without its unit."""
    return next((name[: -len(unit)] for unit in UNITS if name.endswith(unit) and len(name) > len(unit)), name)


def sections_in(annotation: Any) -> list[type[Section]]:
    """Section models that a field's type allows."""
    if isinstance(annotation, type) and issubclass(annotation, Section):
        return [annotation]
    return [model for part in get_args(annotation) for model in sections_in(part)]


def key_of(name: str, info: FieldInfo) -> str:
    """Key of a field in the file."""
    return info.alias or name


def fields(models: list[type[Section]]) -> dict[str, FieldInfo]:
    """All keys of these sections."""
    return {key_of(name, info): info for model in models for name, info in model.model_fields.items()}


def models_at(root: type[Section], path: tuple[str | int, ...]) -> list[type[Section]]:
    """Section models whose keys may stand below a path; empty if none."""
    models = [root]
    for part in path:
        if isinstance(part, str) and models and part in (known := fields(models)):
            models = sections_in(known[part].annotation)
    return models


def field_at(root: type[Section], path: tuple[str | int, ...]) -> FieldInfo | None:
    """Field of a path, or None; of an element of a short list ([latitude, longitude]) its range."""
    if not path:
        return None
    last = path[-1]
    if isinstance(last, str):
        return fields(models_at(root, path[:-1])).get(last)
    listed = field_at(root, path[:-1])
    parts = get_args(listed.annotation) if listed else ()
    return FieldInfo.from_annotation(parts[last]) if last < len(parts) else None


def walk(root: type[Section], prefix: str = "") -> Iterator[tuple[str, FieldInfo]]:
    """Every field with its dotted key, sections included, depth first."""
    for key, info in fields([root]).items():
        yield prefix + key, info
        for model in sections_in(info.annotation):
            yield from walk(model, f"{prefix}{key}.")


def _near(name: str, known: list[str]) -> str | None:
    lower, own = name.lower(), stem(name.lower())
    for test in (
        lambda key: key.lower() == lower,
        lambda key: stem(key) == own,
        lambda key: len(own) > 3 and (stem(key).endswith(own) or stem(key).startswith(own)),
    ):
        if found := next((key for key in known if test(key)), None):
            return found
    return None


def _similar(name: str, known: list[str]) -> str | None:
    lower, own = name.lower(), stem(name.lower())
    if near := get_close_matches(lower, known, 1, 0.6):
        return near[0]
    stems = {stem(key): key for key in reversed(known)}
    near = get_close_matches(own, list(stems), 1, 0.6)
    return stems[near[0]] if near else None


def misspelt(root: type[Section], path: tuple[str | int, ...]) -> tuple[str, str]:
    """Problem and hint for a key that does not exist: missing unit, nearest name, or the section it belongs to."""
    name, known = str(path[-1]), list(fields(models_at(root, path[:-1])))
    near = _near(name, known)
    elsewhere = [key for key, _ in walk(root) if key == name or key.endswith(f".{name}")]
    if not near and elsewhere:
        return "unknown key here", f"did you mean {elsewhere[0]}?"
    if near := near or _similar(name, known):
        unitless = name == stem(name) and near != stem(near)
        return f"unknown key{', without its unit' if unitless else ''}", f"did you mean {near}?"
    return "unknown key", f"allowed: {', '.join(known)}" if known else ""
