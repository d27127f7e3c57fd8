"""What the schema knows but this version cannot fly yet: the only table of it.  To open a key, delete its row."""

from __future__ import annotations

from typing import Any

from aerosim.scenario.section import Section

# key -> the values that can be flown; a key that is not here is open
AVAILABLE: dict[str, tuple[Any, ...]] = {
    "mount.level": ("static", "none"),
    "control.mode": ("fixed", "ideal", "navigator", "schmelovsky_1988", "pipelined", "best", "gnss_ins"),
    "frame_camera.write": (False,),
    "frame_camera.render_pixel_um": (None,),
    "navigation.smooth": (None,),
}


def _value(section: Any, key: str) -> Any:
    for name in key.split("."):
        section = getattr(section, name, None)
    return section


def _word(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if value == ():
        return "[]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def unavailable(scenario: Section) -> list[tuple[str, str, str]]:
    """Keys whose value this version cannot fly, each with the problem and what is allowed."""
    out = []
    for key, values in AVAILABLE.items():
        value = _value(scenario, key)
        if value not in values:
            shown = f"{_word(value)} is" if isinstance(value, (str, float, bool)) else "is"
            allowed = ", ".join(_word(each) for each in values)
            out.append((key, f"{shown} not available in this version", f"allowed: {allowed}"))
    return out
