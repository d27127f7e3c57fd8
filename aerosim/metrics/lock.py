"""Whether the rows kept the ground: strips that say something wrong, and times without any."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from aerosim.recorder import Columns

BAD_DEG = 0.5  # a strip that is further off says something wrong


def bad_share(matches: Columns, counted: NDArray[np.bool_]) -> float | None:
    """Accepted strips whose angle is more than BAD_DEG off what they ought to have said, in % of the accepted.

    counted: (n,) True for the strips that count.  None without an accepted strip.
    """
    off = np.abs(matches["angle_deg"] - matches["crab_true_deg"])[counted & matches["accepted"]]
    known = off[np.isfinite(off)]
    return float(100.0 * (known > BAD_DEG).mean()) if len(known) else None


def silence(matches: Columns, lines: Mapping[int, tuple[float, float]]) -> tuple[float | None, float | None]:
    """Longest times without an accepted strip, s: anywhere on a line, and up to the end of a line.

    lines: from when to when each counts, s.  A lock that was lost and not regained shows in the second.  None
    where no strip was looked for at all.
    """
    if not len(matches["accepted"]):
        return None, None
    at = np.sort(matches["t_decided_s"][matches["accepted"]])
    longest, last = [], []
    for begin, end in lines.values():
        marks = np.concatenate([[begin], at[(at > begin) & (at <= end)], [end]])
        longest.append(float(np.diff(marks).max()))
        last.append(float(marks[-1] - marks[-2]))
    return max(longest, default=None), max(last, default=None)
