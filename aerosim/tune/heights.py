"""What was found of the disturbances at each height, and the table of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

from aerosim.errors import InputError
from aerosim.estimation import tuning
from aerosim.estimation.tuning import Measured, PhotoWalk
from aerosim.scenario.disturbances import DisturbanceTable
from aerosim.tune.records import Flown

DEG2 = math.degrees(1.0) ** 2
PCT2 = 1e4


class Given(NamedTuple):
    """What is known from elsewhere.  crab_walk: rad^2/s; vh_walk: 1/s as shares squared.

    height: above ground, m, at which crab_walk was found: b2 T is then the same at all heights, as the paper
    assumes; None: b2 is.
    """

    crab_walk: float | None = None
    vh_walk: float | None = None
    height: float | None = None


class AtHeight(NamedTuple):
    """Disturbances at one height.  time: T, s; None: not in the record."""

    source: str
    height: float
    vh: float
    time: float
    crab_walk: Measured | None
    crab_noise: Measured
    vh_walk: Measured | None
    vh_noise: Measured | None
    photos: PhotoWalk | None


def at_height(flown: Flown, given: Given) -> AtHeight:
    """Disturbances out of one record.  Raises InputError if no part of it lasts as long as a strip."""
    rows = flown.rows
    time = tuning.strip_time(rows.spacing, rows.focal, flown.vh)
    noise = tuning.roll_noise(flown.roll, time, *rows)
    if noise is None:
        longest = max((each.t[-1] - each.t[0] for each in flown.roll), default=0.0)
        raise InputError(
            f"lasts {longest:.3g} s without a gap, a strip {time:.3g} s",
            where=flown.source,
            allowed="a longer record",
        )
    crab = tuning.drift_walk(flown.drift, time) if flown.drift else None
    if given.crab_walk is not None:
        value = given.crab_walk * (given.height / flown.height if given.height else 1.0)
        crab = Measured(value, value, value, 1.0)
    photos = None
    if flown.mode == "fixed" and flown.lines:
        photos = tuning.photo_walk(flown.lines, flown.wanted)
    vh = None if photos is None else photos.walk
    if given.vh_walk is not None:
        vh = Measured(given.vh_walk, given.vh_walk, given.vh_walk, 1.0)
    pitch = tuning.pitch_noise(flown.pitch, time, rows.spacing, rows.focal) if flown.pitch else None
    return AtHeight(flown.source, flown.height, flown.vh, time, crab, noise, vh, pitch, photos)


def _limits(found: Measured | None, factor: float) -> dict[str, float] | None:
    return None if found is None else found.scaled(factor)._asdict()


def figures(found: AtHeight) -> dict[str, Any]:
    """The figures of one height, keys with their units; None is not in the record."""
    crab, vh, noise = found.crab_walk, found.vh_walk, found.vh_noise
    photos = found.photos
    return {
        "source": found.source,
        "height_agl_m": found.height,
        "vh_per_s": found.vh,
        "strip_time_s": found.time,
        "crab": {
            "walk_deg2_per_s": _limits(crab, DEG2),
            "noise_deg2": _limits(found.crab_noise, DEG2),
            "sigma_deg": math.degrees(math.sqrt(found.crab_noise.value)),
            "gamma": _gamma(crab, found.time, found.crab_noise),
        },
        "vh": {
            "walk_pct2_per_s": _limits(vh, PCT2),
            "noise_pct2": _limits(noise, PCT2),
            "sigma_pct": None if noise is None else 100.0 * math.sqrt(noise.value),
            "gamma": _gamma(vh, found.time, noise),
        },
        "photos": None
        if photos is None
        else {
            "greatest_n_error_pct": 100.0 * photos.greatest_error,
            "greatest_walk_pct2_per_s": PCT2 * photos.greatest,
            "walk_pct2_per_s": _limits(photos.walk, PCT2),
            "noise_pct2": _limits(photos.noise, PCT2),
        },
    }


def _gamma(walk: Measured | None, time: float, noise: Measured | None) -> float | None:
    """b2 T/N0, if there is both."""
    return None if walk is None or noise is None or noise.value == 0.0 else walk.value * time / noise.value


def table_rows(heights: Sequence[AtHeight]) -> list[dict[str, Any]]:
    """Rows of the table, by height.  Raises InputError for what a filter cannot live with or the record lacks."""
    rows = []
    for each in sorted(heights, key=lambda one: one.height):
        for part, walk, option in (("crab", each.crab_walk, "crab"), ("vh", each.vh_walk, "vh")):
            unit = "deg2" if part == "crab" else "pct2"
            if walk is None:
                lacks = "no drift" if part == "crab" else "no series of three photos by control.mode: fixed"
                raise InputError(f"has {lacks}", where=each.source, allowed=f"--{option}_walk_{unit}_per_s")
            if walk.value <= 0.0:
                problem = f"the walk of {part} does not stand out of the noise"
                raise InputError(problem, where=each.source, allowed=f"--{option}_walk_{unit}_per_s")
        if each.vh_noise is None:
            raise InputError("has no pitch", where=each.source, allowed="a column pitch_deg or q_deg_s")
        if min(each.vh_noise.value, each.crab_noise.value) <= 0.0:
            raise InputError("roll or pitch never change: no noise to tune to", where=each.source)
        assert each.crab_walk is not None
        assert each.vh_walk is not None
        rows.append({
            "height_agl_m": _rounded(each.height),
            "crab": {
                "walk_deg2_per_s": _rounded(each.crab_walk.value * DEG2),
                "sigma_deg": _rounded(math.degrees(math.sqrt(each.crab_noise.value))),
                "gamma": None,
            },
            "vh": {
                "walk_pct2_per_s": _rounded(each.vh_walk.value * PCT2),
                "sigma_pct": _rounded(100.0 * math.sqrt(each.vh_noise.value)),
                "gamma": None,
            },
        })  # fmt: skip
    return rows


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")


def write_table(heights: Sequence[AtHeight], file: Path, overwrite: bool = False) -> list[dict[str, Any]]:
    """Write the table as YAML, to be named in estimation.table; returns its rows.  Raises InputError."""
    if file.exists() and not overwrite:
        raise InputError(f"{file} exists", key="--out", allowed="another file, or --overwrite")
    rows = table_rows(heights)
    for low, high in pairwise(rows):
        if high["height_agl_m"] <= low["height_agl_m"]:
            raise InputError(
                f"two records at {low['height_agl_m']:g} m", key="--out", allowed="one for each height"
            )
    DisturbanceTable.model_validate({"rows": tuple(rows)})
    lines = [
        "# Disturbances by height above ground, by `aerosim tune`; a scenario names this: estimation.table",
        "rows:",
    ]
    for row, each in zip(rows, sorted(heights, key=lambda one: one.height), strict=True):
        lines += [f"  - height_agl_m: {row['height_agl_m']:g}  # {' '.join(each.source.split())}"]
        for part in ("crab", "vh"):
            values = ", ".join(f"{k}: {'null' if v is None else format(v, 'g')}" for k, v in row[part].items())
            lines.append(f"    {part}: {{{values}}}")
    try:
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"{file} cannot be written: {error.strerror}", key="--out") from error
    return rows
