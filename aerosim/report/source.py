"""What is drawn: the tables of a run as columns, its summary, scenario and land."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from aerosim.errors import InputError, RunFailure
from aerosim.frames import Array, MapGrid

if TYPE_CHECKING:
    from aerosim.scenario import Scenario
    from aerosim.world.terrain import Terrain

Columns = dict[str, NDArray[Any]]

CORNERS = ("front_left", "front_right", "rear_right", "rear_left")


@dataclass(frozen=True)
class Source:
    """One run as it was recorded.  Tables are columns by name, empty if the run has no such file.

    missing: sentences about what a drawing cannot show.
    """

    path: Path
    scenario: Scenario
    summary: Mapping[str, Any]
    manifest: Mapping[str, Any]
    telemetry: Columns
    matches: Columns
    photos: Columns
    lines: Columns
    missing: list[str] = field(default_factory=list)

    @cached_property
    def terrain(self) -> Terrain | None:
        """The land, None if its files cannot be opened (any more): a drawing does without, and says so."""
        from aerosim.scenario.build import terrain_of

        try:
            return terrain_of(self.scenario)
        except (InputError, RunFailure) as error:
            self.missing.append(f"The land is not shown: {error}.")
            return None

    @cached_property
    def grid(self) -> MapGrid:
        """Map grid of the drawings: the terrain's, or the UTM zone of the first line."""
        if self.terrain is not None:
            return self.terrain.grid
        if not self.count(self.lines):
            raise InputError("cannot be drawn without its lines", where=str(self.path / "lines.parquet"))
        lat, lon = float(self.lines["start_lat_deg"][0]), float(self.lines["start_lon_deg"][0])
        return MapGrid(f"EPSG:{(32600 if lat >= 0 else 32700) + int((lon + 180.0) // 6.0) % 60 + 1}")

    def count(self, table: Columns) -> int:
        """Rows of a table."""
        return len(next(iter(table.values()))) if table else 0

    def on_map(self, lat_deg: NDArray[Any], lon_deg: NDArray[Any]) -> Array:
        """Easting and northing (m) of points (deg).  (n,), (n,) to (n, 2)."""
        if len(lat_deg) == 0:
            return np.empty((0, 2))
        return np.column_stack(self.grid.from_geodetic(np.radians(lat_deg), np.radians(lon_deg)))

    @cached_property
    def path_g(self) -> Array:
        """Flown path: easting, northing, ellipsoidal height, m.  (n, 3)."""
        tel = self.telemetry
        if not self.count(tel):
            return np.empty((0, 3))
        return np.column_stack([self.on_map(tel["lat_deg"], tel["lon_deg"]), tel["height_m"]])

    @cached_property
    def lines_g(self) -> Array:
        """Planned lines: start and end, easting and northing, m.  (lines, 2, 2)."""
        if not self.count(self.lines):
            return np.empty((0, 2, 2))
        ends = [
            self.on_map(self.lines[f"{end}_lat_deg"], self.lines[f"{end}_lon_deg"]) for end in ("start", "end")
        ]
        return np.stack(ends, axis=1)

    @cached_property
    def line_names(self) -> list[str]:
        """Names of the planned lines."""
        return [str(name) for name in self.lines.get("name", range(self.count(self.lines)))]

    @cached_property
    def footprints_g(self) -> Array:
        """Footprint corners of the photos, front left and on to the right: easting, northing, m.  (photos, 4, 2).

        A corner that meets no ground is NaN.
        """
        names = [(f"corner_{c}_lat_deg", f"corner_{c}_lon_deg") for c in CORNERS]
        if not self.count(self.photos):
            return np.empty((0, 4, 2))
        corners = [self.on_map(self.photos[lat], self.photos[lon]) for lat, lon in names]
        found = np.stack(corners, axis=1)
        return np.where(np.isfinite(found), found, np.nan)

    @cached_property
    def whole_footprints(self) -> NDArray[np.bool_]:
        """Which photos have all four corners on the ground.  (photos,)."""
        return np.asarray(np.isfinite(self.footprints_g).all(axis=(1, 2)))

    def spans(self, want_turns: bool) -> list[tuple[float, float]]:
        """Times (s) between which the aircraft is in a turn, or on a line."""
        tel = self.telemetry
        if not self.count(tel):
            return []
        line = tel["line"]
        edges = np.flatnonzero(np.diff(line)) + 1
        starts, ends = np.r_[0, edges], np.r_[edges, len(line) - 1]
        return [
            (float(tel["t_s"][a]), float(tel["t_s"][b]))
            for a, b in zip(starts, ends, strict=True)
            if (line[a] < 0) == want_turns
        ]


def middle(values: NDArray[Any], otherwise: float = 0.0) -> float:
    """Median of the known values, or something else if there is none."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else otherwise


def _columns(path: Path, missing: list[str]) -> Columns:
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        table = pq.read_table(path)
    except (OSError, pa.ArrowInvalid) as error:
        missing.append(f"{path.name} cannot be read ({type(error).__name__}).")
        return {}
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}


def _json(path: Path) -> dict[str, Any]:
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found


def open_source(run_dir: Path) -> Source:
    """Read a run.  Raises InputError: no such directory, or no scenario in it."""
    from aerosim.scenario import load

    if not (run_dir / "scenario.yaml").is_file():
        raise InputError("is no run directory: it has no scenario.yaml", where=str(run_dir))
    missing: list[str] = []
    telemetry, matches, photos, lines = (
        _columns(run_dir / f"{name}.parquet", missing) for name in ("telemetry", "matches", "photos", "lines")
    )
    return Source(
        run_dir,
        load(run_dir / "scenario.yaml"),
        _json(run_dir / "summary.json"),
        _json(run_dir / "manifest.json"),
        telemetry,
        matches,
        photos,
        lines,
        missing,
    )
