"""The map of a plan's trackability: where the two rows will recognise the land under the lines, and where not."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from aerosim.frames import Array
from aerosim.report.plan_map import PlanOnMap, blank_axes, empty_figure, furniture, land, shape_of
from aerosim.report.plots import style

if TYPE_CHECKING:
    from aerosim.forecast.check import Outlook
    from aerosim.forecast.trackability import Stations

# From bad to good: good land stays visible, bad land is dark to every eye
COLOURS = ("#2b0a57e6", "#c8456cb8", "#f6a93280", "#fff3a030")
SHARES = (0.0, 0.5, 0.85, 1.0)  # of accepted strips
ERRORS_DEG = (0.1, 0.2, 0.5, 1.0, 2.0)  # of a strip's angle; from light to dark as its logarithm


def track_png(found: Outlook) -> bytes:
    """The map as a PNG picture, 1300 px wide."""
    out = io.BytesIO()
    with style():
        track_figure(found).savefig(out, format="png", metadata={"Software": None})
    return out.getvalue()


def track_figure(found: Outlook) -> Any:
    """The map as a matplotlib figure, 10 inches wide; to be called and saved within `plots.style`."""
    plan = PlanOnMap(found)
    fields = fields_of(found.track)
    bounds = _extent(plan, fields)
    shape = shape_of(bounds)
    if shape <= 1.0:  # below each other, else side by side
        figure = empty_figure(float(np.clip(18.0 * shape + 2.7, 6.0, 15.0)))
        upper, lower = figure.subplots(2, 1, sharex=True)
    else:
        figure = empty_figure(float(np.clip(4.4 * shape + 1.9, 5.0, 12.0)))
        upper, lower = figure.subplots(1, 2, sharey=True)
    for ax in (upper, lower):
        blank_axes(ax, bounds)
        land(ax, found, bounds)
        _draw_lines(ax, plan)
    upper.label_outer()
    lower.label_outer()
    _draw_accepted(upper, found.track, fields)
    _draw_errors(lower, found.track, fields)
    figure.suptitle(_title(found), fontsize=10, x=0.01, ha="left")
    furniture(upper, plan, bounds)
    return figure


def fields_of(track: Stations) -> Array:
    """Outlines of the land that each station stands for: (n, 4, 2) easting, northing, m."""
    right = np.stack([track.ahead[:, 1], -track.ahead[:, 0]], axis=-1)
    along, across = 0.5 * track.length[:, None] * track.ahead, 0.5 * track.width[:, None] * right
    signs = ((1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0))
    return np.stack([track.place + a * along + b * across for a, b in signs], axis=1)


def _extent(plan: PlanOnMap, fields: Array) -> tuple[float, float, float, float]:
    points = np.vstack([fields.reshape(-1, 2), plan.lines.reshape(-1, 2)])
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.05 * float((high - low).max())
    return float(low[0] - margin), float(low[1] - margin), float(high[0] + margin), float(high[1] + margin)


def _draw_accepted(ax: Any, track: Stations, fields: Array) -> None:
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    ramp = LinearSegmentedColormap.from_list("accepted", list(zip(SHARES, COLOURS, strict=True)))
    bar = _draw_fields(ax, fields, 100.0 * track.of("accepted"), ramp, Normalize(0.0, 100.0))
    unknown = "; hatched: no land" if np.isnan(track.of("accepted")).any() else ""
    bar.set_label(f"strips that will be accepted [%]{unknown}")


def _draw_errors(ax: Any, track: Stations, fields: Array) -> None:
    from matplotlib.colors import LinearSegmentedColormap, LogNorm

    ramp = LinearSegmentedColormap.from_list("error", list(reversed(COLOURS)))
    values = np.degrees(track.of("sd_angle"))
    bar = _draw_fields(ax, fields, values, ramp, LogNorm(ERRORS_DEG[0], ERRORS_DEG[-1], clip=True))
    bar.set_ticks(ERRORS_DEG, labels=[f"{each:g}" for each in ERRORS_DEG])
    bar.minorticks_off()
    bar.set_label("standard deviation of a strip's angle [deg]")


def _draw_fields(ax: Any, fields: Array, values: Array, ramp: Any, norm: Any) -> Any:
    """Colour the land of each station by its value.  Returns the colour bar."""
    from matplotlib.collections import PolyCollection

    known = np.isfinite(values)
    shown = PolyCollection(list(fields[known]), cmap=ramp, norm=norm, lw=0, zorder=2)
    shown.set_array(values[known])
    ax.add_collection(shown)
    if (~known).any():
        outside = PolyCollection(list(fields[~known]), facecolors="none", edgecolors="#000000", lw=0.0, zorder=2)
        outside.set_hatch("///")
        ax.add_collection(outside)
    return ax.figure.colorbar(shown, ax=ax, orientation="horizontal", shrink=0.5, aspect=40, pad=0.02)


def _draw_lines(ax: Any, plan: PlanOnMap) -> None:
    from matplotlib.collections import LineCollection

    for colour, width in (("#000000", 2.6), ("#ffffff", 1.2)):
        ax.add_collection(LineCollection(list(plan.lines), colors=colour, lw=width, zorder=4))
    plan.name_lines(ax)


def _title(found: Outlook) -> str:
    """Name, and figures of all lines."""
    lines = [line for line in found.figures["lines"] if line["strips_accepted_pct"] is not None]
    head = f"{found.figures['name']}: trackability, in calm air"
    if not lines:
        return f"{head}\nno land under the lines"
    shares, angles = (np.array([line[key] for line in lines]) for key in ("strips_accepted_pct", "strip_sd_deg"))
    blind = max(line["strips_blind_m"] for line in lines)
    parts = [
        f"accepted {shares.mean():.0f} %, least on a line {shares.min():.0f} %",
        f"error of a strip {np.median(angles):.2f} deg",
        f"longest stretch without strips {blind / 1000.0:.1f} km" if blind > 0.0 else "no stretch without strips",
    ]
    return f"{head}\n{', '.join(parts)}"
