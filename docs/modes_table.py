"""Puts the figures of sweeps into docs/modes.md: ``python docs/modes_table.py runs/modes runs/modes_real ...``.

Each sweep is one of `modes`, `modes_relief` and `modes_real`; its tables replace what stands between the lines
``<!-- NAME -->`` and ``<!-- end of NAME -->`` of the page, and its picture is images/NAME.png.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from aerosim.errors import InputError
from aerosim.report import plots
from aerosim.report.sweep_view import with_limits
from aerosim.sweep.matrix import matrix
from aerosim.sweep.results import Sweep, open_sweep
from aerosim.sweep.stats import Mean

sys.path.insert(0, str(Path(__file__).parent))

HERE = Path(__file__).parent
SIGMA, SLOW = "air.turbulence.sigma_m_s", "air.slow_wind.sigma_m_s"
MODE, AIDING = "control.mode", "estimation.aiding"
USE_STRIPS = ("schmelovsky_1988", "pipelined", "best")
LOCK = ("crab.silent_end_s", "crab.accepted_pct")
LOST_S = 30.0  # two strip times and more without an accepted strip up to the line's end: the lock is lost
LOST_PCT = 50.0  # as in the summary's notes: a lock that is regained again and again is none
WIDE_PCT = 5.0  # half width of a mean that is known well enough
COLOURS = (
    "#8c8c8c",
    "#CC79A7",
    "#D55E00",
    "#E69F00",
    "#56B4E9",
    "#000000",
    "#B0D0A0",
    "#66B266",
    "#0072B2",
    "#004466",
)


class Metric(NamedTuple):
    """A figure of the runs.  limits: wanted of a row (mode, aiding) at each strength of turbulence."""

    path: str
    title: str
    digits: int
    limits: Mapping[str, Mapping[float, float]] = {}


NOTHING = 1e-9  # rounding: the mode believes the truth


def _at(*values: float) -> dict[float, float]:
    return dict(zip((0.0, 0.35, 0.7, 1.4, 2.88), values, strict=True))


CRAB = {
    "best, none": _at(0.5, 0.75, 1.0, 1.7, 3.2),
    "best, gyro": _at(0.15, 0.2, 0.25, 0.45, 1.0),
    "best, bank": _at(0.15, 0.2, 0.25, 0.45, 1.0),
    "best, imu": _at(0.06, 0.08, 0.1, 0.2, 0.5),
}
METRICS = (
    Metric("crab.residual_rms_deg", "Crab residual, deg rms", 3, CRAB),
    Metric("vh.error_rms_pct", "v/h error, % rms", 3),
    Metric(
        "photos.end_lap_error_rms_pct",
        "End lap error of the footprints, % rms",
        3,
        {"best, imu": _at(0.1, 0.1, 0.1, 0.15, 0.3)},
    ),
    Metric("crab.accepted_pct", "Strips accepted, %", 1),
    Metric("crab.bad_pct", "Accepted strips more than 0.5 deg off, %", 1),
)
NO_LIMITS = ("modes_relief",)  # what the relief costs is told, nothing is asked


def row_of(values: Mapping[str, Any]) -> str:
    """Name of a mode with its aiding."""
    return str(values[MODE]) if values.get(AIDING) is None else f"{values[MODE]}, {values[AIDING]}"


def winds(sweep: Sweep) -> list[Any]:
    """Slow winds of a sweep, None where all runs have the same."""
    return list(dict.fromkeys(sweep.table[SLOW].to_pylist())) if SLOW in sweep.parameters else [None]


def means_of(sweep: Sweep, metric: str, wind: Any) -> dict[str, dict[float, Mean]]:
    """Means by row and turbulence in one slow wind."""
    out: dict[str, dict[float, Mean]] = {}
    for mean in sweep.means(metric):
        if mean.values.get(SLOW) == wind:
            out.setdefault(row_of(mean.values), {})[float(mean.values[SIGMA])] = mean
    return out


def wind_words(sweep: Sweep, wind: Any) -> str:
    """A slow wind and what walk of the drift it makes."""
    slow, flight = sweep.spec.scenario.air.slow_wind, sweep.spec.scenario.flight
    sigma = slow.sigma_m_s if wind is None else wind
    walk = 2.0 * np.degrees(sigma / flight.airspeed_m_s) ** 2 / slow.time_constant_s
    return f"slow wind of {sigma:g} m/s and {slow.time_constant_s:g} s, b2 = {walk:.3g} deg2/s"


def table(sweep: Sweep, metric: Metric, wind: Any) -> list[str]:
    """Markdown of one metric in one slow wind; bold: above what is asked."""
    found = means_of(sweep, metric.path, wind)
    sigmas = sorted({sigma for row in found.values() for sigma in row})
    limits = {} if sweep.spec.scenario.name in NO_LIMITS else metric.limits
    lines = [
        "| sigma, m/s | " + " | ".join(f"{sigma:g}" for sigma in sigmas) + " |",
        "|---|" + "---|" * len(sigmas),
    ]
    for name, row in found.items():
        asked = limits.get(name, {})
        cells = [_cell(row.get(sigma), metric.digits, asked.get(sigma)) for sigma in sigmas]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    for names in _alike(limits, found):
        asked = [f"{limits[names[0]].get(sigma, float('nan')):g}" for sigma in sigmas]
        lines.append(f"| *asked of {' and '.join(names)}* | " + " | ".join(asked) + " |")
    return lines


def _alike(limits: Mapping[str, Mapping[float, float]], found: Mapping[str, Any]) -> list[list[str]]:
    """Rows of the same limits together."""
    out: list[list[str]] = []
    for name in (name for name in limits if name in found):
        same = next((names for names in out if limits[names[0]] == limits[name]), None)
        (same if same is not None else out.append([]) or out[-1]).append(name)
    return out


def _cell(mean: Mean | None, digits: int, limit: float | None) -> str:
    if mean is None:
        return ""
    text = "0" if mean.mean < NOTHING else with_limits(mean.mean, mean.half_width, digits)
    if mean.failed:
        text += f" ({mean.failed} failed)"
    return f"**{text}**" if limit is not None and mean.mean > limit else text


def locks(sweep: Sweep) -> list[str]:
    """In how many runs of the modes that use strips the lock was lost, by row; only rows that lost it in any."""
    silent, share = (matrix(sweep.table, name, sweep.parameters) for name in LOCK)
    lost: dict[str, list[int]] = {}
    for point, ends, accepted in zip(silent.points, silent.values, share.values, strict=True):
        if point[MODE] in USE_STRIPS:
            each = lost.setdefault(row_of(point), [0, 0])
            each[0] += int(((ends > LOST_S) | (accepted < LOST_PCT)).sum())
            each[1] += int(np.isfinite(ends).sum())
    rule = f"no accepted strip in the last {LOST_S:g} s, or fewer than {LOST_PCT:g} % accepted"
    told = [f"{name} {each[0]} of {each[1]}" for name, each in lost.items() if each[0]]
    if told:
        return [f"Lock lost ({rule}): {', '.join(told)} runs; of all others, none."]
    return [f"Lock lost ({rule}) in none of {sum(each[1] for each in lost.values())} runs that use strips."]


def against_pipelined(sweep: Sweep) -> list[str]:
    """Where best leaves more crab than pipelined, over common seeds."""
    runs = matrix(sweep.table, "crab.residual_rms_deg", sweep.parameters)
    rows = {
        (row_of(point), point.get(SLOW), point[SIGMA]): values
        for point, values in zip(runs.points, runs.values, strict=True)
    }
    told = []
    for (name, wind, sigma), values in rows.items():
        off = values - rows.get(("pipelined", wind, sigma), np.full_like(values, np.nan))
        if name.startswith("best") and np.isfinite(off).any() and np.nanmean(off) > 0.0:
            place = f"{sigma:g} m/s" if wind is None else f"{sigma:g} m/s in slow wind of {wind:g} m/s"
            told.append(f"{name} at {place} by {np.nanmean(off):.3f} deg")
    if told:
        return ["Worse than `pipelined`: " + "; ".join(told) + "."]
    return ["`best` leaves less crab than `pipelined` at every point."]


def widths(sweep: Sweep) -> list[str]:
    """Seeds, and how well the means are known."""
    seeds = len(set(sweep.table["seed"].to_pylist()))
    told = []
    for metric in METRICS[:3]:
        parts = np.array(
            [100.0 * m.half_width / abs(m.mean) for m in sweep.means(metric.path) if m.half_width > 0.0 and m.mean]
        )
        if len(parts):
            told.append(f"{metric.title.split(',')[0].lower()} {np.median(parts):.1f} and {parts.max():.1f} %")
            told[-1] += f" ({(parts > WIDE_PCT).sum()} of {len(parts)} above {WIDE_PCT:g} %)"
    return [
        f"{seeds} seeds, {sweep.summary['failed']} runs failed. Half widths, median and widest: {'; '.join(told)}."
    ]


def section(sweep: Sweep) -> str:
    """Everything about one sweep, in Markdown."""
    name = sweep.spec.scenario.name
    lines = [
        *widths(sweep),
        *locks(sweep),
        *against_pipelined(sweep),
        "",
        f"![crab residual by turbulence](images/{name}.png)",
    ]
    for wind in winds(sweep):
        for metric in METRICS:
            lines += ["", f"**{metric.title}**, {wind_words(sweep, wind)}", "", *table(sweep, metric, wind)]
    return "\n".join(lines)


def picture(sweep: Sweep, file: Path) -> None:
    """Crab residual against turbulence, a curve with its band for each mode, limits grey."""
    from make_figures import save

    limits = {} if sweep.spec.scenario.name in NO_LIMITS else CRAB
    with plots.style() as figure_class:
        figure = figure_class(figsize=(10.0, 4.6), layout="constrained", dpi=120)
        axes = figure.subplots(1, len(winds(sweep)), sharey=True, squeeze=False)[0]
        for ax, wind in zip(axes, winds(sweep), strict=True):
            found = means_of(sweep, "crab.residual_rms_deg", wind)
            for k, (name, row) in enumerate(found.items()):
                _curve(ax, row, name, COLOURS[k % len(COLOURS)])
            for k, limit in enumerate(limits[name] for name in limits if name in found):
                label = None if k else "asked of best"
                ax.plot(list(limit), list(limit.values()), color="#b0b0b0", ls=(0, (4, 2)), zorder=0, label=label)
            ax.set(xlabel="turbulence, sigma [m/s]", yscale="log", title=wind_words(sweep, wind).split(", ")[1])
        axes[0].yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes[0].set(ylabel="crab residual, rms [deg]")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside right")
        save(figure, file)


def _curve(ax: Any, row: Mapping[float, Mean], name: str, colour: str) -> None:
    at = np.array(sorted(row))
    mean, half = (np.array([getattr(row[sigma], part) for sigma in at]) for part in ("mean", "half_width"))
    half = np.nan_to_num(half)
    # a band that reaches zero has no lower end on this axis
    ax.fill_between(at, np.maximum(mean - half, 0.2 * mean), mean + half, color=colour, alpha=0.25, lw=0)
    ax.plot(at, mean, color=colour, marker=".", label=name)


def replaced(page: str, name: str, text: str, where: str) -> str:
    """The page with new text between its marks.  Raises InputError for a page without them."""
    first, last = f"<!-- {name} -->", f"<!-- end of {name} -->"
    if first not in page or last not in page:
        raise InputError(
            f"has no place for {name}", where=where, allowed=f"{first} and {last} on lines of their own"
        )
    head, tail = page.partition(first)[0], page.partition(last)[2]
    return f"{head}{first}\n{text}\n{last}{tail}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Tables and pictures of the sweeps named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("sweeps", nargs="+", type=Path, help="directories of sweeps")
    parser.add_argument("--page", type=Path, default=HERE / "modes.md", help="page that is filled in")
    parsed = parser.parse_args(arguments)
    try:
        for path in parsed.sweeps:
            sweep = open_sweep(path)
            name = sweep.spec.scenario.name
            page = parsed.page.read_text(encoding="utf-8")
            parsed.page.write_text(replaced(page, name, section(sweep), str(parsed.page)), encoding="utf-8")
            picture(sweep, parsed.page.parent / "images" / f"{name}.png")
    except InputError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
