"""Makes the pictures of docs/air.md: ``python docs/air_figures.py``."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerosim.report import plots
from aerosim.rng import generator
from aerosim.world.air import AIR_RATE_HZ
from aerosim.world.dryden import dryden_processes
from aerosim.world.local import LocalPlane
from aerosim.world.mesoscale import Mesoscale, MesoscaleWind
from aerosim.world.turbulence import Turbulence
from aerosim.world.von_karman import von_karman_processes

IMAGES = Path(__file__).parent / "images"
SIGMA, SPEED, SPAN, SECONDS = 0.7, 69.44, 19.81, 4800.0
LAT, LON = 0.82, 0.14
Array = NDArray[np.float64]


def gust_series() -> dict[str, dict[str, Array]]:
    """Gusts w and p of 80 minutes at 40 Hz, by spectrum and name."""
    made = {}
    for name, make, length in (("Dryden", dryden_processes, 533.4), ("von Karman", von_karman_processes, 762.0)):
        turbulence = Turbulence.equal("dryden", SIGMA, length)
        processes = make(turbulence, SPEED, SPAN, 1.0 / AIR_RATE_HZ, partial(generator, 1))
        steps = round(SECONDS * AIR_RATE_HZ)
        made[name] = {"w": processes[2].draw(steps)[:, 0], "p": processes[3].draw(steps)[:, 0]}
    return made


def formula(name: str, gust: str, hz: Array) -> Array:
    """Spectrum of MIL-F-8785C per Hz."""
    omega = 2.0 * math.pi * hz
    length = 533.4 if name == "Dryden" else 762.0
    if gust == "p":
        level = 0.8 * (math.pi * length / (4.0 * SPAN)) ** (1.0 / 3.0) * SIGMA**2 / (SPEED * length)
        rolling: Array = 2.0 * math.pi * level / (1.0 + (4.0 * SPAN * omega / (math.pi * SPEED)) ** 2)
        return rolling
    x2 = (length * omega / SPEED * (1.0 if name == "Dryden" else 1.339)) ** 2
    level = 2.0 * SIGMA**2 * length / SPEED
    rise, power = (3.0, 2.0) if name == "Dryden" else (8.0 / 3.0, 11.0 / 6.0)
    found: Array = level * (1.0 + rise * x2) / (1.0 + x2) ** power
    return found


def banded(y: Array) -> tuple[Array, Array]:
    """Spectrum of a series held from state to state, in 28 bands of equal ratio.  Hz, per Hz."""
    window = np.hanning(len(y))
    power = np.abs(np.fft.rfft(y * window)) ** 2 * 2.0 / (AIR_RATE_HZ * (window**2).sum())
    hz = np.fft.rfftfreq(len(y), 1.0 / AIR_RATE_HZ)
    power *= np.sinc(hz / AIR_RATE_HZ) ** 2
    edges = np.geomspace(3e-3, 10.0, 29)
    number = np.digitize(hz, edges)
    middle = np.sqrt(edges[:-1] * edges[1:])
    return middle, np.array([power[number == k].mean() for k in range(1, len(edges))])


def air_spectra(file: Path) -> None:
    """Spectra of w and p over 80 minutes against the standard's formulas."""
    series, hz = gust_series(), np.geomspace(3e-3, 10.0, 300)
    with plots.style() as figure_class:
        figure = figure_class(figsize=(9.0, 3.8), layout="constrained", dpi=120)
        for ax, gust, unit in zip(figure.subplots(1, 2), "wp", ("(m/s)²/Hz", "(rad/s)²/Hz"), strict=True):
            for name, colour in (("Dryden", plots.ESTIMATE), ("von Karman", plots.BAD)):
                middle, found = banded(series[name][gust])
                ax.loglog(hz, formula(name, gust, hz), color=colour, lw=1.0, label=f"{name}, MIL-F-8785C")
                ax.loglog(middle, found, ".", color=colour, label=f"{name}, made")
            ax.set(xlabel="frequency [Hz]", ylabel=f"{gust} [{unit}]")
        ax.legend()
        save(figure, file)


def structure(r: Array, fields: int = 300) -> tuple[Array, Array]:
    """Mean square differences of the mesoscale wind along and across a distance (m), over many fields."""
    plane = LocalPlane(LAT, LON, 3000.0)
    per_metre = plane.at(0.0, LAT + 1e-3, LON)[0] / 1e-3
    along, across = np.zeros(len(r)), np.zeros(len(r))
    for seed in range(fields):
        wind = MesoscaleWind(Mesoscale(), plane, np.random.default_rng(seed))
        here = wind.at(0.0, LAT, LON, 0.0)
        there = np.array([wind.at(0.0, LAT + each / per_metre, LON, 0.0) for each in r]) - here
        along += there[:, 0] ** 2 / fields
        across += there[:, 1] ** 2 / fields
    return along, across


def mesoscale(file: Path) -> None:
    """Wind along a line of 60 km, and structure functions against the two-thirds law."""
    plane = LocalPlane(LAT, LON, 3000.0)
    wind = MesoscaleWind(Mesoscale(), plane, np.random.default_rng(6))
    per_metre = plane.at(0.0, LAT + 1e-3, LON)[0] / 1e-3
    metres, r = np.arange(0.0, 60e3, 100.0), np.geomspace(300.0, 100e3, 25)
    speeds = np.array([wind.at(0.0, LAT + each / per_metre, LON, 0.0) for each in metres])
    along, across = structure(r)
    with plots.style() as figure_class:
        figure = figure_class(figsize=(9.0, 3.8), layout="constrained", dpi=120)
        left, right = figure.subplots(1, 2)
        for column, name, colour in ((0, "along the line", plots.ESTIMATE), (1, "across", plots.BAD)):
            left.plot(metres / 1e3, speeds[:, column], color=colour, label=name)
        left.set(xlabel="way [km]", ylabel="wind [m/s]")
        left.legend()
        law = Mesoscale().structure * r ** (2.0 / 3.0)
        right.loglog(r / 1e3, law, color=plots.TRUE, label="0.0036 r^(2/3)")
        right.loglog(r / 1e3, along + across, ".", color=plots.GOOD, label="both components")
        right.loglog(r / 1e3, across / along, "+", color=plots.GREY, label="across / along (5/3)")
        right.set(xlabel="distance [km]", ylabel="mean square difference [m²/s²]")
        right.legend()
        save(figure, file)


def save(figure: Any, file: Path) -> None:
    """Write a PNG of 64 colours."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from PIL import Image

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    file.parent.mkdir(exist_ok=True)
    Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3]).quantize(64).save(file, optimize=True)
    print(f"{file} {file.stat().st_size / 1000:.0f} kB")


def main() -> None:
    """Both pictures."""
    air_spectra(IMAGES / "air_spectra.png")
    mesoscale(IMAGES / "air_mesoscale.png")


if __name__ == "__main__":
    main()
