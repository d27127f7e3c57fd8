"""Trackability of a plan: what the two rows will make of the land under each line, station by station."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.flight.plan import FlightPlan
from aerosim.forecast.land import Land
from aerosim.forecast.strip_forecast import Eye, Prospect, prospect
from aerosim.frames import Array
from aerosim.raster import WindowedRaster
from aerosim.scenario.scenario import Scenario
from aerosim.world.terrain import Terrain

STATION_M = 250.0
MOST_STATIONS = 800  # of a plan; then they lie further apart
PIECE_M = 8000.0  # of a line, whose land is read at once
BLIND = 0.2  # share of accepted strips below which the controller holds what it knew
REFERENCE_S = 0.01  # exposure whose motion blur is forecast


class Stations(NamedTuple):
    """Strips forecast along the lines, at equal distances.

    place: (n, 2) easting, northing of a strip's middle, m; ahead: (n, 2) unit vector of the flight on the grid;
    line: (n,), index; length, width: (n,), m of the land that it stands for; strips: (n, 6), a column for each
    field of `Prospect`, NaN where there is no land.
    """

    place: Array
    ahead: Array
    line: NDArray[np.int64]
    length: Array
    width: Array
    strips: Array

    def of(self, field: str) -> Array:
        """One field of `Prospect` at all stations, (n,)."""
        return np.asarray(self.strips[:, Prospect._fields.index(field)])


def eye_of(scenario: Scenario) -> Eye:
    """Rows and recogniser of a scenario."""
    rows, est = scenario.ccd_rows, scenario.estimation
    return Eye(
        pixels=rows.pixels_px,
        max_shift=rows.max_shift_px,
        spacing_px=rows.spacing_px,
        focal_px=rows.focal_px,
        smear_along_px=rows.smear_along_px,
        smear_across_px=rows.smear_across_px,
        noise_grey=rows.noise_grey,
        full_grey=2.0**rows.bits - 1.0,
        exposure=None if rows.exposure_s == "auto" else rows.exposure_s,
        search=est.search_n,
        mean_subtracted=est.mean_subtracted,
        subpixel=est.subpixel,
    )


def stations(scenario: Scenario, plan: FlightPlan, land: Land, terrain: Terrain, ground: float) -> Stations:
    """Forecast of the strips along all lines, for a camera that points into the track.  ground: mean height, m."""
    eye = eye_of(scenario)
    total = sum(track.length for track in land.tracks)
    spacing = max(STATION_M, total / MOST_STATIONS)
    pixel = (plan.height - ground) / eye.focal_px
    # valleys are further down than the mean, and their rows wider
    reach = 1.3 * pixel * math.hypot(eye.pixels / 2.0 + eye.max_shift, eye.spacing_px * eye.search[1]) + 200.0
    rasters = _orthophoto(terrain, pixel / 2.0, PIECE_M + 2.0 * reach), terrain.elevation(pixel / 2.0)
    parts = []
    for index, track in enumerate(land.tracks):
        count = max(round(track.length / spacing), 1)
        way = (np.arange(count) + 0.5) / count * track.length
        middle = track.start + way[:, None] * track.ahead
        place = _placed(land, terrain, middle)
        ahead = _placed(land, terrain, middle + 10.0 * track.ahead) - place
        ahead /= np.hypot(*ahead.T)[:, None]
        length = np.full(count, track.length / count)
        motion = plan.airspeed * REFERENCE_S
        strips = _strips(eye, rasters, place, ahead, plan.height, reach, motion)
        width = np.full(count, eye.pixels * pixel)
        parts.append(Stations(place, ahead, np.full(count, index, np.int64), length, width, strips))
    return Stations(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _placed(land: Land, terrain: Terrain, places: Array) -> Array:
    """Easting and northing of places on the plane, (n, 2), m."""
    lat, lon = np.moveaxis(land.plane.to_geodetic(places), -1, 0)
    return np.stack(terrain.grid.from_geodetic(lat, lon), axis=-1)


def _orthophoto(terrain: Terrain, resolution: float, side: float) -> WindowedRaster:
    """The orthophoto in windows that are read as large as asked for, up to so many m a side."""
    cell = terrain.orthophoto_file.cell_size(terrain.grid.crs, resolution)
    weights = terrain.orthophoto_weights()
    size = math.ceil(side / cell / 2.0) + 1
    return WindowedRaster(terrain.orthophoto_file, terrain.grid.crs, resolution, weights=weights, size=size)


def _strips(
    eye: Eye,
    rasters: tuple[WindowedRaster, WindowedRaster],
    place: Array,
    ahead: Array,
    height: float,
    reach: float,
    motion: float,
) -> Array:
    """Forecasts at the stations of one line, (n, 6); the land is read piece by piece."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(place, axis=0).T))])
    found = np.empty((len(place), len(Prospect._fields)))
    for number in np.unique(along // PIECE_M):
        here = np.flatnonzero(along // PIECE_M == number)
        area = (*(place[here].min(axis=0) - reach), *(place[here].max(axis=0) + reach))
        ortho, relief = (raster.covering(*area) for raster in rasters)
        for k in here.tolist():
            found[k] = prospect(eye, ortho, relief, place[k], ahead[k], height, motion)
    return found


def line_strips(found: Stations, index: int) -> dict[str, Any]:
    """Figures of one line: share of strips accepted, error of one strip, longest stretch without strips; None
    if there is no land to be seen."""
    here = found.line == index
    accepted = found.of("accepted")[here]
    known = np.isfinite(accepted)
    if not known.any():
        return dict.fromkeys(("strips_accepted_pct", "strip_sd_deg", "strip_vh_sd_pct", "strips_blind_m"))
    return {
        "strips_accepted_pct": 100.0 * float(accepted[known].mean()),
        "strip_sd_deg": math.degrees(float(np.median(found.of("sd_angle")[here][known]))),
        "strip_vh_sd_pct": 100.0 * float(np.median(found.of("sd_vh")[here][known])),
        "strips_blind_m": _longest(accepted < BLIND, found.length[here]),
    }


def _longest(blind: NDArray[np.bool_], length: Array) -> float:
    """Longest run of blind stations, m."""
    longest, run = 0.0, 0.0
    for each, way in zip(blind, length, strict=True):
        run = run + float(way) if each else 0.0
        longest = max(longest, run)
    return longest
