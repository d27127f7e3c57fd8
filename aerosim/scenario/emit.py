"""A scenario as YAML: every default filled in, on request with a comment to each key."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from aerosim.scenario.fields import field_at
from aerosim.scenario.reader import plain
from aerosim.scenario.scenario import Scenario

_COLUMN = 44


def _quoted(text: str) -> str:
    escaped = json.dumps(text, ensure_ascii=False)
    # characters that YAML does not print: escaped as YAML has it (json splits those above U+FFFF in two)
    return "".join(
        c if " " <= c < "\x7f" or c in "°²µ" or ("\u00c0" <= c < "\u2000") else f"\\U{ord(c):08x}" for c in escaped
    )


def _word(text: str) -> str:
    plain_letters = text.isascii() and re.fullmatch(r"[A-Za-z][A-Za-z0-9_.-]*", text)
    return text if plain_letters and isinstance(plain(text), str) else _quoted(text)


def _number(value: float) -> str:
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)


def scalar(value: Any) -> str:
    """One value, or a list or mapping in flow style, on one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{scalar(key)}: {scalar(each)}" for key, each in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(scalar(each) for each in value) + "]"
    if isinstance(value, str):
        return _word(value)
    if isinstance(value, float):
        return _number(value)
    return json.dumps(value)


def _is_block(value: Any) -> bool:
    return isinstance(value, Mapping) and bool(value)


def _comment(key: str, parts: tuple[str, ...], comments: bool) -> str:
    info = field_at(Scenario, parts) if comments else None
    return f"{key:<{_COLUMN}} # {info.description}" if info and info.description else key


def _lines(data: Mapping[str, Any], path: tuple[str, ...], comments: bool) -> Iterator[str]:
    pad, after_block = "  " * len(path), False
    for key, value in data.items():
        here = (*path, key)
        name = f"{pad}{scalar(key)}:"
        if _is_block(value):
            if comments and not path:
                yield ""
            after_block = comments and not path
            yield _comment(name, here, comments)
            yield from _lines(value, here, comments)
            continue
        if after_block:
            yield ""
            after_block = False
        if isinstance(value, (list, tuple)) and any(isinstance(each, (Mapping, str)) for each in value):
            yield _comment(name, here, comments)
            yield from (f"{pad}  - {scalar(each)}" for each in value)
        else:
            yield _comment(f"{name} {scalar(value)}", here, comments)


def text_of(data: Mapping[str, Any]) -> str:
    """YAML text of plain values: mappings in block style, lists of plain values on one line."""
    return "\n".join(_lines(data, (), False)) + "\n"


def to_yaml(scenario: Scenario, *, comments: bool = False) -> str:
    """YAML text of a scenario, every default filled in; loading it gives an equal scenario."""
    data = scenario.model_dump(by_alias=True)
    for limit in data["expect"].values():
        for name in [name for name, value in limit.items() if value is None]:
            del limit[name]
    return "\n".join(_lines(data, (), comments)) + "\n"
