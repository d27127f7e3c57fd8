"""The verdict: what a scenario expects, against the summary of its run."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol


class Range(Protocol):
    """Closed range of a number."""

    @property
    def min(self) -> float | None:
        """Least value that meets it."""

    @property
    def max(self) -> float | None:
        """Greatest value that meets it."""


def value_at(summary: Mapping[str, Any], path: str) -> Any:
    """Value of a dotted path in the summary, None if it is not there."""
    value: Any = summary
    for name in path.split("."):
        value = value.get(name) if isinstance(value, Mapping) else None
    return value


def _unmet(path: str, value: Any, wanted: Range, note: str) -> str:
    if not isinstance(value, (int, float)) or isinstance(value, bool) or value != value:  # noqa: PLR0124
        return f"{path} was not measured{f': {note}' if note else ''}"
    if wanted.min is not None and value < wanted.min:
        return f"{path} is {value:.6g}, below min {wanted.min:g}"
    if wanted.max is not None and value > wanted.max:
        return f"{path} is {value:.6g}, above max {wanted.max:g}"
    return ""


def check_expect(summary: Mapping[str, Any], expect: Mapping[str, Range]) -> list[str]:
    """Lines about what is not met, empty if all is.

    summary: as in summary.json; its `notes` by path give the reason of a null.  expect: ranges by dotted path;
    what was not measured (null, not a number, not there) is not met.
    """
    notes = summary.get("notes")
    reasons = notes if isinstance(notes, Mapping) else {}
    lines = (
        _unmet(path, value_at(summary, path), wanted, str(reasons.get(path) or ""))
        for path, wanted in expect.items()
    )
    return [line for line in lines if line]
