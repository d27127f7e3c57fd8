"""A small run directory made up here: kinematics in a steady crosswind over hills, every file of the contract."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import rasterio
from rasterio.transform import from_origin

from aerosim.frames import MapGrid
from aerosim.scenario import load
from aerosim.scenario.emit import to_yaml

GRID = MapGrid("EPSG:32616")
EAST0, NORTH0, SPEED, HEIGHT = 730_000.0, 4_040_000.0, 69.0, 3400.0
DRIFT = np.radians(8.3)
FOCAL, SPACING, PERIOD = 132.6, 39.7, 0.05

SCENARIO = """\
name: made_up
purpose: Two short lines for the tests of the report <with a bracket & an ampersand>.
verifies: [Drawing.]
terrain: {{source: {{orthophoto: {folder}/orthophoto.tif, elevation: {folder}/elevation.tif}}}}
air: {{wind: {{speed_m_s: 10, from_deg: 0}}}}
flight:
  lines:
    - {{start_deg: {a}, end_deg: {b}}}
    - {{start_deg: {c}, end_deg: {d}}}
expect:
  crab.residual_rms_deg: {{max: 2.1}}
  photos.end_lap_mean_pct: {{min: 59.1, max: 60.9}}
"""


def write_terrain(folder: Path, length: float) -> None:
    """Hills and fields around the lines, 25 m cells."""
    cell, margin = 25.0, 3500.0
    cols, rows = int((length + 2 * margin) / cell), int((2000 + 2 * margin) / cell)
    y, x = np.mgrid[:rows, :cols]
    height = 350 + 120 * np.sin(x / 40) * np.cos(y / 30)
    noise = np.random.default_rng(5).normal(0, 18, (3, rows, cols))
    fields = 110 + 50 * np.sign(np.sin(x / 6) * np.sin(y / 9))
    picture = np.clip(np.stack([fields * 0.9, fields, fields * 0.7]) + noise, 0, 255).astype(np.uint8)
    place = from_origin(EAST0 - margin, NORTH0 + 2000 + margin, cell, cell)
    common = {"driver": "GTiff", "height": rows, "width": cols, "crs": "EPSG:32616", "transform": place}
    with rasterio.open(folder / "orthophoto.tif", "w", count=3, dtype="uint8", **common) as file:
        file.write(picture)
    with rasterio.open(folder / "elevation.tif", "w", count=1, dtype="float32", **common) as file:
        file.write(height.astype(np.float32), 1)
        file.update_tags(VERTICAL_DATUM="ELLIPSOIDAL")


def fly(length: float) -> dict[str, np.ndarray]:
    """East along one line, a half circle to the north, west along the other.  Telemetry at 20 Hz."""
    radius = 1000.0
    t_line, t_turn = length / SPEED, np.pi * radius / SPEED
    t = np.arange(0.0, 2 * t_line + t_turn, 0.05)
    turning = np.clip((t - t_line) * SPEED / radius, 0.0, np.pi)
    on = [t < t_line, (t >= t_line) & (t < t_line + t_turn), t >= t_line + t_turn]
    easting = EAST0 + np.select(
        on, [t * SPEED, length + radius * np.sin(turning), length - (t - t_line - t_turn) * SPEED]
    )
    northing = NORTH0 + np.select(on, [0.0 * t, radius - radius * np.cos(turning), 0.0 * t + 2000.0])
    lat, lon = GRID.to_geodetic(easting, northing)
    rng = np.random.default_rng(1)
    wobble = rng.normal(0, 1, (6, len(t)))
    wobble = np.stack([np.convolve(w, np.ones(40) / 8, "same") for w in wobble])
    track = (90.0 - np.degrees(turning)) % 360.0
    drift = np.degrees(DRIFT) * np.where(on[2], -1.0, np.where(on[0], 1.0, np.cos(turning))) + 0.3 * wobble[0]
    yaw = drift - 0.2 * wobble[1] - 3.0 * np.exp(-t / 15)
    vh = SPEED / 3030.0 * (1 + 0.01 * wobble[2])
    zero = 0.0 * t
    return {
        "t_s": t, "lat_deg": np.degrees(lat), "lon_deg": np.degrees(lon), "height_m": zero + HEIGHT,
        "agl_m": zero + 3030.0, "v_north_m_s": SPEED * np.cos(np.radians(track)),
        "v_east_m_s": SPEED * np.sin(np.radians(track)), "v_down_m_s": zero,
        "roll_deg": np.where(on[1], -20.0, 0.3 * wobble[3]), "pitch_deg": 2.0 + 0.2 * wobble[4],
        "heading_deg": (track - drift) % 360.0, "p_deg_s": zero, "q_deg_s": zero, "r_deg_s": zero,
        "track_deg": track, "airspeed_m_s": zero + 69.44, "wind_north_m_s": zero - 10.0, "wind_east_m_s": zero,
        "wind_down_m_s": zero, "gust_u_m_s": zero, "gust_v_m_s": zero, "gust_w_m_s": zero, "mount_yaw_deg": yaw,
        "drift_true_deg": drift, "drift_est_deg": drift + 0.2 * wobble[5], "crab_true_deg": drift - yaw,
        "crab_est_deg": drift - yaw + 0.2 * wobble[5], "vh_true_per_s": vh,
        "vh_est_per_s": np.where(t < 13.0, np.nan, vh * (1 + 0.003 * wobble[5])),
        "line": np.select(on, [0, -1, 1]).astype(np.int32), "cross_track_m": 3 * wobble[1],
    }  # fmt: skip


def strips_of(tel: dict[str, np.ndarray]) -> tuple[dict[str, list], dict[str, list]]:
    """One strip a second on the lines; each ninth is refused, the last of a line is given up."""
    rng = np.random.default_rng(2)
    reasons = ("border_mu", "ambiguous", "degenerate")
    out: dict[str, list] = {}
    mad: dict[str, list] = {
        "strip": [],
        "first_n": [],
        "steps": [],
        "first_mu_px": [],
        "shifts": [],
        "mad_grey": [],
    }
    t_end = {line: tel["t_s"][tel["line"] == line].max() for line in (0, 1)}
    for k in range(0, len(tel["t_s"]), 20):
        line = int(tel["line"][k])
        if line < 0:
            continue
        t1, vh = float(tel["t_s"][k]), float(tel["vh_true_per_s"][k])
        n_true = SPACING / FOCAL / PERIOD / vh
        given_up = t1 + n_true * PERIOD > t_end[line]
        bad = given_up or k % 180 == 0
        n = n_true * (1.004 if not bad else rng.uniform(0.7, 1.5))
        strip = k // 20
        row = {
            "strip": strip, "t_row1_s": t1, "t_row2_s": np.nan if given_up else t1 + n * PERIOD,
            "t_decided_s": t_end[line] if given_up else t1 + n * PERIOD + 0.6, "n": np.nan if given_up else n,
            "mu_px": np.nan if given_up else rng.normal(0, 0.4),
            "mad_min_grey": np.nan if given_up else rng.uniform(3, 6),
            "variance_drift_deg2": 0.2, "variance_vh_per_s2": 1e-8, "gain_drift": 0.1, "gain_vh": 0.1,
            "innovation_drift": rng.normal(), "innovation_vh": rng.normal(),
            "drift_deg": float(tel["drift_true_deg"][k]),
            "vh_per_s": np.nan if given_up else vh / 1.004, "accepted": not bad,
            "reason": "timeout" if given_up else reasons[strip // 9 % 3] if bad else "accepted",
            "crab_true_deg": float(tel["crab_true_deg"][k]), "vh_true_per_s": vh, "n_true": n_true,
        }  # fmt: skip
        for name, value in row.items():
            out.setdefault(name, []).append(value)
        if not bad:
            steps, shifts, right = 120, 15 + 2 * (strip % 3), -9 + strip % 5  # windows of all sizes and places
            down, across = np.mgrid[:steps, :shifts]
            cone = np.hypot((down - (n - 150)) / 8.0, across + right - row["mu_px"])
            for name, value in zip(
                mad, (strip, 150, steps, right, shifts, (4 + 25 * cone / (1 + cone)).ravel()), strict=True
            ):
                mad[name].append(value)
    return out, mad


def photos_of(tel: dict[str, np.ndarray]) -> dict[str, list]:
    """A photo each 20 s on the lines, its footprint a rectangle turned by the crab."""
    out: dict[str, list] = {}
    before = -1
    for k in range(100, len(tel["t_s"]), 400):
        line = int(tel["line"][k])
        if line < 0:
            continue
        east, north = GRID.from_geodetic(np.radians(tel["lat_deg"][k]), np.radians(tel["lon_deg"][k]))
        azimuth = np.radians(tel["track_deg"][k] - tel["crab_true_deg"][k])
        ahead = np.array([np.sin(azimuth), np.cos(azimuth)])
        right = np.array([np.cos(azimuth), -np.sin(azimuth)])
        row = {
            "photo": len(out.get("photo", [])), "t_s": float(tel["t_s"][k]), "line": line,
            "lat_true_deg": float(tel["lat_deg"][k]), "lon_true_deg": float(tel["lon_deg"][k]),
            "height_true_m": HEIGHT,
            "roll_true_deg": 0.3, "pitch_true_deg": 0.1, "heading_true_deg": float(np.degrees(azimuth) % 360.0),
            "interval_s": 20.0, "end_lap_pct": None if line != before else 60.0 + 3.0 * np.sin(k),
            "end_lap_terrain_pct": None if line != before else 57.0, "crab_deg": float(tel["crab_true_deg"][k]),
            "tilt_deg": 0.4, "blur_px": 0.3, "gsd_m": 0.24,
            "verdict": "ok" if (k - 100) % 1600 else "end_lap", "file": None,
        }  # fmt: skip
        for name, (a, b) in {
            "front_left": (1, -1), "front_right": (1, 1), "rear_right": (-1, 1), "rear_left": (-1, -1)
        }.items():  # fmt: skip
            corner = np.array([east, north]) + 2290.0 * (a * ahead + b * right)
            lat, lon = GRID.to_geodetic(*corner)
            row[f"corner_{name}_lat_deg"], row[f"corner_{name}_lon_deg"] = np.degrees(lat), np.degrees(lon)
        before = line
        for name, value in row.items():
            out.setdefault(name, []).append(value)
    return out


def rows_of(tel: dict[str, np.ndarray]) -> dict[str, list]:
    """Both rows over a made-up ground that drifts by; nothing in turns."""
    ground = np.convolve(np.random.default_rng(3).normal(0, 60, 40000), np.ones(9) / 3, "same")
    out: dict[str, list] = {"t_s": [], "row1_grey": [], "row2_grey": []}
    for t in tel["t_s"][tel["line"] >= 0]:
        k = int(t / PERIOD)
        line = 128 + 0.5 * ground[k : k + 110] + 0.5 * ground[::-1][:110] * np.sin(k / 50)
        out["t_s"].append(t)
        out["row1_grey"].append(np.clip(line, 0, 255).astype(np.uint8))
        out["row2_grey"].append(np.clip(line[7:-7], 0, 255).astype(np.uint8))
    return out


SUMMARY = {
    "status": "done", "seed": 1, "telemetry_sha256": "0" * 64,
    "flight": {"duration_s": 300.0, "lines": 2, "cross_track_rms_m": 1.25, "height_rms_m": 0.5,
               "airspeed_rms_m_s": 0.2,
               "roll_rms_deg": 0.3, "pitch_rms_deg": 0.2, "roll_rate_rms_deg_s": 0.5, "pitch_rate_rms_deg_s": 0.4,
               "yaw_rate_rms_deg_s": 0.3, "drift_mean_deg": 8.31},
    "crab": {"residual_rms_deg": 0.8765, "residual_mean_deg": 0.1, "residual_max_deg": 2.5,
             "estimate_error_rms_deg": 0.4, "settle_s": 25.0, "strips": 260, "accepted_pct": 88.5},
    "vh": {"error_rms_pct": 0.31, "error_mean_pct": 0.02, "strip_error_rms_pct": 0.42},
    "photos": {"count": 14, "end_lap_mean_pct": 60.123, "end_lap_error_rms_pct": 2.1, "end_lap_min_pct": 57.0,
               "side_lap_min_pct": None, "blur_rms_px": 0.3, "out_of_tolerance": 3},
    "speed": {"wall_s": 9.0, "fdm_wall_s": 4.0, "real_time_factor": 33.0},
    "notes": {"photos.side_lap_min_pct": "no neighbouring line overlaps"},
}  # fmt: skip


def make_run(folder: Path, length: float = 8000.0) -> Path:
    """Write a run directory; length of a line, m.  Returns the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    write_terrain(folder, length)
    ends = [(EAST0, NORTH0), (EAST0 + length, NORTH0), (EAST0 + length, NORTH0 + 2000), (EAST0, NORTH0 + 2000)]
    geo = [[round(float(np.degrees(v)), 7) for v in GRID.to_geodetic(*p)] for p in ends]
    source = folder / "scenario_in.yaml"
    source.write_text(SCENARIO.format(folder=folder, **dict(zip("abcd", geo, strict=True))))
    (folder / "scenario.yaml").write_text(to_yaml(load(source)))
    source.unlink()
    tel = fly(length)
    matches, mad = strips_of(tel)
    pq.write_table(pa.table(tel), folder / "telemetry.parquet")
    pq.write_table(pa.table(matches), folder / "matches.parquet")
    pq.write_table(pa.table(photos_of(tel)), folder / "photos.parquet")
    legs = [(*geo[0], *geo[1]), (*geo[2], *geo[3])]
    names = ("start_lat_deg", "start_lon_deg", "end_lat_deg", "end_lon_deg")
    pq.write_table(pa.table(dict(zip(names, np.transpose(legs), strict=True))), folder / "lines.parquet")
    pq.write_table(pa.table(rows_of(tel)), folder / "rows.parquet")
    grey = pa.array([m.astype(np.float32) for m in mad["mad_grey"]], pa.list_(pa.float32()))
    pq.write_table(pa.table({**mad, "mad_grey": grey}), folder / "mad.parquet")
    (folder / "summary.json").write_text(json.dumps(SUMMARY))
    manifest = {"versions": {"aerosim": "0.1.0", "jsbsim": "1.2.3"}, "seed": 1}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    (folder / "run.log").write_text("done\n")
    return folder


@pytest.fixture(scope="session")
def run_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One finished run; read only."""
    return make_run(tmp_path_factory.mktemp("runs") / "made_up")


@pytest.fixture
def fresh_run(tmp_path: Path) -> Callable[[], Path]:
    """A run of its own for a test that changes it."""
    return lambda: make_run(tmp_path / "run", 3000.0)
