"""A gorge in the Eastern Cape, photographed in 2015: land that nobody here made, flown closed loop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flights import on_line, rms

from aerosim.cli.app import call
from aerosim.errors import InputError
from aerosim.record import Record
from aerosim.scenario import Scenario, from_mapping, to_yaml
from aerosim.scenario.build import terrain_of
from aerosim.simulate import simulate

# data that is handed out beside the project, and is not part of it
DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "real_terrain"
pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data/real_terrain is not there")

UNDULATION = 28.26  # m, EGM96 there, measured with its grid by those who hand the data out
SOUTH, NORTH = -33.7270, -33.6530  # 8.2 km; the rasters hold 10.4 x 6.2 km
MEASURED_FROM = 40.0  # s; the run-in lies outside of the rasters, so the camera turns on the line


def real(datum: Any = None, outside: str = "fail", lon: tuple[float, float] = (24.380, 24.384)) -> Scenario:
    """Two lines north and south with an east wind across, over the western half, where the swath is all inside."""
    files = {"orthophoto": str(DATA / "orthophoto_5m.tif"), "elevation": str(DATA / "elevation_24m_egm2008.tif")}
    return from_mapping({
        "name": "real",
        "terrain": {"source": files, "vertical_datum": datum or {"undulation_m": UNDULATION}, "outside": outside},
        "air": {
            "wind": {"speed_m_s": 10, "from_deg": 90},
            "slow_wind": {"sigma_m_s": 0.5},
            "turbulence": {"sigma_m_s": 0.35},
        },
        "flight": {
            "run_in_s": 20,
            "lines": [
                {"start_deg": [SOUTH, lon[0]], "end_deg": [NORTH, lon[0]]},
                {"start_deg": [NORTH, lon[1]], "end_deg": [SOUTH, lon[1]]},
            ],
        },
        "record": {"exclude_first_s": MEASURED_FROM, "rrd": False, "report": False},
    })  # fmt: skip


@pytest.fixture(scope="module")
def flown() -> Record:
    return simulate(real())


def test_it_flies_and_stays_over_the_land(flown: Record) -> None:
    assert flown.status == "done", flown.reason
    assert flown.summary["flight"]["lines"] == 2
    on_lines = flown.telemetry["line"] >= 0
    assert on_lines.sum() * 0.05 == pytest.approx(2 * 8208.0 / 68.7, rel=0.03)  # wind triangle's ground speed
    assert np.isfinite(flown.telemetry["vh_true_per_s"][on_lines]).all()


def test_it_locks(flown: Record) -> None:
    crab = flown.summary["crab"]
    assert crab["strips"] > 100
    assert crab["accepted_pct"] >= 80.0


def test_the_camera_is_turned_into_the_track(flown: Record) -> None:
    summary = flown.summary
    drift = summary["flight"]["drift_mean_deg"]
    assert drift == pytest.approx(np.degrees(np.arcsin(10.0 / 69.44)), abs=1.0)
    assert summary["crab"]["residual_rms_deg"] < drift / 4.0
    # east is right of the line north: wind from the right drifts to the left, and back the other way
    for line, sign in ((0, -1.0), (1, 1.0)):
        assert sign * on_line(flown, "drift_true_deg", line).mean() > 7.0
        assert rms(on_line(flown, "crab_true_deg", line, after=MEASURED_FROM)) < drift / 4.0


def test_strips_say_what_was_flown(flown: Record) -> None:
    good = flown.matches["accepted"]
    # roll differences of 0.16 deg x sqrt(2) read as 3.3 deg a degree: 0.7 deg a strip
    error = (flown.matches["angle_deg"] - flown.matches["crab_true_deg"])[good]
    assert abs(np.median(error)) < 0.3
    # studied over this gorge: v/h of the best-textured height, bias +0.4 %, sd 2.2 %, and pitch on top
    assert np.median(flown.matches["n"][good] / flown.matches["n_true"][good]) == pytest.approx(1.0, abs=0.02)


def test_end_lap_over_the_gorge(flown: Record) -> None:
    assert flown.summary["photos"]["end_lap_mean_pct"] == pytest.approx(60.0, abs=1.5)


def test_heights_are_raised_by_the_undulation(flown: Record) -> None:
    """Ellipsoidal, not the file's own: read by another way, at a point of the line."""
    import rasterio
    from pyproj import CRS, Transformer

    with rasterio.open(DATA / "elevation_24m_egm2008.tif") as file:
        flat = CRS.from_wkt(file.crs.to_wkt()).sub_crs_list[0]
        to_file = Transformer.from_crs("EPSG:4326", flat, always_xy=True)
        middle = np.flatnonzero(flown.telemetry["line"] == 0)[1000]
        lat, lon = (flown.telemetry[name][middle] for name in ("lat_deg", "lon_deg"))
        orthometric = float(next(file.sample([to_file.transform(lon, lat)]))[0])
    nadir = flown.telemetry["height_m"][middle] - flown.telemetry["agl_m"][middle]
    # the next cell of 24 m may lie higher or lower by the slope; a datum taken for another is 28 m
    assert nadir == pytest.approx(orthometric + UNDULATION, abs=12.0)


def test_heights_above_the_geoid_are_refused_without_a_way(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for datum in ("file", "egm2008"):
        try:
            terrain_of(real(datum))
        except InputError as error:
            said = str(error)
            assert "\n" not in said
            assert "undulation_m" in said
            file = tmp_path / "real.yaml"
            file.write_text(to_yaml(real(datum)))
            assert call(["run", str(file), "--out", str(tmp_path / "run")]) == 2
            out, err = capsys.readouterr()
            assert (out, err.count("\n")) == ("", 1)
            assert err.startswith(f"{file}:")
            assert not (tmp_path / "run").exists()
        else:  # this machine has the grid: then the heights have risen by it
            low = terrain_of(real({"undulation_m": 0.0}))
            high = terrain_of(real(datum))
            east, north = low.grid.from_geodetic(np.radians([SOUTH, NORTH]), np.radians([24.38, 24.38]))
            risen = high.mean_height(east, north, 500.0).mean - low.mean_height(east, north, 500.0).mean
            assert risen == pytest.approx(UNDULATION, abs=1.0)


def test_a_swath_that_leaves_the_land_ends_the_run_or_is_masked() -> None:
    """At the western edge the line itself is inside, what the rows see is not."""
    edge = (24.3645, 24.384)
    left = simulate(real(lon=edge))
    assert left.status == "failed"
    assert "line 0 left the terrain" in left.reason
    masked = simulate(real(outside="mask", lon=edge))
    assert masked.status == "done"
    on_first = (
        masked.matches["t_decided_s"] < masked.telemetry["t_s"][np.argmax(masked.telemetry["line"] == 1)] - 60.0
    )
    assert not masked.matches["accepted"][on_first].any()
