"""Validation errors in the words of the user: key, what is wrong, what is allowed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from pydantic.fields import FieldInfo

from aerosim.scenario.available import AVAILABLE
from aerosim.scenario.checks import Problem
from aerosim.scenario.fields import field_at, fields, misspelt, sections_in
from aerosim.scenario.places import dotted
from aerosim.scenario.section import Section

_WORDS = {"gt": "more than {}", "ge": "at least {}", "lt": "less than {}", "le": "at most {}"}
_RANGES = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}
_TYPES = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "a word",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "dict_type": "a section",
    "model_type": "a section",
    "model_attributes_type": "a section",
}


def shown(value: Any) -> str:
    """Value as the user wrote it, short."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else f"{'-' if value < 0 else ''}.inf"
    if isinstance(value, Mapping):
        return "{...}"
    if isinstance(value, (tuple, list)):
        return "[...]" if value else "[]"
    text = repr(value)
    return text if len(text) <= 40 else text[:36] + "..."


def _bound(value: float) -> str:
    return str(value) if isinstance(value, int) else f"{value:.10g}"


def limits(info: FieldInfo | None, ctx: Mapping[str, Any] | None = None) -> str:
    """Range of a field in words: "more than 0, at most 20000"; from an error's context if the field has none."""
    found = {}
    for bound in info.metadata if info else ():
        found.update({name: value for name in _WORDS if (value := getattr(bound, name, None)) is not None})
    if not found and ctx:
        found = {name: ctx[name] for name in _WORDS if name in ctx}
    return ", ".join(word.format(_bound(found[name])) for name, word in _WORDS.items() if name in found)


def _type_problem(error: Mapping[str, Any], info: FieldInfo | None) -> tuple[str, str]:
    kind = error["type"]
    value, wanted = error.get("input"), _TYPES[kind]
    if wanted == "a section":
        return f"{shown(value)} is not a section", "allowed: a section of KEY: VALUE lines"
    span = limits(info) if kind in {"float_type", "int_type", "int_from_float"} else ""
    return f"{shown(value)} is not {wanted}", f"allowed: {wanted}{', ' + span if span else ''}"


def _count(number: int) -> str:
    return f"{number} value{'' if number == 1 else 's'}"


def _length_problem(error: Mapping[str, Any]) -> tuple[str, str]:
    ctx = error["ctx"]
    if "actual_length" in ctx and ctx.get("field_type") == "Tuple":
        bound = f"at least {ctx['min_length']}" if "min_length" in ctx else f"{ctx['max_length']}"
        return f"has {_count(ctx['actual_length'])}", f"allowed: {bound}"
    return "is empty", "at least one character"


def _choice(error: Mapping[str, Any], info: FieldInfo | None, key: str) -> str:
    """Words that are allowed, what else the field's type allows, and the nearest word."""
    loc, value = error["loc"], error.get("input")
    words = ", ".join(AVAILABLE.get(key, (error["ctx"]["expected"].replace("'", "").replace(" or ", ", "),)))
    if info and "<word>" in loc:
        keys = fields(sections_in(info.annotation))
        words += f", or {{{', '.join(keys)}: VALUE}}" if keys else ", or a number"
    near = get_close_matches(str(value), words.split(", "), 1, 0.6)
    return f"allowed: {words}{f'; did you mean {near[0]}?' if near else ''}"


def _words_of(error: Mapping[str, Any], root: type[Section], path: tuple[str | int, ...]) -> tuple[str, str]:
    """Problem and what is allowed, for one error of pydantic."""
    kind, value, ctx = error["type"], error.get("input"), error.get("ctx", {})
    info = field_at(root, path)
    if kind == "extra_forbidden":
        return misspelt(root, path)
    if kind == "literal_error":
        return f"{shown(value)} is not known", _choice(error, info, dotted(path))
    if kind in _TYPES:
        return _type_problem(error, info)
    if kind in {"too_short", "too_long", "string_too_short"}:
        return _length_problem(error)
    means = info.description if info and info.description else ""
    problem, allowed = {
        "missing": ("is missing", means),
        "finite_number": (f"{shown(value)} is not a finite number", f"allowed: {limits(info) or 'a number'}"),
        "string_pattern_mismatch": (f"{shown(value)} cannot be used", f"allowed: {means}"),
    }.get(kind, (str(error["msg"]).lower(), ""))
    if kind in _RANGES:
        return f"{shown(value)} is out of range", f"allowed: {limits(info, ctx)}"
    return problem, allowed


def _path(error: Mapping[str, Any]) -> tuple[str | int, ...]:
    """Keys that lead to an error; the tags of unions are no keys."""
    return tuple(part for part in error["loc"] if not (isinstance(part, str) and part.startswith("<")))


def translated(errors: Sequence[Mapping[str, Any]], root: type[Section]) -> list[Problem]:
    """Key, problem and what is allowed of each error.  errors: of pydantic's ValidationError."""
    out: list[Problem] = []
    for error in errors:
        path = _path(error)
        if error["type"] == "too_short" and any(
            _path(other)[: len(path)] == path != _path(other) for other in errors
        ):
            continue  # wrong elements are not counted: theirs are the errors
        if error["type"] == "aerosim":
            for below, problem, allowed in error["ctx"]["problems"]:
                out.append((".".join(part for part in (dotted(path), below) if part), problem, allowed))
        elif error["type"] == "missing" and isinstance(path[-1], int):
            out.append((dotted(path[:-1]), f"has {_count(len(error['input']))}", f"at least {path[-1] + 1}"))
        else:
            out.append((dotted(path), *_words_of(error, root, path)))
    return out
