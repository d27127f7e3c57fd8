"""The map of a plan's trackability: where the two rows will recognise the land under the lines, and where not."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from aerosim.frames import Array
from aerosim.report.plan_map import PlanOnMap, blank_axes, furniture, land, sized_figure
from aerosim.report.plots import style

if TYPE_CHECKING:
    from aerosim.forecast.check import Outlook
    from aerosim.forecast.trackability import Stations

# Share of accepted strips and its colour: good land stays visible, blind land is dark to every eye
COLOURS = ((0.0, "#2b0a57e6"), (0.5, "#c8456cb8"), (0.85, "#f6a93280"), (1.0, "#fff3a030"))


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
    figure = sized_figure(bounds)
    ax = figure.subplots()
    blank_axes(ax, bounds)
    land(ax, found, bounds)
    _draw_fields(ax, found.track, fields)
    _draw_lines(ax, plan)
    figure.suptitle(_title(found), fontsize=10, x=0.01, ha="left")
    furniture(ax, plan, bounds)
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


def _draw_fields(ax: Any, track: Stations, fields: Array) -> None:
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import LinearSegmentedColormap

    accepted = 100.0 * track.of("accepted")
    known = np.isfinite(accepted)
    shown = PolyCollection(
        list(fields[known]), cmap=LinearSegmentedColormap.from_list("track", COLOURS), lw=0, zorder=2
    )
    shown.set_array(accepted[known])
    shown.set_clim(0.0, 100.0)
    ax.add_collection(shown)
    if (~known).any():
        outside = PolyCollection(list(fields[~known]), facecolors="none", edgecolors="#000000", lw=0.0, zorder=2)
        outside.set_hatch("///")
        ax.add_collection(outside)
    bar = ax.figure.colorbar(shown, ax=ax, orientation="horizontal", shrink=0.5, aspect=40, pad=0.02)
    bar.set_label("strips that will be accepted [%]" + ("; hatched: no land" if (~known).any() else ""))


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
