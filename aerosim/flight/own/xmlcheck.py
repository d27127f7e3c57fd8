"""A look at a user's JSBSim model before JSBSim sees it: well-formed, closed in its folder, without loops."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.parsers import expat

from aerosim.errors import InputError

FILE_MAX = 5_000_000  # bytes of one file: the largest model that comes with JSBSim has 0.5 MB
FILES_MAX = 100
DEPTH_MAX = 200
# Folders in which JSBSim looks for a file that an element names, inside the model's own.
PLACES = {
    "system": ("", "Systems"),
    "autopilot": ("", "Systems"),
    "flight_control": ("", "Systems"),
    "engine": ("Engines", ""),
    "thruster": ("Engines", ""),
}
ROOT = "fdm_config"
# What a model may not do beside flying.
OWN_WAYS = {
    "output": "writes files or sends data",
    "input": "listens to the network",
    "child": "loads another model",
}


@dataclass
class Element:
    """An XML element and the line where it begins."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def walk(self) -> Iterator[Element]:
        """The element and all below it."""
        stack = [self]
        while stack:
            element = stack.pop()
            yield element
            stack.extend(reversed(element.children))


@dataclass(frozen=True)
class Source:
    """A file of the model: its place in messages, its root element, its bytes."""

    place: str
    root: Element
    content: bytes


def refusal(place: str, problem: str, allowed: str = "") -> InputError:
    """Error about a place in the model.  It stands in the problem: the scenario's own place goes before it."""
    return InputError(f"{place}: {problem}" if place else problem, allowed=allowed)


class _Reader:
    """Builds elements; stops at the first document type, so that no entity is ever expanded."""

    def __init__(self, place: str) -> None:
        self.place = place
        self.root: Element | None = None
        self._open: list[Element] = []
        self._parser: Any = expat.ParserCreate()
        self._parser.buffer_text = True
        self._parser.StartDoctypeDeclHandler = self._doctype
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._data

    def read(self, content: bytes) -> Element:
        try:
            self._parser.Parse(content, True)
        except expat.ExpatError as error:
            why = expat.ErrorString(error.code)
            raise refusal(f"{self.place}:{error.lineno}", f"not well-formed XML: {why}") from error
        except ValueError as error:  # an encoding that neither expat nor Python knows
            raise refusal(self.place, f"cannot be read as XML: {error}", "UTF-8") from error
        assert self.root is not None
        return self.root

    def _here(self) -> str:
        return f"{self.place}:{self._parser.CurrentLineNumber}"

    def _doctype(self, *_: Any) -> None:
        raise refusal(self._here(), "document type with entities", "plain XML without <!DOCTYPE ...>")

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, self._parser.CurrentLineNumber)
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)
        if len(self._open) > DEPTH_MAX:
            raise refusal(self._here(), f"elements nested deeper than {DEPTH_MAX}")

    def _end(self, _: str) -> None:
        self._open.pop()

    def _data(self, text: str) -> None:
        if self._open:
            self._open[-1].text += text


def read_bounded(file: Path, place: str) -> bytes:
    """Content of a file of the model.  Raises InputError for one that is missing, no file, or too large."""
    try:
        if not file.is_file():
            raise refusal(place, "no such file")
        if file.stat().st_size > FILE_MAX:
            raise refusal(place, f"larger than {FILE_MAX / 1e6:g} MB")
        return file.read_bytes()
    except OSError as error:
        raise refusal(place, f"cannot be read: {error.strerror}") from error


def check_xml(folder: Path) -> dict[Path, Source]:
    """Read all XML files of a model.  folder bears the model's name.  Returns them by their resolved path.

    Raises InputError with file and line for XML that is broken, has a document type, names files that are missing
    or outside the folder, includes itself, writes or listens by itself, or has functions that call themselves.
    """
    name = folder.name
    if not folder.is_dir():
        raise InputError(f"no aircraft folder {name}")
    if not (folder / f"{name}.xml").is_file():
        raise refusal(name, f"no aircraft model {name}.xml in it", "a file named like its folder")
    sources: dict[Path, Source] = {}
    _read(folder, folder / f"{name}.xml", ROOT, (), sources)
    _check_traffic(next(iter(sources.values())))
    for source in sources.values():
        _check_numbers(source)
    _check_functions(list(sources.values()))
    return sources


def _read(folder: Path, file: Path, tag: str, above: tuple[Path, ...], sources: dict[Path, Source]) -> None:
    """One file and those that it names.  above: the files that led here."""
    resolved = file.resolve()
    place = f"{folder.name}/{file.relative_to(folder).as_posix()}"
    if resolved not in sources:
        if len(sources) == FILES_MAX:
            raise refusal(place, f"more than {FILES_MAX} files in the model")
        content = read_bounded(file, place)
        sources[resolved] = Source(place, _Reader(place).read(content), content)
    root = sources[resolved].root
    # A file of a thruster may be a propeller, a nozzle or a rotor, one of an engine any kind of engine.
    if root.tag != tag and tag not in {"engine", "thruster"}:
        raise refusal(f"{place}:{root.line}", f"root element <{root.tag}>", f"<{tag}>")
    for element in root.walk():
        if "file" not in element.attributes:
            continue
        here = f"{place}:{element.line}"
        target = _find(folder, element, here)
        if target.resolve() in (*above, resolved):
            raise refusal(here, f'file="{element.attributes["file"]}" includes itself')
        _read(folder, target, element.tag, (*above, resolved), sources)


def _find(folder: Path, element: Element, here: str) -> Path:
    """File that an element names.  Raises InputError."""
    named = element.attributes["file"].strip()
    inside = folder.resolve()
    relative = Path(named if Path(named).suffix else f"{named}.xml")
    for part in PLACES.get(element.tag, ("",)):
        # Compared before anything is opened, and again behind symbolic links.
        target = Path(os.path.normpath(folder / part / relative))
        try:
            if not (target.is_relative_to(folder) and target.resolve().is_relative_to(inside)):
                raise refusal(here, f'file="{named}" lies outside the folder', f"files inside {folder.name}/")
            if named and target.is_file():
                return target
        except (OSError, RuntimeError):  # links in a circle, names longer than the system's
            continue
    places = " or ".join(f"{folder.name}/{part}".rstrip("/") for part in PLACES.get(element.tag, ("",)))
    raise refusal(here, f'no file "{named}" for <{element.tag}>', f"a file in {places}")


def _check_traffic(source: Source) -> None:
    for element in source.root.children:
        if element.tag in OWN_WAYS:
            raise refusal(
                f"{source.place}:{element.line}",
                f"<{element.tag}> {OWN_WAYS[element.tag]} by itself",
                "take it out: aerosim flies one model and records it",
            )


def _check_numbers(source: Source) -> None:
    for element in source.root.walk():
        if element.tag not in {"value", "v"}:
            continue
        try:
            finite = math.isfinite(float(element.text))
        except ValueError:
            finite = False
        if not finite:
            text = " ".join(element.text.split())[:40]
            raise refusal(f"{source.place}:{element.line}", f"<{element.tag}> of '{text}'", "a finite number")


def _calls(function: Element) -> Iterator[str]:
    for element in function.walk():
        if element.tag in {"property", "p", "independentVar"}:
            yield element.text.strip().lstrip("-")


def _check_functions(sources: list[Source]) -> None:
    """Functions are evaluated when they are read, so a circle of them has no end."""
    places: dict[str, str] = {}
    calls: dict[str, list[str]] = {}
    for source in sources:
        for element in source.root.walk():
            if element.tag == "function" and (name := element.attributes.get("name", "")):
                places[name], calls[name] = f"{source.place}:{element.line}", list(_calls(element))
    done: set[str] = set()
    for name, called_first in calls.items():
        path, stack = [name], [iter(called_first)]
        while stack and path[0] not in done:
            called = next((each for each in stack[-1] if each in calls and each not in done), None)
            if called is None:
                done.add(path.pop())
                stack.pop()
            elif called in path:
                circle = " -> ".join([*path[path.index(called) :], called])
                raise refusal(places[called], f"function without an end: {circle}")
            else:
                path.append(called)
                stack.append(iter(calls[called]))
