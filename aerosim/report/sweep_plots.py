"""Plots of a sweep as inline SVG: a metric over what was varied, paired differences, main effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from aerosim.frames import Array
from aerosim.report.plots import BAD, GREY, style, to_svg
from aerosim.report.sweep_view import Axes, Known, MetricView, axis, is_number, less, told, word

# Okabe and Ito's colours, the yellow left out: too faint for a line
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
DASHES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 2, 1.5, 2)), "-", (0, (6, 2)), (0, (2, 1.5)))
PANELS_MOST = 4
TICKS_MOST = 8  # at numbers that were flown; of more, the axis has ticks of its own
CROSS_ROOM = 0.06  # of the axes' height, for the crosses of one curve


def places_of(values: Sequence[Any]) -> tuple[dict[Any, float], bool]:
    """Place on the axis of each value, and whether the axis is one of numbers."""
    if all(is_number(value) for value in values):
        return {value: float(value) for value in values}, True
    return {value: float(k) for k, value in enumerate(values)}, False


def draw_curve(
    ax: Any, x: Array, known: Sequence[Known], label: str, number: int, *, joined: bool = True, shift: float = 0.0
) -> None:
    """One curve with its confidence band, or points with bars where they must not be joined.

    x: (n,) places; number: of the curve, gives colour, marker and dashes; shift: of the points along x.
    Where runs failed, a cross with their number stands on the axis.
    """
    order = np.argsort(x, kind="stable")
    x = x[order]
    mean = np.array([known[k].mean for k in order])
    half = np.array([known[k].half_width for k in order])
    colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
    there = np.isfinite(mean)
    half = np.where(np.isfinite(half), half, 0.0)
    if joined:
        dashes = DASHES[number % len(DASHES)]
        ax.fill_between(x[there], (mean - half)[there], (mean + half)[there], color=colour, alpha=0.18, lw=0)
        ax.plot(x[there], mean[there], ls=dashes, marker=marker, ms=5, lw=1.6, color=colour, label=label)
    else:
        ax.errorbar(
            (x + shift)[there], mean[there], half[there], fmt=marker, ms=5, lw=1.4, capsize=3, color=colour,
            label=label,
        )  # fmt: skip
    for place, k in zip(x, order, strict=True):
        if known[k].failed:
            _cross(ax, place + shift, colour, known[k].failed, number)


def _cross(ax: Any, place: float, colour: str, failed: int, number: int) -> None:
    """A cross at the foot of the axes, with the number of seeds that failed there; curves one over another."""
    height = (number + 0.5) * CROSS_ROOM
    ax.plot(
        [place], [height], "x", ms=7, mew=2.0, color=colour, transform=ax.get_xaxis_transform(), clip_on=False,
        zorder=6,
    )  # fmt: skip
    ax.annotate(
        f"{failed} failed", (place, height), xycoords=ax.get_xaxis_transform(), xytext=(6, 0),
        textcoords="offset points", va="center", fontsize=8, color=BAD, zorder=6, annotation_clip=False,
    )  # fmt: skip


def _room(axes: Sequence[Any], known: Sequence[Known], curves: int) -> None:
    """Room for the crosses below the curves, where runs failed; the panels share their range."""
    if any(k.failed for k in known):
        low, high = axes[0].get_ylim()
        below = CROSS_ROOM * curves
        axes[0].set_ylim(low - (high - low) * below / (1.0 - below), high)


def _curves(ax: Any, known: Sequence[Known], varied: Mapping[str, Sequence[Any]], axes: Axes) -> None:
    """All curves of one panel."""
    values = list(varied[axes.x]) if axes.x in varied else [""]
    places, numbers = places_of(values)
    curves = list(varied[axes.curve]) if axes.curve else [None]
    step = 0.0 if numbers else 0.6 / max(len(curves), 1)
    for number, curve in enumerate(curves):
        mine = [k for k in known if not axes.curve or k.values[axes.curve] == curve]
        if not mine:
            continue
        x = np.array([places[k.values[axes.x]] if axes.x else 0.0 for k in mine])
        shift = (number - (len(curves) - 1) / 2.0) * step
        label = told(axes.curve, curve) if axes.curve else ""
        draw_curve(ax, x, mine, label, number, joined=numbers and len(x) > 1, shift=shift)
    _ticks(ax, axes.x if axes.x in varied else "", places, numbers)


def _ticks(ax: Any, key: str, places: Mapping[Any, float], numbers: bool) -> None:
    """Ticks of the axis of a key: at numbers, or at words; without any if there is no key."""
    if not key:
        ax.set_xticks([])
    elif not numbers:
        ax.set_xticks(list(places.values()), [told(key, value) for value in places])
    elif len(places) <= TICKS_MOST:
        ax.set_xticks(sorted(places.values()), [told("", value) for value in sorted(places)])
    if not numbers:
        ax.set_xlim(-0.6, len(places) - 0.4)
    ax.set_xlabel(axis(key) if key else "")


def _panels(figure_class: Any, count: int, height: float = 3.6) -> tuple[Any, list[Any]]:
    figure = figure_class(figsize=(9.6, height), layout="constrained")
    return figure, list(figure.subplots(1, count, sharey=True, squeeze=False)[0])


def _legend(figure: Any, ax: Any, key: str) -> None:
    handles, labels = ax.get_legend_handles_labels()
    if key and handles:
        # one column of room for each label, so that long names wrap into rows instead of leaving the figure
        columns = max(1, min(len(labels), int(95 / (max(map(len, labels)) + 7))))
        figure.legend(handles, labels, loc="outside upper center", ncols=columns, title=word(key), fontsize=9)


def draw_over_parameter(metric: MetricView, varied: Mapping[str, Sequence[Any]], axes: Axes) -> Any:
    """The metric over the first key, one curve for each value of the second, a panel for each of the third.

    Returns a matplotlib figure.
    """
    panels = list(varied[axes.panel])[:PANELS_MOST] if axes.panel else [None]
    with style() as figure_class:
        figure, places = _panels(figure_class, len(panels))
        for ax, panel in zip(places, panels, strict=True):
            mine = [k for k in metric.drawn if not axes.panel or k.values[axes.panel] == panel]
            _curves(ax, mine, varied, axes)
            if axes.panel:
                ax.set_title(f"{word(axes.panel)} {told(axes.panel, panel)}", fontsize=10)
        _room(places, metric.drawn, max(len(varied.get(axes.curve, ())), 1))
        places[0].set_ylabel(_name(metric))
        _legend(figure, max(places, key=lambda ax: len(ax.get_legend_handles_labels()[1])), axes.curve)
        return figure


def over_parameter(metric: MetricView, varied: Mapping[str, Sequence[Any]], axes: Axes) -> str:
    """The same, to stand in a page."""
    figure = draw_over_parameter(metric, varied, axes)
    with style():
        return to_svg(figure)


def cloud(metric: MetricView, varied: Mapping[str, Sequence[Any]]) -> str:
    """The points of a sample that is no grid, over each number that was varied."""
    keys = [key for key, values in varied.items() if all(is_number(value) for value in values)][:PANELS_MOST]
    other = next((key for key in varied if key not in keys), "")
    curves = list(varied[other]) if other else [None]
    with style() as figure_class:
        figure, places = _panels(figure_class, max(len(keys), 1))
        for ax, key in zip(places, keys, strict=False):
            for number, curve in enumerate(curves):
                mine = [k for k in metric.means if not other or k.values[other] == curve]
                x = np.array([float(k.values[key]) for k in mine])
                draw_curve(ax, x, mine, told(other, curve) if other else "", number, joined=False)
            ax.set_xlabel(axis(key))
        _room(places, metric.means, len(curves))
        places[0].set_ylabel(_name(metric))
        _legend(figure, places[0], other)
        return to_svg(figure)


def differences(metric: MetricView, varied: Mapping[str, Sequence[Any]], axes: Axes, compared: str) -> str:
    """Paired differences over the first key, one curve for each pair of values of the compared one."""
    key = axes.x if axes.x != compared else ""
    values = list(varied[key]) if key else [""]
    places, numbers = places_of(values)
    numbers = numbers and bool(key)
    shifts = (np.arange(len(metric.pairs)) - (len(metric.pairs) - 1) / 2.0) * 0.6 / len(metric.pairs)
    with style() as figure_class:
        panels = list(varied[axes.panel])[:PANELS_MOST] if axes.panel and axes.panel != compared else [None]
        figure, parts = _panels(figure_class, len(panels))
        for ax, panel in zip(parts, panels, strict=True):
            ax.axhline(0.0, color=GREY, lw=0.9, zorder=1)
            for number, pair in enumerate(metric.pairs):
                mine = [d for d in pair.differences if panel is None or d.values[axes.panel] == panel]
                x = np.array([places[d.values[key] if key else ""] for d in mine])
                joined, shift = numbers and len(x) > 1, 0.0 if numbers else float(shifts[number])
                draw_curve(ax, x, mine, less(compared, pair), number, joined=joined, shift=shift)
            _ticks(ax, key, places, numbers)
            if panel is not None:
                ax.set_title(f"{word(axes.panel)} {told(axes.panel, panel)}", fontsize=10)
        _room(parts, [d for pair in metric.pairs for d in pair.differences], len(metric.pairs))
        parts[0].set_ylabel(f"difference of {_name(metric)}")
        _legend(figure, parts[0], compared)
        return to_svg(figure)


def main_effects(metric: MetricView) -> str:
    """Main effects of all keys: one panel each in a grid, one for all slopes."""
    levels = [e for e in metric.effects if e.kind == "level"]
    slopes = [e for e in metric.effects if e.kind == "slope"]
    keys = list(dict.fromkeys(e.key for e in levels))
    groups = [([e for e in levels if e.key == key], word(key)) for key in keys]
    if slopes:
        groups.append((slopes, "over the whole range"))
    with style() as figure_class:
        figure, places = _panels(figure_class, len(groups), 3.2)
        for ax, (group, title) in zip(places, groups, strict=True):
            ax.axhline(0.0, color=GREY, lw=0.9, zorder=1)
            at = np.arange(len(group), dtype=float)
            half = np.array([e.half_width for e in group])
            ax.errorbar(
                at, [e.effect for e in group], np.where(np.isfinite(half), half, 0.0), fmt="o", ms=6, capsize=4,
                lw=1.4, color=COLOURS[0],
            )  # fmt: skip
            names = [word(e.key) if e.kind == "slope" else f"{told('', e.value)}" for e in group]
            long = sum(map(len, names)) > 90 / len(groups)
            ax.set_xticks(
                at, names, rotation=25 if long else 0, ha="right" if long else "center", rotation_mode="anchor"
            )
            ax.set_xlim(-0.5, len(group) - 0.5)
            ax.set_title(axis(group[0].key) if group[0].kind == "level" else title, fontsize=10)
        places[0].set_ylabel(f"effect on {_name(metric)}")
        return to_svg(figure)


def _name(metric: MetricView) -> str:
    figure = metric.figure
    name = figure.name[0].lower() + figure.name[1:] if not figure.name.startswith("v/h") else figure.name
    return f"{name} [{figure.unit}]" if figure.unit else name
