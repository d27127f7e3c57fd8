"""Strict reading of YAML 1.2: plain values and the line of each key; no anchors, tags, duplicate keys."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path as FilePath
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)
from ruamel.yaml.reader import ReaderError

from aerosim.errors import InputError
from aerosim.scenario.places import Path, dotted

BYTES_MAX = 256 * 1024
DEPTH_MAX = 12
VALUES_MAX = 20000

# the core schema of YAML 1.2 (section 10.3.2): `off`, `yes` and 1:30 stay words
_INT = re.compile(r"[-+]?[0-9]{1,18}")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]{1,4})?")
_WORDS: dict[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
    **{sign + word: float(sign + "inf") for sign in ("", "+", "-") for word in (".inf", ".Inf", ".INF")},
}


def plain(text: str) -> Any:
    """Value of an unquoted scalar."""
    if text in _WORDS:
        return _WORDS[text]
    if _INT.fullmatch(text):
        return int(text)
    return float(text) if len(text) < 400 and _FLOAT.fullmatch(text) else text


@dataclass
class _Composer:
    """Builds values from the parser's events.  lines: of each key, from 1."""

    events: Iterator[Event]
    where: str
    lines: dict[str, int] = field(default_factory=dict)
    count: int = 0

    def error(self, event: Event, problem: str, allowed: str = "", key: str = "") -> InputError:
        return InputError(problem, key=key, allowed=allowed, where=f"{self.where}:{event.start_mark.line + 1}")

    def refuse(self, event: Event, path: Path) -> None:
        """Anchors, aliases, tags, and what is too deep or too much."""
        self.count += 1
        if isinstance(event, AliasEvent) or getattr(event, "anchor", None):
            raise self.error(event, "anchors and aliases are not read", "write the value out", dotted(path))
        if tag := getattr(event, "tag", None):
            raise self.error(event, f"tag {tag} is not read", "plain values", dotted(path))
        if len(path) > DEPTH_MAX:
            raise self.error(event, "nested too deeply", f"at most {DEPTH_MAX} levels", dotted(path[:2]))
        if self.count > VALUES_MAX:
            raise self.error(event, "too many values", f"at most {VALUES_MAX}")

    def value(self, event: Event, path: Path) -> Any:
        self.refuse(event, path)
        self.lines.setdefault(dotted(path), event.start_mark.line + 1)
        if isinstance(event, MappingStartEvent):
            return self.mapping(path)
        if isinstance(event, SequenceStartEvent):
            return self.sequence(path)
        assert isinstance(event, ScalarEvent)
        return plain(event.value) if event.style is None else event.value

    def mapping(self, path: Path) -> dict[str, Any]:
        out: dict[str, Any] = {}
        while not isinstance(event := next(self.events), MappingEndEvent):
            self.refuse(event, path)
            if not isinstance(event, ScalarEvent):
                raise self.error(event, "key is not a word", "KEY: VALUE", dotted(path))
            here = (*path, event.value)
            if event.value in out:
                first = self.lines[dotted(here)]
                raise self.error(event, "key is given twice", f"first in line {first}", dotted(here))
            self.lines[dotted(here)] = event.start_mark.line + 1
            out[event.value] = self.value(next(self.events), here)
        return out

    def sequence(self, path: Path) -> tuple[Any, ...]:
        out: list[Any] = []
        while not isinstance(event := next(self.events), SequenceEndEvent):
            out.append(self.value(event, (*path, len(out))))
        return tuple(out)

    def document(self) -> Any:
        """The only document of the text."""
        out, seen = None, False
        for event in self.events:
            if isinstance(event, DocumentStartEvent):
                if seen:
                    raise self.error(event, "more than one document", "one document, no second ---")
                if event.version or event.tags:
                    raise self.error(event, "directives are not read", "no line that starts with %")
                seen, out = True, self.value(next(self.events), ())
        return out


def _syntax(error: YAMLError, where: str) -> InputError:
    if isinstance(error, ReaderError):
        return InputError("is not a text file", allowed="YAML, UTF-8", where=where)
    mark = getattr(error, "problem_mark", None)
    place = f"{where}:{mark.line + 1}" if mark else where
    problem = error.problem if isinstance(error, MarkedYAMLError) else None
    return InputError(
        f"is no YAML: {problem or 'cannot be read'}", allowed="KEY: VALUE, indented by blanks", where=place
    )


def parse(text: str, where: str) -> tuple[Any, dict[str, int]]:
    """Value of a YAML text (mappings as dict, sequences as tuple) and the line of each dotted key.

    where: file or option, for the messages.  Raises InputError.
    """
    try:
        composer = _Composer(iter(YAML(typ="safe", pure=True).parse(text)), where)
        return composer.document(), composer.lines
    except YAMLError as error:
        raise _syntax(error, where) from error


def read(
    file: FilePath,
    shown: str,
    kind: str = "a scenario",
    writer: str = "`aerosim new NAME` writes one to start from",
) -> tuple[dict[str, Any], dict[str, int]]:
    """Contents of a YAML file and the line of each key.

    shown, kind, writer: its name, what it is and what makes one, in messages.  Raises InputError.
    """
    try:
        with file.open("rb") as stream:
            data = stream.read(BYTES_MAX + 1)
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", where=shown) from error
    if len(data) > BYTES_MAX:
        raise InputError(f"is too large for {kind}", allowed=f"at most {BYTES_MAX // 1024} KiB", where=shown)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError("is not a text file", allowed="YAML, UTF-8", where=shown) from error
    if "\0" in text:
        raise InputError("is not a text file", allowed="YAML, UTF-8", where=shown)
    value, lines = parse(text, shown)
    if value is None:
        raise InputError("is empty", allowed=f"{kind}; {writer}", where=shown)
    if not isinstance(value, dict):
        raise InputError(
            f"is not {kind}" if kind != "a scenario" else "is no scenario",
            allowed="KEY: VALUE at the top level",
            where=f"{shown}:{lines[''] or 1}",
        )
    return value, lines
