"""The layout of the scenario file: JSON schema for editors, Markdown for people; both from the models."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from aerosim.scenario.available import AVAILABLE
from aerosim.scenario.emit import scalar
from aerosim.scenario.fields import fields, sections_in
from aerosim.scenario.scenario import Scenario
from aerosim.scenario.section import Section
from aerosim.scenario.translate import limits

_HEAD = """\
# Scenario reference

Made from the models by `python -m aerosim.scenario.reference`; a test keeps it current.

YAML 1.2, strict: no unknown or double keys, no anchors, no tags. Every key carries its unit. A scenario needs
`name`, `terrain.source` and `flight.lines`; everything else has the default given here. `aerosim new NAME` writes
a file with all keys, `aerosim schema` prints the JSON schema. Paths are relative to the scenario file. Angles of
direction are clockwise from true north, wind is given by where it comes from, heights are ellipsoidal unless said
otherwise.

`control.mode: schmelovsky_1988` changes defaults, for keys that are not set: `ccd_rows.mounted_on: airframe`,
`ccd_rows.extension: padded`, `estimation.strip_period_s: null`, `estimation.subpixel: false`,
`estimation.aiding: none`, `estimation.crab.gamma: 0.01`, `estimation.vh.gamma: 0.01`.
`control.mode: gnss_ins` brings `navigation.gnss` and `navigation.ins`, and `estimation.aiding: gyro`, `bank` or
`imu` brings `navigation.imu`, read with the rows; what else stands in `navigation` is then `null`.
"""


def schema() -> dict[str, Any]:
    """JSON schema of the scenario file."""
    return Scenario.model_json_schema(by_alias=True)


def _choices(annotation: Any) -> str:
    """What may stand there, in words."""
    if get_origin(annotation) is Literal:
        return " \\| ".join(str(each) for each in get_args(annotation))
    if isinstance(annotation, type):
        words = {float: "number", int: "whole number", str: "text", bool: "true \\| false", type(None): "null"}
        return words.get(annotation, "section" if issubclass(annotation, Section) else "")
    parts = get_args(annotation)
    if get_origin(annotation) is tuple:
        items = [_choices(part) for part in parts if part is not ...]
        return f"list of {items[0]}s" if ... in parts else f"[{', '.join(items)}]"
    if get_origin(annotation) is dict:
        return "section"
    words_of = [_choices(part) for part in parts if isinstance(part, type) or get_args(part)]
    return " \\| ".join(dict.fromkeys(word for word in words_of if word))


def _allowed(info: FieldInfo, key: str) -> str:
    words = _choices(info.annotation)
    span = limits(info)
    only = AVAILABLE.get(key)
    note = f"; in this version only {', '.join(scalar(each) for each in only)}" if only else ""
    return words + (f", {span}" if span else "") + note


def _default(info: FieldInfo) -> str:
    if info.default is PydanticUndefined:
        return "required"
    value = info.default.model_dump(by_alias=True) if isinstance(info.default, Section) else info.default
    return f"`{scalar(value)}`"


def _tables(model: type[Section], prefix: str) -> Iterator[str]:
    """Table of a section's own keys, then its sections."""
    rows, below = [], []
    for key, info in fields([model]).items():
        models = sections_in(info.annotation)
        plain_section = len(models) == 1 and info.annotation is models[0]
        if not plain_section:
            rows.append(f"| `{key}` | {info.description} | {_allowed(info, prefix + key)} | {_default(info)} |")
        below += [(f"{prefix}{key}", each, info) for each in models]
    if rows:
        yield "\n| key | meaning | allowed | default |\n|---|---|---|---|\n" + "\n".join(rows) + "\n"
    for key, each, info in below:
        listed = " (each element)" if get_origin(info.annotation) is tuple else ""
        yield f"\n## {key}{listed}\n\n{(each.__doc__ or '').strip()}\n"
        yield from _tables(each, f"{key}.")


def markdown() -> str:
    """The scenario reference, Markdown."""
    return _HEAD + "".join(_tables(Scenario, ""))


if __name__ == "__main__":
    print(markdown(), end="")
