"""run.rrd: valid, complete, on one timeline, the same for the same run; and the signs of what it draws."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from pyproj import Geod
from rerun.chunk import RrdReader

from aerosim.errors import InputError
from aerosim.report.page import write_report
from aerosim.report.rowview import COLOURS, N_STEP, NOT_LOOKED_AT
from aerosim.report.scene import Scene, aircraft_mesh, camera_attitude, land_mesh, quaternions, upright
from aerosim.report.source import open_source
from aerosim.report.view import write_rrd

MOVING = {
    "/world/aircraft", "/world/camera", "/world/chase", "/world/photos/all", "/world/photos/last",
    "/rows/scroll", "/rows/scroll/strip", "/mad/surface", "/mad/minimum",
    "/plots/drift/true", "/plots/drift/estimated", "/plots/crab/true", "/plots/crab/estimated",
    "/plots/vh/true", "/plots/vh/estimated", "/plots/vh/strip", "/plots/mount/yaw",
    "/plots/end_lap/photo", "/plots/end_lap/wanted",
}  # fmt: skip
STILL = {"/world/land", "/world/lines", "/world/path", "/rows/scroll/row1_0", "/rows/scroll/row2_0"}


def rerun(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """The viewer's command line; CI in the environment keeps its analytics off."""
    code = "import sys; from rerun_cli.__main__ import main; sys.exit(main())"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        env={**os.environ, "CI": "1"}, capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip


def chunks(file: Path) -> dict[str, list[Any]]:
    """Chunks of the recording by entity, read by the viewer's own reader."""
    found: dict[str, list[Any]] = {}
    for chunk in RrdReader(str(file)).stream():
        found.setdefault(chunk.entity_path, []).append(chunk)
    return found


def moving(chunks_of: list[Any]) -> Any:
    """The one chunk of an entity that has a time."""
    (chunk,) = (chunk for chunk in chunks_of if not chunk.is_static)
    return chunk


@pytest.fixture(scope="module")
def rrd(run_dir: Path) -> Path:
    return write_rrd(run_dir)


def test_is_valid_and_small(rrd: Path, run_dir: Path) -> None:
    assert rrd == run_dir / "run.rrd"
    done = rerun("rrd", "verify", rrd)
    assert done.returncode == 0, done.stdout + done.stderr
    assert rrd.stat().st_size < 15e6
    assert not [f.name for f in run_dir.iterdir() if f.name.startswith(".")]


def test_holds_everything_on_one_timeline(rrd: Path, run_dir: Path) -> None:
    found = chunks(rrd)
    assert set(found) >= MOVING | STILL
    for entity, pieces in found.items():
        assert {name for piece in pieces for name in piece.timeline_names} == (
            {"sim_time"} if entity in MOVING else set()
        ), entity
    assert not [entity for entity in found if "__properties" in entity]  # the wall clock is among them
    whole = np.isfinite(open_source(run_dir).footprints_g).all(axis=(1, 2)).sum()
    assert moving(found["/world/photos/all"]).num_rows == whole
    accepted = sum(pq.read_table(run_dir / "matches.parquet")["accepted"].to_pylist())
    assert moving(found["/mad/surface"]).num_rows == accepted
    reader = RrdReader(str(rrd))
    assert [entry.recording_id for entry in reader.recordings()] == ["made_up-1"]
    assert len(list(reader.blueprints())) == 1  # the layout is in the file


def test_surfaces_of_any_window_lie_where_their_minimum_is(rrd: Path, run_dir: Path) -> None:
    """The darkest pixel of each picture is at the n and mu of its strip; windows are of all sizes and places."""
    mad = pq.read_table(run_dir / "mad.parquet").to_pandas()
    low, high = mad["first_n"].min(), (mad["first_n"] + mad["steps"]).max()
    top = (mad["first_mu_px"] + mad["shifts"]).max() - 1
    width, height = (high - low) // N_STEP + 1, top - mad["first_mu_px"].min() + 1
    assert mad["shifts"].nunique() > 1
    strips = pq.read_table(run_dir / "matches.parquet").to_pandas()
    strips = strips[strips["accepted"]].sort_values("t_decided_s")
    batch = moving(chunks(rrd)["/mad/surface"]).to_record_batch()
    for (_, strip), buffer in zip(strips.iterrows(), batch.column("Image:buffer").to_pylist(), strict=True):
        picture = np.array(buffer[0], np.uint8).reshape(height, width, 3)
        row, column = np.unravel_index((picture != COLOURS[0].astype(np.uint8)).sum(-1).argmin(), (height, width))
        assert top - row == pytest.approx(strip["mu_px"], abs=0.51)
        assert low + N_STEP * column == pytest.approx(strip["n"], abs=N_STEP)
        assert (picture == NOT_LOOKED_AT).all(-1).any()


def test_curves_are_the_telemetry(rrd: Path, run_dir: Path) -> None:
    table = pq.read_table(run_dir / "telemetry.parquet")
    batch = moving(chunks(rrd)["/plots/vh/estimated"]).to_record_batch()
    t = batch.column("sim_time").cast("int64").to_numpy() / 1e9
    values = batch.column("Scalars:scalars").to_pylist()
    step = np.searchsorted(table["t_s"].to_numpy(), t - 1e-6)
    wanted = 1e3 * table["vh_est_per_s"].to_numpy()[step]
    # before the first accepted strip there is nothing, rather than a number
    assert not values[0]
    assert np.isnan(wanted[0])
    shown = np.array([value[0] if value else np.nan for value in values])
    np.testing.assert_allclose(shown, wanted, rtol=1e-12)
    assert np.diff(t).max() < 0.11


def test_the_same_run_gives_the_same_file(rrd: Path, run_dir: Path, tmp_path: Path) -> None:
    first = tmp_path / "first.rrd"
    first.write_bytes(rrd.read_bytes())
    again = write_rrd(run_dir)
    done = rerun("rrd", "compare", first, again)
    assert done.returncode == 0, done.stderr[-500:]


def test_another_run_gives_another_file(rrd: Path, fresh_run: Callable[[], Path]) -> None:
    assert rerun("rrd", "compare", rrd, write_rrd(fresh_run())).returncode != 0


@pytest.mark.parametrize("rows", [0, 1, 40])
def test_short_and_empty_runs(fresh_run: Callable[[], Path], rows: int) -> None:
    run = fresh_run()
    for name, count in {"telemetry": rows, "matches": 0, "photos": 0, "rows": 0, "mad": 0}.items():
        pq.write_table(pq.read_table(run / f"{name}.parquet").slice(0, count), run / f"{name}.parquet")
    found = chunks(write_rrd(run))
    assert "/world/land" in found
    assert "/mad/surface" not in found
    assert ("/plots/drift/true" in found) == (rows > 1)
    assert rerun("rrd", "verify", run / "run.rrd").returncode == 0


def test_a_run_that_never_reached_its_line_nor_knew_the_ground(fresh_run: Callable[[], Path]) -> None:
    run = fresh_run()
    table = pq.read_table(run / "telemetry.parquet").slice(0, 300)
    for name, value in {"line": -1, "agl_m": None, "vh_true_per_s": None, "crab_est_deg": None}.items():
        column = pa.array([value] * table.num_rows, table.schema.field(name).type)
        table = table.set_column(table.column_names.index(name), name, column)
    pq.write_table(table, run / "telemetry.parquet")
    (run / "elevation.tif").unlink()
    for name in ("matches", "photos", "rows", "mad"):
        pq.write_table(pq.read_table(run / f"{name}.parquet").slice(0, 0), run / f"{name}.parquet")
    found = chunks(write_rrd(run))
    assert "/plots/drift/true" in found
    assert "/plots/crab/estimated" not in found
    # the drift of the run-in is drawn although no line was flown
    assert write_report(run).read_text(encoding="utf-8").count("<svg") == 2


def test_a_run_without_signals_or_land(fresh_run: Callable[[], Path]) -> None:
    run = fresh_run()
    for name in ("rows.parquet", "mad.parquet", "elevation.tif"):
        (run / name).unlink()
    found = chunks(write_rrd(run))
    assert "/world/aircraft" in found
    assert "/world/land" not in found
    assert "/rows/scroll" not in found


def test_not_a_run(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no run directory"):
        write_rrd(tmp_path)
    assert list(tmp_path.iterdir()) == []


def rotate(quaternion: np.ndarray, vector: tuple[float, float, float]) -> np.ndarray:
    """Vector turned by a quaternion x, y, z, w, written out."""
    u, w, v = quaternion[:3], quaternion[3], np.array(vector)
    return v + 2.0 * np.cross(u, np.cross(u, v) + w * v)


def one(heading: float, pitch: float = 0.0, roll: float = 0.0, convergence: float = 0.0) -> np.ndarray:
    """Quaternion of one attitude, deg."""
    angles = [np.radians([a]) for a in (heading, pitch, roll)]
    return quaternions(angles[0], angles[1], angles[2], float(np.radians(convergence)))[0]


def test_signs_of_attitude_in_the_scene() -> None:
    # east, north, up: the nose of an aircraft heading east points east, its belly down, its right wing south
    np.testing.assert_allclose(rotate(one(90), (1, 0, 0)), [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(rotate(one(90), (0, 0, 1)), [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(rotate(one(90), (0, 1, 0)), [0, -1, 0], atol=1e-12)
    assert rotate(one(0, pitch=5), (1, 0, 0))[2] > 0.08  # nose up
    assert rotate(one(0, roll=20), (0, 1, 0))[2] < -0.3  # right wing down
    # where grid north lies to the west of true north (convergence negative), true north bears right of it
    np.testing.assert_allclose(rotate(one(0, convergence=-2), (1, 0, 0))[0], np.sin(np.radians(2)), atol=1e-12)
    np.testing.assert_allclose(rotate(upright(np.radians([90.0]))[0], (1, 0, 0)), [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(rotate(upright(np.radians([0.0]))[0], (1, 0, 0)), [0, 1, 0], atol=1e-12)


def test_bearings_in_the_scene_agree_with_the_geodesic(run_dir: Path) -> None:
    source = open_source(run_dir)
    scene = Scene(source)
    lat, lon = (np.degrees(a) for a in source.grid.to_geodetic(*scene.centre))
    far_lon, far_lat, _ = Geod(ellps="WGS84").fwd(float(lon), float(lat), 37.0, 1000.0)
    there = scene.local(*source.on_map(np.array([far_lat]), np.array([far_lon])).T, [0.0])[0].astype(float)
    ahead = rotate(one(37.0, convergence=float(np.degrees(scene.convergence))), (1, 0, 0))
    # the scene is in 32-bit floats of a few km: a millimetre in 1000 m
    assert np.degrees(np.arctan2(there[0], there[1]) - np.arctan2(ahead[0], ahead[1])) == pytest.approx(
        0, abs=0.01
    )


def test_camera_looks_along_its_photos(run_dir: Path) -> None:
    source = open_source(run_dir)
    t, shots = source.telemetry["t_s"], source.photos
    keep = np.searchsorted(t, shots["t_s"])
    heading, pitch, _ = camera_attitude(source, keep)
    off = (np.degrees(heading) - shots["heading_true_deg"] + 180.0) % 360.0 - 180.0
    assert np.abs(off).max() < 1e-6
    # the mount takes the trim out: 2 deg of mean pitch do not tilt the camera
    assert abs(np.degrees(pitch).mean()) < 0.2


def test_land_carries_the_picture_where_it_belongs(run_dir: Path) -> None:
    source = open_source(run_dir)
    scene = Scene(source)
    mesh = land_mesh(scene)
    uv, points = mesh["vertex_texcoords"], 1e3 * mesh["vertex_positions"].astype(float)
    assert mesh["triangle_indices"].max() < len(points)
    assert uv.min() >= -1e-3
    assert uv.max() <= 1.0 + 1e-3
    picture = mesh["albedo_texture"]
    assert max(picture.shape[:2]) <= 2048
    # the picture's colour under some vertices against the file read by rasterio itself: the fields are of two
    # greens some 100 apart, the noise of 18 is averaged in an overview or the same pixel
    import rasterio

    pick = np.random.default_rng(4).choice(len(points), 400, replace=False)
    e, n = points[pick, 0] + scene.centre[0], points[pick, 1] + scene.centre[1]
    with rasterio.open(run_dir / "orthophoto.tif") as file:
        truth = np.array([value[1] for value in file.sample(zip(e, n, strict=True))], float)
    rows = np.clip((uv[pick, 1] * picture.shape[0]).astype(int), 0, picture.shape[0] - 1)
    cols = np.clip((uv[pick, 0] * picture.shape[1]).astype(int), 0, picture.shape[1] - 1)
    assert np.corrcoef(picture[rows, cols, 1], truth)[0, 1] > 0.9
    # triangles face up
    a, b, c = (points[mesh["triangle_indices"][:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()


def test_aircraft_is_symmetric_and_points_forward() -> None:
    points = aircraft_mesh(800.0)["vertex_positions"]
    assert points[:, 1].max() == pytest.approx(400.0)
    mirrored = {(round(x), round(-y), round(z)) for x, y, z in points.tolist()}
    assert mirrored == {(round(x), round(y), round(z)) for x, y, z in points.tolist()}
    # the fin, the highest point (z down), is behind
    assert points[points[:, 2].argmin(), 0] < -200.0
