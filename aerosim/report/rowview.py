"""The two CCD rows as waterfalls that scroll with the time, and the MAD surfaces of accepted strips."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from aerosim.report.source import Source

TIMELINE = "sim_time"
SHOWN_S = 20.0
PX_PER_STEP = 1.2  # drawn width of one exposure
BACKGROUND = (13, 16, 17)
LABEL_RGB = (255, 255, 255)  # read on the label's box over a dark ground, in the viewer's dark and light theme
CHUNK = 2000  # exposures in one picture: what the smallest graphics cards take as one texture
GAP_PX = 12
SCROLL_PERIOD = 0.1
MU_PX = 9.0  # height of one shift in the picture of a MAD surface
NOT_LOOKED_AT = 60  # grey level of shifts and exposures outside of a strip's window
N_STEP = 2  # exposures that a pixel of the MAD picture stands for: every second one is drawn
# Viridis in seven steps
COLOURS = np.array(
    [[68, 1, 84], [70, 50, 127], [54, 92, 141], [39, 127, 142], [31, 161, 135], [74, 194, 109], [253, 231, 37]],
    float,
)


def fixed(rec: rr.RecordingStream, entity: str, *archetypes: Any) -> None:
    """Log what does not change with time, in order: columns do not wait for it in the stream's batches."""
    rec.log(entity, *archetypes, static=True)
    rec.flush()


def _table(path: Path) -> Any:
    """Arrow table, None if the run has no such file."""
    import pyarrow.parquet as pq

    return pq.read_table(path) if path.is_file() else None


def _rows(table: Any, name: str) -> NDArray[np.uint8]:
    """A column of equal lists as (n, pixels), brought to 8 bits."""
    column = table[name].combine_chunks()
    values = column.flatten().to_numpy(zero_copy_only=False).reshape(len(column), -1)
    if values.dtype == np.uint8:
        return np.asarray(values)
    top = max(float(values.max()), 1.0)
    return np.asarray(values * (255.0 / top)).astype(np.uint8)


def _pieces(t_s: NDArray[Any], period: float) -> list[slice]:
    """Exposures without a gap, in pieces that one texture holds."""
    breaks = np.flatnonzero(np.diff(t_s) > 1.5 * period) + 1
    edges = np.unique(np.concatenate([[0, len(t_s)], breaks, np.arange(0, len(t_s), CHUNK)]).astype(int))
    return [slice(int(a), int(b)) for a, b in pairwise(edges)]


def log_rows(rec: rr.RecordingStream, source: Source) -> float:
    """The rows over time: now at 0, the past to the left; one exposure a pixel.

    Returns the height of the drawing in px, 0 if the run has no rows.
    """
    table = _table(source.path / "rows.parquet")
    if table is None or table.num_rows == 0:
        return 0.0
    period = source.scenario.ccd_rows.period_s
    t = table["t_s"].to_numpy()
    rows = [_rows(table, "row1_grey"), _rows(table, "row2_grey")]
    wide, narrow = (r.shape[1] for r in rows)
    tops = (0, wide + GAP_PX + (wide - narrow) // 2)
    for number, piece in enumerate(_pieces(t, period)):
        for name, grey, top in zip(("row1", "row2"), rows, tops, strict=True):
            picture = np.ascontiguousarray(grey[piece].T)
            place = rr.Transform3D(
                translation=[PX_PER_STEP * float(t[piece.start]) / period, top, 0.0], scale=[PX_PER_STEP, 1.0, 1.0]
            )
            fixed(rec, f"rows/scroll/{name}_{number}", rr.Image(picture, "L"), place)
    times = np.arange(0.0, float(source.telemetry["t_s"][-1]) + SCROLL_PERIOD, SCROLL_PERIOD)
    shift = np.column_stack([-PX_PER_STEP * times / period, 0.0 * times, 0.0 * times])
    index = [rr.TimeColumn(TIMELINE, duration=times)]
    rec.send_columns("rows/scroll", index, rr.Transform3D.columns(translation=shift))
    height = float(tops[1] + narrow)
    _log_row_scale(rec, PX_PER_STEP / period, tops, height)
    _log_links(rec, source, PX_PER_STEP / period, ((0.0, wide), (tops[1], height)))
    return height


def _log_row_scale(rec: rr.RecordingStream, px_per_s: float, tops: tuple[int, int], height: float) -> None:
    """Marks each 5 s, the rows' names, and a cover over what lies ahead in time."""
    ago = np.arange(0.0, SHOWN_S + 0.1, 5.0)
    strips = [[(-a * px_per_s, height + 2.0), (-a * px_per_s, height + 8.0)] for a in ago]
    fixed(rec, "rows/scale", rr.LineStrips2D(strips, colors=(200, 200, 200), radii=rr.Radius.ui_points(0.8)))
    names = [f"-{a:.0f} s" if a else "now" for a in ago] + ["row I, ahead", "row II, behind"]
    at = np.column_stack([-ago * px_per_s, np.full(len(ago), height + 9.0)])
    at = np.concatenate([at, [[-(SHOWN_S - 2.0) * px_per_s, y - GAP_PX - 2.0] for y in tops]])
    _log_labels(rec, "rows/names", at, names)
    cover = rr.Image(np.full((1, 1, 3), BACKGROUND, np.uint8), draw_order=5.0)
    place = rr.Transform3D(translation=[1.0, -50.0, 0.0], scale=[1e5, height + 100.0, 1.0])
    fixed(rec, "rows/future", cover, place)


def _log_labels(rec: rr.RecordingStream, entity: str, at: NDArray[Any], labels: list[str]) -> None:
    """Words in a 2D view, below their points, which are too small to be seen."""
    small = rr.Radius.ui_points(0.3)
    points = rr.Points2D(at, labels=labels, show_labels=True, radii=small, colors=LABEL_RGB, draw_order=20.0)
    fixed(rec, entity, points)


def _log_links(rec: rr.RecordingStream, source: Source, px_per_s: float, spans: Any) -> None:
    """The last strip recognised: where row I was kept and where row II showed the same ground."""
    strips = source.matches
    if not source.count(strips):
        return
    good = strips["accepted"].astype(bool)
    if not good.any():
        return
    x1, x2 = (np.asarray(strips[k][good], float) * px_per_s for k in ("t_row1_s", "t_row2_s"))
    (a0, a1), (b0, b1) = spans
    drawn = [
        [[(u, a0), (u, a1)], [(v, b0), (v, b1)], [(u, a1), (v, b0)]]
        for u, v in zip(x1.tolist(), x2.tolist(), strict=True)
    ]
    flat = [strip for each in drawn for strip in each]
    index = [rr.TimeColumn(TIMELINE, duration=np.asarray(strips["t_decided_s"][good], float))]
    rec.send_columns("rows/scroll/strip", index, rr.LineStrips2D.columns(strips=flat).partition([3] * len(drawn)))
    style = rr.LineStrips2D.from_fields(colors=(255, 140, 0), radii=rr.Radius.ui_points(1.2), draw_order=10.0)
    fixed(rec, "rows/scroll/strip", style)


def rows_view(source: Source, height: float) -> rrb.Spatial2DView:
    """View of the rows over the last 20 s."""
    width = PX_PER_STEP * SHOWN_S / source.scenario.ccd_rows.period_s
    bounds = rrb.VisualBounds2D(x_range=(-width, 14.0), y_range=(-22.0, height + 34.0))
    return rrb.Spatial2DView(
        origin="/rows", name="CCD rows, last strip recognised", visual_bounds=bounds, background=BACKGROUND
    )


def log_surfaces(rec: rr.RecordingStream, source: Source) -> tuple[float, float, int]:
    """MAD over n (across) and mu (up) of each accepted strip, at the time of its decision.

    Returns the range of n and the number of shifts of all together; shifts 0 if there is no surface.
    """
    table, strips = _table(source.path / "mad.parquet"), source.matches
    if table is None or table.num_rows == 0 or not source.count(strips):
        return 0.0, 0.0, 0
    good = strips["accepted"].astype(bool)
    row_of = {int(s): k for k, s in enumerate(strips["strip"]) if good[k]}
    numbers = table["strip"].to_numpy()
    kept = [k for k, s in enumerate(numbers) if int(s) in row_of]
    if not kept:
        return 0.0, 0.0, 0
    first, steps = table["first_n"].to_numpy()[kept], table["steps"].to_numpy()[kept]
    low, high = int(first.min()), int((first + steps).max())
    shifts, right = table["shifts"].to_numpy()[kept], table["first_mu_px"].to_numpy()[kept]
    least, most = int(right.min()), int((right + shifts).max()) - 1
    order = np.array([row_of[int(numbers[k])] for k in kept])
    surfaces = [
        table["mad_grey"][k].values.to_numpy(zero_copy_only=False).reshape(-1, count)[::N_STEP]
        for k, count in zip(kept, shifts, strict=True)
    ]
    formed = np.concatenate([s[::4].ravel() for s in surfaces])
    top = float(np.percentile(formed[np.isfinite(formed)], 90.0))
    size = (most - least + 1, (high - low) // N_STEP + 1)
    corners = zip((most - (right + shifts - 1)).tolist(), ((first - low) // N_STEP).tolist(), strict=True)
    pictures = [_picture(s, corner, size, top) for s, corner in zip(surfaces, corners, strict=True)]
    form = rr.components.ImageFormat(width=size[1], height=size[0], color_model="RGB", channel_datatype="U8")
    index = [rr.TimeColumn(TIMELINE, duration=np.asarray(strips["t_decided_s"][order], float))]
    rec.send_columns("mad/surface", index, rr.Image.columns(buffer=pictures, format=[form] * len(pictures)))
    fixed(
        rec, "mad/surface", rr.Transform3D(translation=[low - N_STEP / 2.0, 0.0, 0.0], scale=[N_STEP, MU_PX, 1.0])
    )
    _log_minima(rec, source, order, most, index)
    _log_mad_scale(rec, low, high, least, most)
    return float(low), float(high), size[0]


def _picture(
    surface: NDArray[Any], corner: tuple[int, int], size: tuple[int, int], top: float
) -> NDArray[np.uint8]:
    """One surface in colours, dark at its minimum, bright from top (grey levels); not looked at is grey.

    surface: (steps, shifts).  corner: row and column of its upper left corner, its largest shift and first step;
    size: of the picture, rows and columns.
    """
    out = np.full((*size, 3), NOT_LOOKED_AT, np.uint8)
    least = float(surface.min())
    x = np.clip((surface - least) / max(top - least, 1.0), 0.0, 1.0) * (len(COLOURS) - 1)
    colour = np.stack([np.interp(x, np.arange(len(COLOURS)), COLOURS[:, k]) for k in range(3)], axis=-1)
    colour[~np.isfinite(surface)] = NOT_LOOKED_AT
    # mu > 0 (track to the right) upwards
    (row, column), (steps, shifts) = corner, surface.shape
    upright = np.flip(colour.transpose(1, 0, 2), axis=0).astype(np.uint8)
    out[row : row + shifts, column : column + steps] = upright
    return out.ravel()


def _log_minima(rec: rr.RecordingStream, source: Source, order: NDArray[Any], most: int, index: Any) -> None:
    """Where the minimum lies.  most: shift in the picture's first row, px."""
    n, mu, least = (np.asarray(source.matches[k][order], float) for k in ("n", "mu_px", "mad_min_grey"))
    at = np.column_stack([n, (most + 0.5 - mu) * MU_PX])
    labels = [f"n {a:.1f}, mu {b:+.2f} px, MAD {c:.1f}" for a, b, c in zip(n, mu, least, strict=True)]
    rec.send_columns("mad/minimum", index, rr.Points2D.columns(positions=at, labels=labels))
    style = rr.Points2D.from_fields(
        colors=LABEL_RGB, radii=rr.Radius.ui_points(4.0), show_labels=True, draw_order=10.0
    )
    fixed(rec, "mad/minimum", style)


def _log_mad_scale(rec: rr.RecordingStream, low: int, high: int, least: int, most: int) -> None:
    """Numbers along n, and of mu at the left: its ends and, if it lies between them, 0."""
    step = 50 if high - low > 150 else 20
    n = np.arange(-(-low // step) * step, high + 1, step)
    mu = np.unique([least, most, min(max(0, least), most)])
    at = np.concatenate([
        np.column_stack([n, np.full(len(n), (most - least + 1) * MU_PX + 1.0)]),
        np.column_stack([np.full(len(mu), low - 14.0), (most + 0.5 - mu) * MU_PX - 6.0]),
    ])  # fmt: skip
    _log_labels(rec, "mad/scale", at, [f"n {k}" for k in n] + [f"mu {k:+d}" if k else "mu 0" for k in mu])


def mad_view(low: float, high: float, shifts: int) -> rrb.Spatial2DView:
    """View of the last accepted surface."""
    bounds = rrb.VisualBounds2D(x_range=(low - 32.0, high + 6.0), y_range=(-12.0, shifts * MU_PX + 26.0))
    return rrb.Spatial2DView(
        origin="/mad",
        name="MAD of the last accepted strip (grey: not looked at)",
        visual_bounds=bounds,
        background=BACKGROUND,
    )
