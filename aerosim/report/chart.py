"""The map of a run: land, lines, flown path, footprints, wind."""

from __future__ import annotations

import io
from typing import Any

import numpy as np

from aerosim.frames import Array
from aerosim.report.plots import BAD, GOOD, STRIP, style
from aerosim.report.source import Source, middle

PATH = "#56B4E9"
MAP_PX = 1800
BARE = {"shrinkA": 0, "shrinkB": 0}
WHITE = {"fc": "#ffffffd8", "ec": "none"}


def extent(source: Source) -> tuple[float, float, float, float]:
    """Easting and northing range (m) of everything drawn, with a margin: e_min, n_min, e_max, n_max."""
    points = [source.lines_g.reshape(-1, 2), source.path_g[:, :2], source.footprints_g.reshape(-1, 2)]
    known = np.concatenate(points)
    known = known[np.isfinite(known).all(axis=1)]
    low, high = known.min(axis=0), known.max(axis=0)
    margin = max(400.0, 0.02 * float((high - low).max()))
    return float(low[0] - margin), float(low[1] - margin), float(high[0] + margin), float(high[1] + margin)


def _round_length(limit: float) -> float:
    """The greatest of 1, 2, 5 times a power of ten that does not exceed the limit (m)."""
    power = 10.0 ** np.floor(np.log10(limit))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= limit))


def _land(ax: Any, source: Source, bounds: tuple[float, float, float, float]) -> None:
    if source.terrain is None:
        return
    land = source.terrain.bounds
    cut = (*np.maximum(bounds[:2], land[:2]), *np.minimum(bounds[2:], land[2:]))
    if cut[0] >= cut[2] or cut[1] >= cut[3]:
        return
    picture, window = source.terrain.picture(MAP_PX, cut)
    e_min, n_min, e_max, n_max = window.bounds
    half = window.dx / 2.0
    # washed out a little: lines and footprints are what the map is about
    soft = (0.78 * picture + 0.22 * 255.0).astype(np.uint8)
    ax.imshow(soft, extent=(e_min - half, e_max + half, n_min - half, n_max + half), origin="upper", zorder=0)


def _footprints(ax: Any, source: Source) -> None:
    from matplotlib.collections import PolyCollection

    corners, whole = source.footprints_g, source.whole_footprints
    if not whole.any():
        return
    ax.add_collection(
        PolyCollection(list(corners[whole]), facecolors="#ffffff10", edgecolors="#ffffff", lw=0.9, zorder=2)
    )
    label = "photo footprint, projection centre"
    centres = source.on_map(source.photos["lat_true_deg"], source.photos["lon_true_deg"])
    ax.plot([], [], marker="s", ls="none", mfc="#b8b8b8", mec="#ffffff", ms=9, label="photo footprint")
    ax.plot(*centres.T, "o", ms=3.2, color=STRIP, mec="#000000", mew=0.4, zorder=5, label=label.split(", ")[1])


def _arrow(ax: Any, at: float, direction: Array, text: str, colour: str) -> None:
    """An arrow at the figure's upper left.  at: pt from its left edge; direction: unit vector on the grid."""
    corner = _corner(ax.figure)
    middle = np.array([at, -16.0])
    ax.annotate(
        "", xy=middle + 10.0 * direction, xytext=middle - 10.0 * direction, xycoords=corner, textcoords=corner,
        annotation_clip=False,
        arrowprops={"arrowstyle": "-|>,head_width=0.3,head_length=0.5", "color": colour, "lw": 2.2} | BARE,
    ).set_in_layout(False)  # fmt: skip
    label = ax.annotate(
        text, xy=(at + 14.0, -16.0), xycoords=corner, va="center", fontsize=9, annotation_clip=False
    )
    label.set_in_layout(False)


def _corner(figure: Any) -> Any:
    """Coordinates in pt from the upper left corner of the figure."""
    from matplotlib.transforms import Affine2D

    return Affine2D().scale(figure.dpi / 72.0).translate(0.0, figure.bbox.height)


def _furniture(ax: Any, source: Source, bounds: tuple[float, float, float, float]) -> None:
    """North arrow and wind arrow above the map, at the left; scale bar in it."""
    up = source.on_map(*np.degrees(_north_pair(source, bounds)))
    north = (up[1] - up[0]) / np.hypot(*(up[1] - up[0]))
    _arrow(ax, 20.0, north, "N", "#000000")
    tel = source.telemetry
    if source.count(tel):
        wind = np.array([middle(tel["wind_east_m_s"]), middle(tel["wind_north_m_s"])])
        speed = float(np.hypot(*wind))
        if speed >= 0.05:
            east = np.array([north[1], -north[0]])
            _arrow(ax, 68.0, (wind[0] * east + wind[1] * north) / speed, f"wind {speed:.1f} m/s", BAD)
    width = bounds[2] - bounds[0]
    length = _round_length(width / 5.0)
    x, y = bounds[2] - 0.03 * width - length, bounds[1] + 0.045 * (bounds[3] - bounds[1])
    ax.plot([x, x + length], [y, y], color="#ffffff", lw=7, solid_capstyle="butt", zorder=7)
    ax.plot([x, x + length], [y, y], color="#000000", lw=3, solid_capstyle="butt", zorder=8)
    label = f"{length / 1000:g} km" if length >= 1000 else f"{length:g} m"
    ax.annotate(
        label, (x + length / 2.0, y), xytext=(0, 5), textcoords="offset points", ha="center", va="bottom",
        fontsize=9, zorder=8, bbox={"boxstyle": "round,pad=0.15"} | WHITE,
    )  # fmt: skip


def _north_pair(source: Source, bounds: tuple[float, float, float, float]) -> Array:
    """Latitude and longitude (rad) of the map's middle and of a point 1e-3 rad north of it.  (2, 2)."""
    lat, lon = source.grid.to_geodetic((bounds[0] + bounds[2]) / 2.0, (bounds[1] + bounds[3]) / 2.0)
    return np.array([[lat, lat + 1e-3], [lon, lon]], float)


def _plan(ax: Any, source: Source) -> None:
    """Planned lines, named at their starts."""
    ring = {"boxstyle": "circle,pad=0.2", "fc": "#ffffff", "ec": "#000000", "lw": 0.8}
    for k, (name, (start, end)) in enumerate(zip(source.line_names, source.lines_g, strict=True)):
        label = "planned line" if k == 0 else None
        ax.plot(*zip(start, end, strict=True), color="#000000", lw=1.1, ls=(0, (6, 3)), zorder=4, label=label)
        ax.annotate(name, start, ha="center", va="center", fontsize=8.5, zorder=6, bbox=ring)


def draw(ax: Any, source: Source) -> None:
    """Draw the map into matplotlib axes whose figure has its final size."""
    bounds = extent(source)
    ax.set_xlim(bounds[0], bounds[2])
    ax.set_ylim(bounds[1], bounds[3])
    ax.set_aspect("equal")
    ax.grid(visible=False)
    _land(ax, source, bounds)
    _footprints(ax, source)
    _plan(ax, source)
    path = source.path_g
    if len(path):
        thin = path[:: max(1, len(path) // 3000)]
        ax.plot(thin[:, 0], thin[:, 1], color=PATH, lw=1.8, zorder=3, label="flown path")
        ax.plot(*path[0, :2], marker="o", color=GOOD, ms=8, mec="#000000", ls="none", zorder=6, label="begin")
        ax.plot(*path[-1, :2], marker="s", color=BAD, ms=7, mec="#000000", ls="none", zorder=6, label="end")
    ax.xaxis.set_major_formatter(lambda value, _: f"{value / 1000:g}")
    ax.yaxis.set_major_formatter(lambda value, _: f"{value / 1000:g}")
    ax.set_xlabel("easting [km]")
    ax.set_ylabel("northing [km]")
    handles, labels = ax.get_legend_handles_labels()
    ax.figure.legend(handles, labels, loc="outside upper right", ncols=7, fontsize=9, handlelength=1.6)
    ax.figure.canvas.draw()
    _furniture(ax, source, bounds)


def map_jpeg(source: Source) -> bytes:
    """The map as a JPEG picture, 1500 px wide."""
    bounds = extent(source)
    shape = (bounds[3] - bounds[1]) / (bounds[2] - bounds[0])
    with style() as figure_class:
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        height = float(np.clip(9.2 * shape + 1.0, 2.8, 8.0))
        figure = figure_class(figsize=(10.0, height), layout="constrained", dpi=150)
        FigureCanvasAgg(figure)
        draw(figure.subplots(), source)
        out = io.BytesIO()
        figure.savefig(out, format="jpg", pil_kwargs={"quality": 85})
        return out.getvalue()
