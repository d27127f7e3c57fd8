"""What a run leaves behind: the files and columns of the contract, their units, digests, and opening it again."""

# ruff: noqa: E501  (lists of columns)

from __future__ import annotations

import hashlib
import json
import struct
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import aerosim
from aerosim.errors import InputError
from aerosim.record import Run, arrow_table, open_run, plain, telemetry_sha256, unit_of

FILES = {
    "scenario.yaml", "telemetry.parquet", "matches.parquet", "photos.parquet", "lines.parquet", "summary.json", "report.html", "run.rrd",
    "run.log", "manifest.json",
}  # fmt: skip
TELEMETRY = [
    "t_s",
    "lat_deg",
    "lon_deg",
    "height_m",
    "agl_m",
    "v_north_m_s",
    "v_east_m_s",
    "v_down_m_s",
    "roll_deg",
    "pitch_deg",
    "heading_deg",
    "p_deg_s",
    "q_deg_s",
    "r_deg_s",
    "track_deg",
    "airspeed_m_s",
    "wind_north_m_s",
    "wind_east_m_s",
    "wind_down_m_s",
    "gust_u_m_s",
    "gust_v_m_s",
    "gust_w_m_s",
    "mount_yaw_deg",
    "drift_true_deg",
    "drift_est_deg",
    "crab_true_deg",
    "crab_est_deg",
    "vh_true_per_s",
    "vh_est_per_s",
    "line",
    "cross_track_m",
]
MATCHES = [
    "strip",
    "t_row1_s",
    "t_row2_s",
    "t_decided_s",
    "n",
    "mu_px",
    "mad_min_grey",
    "variance_drift_deg2",
    "variance_vh_per_s2",
    "gain_drift",
    "gain_vh",
    "innovation_drift",
    "innovation_vh",
    "accepted",
    "reason",
    "crab_true_deg",
    "vh_true_per_s",
]
POSE = "lat_{0}_deg lon_{0}_deg height_{0}_m roll_{0}_deg pitch_{0}_deg heading_{0}_deg"
CORNERS = [
    f"corner_{corner}_{axis}_deg"
    for corner in ("front_left", "front_right", "rear_right", "rear_left")
    for axis in ("lat", "lon")
]
PHOTOS = [
    "photo", "t_s", "line", *POSE.format("true").split(), *POSE.format("measured").split(),
    *POSE.format("smoothed").split(), "interval_s", "end_lap_pct", "end_lap_terrain_pct", "crab_deg", "tilt_deg", "blur_px",
    "gsd_m", *CORNERS, "verdict", "file",
]  # fmt: skip
SUMMARY = {
    "flight": "duration_s lines cross_track_rms_m height_rms_m airspeed_rms_m_s roll_rms_deg pitch_rms_deg "
    "roll_rate_rms_deg_s pitch_rate_rms_deg_s yaw_rate_rms_deg_s drift_mean_deg",
    "crab": "residual_rms_deg residual_mean_deg residual_max_deg estimate_error_rms_deg settle_s strips accepted_pct "
    "bad_pct silent_max_s silent_end_s split_deg",
    "vh": "error_rms_pct error_mean_pct strip_error_rms_pct split_pct",
    "photos": "count end_lap_mean_pct end_lap_error_rms_pct end_lap_min_pct side_lap_min_pct blur_rms_px out_of_tolerance",
    "speed": "wall_s fdm_wall_s real_time_factor",
}
UNITS = {
    "deg2": "deg2", "deg_s": "deg/s", "deg": "deg", "m_s": "m/s", "per_s": "1/s", "per_s2": "1/s2", "grey": "grey levels",
    "px": "px", "pct": "%", "m": "m", "s": "s",
}  # fmt: skip
PLAIN = {
    "strip", "n", "n_true", "accepted", "reason", "photo", "line", "verdict", "file", "gain_drift", "gain_vh",
    "innovation_drift", "innovation_vh",
}  # fmt: skip


def in_order(wanted: list[str], found: list[str]) -> bool:
    """Whether all wanted names are found, in this order; others may stand between."""
    rest = iter(found)
    return all(name in rest for name in wanted)


def test_every_file_is_there_and_nothing_else_of_the_making(crosswind: Run) -> None:
    names = {file.name for file in crosswind.path.iterdir()}
    assert names >= FILES
    # rows and MAD surfaces are kept for the viewer
    assert names - FILES == {"rows.parquet", "mad.parquet"}
    assert [file.name for file in crosswind.path.parent.iterdir()] == [crosswind.path.name]


def test_every_column_is_there_in_order(crosswind: Run) -> None:
    assert crosswind.telemetry.column_names == TELEMETRY
    assert in_order(MATCHES, crosswind.matches.column_names)
    assert in_order(PHOTOS, crosswind.photos.column_names)


def test_columns_know_their_units(crosswind: Run) -> None:
    for table in (crosswind.telemetry, crosswind.matches, crosswind.photos):
        for field in table.schema:
            suffix = next((s for s in UNITS if field.name.endswith(f"_{s}")), "")
            assert suffix or field.name in PLAIN, field.name
            assert field.metadata[b"unit"].decode() == UNITS.get(suffix, ""), field.name


def test_the_summary_is_the_contracts(crosswind: Run) -> None:
    summary = crosswind.summary
    assert {name: " ".join(summary[name]) for name in SUMMARY} == SUMMARY
    assert (summary["status"], summary["seed"]) == ("done", 1)
    assert set(summary) == {*SUMMARY, "consistency", "status", "seed", "telemetry_sha256", "notes"}
    nulls = {f"{part}.{name}" for part in SUMMARY for name, value in summary[part].items() if value is None}
    assert nulls == set(summary["notes"])
    assert all(summary["notes"].values())


def test_values_lie_where_they_must(crosswind: Run) -> None:
    tel = {name: crosswind.telemetry[name].to_numpy() for name in TELEMETRY}
    np.testing.assert_allclose(np.diff(tel["t_s"]), 0.05, atol=1e-9)
    assert set(tel["line"]) == {-1, 0, 1}
    for name in ("heading_deg", "track_deg"):
        assert tel[name].min() >= 0.0
        assert tel[name].max() < 360.0
    apart = (tel["track_deg"] - tel["heading_deg"] - tel["drift_true_deg"] + 180.0) % 360.0 - 180.0
    assert abs(apart).max() < 1e-9
    reasons = set(crosswind.matches["reason"].to_pylist())
    assert reasons <= {
        "accepted",
        "border_mu",
        "border_n",
        "degenerate",
        "ambiguous",
        "outside_terrain",
        "timeout",
    }
    accepted = crosswind.matches["accepted"].to_pylist()
    assert accepted == [reason == "accepted" for reason in crosswind.matches["reason"].to_pylist()]
    photos = crosswind.photos
    lines = photos["line"].to_pylist()
    firsts = [k for k, line in enumerate(lines) if line >= 0 and (k == 0 or lines[k - 1] != line)]
    assert len(firsts) == 2
    assert [photos["end_lap_pct"][k].as_py() for k in firsts] == [None, None]


def test_a_run_verifies_until_it_is_touched(crosswind: Run, tmp_path: Path) -> None:
    assert crosswind.verify() == []
    outputs = crosswind.manifest["outputs"]
    assert set(outputs) == {file.name for file in crosswind.path.iterdir()} - {"manifest.json", "run.log"}
    for name, digest in outputs.items():
        assert digest == hashlib.sha256((crosswind.path / name).read_bytes()).hexdigest()
    for file in crosswind.path.iterdir():
        (tmp_path / file.name).symlink_to(file)
    (tmp_path / "photos.parquet").unlink()
    (tmp_path / "scenario.yaml").unlink()
    (tmp_path / "scenario.yaml").write_text("name: other\n")
    assert open_run(tmp_path).verify() == ["photos.parquet", "scenario.yaml"]


def test_the_manifest_names_what_the_run_was_made_of(crosswind: Run) -> None:
    manifest = crosswind.manifest
    assert manifest["aerosim"] == metadata.version("aerosim-survey")
    assert manifest["versions"]["jsbsim"] == metadata.version("jsbsim")
    assert manifest["seed"] == 1
    assert set(manifest["inputs"]) == {
        "orthophoto",
        "elevation",
        "aircraft/survey_twin.xml",
        "aircraft/limits.yaml",
        "aircraft/Systems/autopilot.xml",
    }
    for made_of in manifest["inputs"].values():
        assert made_of["sha256"] == hashlib.sha256(Path(made_of["file"]).read_bytes()).hexdigest()
    assert manifest["terrain"] == {n: manifest["inputs"][n]["file"] for n in ("orthophoto", "elevation")}


def test_the_digest_is_that_of_the_columns(crosswind: Run) -> None:
    """Made anew from the file: little-endian columns in the contract's order, null as NaN."""
    digest = hashlib.sha256()
    for name in TELEMETRY:
        values = crosswind.telemetry[name].to_numpy()
        digest.update(values.astype("<i8" if name == "line" else "<f8").tobytes())
    assert digest.hexdigest() == crosswind.summary["telemetry_sha256"]


def test_the_digest_does_not_depend_on_the_machines_byte_order() -> None:
    wanted = hashlib.sha256(struct.pack("<2d2q", 1.5, -2.0, 3, -1)).hexdigest()
    for order in "<>":
        columns = {"t_s": np.array([1.5, -2.0], f"{order}f8"), "line": np.array([3, -1], f"{order}i8")}
        assert telemetry_sha256(columns) == wanted


def test_the_scenario_of_a_run_is_resolved_and_the_same(crosswind: Run) -> None:
    assert crosswind.scenario == aerosim.load_scenario("crosswind")
    text = (crosswind.path / "scenario.yaml").read_text()
    assert "strip_period_s: 1" in text  # a default, filled in


def test_numbers_that_are_none_become_null() -> None:
    value = {
        "a": np.float64("nan"),
        "b": [np.inf, 1, np.int64(2)],
        "c": (np.bool_(True), "x"),
        "d": {"e": -np.inf},
    }
    assert json.loads(json.dumps(plain(value), allow_nan=False)) == {
        "a": None, "b": [None, 1, 2], "c": [True, "x"], "d": {"e": None},
    }  # fmt: skip


def test_tables_keep_types_and_nulls() -> None:
    table = arrow_table(
        {
            "x_m": np.array([1.0, np.nan]),
            "line": np.array([0, -1]),
            "verdict": np.array(["ok", None], object),
            "file": np.array([None, None], object),
            "row1_grey": np.array([[1, 2], [3, 4]], np.uint8),
            "mad_grey": np.array([[1.0], [2.0, 3.0]], object),
        }
    )
    assert table.to_pylist() == [
        {"x_m": 1.0, "line": 0, "verdict": "ok", "file": None, "row1_grey": [1, 2], "mad_grey": [1.0]},
        {"x_m": None, "line": -1, "verdict": None, "file": None, "row1_grey": [3, 4], "mad_grey": [2.0, 3.0]},
    ]
    assert str(table.schema.field("file").type) == "string"


def test_units_of_names() -> None:
    assert unit_of("variance_vh_per_s2") == "1/s2"
    assert unit_of("p_deg_s") == "deg/s"
    assert unit_of("n") == ""


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (None, "is no run directory: it has no summary.json"),
        (b"{", "cannot be read"),
        (b"\xff\xfe\x00", "cannot be read"),
        (b"[]", "is not what a run writes"),
        (b"{}", "is not what a run writes"),
    ],
)
def test_what_is_no_run_is_refused(tmp_path: Path, content: bytes | None, words: str) -> None:
    if content is not None:
        (tmp_path / "summary.json").write_bytes(content)
    with pytest.raises(InputError, match=words) as refused:
        open_run(tmp_path)
    assert str(tmp_path) in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("content", [None, b"", b"PAR1 cut short"])
def test_a_table_that_cannot_be_read_is_named(tmp_path: Path, content: bytes | None) -> None:
    (tmp_path / "summary.json").write_text('{"status": "done"}')
    if content is not None:
        (tmp_path / "telemetry.parquet").write_bytes(content)
    run: Any = open_run(tmp_path)
    with pytest.raises(InputError, match=r"telemetry\.parquet: cannot be read"):
        _ = run.telemetry
