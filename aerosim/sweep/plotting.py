"""A metric of a sweep over what was varied, as a figure for a notebook."""

from __future__ import annotations

import io
from functools import partial
from typing import TYPE_CHECKING, Any

from aerosim.errors import InputError
from aerosim.sweep.matrix import known
from aerosim.sweep.reporting import axes_of, varied_of
from aerosim.sweep.stats import LEVEL, means

if TYPE_CHECKING:
    import pyarrow as pa


def plot(
    table: pa.Table,
    metric: str,
    *,
    x: str | None = None,
    curve: str | None = None,
    panel: str | None = None,
    level: float = LEVEL,
) -> Any:
    """Means of a metric with confidence bands: matplotlib figure of one row of panels, shown by a notebook.

    x: key along the axis; curve: one curve for each of its values; panel: one panel for each; chosen by kind where
    they are None, "" for none.  Over the other keys the metric is averaged for each seed.
    Raises InputError for an unknown name, or a key that is given twice.
    """
    from aerosim.report.sweep_plots import draw_over_parameter
    from aerosim.report.sweep_view import Axes, MetricView, figure_of

    varied = varied_of(table)
    given = [key for key in (x, curve, panel) if key]
    for key in given:
        known(table, key, "key")
    if len(set(given)) < len(given):
        raise InputError("a key is given twice", key=given[-1], allowed="another key for x, curve and panel")
    auto = axes_of({key: values for key, values in varied.items() if key not in given})
    found = iter(key for key in (auto.x, auto.curve, auto.panel) if key)
    chosen = [next(found, "") if key is None else key for key in (x, curve, panel)]
    shown = [key for key in chosen if key]
    rest = tuple(key for key in varied if key not in shown)
    at = means(table, metric, shown, level)
    axes = Axes(chosen[0], chosen[1], chosen[2], rest)
    figure = draw_over_parameter(MetricView(figure_of(metric), at, at), varied, axes)
    # a notebook draws figures of its own only after `%matplotlib inline`; with this it shows this one anyhow
    figure._repr_png_ = partial(_png, figure)
    return figure


def _png(figure: Any) -> bytes:
    out = io.BytesIO()
    figure.savefig(out, format="png")
    return out.getvalue()
