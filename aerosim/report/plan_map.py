"""The map of a plan: land, area, lines, run-ins, turns, footprints, gaps, wind."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from aerosim.frames import Array
from aerosim.report.plots import BAD, ESTIMATE, STRIP, style

if TYPE_CHECKING:
    from aerosim.forecast.check import Outlook

MAP_PX = 1800
MOST_NAMES = 40
MOST_FOOTPRINTS = 120
GAP = "#d00000"
HALO = {"fc": "#ffffffd8", "ec": "none"}


class PlanOnMap:
    """A plan on the map grid of its terrain.  Lengths in m, easting and northing."""

    def __init__(self, found: Outlook) -> None:
        from aerosim.forecast import paths, shots

        self.found = found
        plane, plan, wind = found.land.plane, found.plan, found.wind
        self.lines = self.placed(np.array([plane.to_plane([line.start, line.end]) for line in plan.lines]))
        replayed = found.path is not None  # its run-ins and turns are part of its path
        self.run_ins = [] if replayed else [self.placed(way) for way in paths.run_ins(plan, wind, plane)]
        ways = [found.path] if found.path is not None else paths.turns(plan, wind, plane)
        self.turns = [self.placed(way) for way in ways]
        self.footprints = self.placed(shots.corners(found.land, found.shots))
        self.centres = self.placed(found.shots.place)
        self.area = None if found.ring is None else self.placed(found.ring)

    def placed(self, places: Array) -> Array:
        """Easting and northing of places on the plane, (..., 2), m."""
        lat, lon = np.moveaxis(self.found.land.plane.to_geodetic(places), -1, 0)
        return np.stack(self.found.terrain.grid.from_geodetic(lat, lon), axis=-1)

    def extent(self) -> tuple[float, float, float, float]:
        """Range of all that is drawn, with a margin: e_min, n_min, e_max, n_max."""
        parts = [self.lines.reshape(-1, 2), self.footprints.reshape(-1, 2), *self.run_ins, *self.turns]
        points = np.vstack(parts if self.area is None else [*parts, self.area])
        low, high = points.min(axis=0), points.max(axis=0)
        margin = 0.03 * float((high - low).max())
        return float(low[0] - margin), float(low[1] - margin), float(high[0] + margin), float(high[1] + margin)

    @property
    def each(self) -> int:
        """Only each so-many-th line bears its name and arrow."""
        return -(-len(self.lines) // MOST_NAMES)

    def name_lines(self, ax: Any) -> None:
        """Names of the lines at their starts."""
        ring = {"boxstyle": "circle,pad=0.2", "fc": "#ffffff", "ec": ESTIMATE, "lw": 0.8}
        for number in range(0, len(self.lines), self.each):
            name, start = self.found.names[number], self.lines[number, 0]
            ax.annotate(name, start, ha="center", va="center", fontsize=7.5, zorder=7, bbox=ring)

    def north(self) -> Array:
        """Direction of true north on the grid in the plan's middle, unit vector."""
        foot, up = self.placed(np.array([[0.0, 0.0], [0.0, 1000.0]]))
        return np.asarray((up - foot) / np.hypot(*(up - foot)))


def draw(ax: Any, found: Outlook) -> None:
    """Draw the map of a plan into matplotlib axes whose figure has its final size."""
    plan = PlanOnMap(found)
    bounds = plan.extent()
    blank_axes(ax, bounds)
    land(ax, found, bounds)
    _photos(ax, plan)
    _ways(ax, plan)
    _gaps(ax, plan)
    ax.figure.suptitle(_title(found), fontsize=10, x=0.01, ha="left")
    ax.figure.legend(loc="outside lower right", ncols=7, fontsize=9, handlelength=1.8)
    furniture(ax, plan, bounds)


def blank_axes(ax: Any, bounds: tuple[float, float, float, float]) -> None:
    """Axes of a map in km.  bounds: e_min, n_min, e_max, n_max, m."""
    ax.set_xlim(bounds[0], bounds[2])
    ax.set_ylim(bounds[1], bounds[3])
    ax.set_aspect("equal")
    ax.grid(visible=False)
    ax.set_facecolor("#e9e9e4")
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_formatter(lambda value, _: f"{value / 1000:g}")
    ax.set_xlabel("easting [km]")
    ax.set_ylabel("northing [km]")


def land(ax: Any, found: Outlook, bounds: tuple[float, float, float, float]) -> None:
    """The orthophoto, paled, as far as there is one."""
    whole = found.terrain.bounds
    cut = (*np.maximum(bounds[:2], whole[:2]), *np.minimum(bounds[2:], whole[2:]))
    if cut[0] >= cut[2] or cut[1] >= cut[3]:
        return
    picture, window = found.terrain.picture(MAP_PX, cut)
    e_min, n_min, e_max, n_max = window.bounds
    half = window.dx / 2.0
    soft = (0.7 * picture + 0.3 * 255.0).astype(np.uint8)
    ax.imshow(soft, extent=(e_min - half, e_max + half, n_min - half, n_max + half), origin="upper", zorder=0)


def _photos(ax: Any, plan: PlanOnMap) -> None:
    from matplotlib.collections import PolyCollection
    from matplotlib.patheffects import withStroke

    each = -(-len(plan.footprints) // MOST_FOOTPRINTS)
    shown = list(plan.footprints[::each])
    thin = float(np.clip(60.0 / len(shown), 0.4, 0.9))
    ax.add_collection(PolyCollection(shown, facecolors="#ffffff0c", edgecolors="#ffffff", lw=thin, zorder=2))
    ax.plot(
        [], [], marker="s", ls="none", mfc="none", mec="#ffffff", ms=9,
        label="photo footprint" if each == 1 else f"photo footprint, 1 of {each}",
        path_effects=[withStroke(linewidth=4.0, foreground="#6f7a60")],  # a white line needs land around it
    )  # fmt: skip
    size = float(np.clip(300.0 / len(plan.centres), 1.0, 3.0))
    ax.plot(*plan.centres.T, "o", ms=size, color=STRIP, mec="#000000", mew=0.3, zorder=6, label="photo")


def _ways(ax: Any, plan: PlanOnMap) -> None:
    """Area, lines with direction and name, run-ins and turns."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Polygon

    if plan.area is not None:
        outline = {"fill": False, "ec": "#000000", "lw": 1.6, "ls": (0, (5, 2)), "zorder": 5}
        ax.add_patch(Polygon(plan.area, closed=True, label="area", **outline))
    ax.add_collection(
        LineCollection(plan.turns, colors="#5b3a8c", lw=0.9, zorder=3, label="turn" if plan.run_ins else "path")
    )
    if plan.run_ins:
        ax.add_collection(LineCollection(plan.run_ins, colors="#5b3a8c", lw=1.6, ls=":", zorder=4, label="run-in"))
    ax.add_collection(LineCollection(list(plan.lines), colors=ESTIMATE, lw=1.6, zorder=4, label="line"))
    arrow = {"arrowstyle": "-|>,head_width=0.25,head_length=0.5", "color": ESTIMATE, "lw": 1.6}
    for start, end in plan.lines[:: plan.each]:
        middle = start + 0.5 * (end - start)
        way = 0.02 * (end - start)
        ax.annotate("", xy=middle + way, xytext=middle - way, arrowprops=arrow, zorder=5)
    plan.name_lines(ax)


def _gaps(ax: Any, plan: PlanOnMap) -> None:
    """What no photo sees, in red, ringed where it is small."""
    from matplotlib.colors import ListedColormap

    seen = plan.found.seen
    if seen is None or not (gap := seen.within & (seen.counts == 0)).any():
        return
    rows, cols = (np.flatnonzero(gap.any(axis=axis)) for axis in (1, 0))
    piece = np.s_[rows[0] : rows[-1] + 1], np.s_[cols[0] : cols[-1] + 1]
    x, y = seen.x[piece[1]], seen.y[piece[0]]
    half = 0.5 * (seen.x[1] - seen.x[0])
    edges = np.meshgrid(np.append(x - half, x[-1] + half), np.append(y + half, y[-1] - half))
    placed = plan.placed(np.stack(edges, axis=-1))
    shown = np.ma.masked_where(~gap[piece], np.ones(gap[piece].shape))
    ax.pcolormesh(placed[..., 0], placed[..., 1], shown, cmap=ListedColormap([GAP]), zorder=5, alpha=0.85)
    places = plan.placed(np.array([(east, north) for east, north, _ in seen.gaps()]))
    ax.plot(*places.T, "o", ms=11, mfc="none", mec=GAP, mew=1.8, ls="none", zorder=8, label="on no photo")


def _title(found: Outlook) -> str:
    """Name and figures, two rows."""
    flight, photos, covered = (found.figures[key] for key in ("flight", "photos", "coverage"))
    duration = divmod(round(flight["duration_s"] / 60.0), 60)
    lap = photos["side_lap_min_pct"]
    parts = [
        f"{flight['lines']} line{'s' if flight['lines'] > 1 else ''}, {flight['line_length_m'] / 1000:.0f} km",
        f"{photos['count']} photos",
        f"{duration[0]} h {duration[1]:02d} min" if duration[0] else f"{duration[1]} min",
        f"{flight['height_m']:.0f} m above the ellipsoid",
    ]
    laps = [
        f"GSD {100 * photos['gsd_min_m']:.1f} to {100 * photos['gsd_max_m']:.1f} cm",
        f"end lap {photos['wanted_end_lap_pct']:g} %",
    ]
    if lap is not None:
        laps.append(f"side lap {photos['side_lap_mean_pct']:.1f} %, least {lap:.1f} %")
    if covered is not None:
        laps.append(f"on no photo {covered['seen_0_pct']:.2g} % of {_area(covered['area_km2'])}")
    return f"{found.figures['name']}: {', '.join(parts)}\n{', '.join(laps)}"


def _area(km2: float) -> str:
    """An area in the unit that suits it."""
    if km2 >= 0.1:
        return f"{km2:.4g} km²"
    return f"{100.0 * km2:.3g} ha" if km2 >= 0.001 else f"{1e6 * km2:.3g} m²"


def furniture(ax: Any, plan: PlanOnMap, bounds: tuple[float, float, float, float]) -> None:
    """Scale bar, north arrow, wind arrow, in the corners of the map."""
    ax.figure.canvas.draw()  # the layout is made only now
    width, height = bounds[2] - bounds[0], bounds[3] - bounds[1]
    power = 10.0 ** np.floor(np.log10(width / 5.0))
    length = float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= width / 5.0))
    x, y = bounds[2] - 0.02 * width - length, bounds[1] + 0.03 * height
    for colour, size in (("#ffffff", 7), ("#000000", 3)):
        ax.plot([x, x + length], [y, y], color=colour, lw=size, solid_capstyle="butt", zorder=9)
    text = f"{length / 1000:g} km" if length >= 1000 else f"{length:g} m"
    ax.annotate(
        text, (x + length / 2, y), xytext=(0, 5), textcoords="offset points", ha="center", va="bottom", fontsize=9,
        zorder=9, bbox={"boxstyle": "round,pad=0.15"} | HALO,
    )  # fmt: skip
    north = plan.north()
    _arrow(ax, 22.0, north, "N", "#000000")
    speed = float(np.hypot(*plan.found.wind))
    if speed >= 0.05:
        east = np.array([north[1], -north[0]])
        way = (plan.found.wind[0] * north + plan.found.wind[1] * east) / speed
        _arrow(ax, 72.0, way, f"wind {speed:.3g} m/s", BAD)


def _arrow(ax: Any, at: float, way: Array, text: str, colour: str) -> None:
    """An arrow and its word in the upper left of the map.  at: pt from its left edge; way: unit vector."""
    middle = np.array([at, -24.0])
    pixels = {"xycoords": "figure pixels", "textcoords": "figure pixels", "zorder": 10}
    ax.annotate(
        text, _points(ax, middle), xytext=_points(ax, middle + np.array([17.0, 0.0])), va="center", fontsize=9,
        bbox={"boxstyle": "round,pad=0.2"} | HALO, **pixels,
    )  # fmt: skip
    head = "-|>,head_width=0.3,head_length=0.5"
    ax.annotate(
        "", xy=_points(ax, middle + 11.0 * way), xytext=_points(ax, middle - 11.0 * way), **pixels,
        arrowprops={"arrowstyle": head, "color": colour, "lw": 2.2, "shrinkA": 0, "shrinkB": 0},
        bbox={"boxstyle": "circle"} | HALO,
    )  # fmt: skip


def _points(ax: Any, place: Array) -> Array:
    """Figure pixels of a place in pt from the upper left corner of the axes."""
    box = ax.get_window_extent()
    return np.asarray(np.array([box.x0, box.y1]) + place * ax.figure.dpi / 72.0)


def figure_of(found: Outlook) -> Any:
    """The map as a matplotlib figure, 10 inches wide; to be called and saved within `plots.style`."""
    figure = sized_figure(PlanOnMap(found).extent())
    draw(figure.subplots(), found)
    return figure


def sized_figure(bounds: tuple[float, float, float, float]) -> Any:
    """An empty figure, 10 inches wide, for a map of these bounds."""
    return empty_figure(float(np.clip(9.2 * shape_of(bounds) + 1.3, 4.0, 12.0)))


def shape_of(bounds: tuple[float, float, float, float]) -> float:
    """Height over width."""
    return (bounds[3] - bounds[1]) / (bounds[2] - bounds[0])


def empty_figure(height: float) -> Any:
    """An empty figure, 10 inches wide.  height: inches."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, height), layout="constrained", dpi=130)
    FigureCanvasAgg(figure)
    return figure


def map_png(found: Outlook) -> bytes:
    """The map as a PNG picture, 1300 px wide."""
    out = io.BytesIO()
    with style():
        figure_of(found).savefig(out, format="png", metadata={"Software": None})
    return out.getvalue()
