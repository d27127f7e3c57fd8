"""Time plots of a run as inline SVG: crab and drift, v/h, photos, strips."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerosim.report.source import Columns, Source

# Okabe and Ito's colours: told apart by every kind of colour vision, and as greys in print
TRUE, ESTIMATE, STRIP, GOOD, BAD = "#000000", "#0072B2", "#E69F00", "#009E73", "#D55E00"
GREY = "#8c8c8c"
POINTS = 1200
STYLE: dict[Any, Any] = {
    "font.family": "sans-serif", "font.size": 10.0, "svg.fonttype": "none", "svg.hashsalt": "aerosim",
    "axes.grid": True, "grid.color": "#e2e2e2", "grid.linewidth": 0.6, "axes.axisbelow": True,
    "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False, "lines.linewidth": 1.2,
    "path.simplify": True, "path.simplify_threshold": 0.3,
}  # fmt: skip
REASONS = ("accepted", "border_mu", "border_n", "degenerate", "ambiguous", "outside_terrain", "timeout", "skipped")
NO_META: dict[str, None] = dict.fromkeys(("Date", "Creator", "Format", "Type"))


@contextmanager
def style() -> Iterator[Any]:
    """Matplotlib set up for these plots, without a display.  Gives `matplotlib.figure.Figure`."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        yield Figure


def thin(t: NDArray[Any], y: NDArray[Any], most: int = POINTS) -> tuple[NDArray[Any], NDArray[Any]]:
    """The least and greatest value of each of most/2 pieces: half the points, all the peaks.  (n,), (n,)."""
    size = -(-2 * len(t) // most)
    if size < 4:
        return t, y
    count = len(t) // size
    piece = np.asarray(y[: count * size], float).reshape(count, size)
    low = np.where(np.isnan(piece), np.inf, piece).argmin(axis=1)
    high = np.where(np.isnan(piece), -np.inf, piece).argmax(axis=1)
    keep = np.sort(np.stack([low, high], axis=1), axis=1) + np.arange(count)[:, None] * size
    index = np.unique(np.r_[keep.ravel(), len(t) - 1])
    return t[index], y[index]


def to_svg(figure: Any) -> str:
    """A figure as an <svg> element to stand in a page."""
    out = io.StringIO()
    figure.savefig(out, format="svg", metadata=NO_META)
    text = out.getvalue()
    return text[text.index("<svg") :].strip()


def _shade(source: Source, axes: Sequence[Any]) -> None:
    """Turns greyed over the curves; the start of each line, which the summary leaves out, tinted."""
    first = source.scenario.record.exclude_first_s
    for ax in axes:
        for k, (start, end) in enumerate(source.spans(want_turns=True)):
            ax.axvspan(
                start, end, color="#d4d4d4", alpha=0.85, lw=0, zorder=5, label="off the lines" if k == 0 else None
            )
        for k, (start, end) in enumerate(source.spans(want_turns=False)):
            label = "not in the summary" if k == 0 else None
            ax.axvspan(start, min(start + first, end), color="#f3ead2", lw=0, zorder=0, label=label)


def _limits(ax: Any, source: Source, *names: str, scale: float = 1.0, extra: Any = ()) -> None:
    """Range of y from what happens on the lines, and from extra values; a turn may leave it."""
    on = source.telemetry["line"] >= 0
    if not on.any():
        on = ~on
    values = [scale * np.asarray(source.telemetry[name][on], float) for name in names]
    known = np.concatenate([*values, np.asarray(extra, float)])
    known = known[np.isfinite(known)]
    if len(known):
        low, high = np.percentile(known, [0.1, 99.9])
        pad = max(0.08 * (high - low), 1e-3 * max(abs(low), abs(high)), 1e-9)
        ax.set_ylim(low - pad, high + pad)


def _curve(ax: Any, tel: Columns, name: str, label: str, colour: str, **kind: Any) -> None:
    """One curve; where it leaves the range of y off the lines, it is left out."""
    y = np.asarray(tel[name], float)
    low, high = ax.get_ylim()
    y = np.where((tel["line"] < 0) & ((y < low) | (y > high)), np.nan, y)
    ax.plot(*thin(tel["t_s"], y), color=colour, label=label, **kind)


def _legend(ax: Any, columns: int = 6) -> None:
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, fontsize=9, handlelength=1.6)


def _axes(figure_class: Any, rows: int, height: float, ratios: Sequence[float] | None = None) -> tuple[Any, Any]:
    figure = figure_class(figsize=(9.6, height), layout="constrained")
    axes = figure.subplots(rows, 1, sharex=True, squeeze=False, height_ratios=ratios)[:, 0]
    axes[-1].set_xlabel("time [s]")
    for ax in axes:
        ax.margins(x=0.01)
    return figure, axes


def draw_motion(axes: Sequence[Any], source: Source) -> None:
    """Drift and crab, true and estimated, into two matplotlib axes that share their time."""
    tel = source.telemetry
    for ax, name in zip(axes, ("drift", "crab"), strict=True):
        _limits(ax, source, f"{name}_true_deg", f"{name}_est_deg")
        _curve(ax, tel, f"{name}_true_deg", "true", TRUE, lw=1.6)
        _curve(ax, tel, f"{name}_est_deg", "estimated", ESTIMATE)
        ax.set_ylabel(f"{name} [deg]")
    axes[1].axhline(0.0, color=GREY, lw=0.8)
    _shade(source, axes)
    _legend(axes[0])


def motion(source: Source) -> str:
    """Drift and crab, true and estimated."""
    with style() as figure_class:
        figure, axes = _axes(figure_class, 2, 5.2)
        draw_motion(axes, source)
        return to_svg(figure)


def speed_to_height(source: Source) -> str:
    """v/h, true and estimated, with each accepted strip at its mid-time."""
    tel, strips = source.telemetry, source.matches
    with style() as figure_class:
        figure, (ax,) = _axes(figure_class, 1, 3.2)
        measured = np.empty(0)
        if source.count(strips):
            good = strips["accepted"].astype(bool)
            t = (strips["t_row1_s"] + strips["t_row2_s"])[good] / 2.0
            measured = 1e3 * np.asarray(strips["vh_per_s"][good], float)
            ax.plot(t, measured, ".", ms=4, color=STRIP, label="accepted strip", zorder=2)
        names = ("vh_true_per_s", "vh_est_per_s")
        milli = {**tel, **{name: 1e3 * np.asarray(tel[name], float) for name in names}}
        _limits(ax, source, *names, scale=1e3, extra=measured)
        _curve(ax, milli, names[0], "true, now", TRUE, lw=1.6, zorder=3)
        _curve(ax, milli, names[1], "estimated", ESTIMATE, zorder=4)
        ax.set_ylabel("v/h [mrad/s]")
        _shade(source, [ax])
        _legend(ax)
        return to_svg(figure)


def photos(source: Source, tolerance_pct: float) -> str:
    """End lap of each photo with its tolerance, tilt, blur.  tolerance_pct: to either side of the wanted lap."""
    shots, wanted = source.photos, source.scenario.control.end_lap_pct
    with style() as figure_class:
        figure, axes = _axes(figure_class, 3, 5.6, (2, 1, 1))
        ax = axes[0]
        ax.axhspan(
            wanted - tolerance_pct, wanted + tolerance_pct, color="#d7eee5", lw=0, label="tolerance", zorder=0
        )
        ax.axhline(wanted, color=GOOD, lw=1.0, label="wanted")
        t = shots["t_s"]
        lap, relief = (np.asarray(shots[f"end_lap{k}_pct"], float) for k in ("", "_terrain"))
        ax.plot(t, relief, "_", color=GREY, ms=7, mew=1.4, label="least on the relief")
        ax.plot(t, lap, "o", ms=4.5, color=ESTIMATE, label="on the mean ground")
        bad = shots["verdict"] != "ok"
        ax.plot(t[bad], lap[bad], "o", ms=9, mfc="none", mec=BAD, mew=1.6, label="verdict not ok")
        ax.set_ylabel("end lap [%]")
        for ax, name, label in ((axes[1], "tilt_deg", "tilt [deg]"), (axes[2], "blur_px", "blur [px]")):
            value = np.asarray(shots[name], float)
            ax.plot(t, value, "o", ms=3.5, color=ESTIMATE)
            ax.plot(t[bad], value[bad], "o", ms=8, mfc="none", mec=BAD, mew=1.4)
            ax.set_ylabel(label)
            known = value[np.isfinite(value)]
            ax.set_ylim(0.0, 1.15 * max(float(known.max(initial=0.0)), 0.1))
        _shade(source, axes)
        _legend(axes[0], 4)
        return to_svg(figure)


def strips(source: Source) -> str:
    """Recognised n against the closed form, the MAD minimum, and why strips were refused."""
    found = source.matches
    t, good = np.asarray(found["t_row1_s"], float), found["accepted"].astype(bool)
    n, minimum = (np.asarray(found[k], float) for k in ("n", "mad_min_grey"))
    with style() as figure_class:
        figure, axes = _axes(figure_class, 3, 6.0, (2, 1.4, 1.3))
        axes[0].plot(t, found["n_true"], "_", color=TRUE, ms=6, mew=1.2, label="equation (1) with the true v/h")
        for ax, y in ((axes[0], n), (axes[1], minimum)):
            ax.plot(t[~good], y[~good], "x", ms=5, color=BAD, label="refused")
            ax.plot(t[good], y[good], ".", ms=5, color=ESTIMATE, label="accepted")
        known = n[good & np.isfinite(n)]
        if len(known):
            middle, spread = np.median(known), np.percentile(np.abs(known - np.median(known)), 99)
            axes[0].set_ylim(middle - 2.0 * spread - 3.0, middle + 2.0 * spread + 3.0)
        axes[0].set_ylabel("n [exposures]")
        axes[1].set_ylabel("least MAD [grey]")
        axes[1].set_ylim(bottom=0.0)
        reason = found["reason"].astype(str)
        used = [r for r in REASONS if (reason == r).any()] + sorted(set(reason) - set(REASONS)) or ["accepted"]
        for k, name in enumerate(used):
            here = reason == name
            axes[2].plot(
                t[here], np.full(here.sum(), -k), "|", ms=9, color=ESTIMATE if name == "accepted" else BAD
            )
        axes[2].set_yticks(
            [-k for k in range(len(used))], [f"{r} ({(reason == r).sum()})" for r in used], fontsize=9
        )
        axes[2].set_ylim(-len(used) + 0.4, 0.6)
        axes[2].set_xlabel("time of row I [s]")
        _shade(source, axes)
        _legend(axes[0])
        return to_svg(figure)
