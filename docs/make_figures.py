"""Makes the pictures of the docs: ``python docs/make_figures.py [RUN]``; without a run it flies `crosswind`."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import aerosim
from aerosim.estimation.mad import mad
from aerosim.forecast.check import outlook
from aerosim.raster import sample
from aerosim.report import chart, plan_map, plots, track_map
from aerosim.report.source import open_source
from aerosim.world.terrain import Terrain, find_terrain

IMAGES = Path(__file__).parent / "images"
PIXEL_M = 22.6  # of a row on the ground, from 3000 m
PIXELS, MAX_SHIFT = 96, 7
SHIFT, MEETING = 3, 4  # Fig. 3 of the 1988 paper: shift 3, found at the fourth correlation
COLOURS = ("#56B4E9", "#009E73", "#E69F00", "#D55E00", "#CC79A7")


def fig3_rows() -> tuple[NDArray[np.float32], list[NDArray[np.float32]]]:
    """Row I and five exposures of row II over the shipped orthophoto, flown east, a pixel of way between two.

    The fourth exposure looks at the ground of row I, three pixels to the right of it.  Noise 1.5 grey levels,
    8 bits.  Returns (110,) and five of (96,), grey levels.
    """
    terrain = Terrain.open(*find_terrain("pine_mountain"), "file")
    e_min, n_min, e_max, n_max = terrain.bounds
    east, north = (e_min + e_max) / 2.0, (n_min + n_max) / 2.0
    half = (PIXELS / 2 + MAX_SHIFT + SHIFT) * PIXEL_M
    window = terrain.orthophoto(PIXEL_M).covering(east - 1000.0, north - half, east + 1000.0, north + half)
    rng = np.random.default_rng(1988)

    def row(along_px: int, right_px: int, pixels: int) -> NDArray[np.float32]:
        across = np.arange(pixels) - (pixels - 1) / 2.0 + right_px
        grey = sample(window, east + along_px * PIXEL_M, north - across * PIXEL_M)
        return np.clip(np.round(grey + rng.normal(0.0, 1.5, pixels)), 0, 255).astype(np.float32)

    row1 = row(0, 0, PIXELS + 2 * MAX_SHIFT)
    return row1, [row(k - MEETING, SHIFT, PIXELS) for k in range(1, 6)]


def fig3(file: Path) -> None:
    """MAD over the shift for the five exposures, by the matcher that flies."""
    row1, rows2 = fig3_rows()
    curves = np.array([mad(row1, row2) for row2 in rows2])
    step, k = np.unravel_index(int(curves.argmin()), curves.shape)
    if (int(step) + 1, int(k) - MAX_SHIFT) != (MEETING, SHIFT):
        raise SystemExit(f"the least MAD lies at correlation {step + 1}, shift {k - MAX_SHIFT}")
    shifts = np.arange(-MAX_SHIFT, MAX_SHIFT + 1)
    with plots.style() as figure_class:
        figure = figure_class(figsize=(7.2, 4.4), layout="constrained", dpi=130)
        ax = figure.subplots()
        for number, (curve, colour) in enumerate(zip(curves, COLOURS, strict=True), start=1):
            wide = 2.6 if number == MEETING else 1.3
            ax.plot(shifts, curve, marker=".", color=colour, lw=wide, label=f"n = {number}")
        note = f"n = {MEETING}, shift {SHIFT} px:\n{curves.min():.1f} grey levels"
        arrow = {"arrowstyle": "->"}
        ax.annotate(note, (SHIFT, curves.min()), xytext=(-3.0, 3.5), arrowprops=arrow, va="center")
        ax.legend(title="exposure of row II", ncols=2, loc="upper right")
        ax.set(
            xlabel="shift of the rows [px]", ylabel="MAD [grey levels a pixel]", xlim=(-7.4, 7.4), ylim=(0, None)
        )
        ax.set_xticks(shifts)
        save(figure, file)


def run_picture(run: Path, file: Path) -> None:
    """Map of a run above its drift and crab."""
    source = open_source(run)
    with plots.style() as figure_class:
        figure = figure_class(figsize=(10.0, 7.1), layout="constrained", dpi=120)
        above, drift, crab = figure.subplots(3, 1, height_ratios=(3.1, 1.2, 1.2))
        drift.sharex(crab)
        drift.tick_params(labelbottom=False)
        plots.draw_motion((drift, crab), source)
        for ax in (drift, crab):
            ax.margins(x=0.01)
        crab.set_xlabel("time [s]")
        chart.draw(above, source)
        save(figure, file)


def plan_picture(file: Path) -> None:
    """Map of the plan of `block_area`."""
    with plots.style():
        save(plan_map.figure_of(outlook(aerosim.load_scenario("block_area"))), file)


def track_picture(file: Path) -> None:
    """Trackability of `crosswind`."""
    with plots.style():
        save(track_map.track_figure(outlook(aerosim.load_scenario("crosswind"))), file)


def save(figure: Any, file: Path) -> None:
    """Write a PNG of 256 colours, the rare ones among them: a photo in it stays small."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    picture = Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3])
    file.parent.mkdir(exist_ok=True)
    picture.quantize(256, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(file, optimize=True)
    print(f"{file} {file.stat().st_size / 1000:.0f} kB")


def main() -> None:
    """All pictures."""
    fig3(IMAGES / "fig3_mad.png")
    plan_picture(IMAGES / "plan.png")
    track_picture(IMAGES / "trackability.png")
    if len(sys.argv) > 1:
        run_picture(Path(sys.argv[1]), IMAGES / "crosswind_run.png")
        return
    with tempfile.TemporaryDirectory() as folder:
        run = aerosim.run(aerosim.load_scenario("crosswind"), Path(folder) / "crosswind")
        run_picture(run.path, IMAGES / "crosswind_run.png")


if __name__ == "__main__":
    main()
