"""From a sweep's table to its report: which keys and figures are shown, and their numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aerosim.errors import InputError
from aerosim.sweep.book import alike
from aerosim.sweep.matrix import identity
from aerosim.sweep.stats import LEVEL, Effect, effects, means, paired
from aerosim.sweep.table import metrics_of, parameters_of, read_table

if TYPE_CHECKING:
    import pyarrow as pa

    from aerosim.report.sweep_view import Axes, MetricView, Pair, SweepView
    from aerosim.sweep.spec import SweepSpec

FOCUS = (
    "crab.residual_rms_deg", "vh.error_rms_pct", "photos.end_lap_error_rms_pct", "photos.out_of_tolerance",
)  # fmt: skip
NOT_TOLD = ("speed.", "flight.lines")
CURVES_MOST = 7
PANELS_MOST = 4
PAIRS_MOST = 7


def write_report(out: Path, spec: SweepSpec | None = None, status: str = "") -> Path:
    """Write report.html of a sweep directory from its runs.parquet and sweep.yaml.  Returns its path.

    spec: of sweep.yaml, if it was read already.  status: a sentence about how the sweep ended.
    Raises InputError for a directory that is no sweep, OSError where it cannot be written.
    """
    from aerosim.report.sweep_page import write_sweep_page
    from aerosim.sweep.specfile import load_sweep

    file = out / "sweep.yaml"
    if not file.is_file():
        raise InputError(f"{out} is no sweep: it has no sweep.yaml", where=str(out))
    spec = load_sweep(file) if spec is None else spec
    view = view_of(read_table(out / "runs.parquet"), spec, file.read_text(encoding="utf-8"), status)
    return write_sweep_page(view, out / "report.html")


def view_of(table: pa.Table, spec: SweepSpec, text: str, status: str = "") -> SweepView:
    """All numbers of the report.  text: of sweep.yaml.  Raises InputError for a table without rows."""
    from aerosim.report.sweep_view import SweepView

    keys = parameters_of(table)
    varied = varied_of(table)
    grid = spec.is_grid
    axes = axes_of(varied)
    compared = axes.curve or axes.x
    here = set(metrics_of(table))
    first = [spec.stop_when.metric] if spec.stop_when else []
    focus = [name for name in dict.fromkeys([*first, *FOCUS]) if name in here]
    seeds = len(set(table["seed"].to_pylist()))
    failed = [row for row in table.select(["status", "reason", *keys]).to_pylist() if row["status"] != "done"]
    return SweepView(
        name=spec.scenario.name,
        purpose=spec.scenario.purpose,
        status=status,
        varied=varied,
        grid=grid,
        points=len(spec.points),
        seeds=seeds,
        runs=table.num_rows,
        planned=spec.size,
        failed=len(failed),
        reasons=_reasons(failed, keys),
        wall_s=float(sum(table["wall_s"].to_pylist())),
        level=LEVEL,
        axes=axes,
        compared=compared,
        metrics=[_metric(table, name, varied, axes, compared, grid) for name in focus],
        text=text,
        others=[
            _plain(table, name, keys) for name in metrics_of(table)
            if name not in focus and not name.startswith(NOT_TOLD)
        ],
    )  # fmt: skip


def varied_of(table: pa.Table) -> dict[str, list[Any]]:
    """Values of each varied key, in the order of the points."""
    return {key: list({identity(v): v for v in table[key].to_pylist()}.values()) for key in parameters_of(table)}


def axes_of(varied: Mapping[str, Sequence[Any]]) -> Axes:
    """Which keys a plot shows: numbers along x, words as curves, what is left as panels or averaged over."""
    from aerosim.report.sweep_view import Axes, is_number

    several = [key for key, values in varied.items() if len(values) > 1] or list(varied)[:1]
    numeric = [key for key in several if all(is_number(value) for value in varied[key])]
    x = max(numeric, key=lambda key: len(varied[key]), default=several[0] if several else "")
    left = [key for key in several if key != x]
    words = [key for key in left if key not in numeric]
    curves = [key for key in [*words, *left] if len(varied[key]) <= CURVES_MOST]
    curve = curves[0] if curves else ""
    left = [key for key in left if key != curve]
    panel = next((key for key in left if len(varied[key]) <= PANELS_MOST), "")
    return Axes(x, curve, panel, tuple(key for key in left if key != panel))


def _metric(
    table: pa.Table, name: str, varied: Mapping[str, Sequence[Any]], axes: Axes, compared: str, grid: bool
) -> MetricView:
    """Everything about a metric that has a section of its own."""
    from aerosim.report.sweep_view import MetricView, figure_of

    keys = list(varied)
    shown = [key for key in (axes.x, axes.curve, axes.panel) if key]
    found, notes = _effects(table, name, varied)
    pairs = _pairs(table, name, varied, compared, shown) if grid and compared else []
    at = means(table, name, keys)
    drawn = at if not axes.rest else means(table, name, shown)
    return MetricView(figure_of(name), at, drawn, pairs, found, notes)


def _effects(table: pa.Table, name: str, varied: Mapping[str, Sequence[Any]]) -> tuple[list[Effect], list[str]]:
    """Main effects, and what has to be said of them."""
    import pyarrow.compute as pc

    from aerosim.report.sweep_view import told, word

    notes, rows = [], table
    for key in varied:
        # a camera that estimates nothing has no error of an estimate: its mode is left out, and that is said
        known = rows.filter(pc.is_valid(rows[name]))
        empty = [value for value in rows[key].unique().to_pylist() if value not in known[key].unique().to_pylist()]
        if known.num_rows and empty:
            rows = rows.filter(pc.is_in(rows[key], known[key].unique()))
            notes.append(
                f"Main effects without {word(key)} {', '.join(told(key, v) for v in empty)}: no value there."
            )
    try:
        found = effects(rows, name, list(varied))
    except InputError as error:
        return [], [*notes, f"Main effects: {error.problem}."]
    if found and not found[0].seeds:
        notes = ["Main effects are not known: no seed has a value at all points."]
    return found, notes


def _plain(table: pa.Table, name: str, keys: Sequence[str]) -> MetricView:
    from aerosim.report.sweep_view import MetricView, figure_of

    at = means(table, name, keys)
    return MetricView(figure_of(name), at, at)


def _pairs(
    table: pa.Table, name: str, varied: Mapping[str, Sequence[Any]], compared: str, shown: Sequence[str]
) -> list[Pair]:
    """Differences of each value of the compared key less the one before it."""
    from aerosim.report.sweep_view import Pair

    keys = list(varied)
    by = [key for key in shown if key != compared]
    out = []
    for before, value in list(pairwise(varied[compared]))[:PAIRS_MOST]:
        try:
            each = paired(table, name, compared, value, before, keys, by)
            (overall,) = paired(table, name, compared, value, before, keys, [])
        except InputError:  # an unfinished sweep need not have both at any point
            continue
        out.append(Pair(value, before, each, overall))
    return out


def _reasons(failed: Sequence[Mapping[str, Any]], keys: Sequence[str]) -> list[tuple[str, int, str]]:
    """Failed runs by reason, most frequent first, with the values at which they failed."""
    from aerosim.report.sweep_view import told, word

    out = []
    for reason, places in alike([str(row["reason"]) for row in failed]):
        where = []
        for key in keys:
            values = list(dict.fromkeys(told(key, failed[place][key]) for place in places))
            more = f" and {len(values) - 6} more" if len(values) > 6 else ""
            where.append(f"{word(key)} {', '.join(values[:6])}{more}")
        out.append((reason, len(places), "; ".join(where)))
    return out
