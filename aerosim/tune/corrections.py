"""A navigator's corrections, as a file or as numbers."""

from __future__ import annotations

from math import degrees, radians
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError
from aerosim.estimation.tuning import CorrectionWalk, walk_from_corrections
from aerosim.tune.csvfile import columns


class Corrections(NamedTuple):
    """What is known of them, each None if not given.  file: CSV with t_s, correction_deg; or numbers."""

    file: Path | None = None
    number: float | None = None
    size_deg: float | None = None
    duration_s: float | None = None
    route_km: float | None = None
    ground_speed_m_s: float | None = None


def walk_of(given: Corrections) -> CorrectionWalk | None:
    """b2 of the drift; None if no corrections are given.  Raises InputError for too many or too few options."""
    duration = _duration(given)
    if given.file is not None:
        if given.number is not None or given.size_deg is not None:
            raise InputError("is given besides numbers", key="--corrections", allowed="one of the two")
        return walk_from_corrections(*_of_file(given.file, duration))
    if given.number is None and given.size_deg is None and duration is None:
        return None
    if given.number is None or given.size_deg is None or duration is None:
        lacking = "--count" if given.number is None else "--size_deg" if given.size_deg is None else "--duration_s"
        raise InputError("is missing", key=lacking, allowed="--count, --size_deg and --duration_s or --route_km")
    return walk_from_corrections([radians(given.size_deg)], duration, given.number)


def _duration(given: Corrections) -> float | None:
    if given.route_km is None:
        return given.duration_s
    if given.duration_s is not None:
        raise InputError("is given besides --duration_s", key="--route_km", allowed="one of the two")
    if given.ground_speed_m_s is None:
        raise InputError("needs a speed", key="--route_km", allowed="--ground_speed_m_s")
    return 1000.0 * given.route_km / given.ground_speed_m_s


def _of_file(path: Path, duration: float | None) -> tuple[NDArray[np.float64], float]:
    """Sizes (rad) of the corrections and the time that they span.

    duration: s; None: from the first correction to the last; the first, whose cause is older, does not count then.
    """
    table = columns(path, ("t_s", "correction_deg"))
    t, sizes = table["t_s"], np.radians(table["correction_deg"])
    if duration is not None:
        return sizes, duration
    if len(t) < 2 or t[-1] <= t[0]:
        raise InputError("has a single moment", where=str(path), allowed="two corrections, or --duration_s")
    return sizes[1:], float(t[-1] - t[0])


def correction_figures(found: CorrectionWalk) -> dict[str, Any]:
    """Figures of a navigator's corrections, keys with their units."""
    deg2 = degrees(1.0) ** 2
    return {
        "walk_deg2_per_s": found.squares.scaled(deg2)._asdict(),
        "largest_each_interval_deg2_per_s": found.largest * deg2,
    }
