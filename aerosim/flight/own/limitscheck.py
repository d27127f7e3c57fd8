"""A look at the limits file of a user's aircraft: every value possible, and in keeping with the others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

from aerosim.errors import InputError
from aerosim.flight.limits import Limits
from aerosim.flight.own.xmlcheck import read_bounded, refusal

FILE = "limits.yaml"
# Key, whether a value of it is possible with the others', and what is.
_RULES: tuple[tuple[str, Callable[[Limits], bool], str], ...] = (
    ("wing_area_m2", lambda x: 1.0 <= x.wing_area_m2 <= 1000.0, "1 to 1000 m2"),
    ("lift_max", lambda x: 0.3 <= x.lift_max <= 5.0, "0.3 to 5"),
    ("stall_margin", lambda x: 1.0 <= x.stall_margin <= 2.0, "1 to 2"),
    ("height_min_m", lambda x: -500.0 <= x.height_min_m <= 11_000.0, "-500 to 11000 m"),
    ("height_max_m", lambda x: x.height_min_m < x.height_max_m <= 11_000.0, "above height_min_m, up to 11000 m"),
    ("alpha_max_deg", lambda x: 0.0 < x.alpha_max_deg <= 90.0, "above 0 to 90 deg"),
    ("mass_empty_kg", lambda x: 100.0 <= x.mass_empty_kg <= 200_000.0, "100 to 200000 kg"),
    ("fuel_max_kg", lambda x: 0.0 < x.fuel_max_kg <= x.mass_empty_kg, "above 0, up to mass_empty_kg"),
    ("fuel_kg", lambda x: 0.0 < x.fuel_kg <= x.fuel_max_kg, "above 0, up to fuel_max_kg"),
    (
        "equivalent_airspeed_max_m_s",
        lambda x: (
            x.stall_margin * x.stall_speed(0.0, x.mass_empty_kg + x.fuel_kg)
            < x.equivalent_airspeed_max_m_s
            <= 250.0
        ),
        "above stall_margin times the stall speed at sea level, up to 250 m/s",
    ),
)


def check_limits(folder: Path) -> tuple[Limits, bytes]:
    """Limits of the aircraft in a folder, and the file's content.

    Raises InputError, with the line where it is known, for a file that is missing, broken or impossible.
    """
    place = f"{folder.name}/{FILE}"
    content = read_bounded(folder / FILE, place)
    lines = _lines(content, place)
    names = [each.name for each in fields(Limits)]
    for key in lines:
        if key not in names:
            raise refusal(_at(place, lines, key), f"unknown key {key}", ", ".join(names))
    for key in names:
        if key not in lines:
            raise refusal(place, f"lacks {key}", ", ".join(names))
    try:
        limits = Limits.read(folder / FILE)
    except InputError as error:
        raise refusal(place, error.problem, error.allowed) from error
    if not isinstance(limits.model, str):
        raise refusal(_at(place, lines, "model"), f"model: {limits.model!r} is not a text")
    for key, possible, allowed in _RULES:
        if not possible(limits):
            raise refusal(_at(place, lines, key), f"{key}: {getattr(limits, key):g} is not possible", allowed)
    return limits, content


def _lines(content: bytes, place: str) -> dict[str, int]:
    """Line of each key.  Raises InputError for what is no plain table of keys and values."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError
    from ruamel.yaml.nodes import MappingNode, ScalarNode

    try:
        table = YAML(typ="safe", pure=True).compose(content.decode())
    except MarkedYAMLError as error:
        line = f":{error.problem_mark.line + 1}" if error.problem_mark else ""
        raise refusal(f"{place}{line}", f"not YAML: {error.problem}") from error
    except (YAMLError, UnicodeDecodeError) as error:
        raise refusal(place, f"not YAML in UTF-8: {error}") from error
    if not isinstance(table, MappingNode):
        raise refusal(place, "no table of keys and values", "key: value, one a line")
    lines = {}
    for key, value in table.value:
        if not (isinstance(key, ScalarNode) and isinstance(value, ScalarNode)):
            raise refusal(f"{place}:{key.start_mark.line + 1}", "not a key and a plain value")
        lines[str(key.value)] = key.start_mark.line + 1
    return lines


def _at(place: str, lines: dict[str, int], key: str) -> str:
    return f"{place}:{lines[key]}" if key in lines else place
