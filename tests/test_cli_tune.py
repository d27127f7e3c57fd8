"""`aerosim tune` as a user meets it: figures, a table that flies, refusals."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow.parquet as pq
import pytest
from flights import air, scenario
from ruamel.yaml import YAML

import aerosim as package
from aerosim.cli.app import call
from aerosim.scenario import with_overrides
from aerosim.scenario.disturbances import at_height, read_table
from aerosim.tune.records import _series


class Result(NamedTuple):
    code: int
    out: str
    err: str


Aerosim = Callable[..., Result]


@pytest.fixture
def aerosim(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Aerosim:
    """Runs a command line in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*args: str | Path) -> Result:
        code = call([str(each) for each in args])
        return Result(code, *capsys.readouterr())

    return run


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two short flights in mode fixed, 1000 and 1600 m above the ground."""
    folder = tmp_path_factory.mktemp("flown")
    paths = []
    for height in (1000.0, 1600.0):
        flight = scenario(
            4.0,
            air=air(5.0, 0.0, slow=1.0, turbulence=0.7),
            control={"mode": "fixed"},
            flight={"height_m": height, "run_in_s": 5},
        )
        paths.append(package.run(flight, folder / f"at{height:.0f}").path)
    return paths[0], paths[1]


def rates(file: Path, names: str = "t_s,roll_deg,pitch_deg,drift_deg", seconds: float = 312.95) -> Path:
    """Roll of 1 deg and pitch of 0.5 deg amplitude in 4 s, drift of 2 deg in 100 s, three periods of it and a strip."""
    t = np.arange(0.0, seconds, 0.1)
    every = {
        "t_s": t,
        "roll_deg": np.sin(np.pi / 2.0 * t),
        "p_deg_s": np.pi / 2.0 * np.cos(np.pi / 2.0 * t),
        "pitch_deg": 3.0 + 0.5 * np.cos(np.pi / 2.0 * t),
        "q_deg_s": -np.pi / 4.0 * np.sin(np.pi / 2.0 * t),
        "drift_deg": 2.0 * np.sin(2.0 * np.pi / 100.0 * t),
        "height_agl_m": np.full(len(t), 2000.0),
        "ground_speed_m_s": np.full(len(t), 70.0),
    }
    rows = [names, *(",".join(f"{every[n][k]:.9g}" for n in names.split(",")) for k in range(len(t)))]
    file.write_text("\n".join(rows) + "\n")
    return file


PLACE = ("--height_agl_m", "3000", "--ground_speed_m_s", "69.44")


def test_the_papers_numbers(aerosim: Aerosim) -> None:
    found = aerosim("tune", "--count", "1", "--size_deg", "3", "--duration_s", "40", "--json")
    assert found.code == 0
    walk = json.loads(found.out)["corrections"]
    assert walk["walk_deg2_per_s"]["value"] == pytest.approx(0.225)
    assert walk["largest_each_interval_deg2_per_s"] == pytest.approx(0.225)
    route = aerosim(
        "tune", "--count", "3.5", "--size_deg", "2.5", "--route_km", "12", "--ground_speed_m_s", "69.444", "--json"
    )
    walk = json.loads(route.out)["corrections"]["walk_deg2_per_s"]
    assert walk["value"] == pytest.approx(0.1266, abs=1e-4)
    assert walk["low"] < 0.05
    assert walk["high"] > 1.0  # three corrections say little


def test_corrections_from_a_file(aerosim: Aerosim) -> None:
    Path("notes.csv").write_text("t_s,correction_deg\n10,9\n50,2\n90,-3\n\n130,2.5\n")
    found = json.loads(aerosim("tune", "--corrections", "notes.csv", "--json").out)["corrections"]
    # the cause of the first is older than the record
    assert found["walk_deg2_per_s"]["value"] == pytest.approx((4.0 + 9.0 + 6.25) / 120.0)
    assert found["largest_each_interval_deg2_per_s"] == pytest.approx(9.0 / 40.0)
    whole = aerosim("tune", "--corrections", "notes.csv", "--duration_s", "160", "--json")
    assert json.loads(whole.out)["corrections"]["walk_deg2_per_s"]["value"] == pytest.approx(100.25 / 160.0)


def test_angles_and_rates_say_the_same(aerosim: Aerosim) -> None:
    """Closed form: differences of A sin(w t) over T have a mean square of 2 A^2 sin^2(w T/2)."""
    angle, rate = rates(Path("angle.csv")), rates(Path("rate.csv"), "t_s,p_deg_s,q_deg_s")
    one = json.loads(aerosim("tune", angle, *PLACE, "--json").out)["heights"][0]
    two = json.loads(aerosim("tune", rate, *PLACE, "--json").out)["heights"][0]
    time = 39.7 * 3000.0 / (132.6 * 69.44)
    assert one["strip_time_s"] == pytest.approx(time)
    wave = 2.0 * math.sin(math.pi / 4.0 * time) ** 2
    # small angles, 4.3 % more over the row; 2 deg of difference are 6.7 of drift: the arctangent takes 1 % of squares
    assert one["crab"]["noise_deg2"]["value"] == pytest.approx(wave * (132.6 / 39.7 * 1.043) ** 2, rel=0.015)
    assert one["vh"]["noise_pct2"]["value"] == pytest.approx(
        wave * 0.25 * (132.6 / 39.7 * (1 + 0.1497**2) * math.pi / 1.8) ** 2, rel=0.01
    )
    # the drift: 2 x 4 sin^2(pi T/100)/T
    assert one["crab"]["walk_deg2_per_s"]["value"] == pytest.approx(
        8.0 * math.sin(math.pi * time / 100.0) ** 2 / time, rel=0.03
    )
    for part, key in (("crab", "noise_deg2"), ("vh", "noise_pct2")):
        assert two[part][key]["value"] == pytest.approx(one[part][key]["value"], rel=5e-3)
    assert two["crab"]["walk_deg2_per_s"] is None
    assert one["photos"] is None


def test_columns_of_height_and_speed(aerosim: Aerosim) -> None:
    file = rates(Path("all.csv"), "t_s,roll_deg,height_agl_m,ground_speed_m_s")
    found = json.loads(aerosim("tune", file, "--json").out)["heights"][0]
    assert (found["height_agl_m"], found["vh_per_s"]) == (2000.0, 0.035)
    assert found["vh"]["sigma_pct"] is None


def test_a_gap_is_no_difference(aerosim: Aerosim) -> None:
    """Two records in one file, roll 0 in the one and 20 deg in the other: no strip spans the gap."""
    t = np.r_[np.arange(0.0, 100.0, 0.1), np.arange(200.0, 300.0, 0.1)]
    roll = np.where(t < 150.0, 0.0, 20.0) + 0.01 * np.sin(t)
    Path("gap.csv").write_text(
        "t_s,roll_deg\n" + "".join(f"{a:.2f},{b:.6f}\n" for a, b in zip(t, roll, strict=True))
    )
    found = json.loads(aerosim("tune", "gap.csv", *PLACE, "--json").out)["heights"][0]
    assert found["crab"]["sigma_deg"] < 0.1


def test_tables_of_two_heights_fly(aerosim: Aerosim, flown: tuple[Path, Path], tmp_path: Path) -> None:
    """Two runs make a table, a third names it."""
    done = aerosim("tune", flown[1], flown[0], "--vh_walk_pct2_per_s", "0.4", "--out", "table.yaml", "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    low, high = found["heights"]
    assert low["height_agl_m"] == pytest.approx(1000.0, abs=60.0)
    assert high["strip_time_s"] == pytest.approx(1.6 * low["strip_time_s"], rel=0.1)
    assert low["photos"]["greatest_n_error_pct"] > 0.0
    table = read_table(Path("table.yaml"))
    assert YAML(typ="safe").load(Path("table.yaml"))["rows"][0] == found["table"]["rows"][0]
    assert [row.height_agl_m for row in table.rows] == [
        pytest.approx(each["height_agl_m"], rel=1e-3) for each in (low, high)
    ]
    assert table.rows[0].crab.sigma_deg == pytest.approx(low["crab"]["sigma_deg"], rel=1e-3)
    assert table.rows[1].vh.walk_pct2_per_s == 0.4
    named = with_overrides(
        scenario(2.5, air=air(5.0, 0.0), flight={"height_m": 1300, "run_in_s": 5}),
        {"estimation.table": str(tmp_path / "table.yaml")},
    )
    run = package.run(named, tmp_path / "run")
    inputs = run.manifest["inputs"]["disturbances"]
    assert inputs["file"] == str(tmp_path / "table.yaml")
    assert len(inputs["sha256"]) == 64
    assert "disturbances at 1300 m above ground" in (run.path / "run.log").read_text()
    # the filters had the values of the table: gain of the second strip, (1 + gamma)/(2 + gamma)
    believed = at_height(table, 1300.0)
    gamma = believed.crab.walk_deg2_per_s * 1.0 / believed.crab.sigma_deg**2
    gains = run.matches["gain_drift"].to_numpy()
    gains = gains[np.isfinite(gains)]
    assert gains[1] == pytest.approx((1.0 + gamma) / (2.0 + gamma), rel=1e-3)
    # and the run reproduces from its own directory
    again = package.simulate(run.scenario)
    assert again.summary["telemetry_sha256"] == run.summary["telemetry_sha256"]


def test_corrections_keep_b2_t_over_height(aerosim: Aerosim, flown: tuple[Path, Path]) -> None:
    """The paper: b2 T is the same at all heights, so b2 falls as the height grows; without a height b2 is kept."""
    numbers = ("--count", "4", "--size_deg", "3", "--duration_s", "160")
    kept = json.loads(aerosim("tune", *flown, *numbers, "--json").out)["heights"]
    assert [each["crab"]["walk_deg2_per_s"]["value"] for each in kept] == pytest.approx([0.225, 0.225])
    scaled = json.loads(aerosim("tune", *flown, *numbers, "--corrections_agl_m", "3000", "--json").out)["heights"]
    products = [each["crab"]["walk_deg2_per_s"]["value"] * each["height_agl_m"] for each in scaled]
    assert products == pytest.approx([0.225 * 3000.0] * 2)


def test_noise_of_roll_is_the_error_of_the_strips_that_flew(aerosim: Aerosim, flown: tuple[Path, Path]) -> None:
    """N0 from the telemetry's roll alone against the errors of the strips that the rows saw.

    Both hold the same roll; the strips add 0.15 to 0.25 deg of matching and are about ten independent values (57 s
    over 5 to 7 s): relative sd of their sd 1/sqrt(20) = 22 %, of which most is common to both: bound 30 %.
    """
    found = json.loads(aerosim("tune", *flown, "--json").out)["heights"]
    for path, figures in zip(flown, found, strict=True):
        matches = package.open_run(path).matches
        good = matches["accepted"].to_numpy(zero_copy_only=False)
        errors = (matches["angle_deg"].to_numpy() - matches["crab_true_deg"].to_numpy())[good]
        assert figures["crab"]["sigma_deg"] == pytest.approx(np.nanstd(errors), rel=0.3)
        assert np.nanstd(errors) > 0.7  # roll, not matching


def test_what_a_person_reads(aerosim: Aerosim, flown: tuple[Path, Path]) -> None:
    done = aerosim(
        "tune",
        *flown,
        "--count",
        "4",
        "--size_deg",
        "3",
        "--duration_s",
        "160",
        "--vh_walk_pct2_per_s",
        "1",
        "--out",
        "t.yaml",
    )
    assert done.code == 0
    for words in (
        "b2 of the drift from corrections",
        "drift: N0 [deg2]",
        "v/h: sigma [%]",
        "photos: greatest n error [%]",
        "95 % limits",
    ):
        assert words in done.out
    assert done.out.splitlines()[-1] == "t.yaml"
    assert "aerosim tune --count 1 --size_deg 3 --duration_s 40" in aerosim("tune", "--help").out


BAD_FILES = {
    "no_roll.csv": "t_s,pitch_deg\n0,1\n1,2\n",
    "no_time.csv": "time,roll_deg\n0,1\n",
    "empty.csv": "",
    "header.csv": "t_s,roll_deg\n",
    "one.csv": "t_s,roll_deg\n0,1\n",
    "words.csv": "t_s,roll_deg\n0,1\n1,left\n",
    "nan.csv": "t_s,roll_deg\n0,nan\n1,2\n",
    "ragged.csv": "t_s,roll_deg\n0,1\n1\n",
    "back.csv": "t_s,roll_deg\n0,1\n1,1\n1,2\n",
    "short.csv": "t_s,roll_deg\n0,1\n1,1\n2,2\n",
    "note.csv": "t_s,correction_deg\n10,2\n",
    "sizes.csv": "t_s,size\n10,2\n",
}


@pytest.mark.parametrize(
    ("args", "message"),
    [
        ((), "tune: nothing to tune from (runs, CSV files, or corrections)"),
        (("no_roll.csv", *PLACE), "no_roll.csv:1: has no column of roll (roll_deg or p_deg_s)"),
        (("no_time.csv", *PLACE), "no_time.csv:1: has no column t_s (t_s)"),
        (("empty.csv", *PLACE), "empty.csv: is empty (columns t_s)"),
        (("header.csv", *PLACE), "header.csv: has no rows below its header"),
        (("one.csv", *PLACE), "one.csv: has a single row (two and more)"),
        (("words.csv", *PLACE), "words.csv:3: roll_deg: 'left' is not a finite number"),
        (("nan.csv", *PLACE), "nan.csv:2: roll_deg: 'nan' is not a finite number"),
        (("ragged.csv", *PLACE), "ragged.csv:3: 1 cells under 2 columns"),
        (("back.csv", *PLACE), "back.csv:4: t_s does not grow"),
        (("short.csv", *PLACE), "short.csv: lasts 2 s without a gap, a strip 12.9 s (a longer record)"),
        (("short.csv",), "short.csv:1: has no column height_agl_m (the column, or --height_agl_m)"),
        (("short.csv", "--height_agl_m", "100"), "short.csv:1: has no column ground_speed_m_s (the column, or --ground_speed_m_s)"),
        (("none.csv", *PLACE), "none.csv: cannot be read: No such file or directory"),
        (("nowhere",), "nowhere: is no run directory: it has no summary.json"),
        (("--corrections", "note.csv"), "note.csv: has a single moment (two corrections, or --duration_s)"),
        (("--corrections", "sizes.csv"), "sizes.csv:1: has no column correction_deg (t_s, correction_deg)"),
        (("--corrections", "note.csv", "--count", "3"), "--corrections: is given besides numbers (one of the two)"),
        (("--count", "3", "--size_deg", "2"), "--duration_s: is missing (--count, --size_deg and --duration_s or --route_km)"),
        (("--count", "3", "--duration_s", "20"), "--size_deg: is missing"),
        (("--count", "3", "--size_deg", "2", "--route_km", "9"), "--route_km: needs a speed (--ground_speed_m_s)"),
        (("--count", "3", "--size_deg", "2", "--route_km", "9", "--duration_s", "9"), "--route_km: is given besides --duration_s"),
        (("--corrections_agl_m", "3000"), "--corrections_agl_m: has no effect without corrections"),
        (("--count", "3", "--size_deg", "2", "--duration_s", "9", "--height_agl_m", "9"), "--height_agl_m: has no effect without a CSV file"),
        (("--count", "-3", "--size_deg", "2", "--duration_s", "9"), "--count: -3 is out of range (more than 0)"),
        (("--count", "3", "--size_deg", "2", "--duration_s", "9", "--out", "t.yaml"), "--out: corrections alone make no table"),
        (("--count", "3", "--size_deg", "2", "--duration_s", "9", "--crab_walk_deg2_per_s", "1"), "--crab_walk_deg2_per_s: is given besides corrections"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(aerosim: Aerosim, args: tuple[str, ...], message: str) -> None:
    for name, text in BAD_FILES.items():
        Path(name).write_text(text)
    found = aerosim("tune", *args)
    assert (found.code, found.out) == (2, "")
    assert found.err.startswith(message), found.err
    assert len(found.err.splitlines()) == 1
    assert not Path("t.yaml").exists()


def test_a_table_that_lacks_something(aerosim: Aerosim, flown: tuple[Path, Path]) -> None:
    rates(Path("full.csv"))
    rates(Path("roll.csv"), "t_s,roll_deg,drift_deg")
    rates(Path("no_drift.csv"), "t_s,roll_deg,pitch_deg")
    Path("taken.yaml").write_text("mine")
    walks = ("--vh_walk_pct2_per_s", "1")
    for args, message in [
        (("full.csv",), "full.csv: has no series of three photos by control.mode: fixed (--vh_walk_pct2_per_s)"),
        (("roll.csv", *walks), "roll.csv: has no pitch (a column pitch_deg or q_deg_s)"),
        (("no_drift.csv", *walks), "no_drift.csv: has no drift (--crab_walk_deg2_per_s)"),
        (("full.csv", "full.csv", *walks), "--out: two records at 3000 m (one for each height)"),
    ]:
        found = aerosim("tune", *args, *PLACE, "--out", "t.yaml")
        assert (found.code, found.err.strip()) == (2, message)
        assert not Path("t.yaml").exists()
    found = aerosim("tune", "full.csv", *walks, *PLACE, "--out", "taken.yaml")
    assert (found.code, found.err.strip()) == (2, "--out: taken.yaml exists (another file, or --overwrite)")
    assert aerosim("tune", "full.csv", *walks, *PLACE, "--out", "taken.yaml", "--overwrite").code == 0
    assert len(read_table(Path("taken.yaml")).rows) == 1


def test_runs_without_a_series_of_photos(aerosim: Aerosim, flown: tuple[Path, Path]) -> None:
    """Flown with v/h control, or with two photos on its line."""
    crab = ("--crab_walk_deg2_per_s", "0.2", "--out", "t.yaml")
    for name in ("followed", "few"):
        shutil.copytree(flown[0], name)
    text = Path("followed/scenario.yaml").read_text()
    Path("followed/scenario.yaml").write_text(text.replace("mode: fixed", "mode: pipelined"))
    pq.write_table(pq.read_table("few/photos.parquet").slice(0, 2), "few/photos.parquet")
    for name in ("followed", "few"):
        found = aerosim("tune", name, *crab)
        assert found.code == 2
        assert (
            found.err == f"{name}: has no series of three photos by control.mode: fixed (--vh_walk_pct2_per_s)\n"
        )
        assert json.loads(aerosim("tune", name, "--json").out)["heights"][0]["photos"] is None


def test_a_gap_in_the_end_laps() -> None:
    """The longest piece counts, with the photo before it."""
    lap = np.array([np.nan, 0.6, np.nan, 0.61, 0.62, 0.63])
    t, found = _series(np.arange(6.0), lap) or ([], [])
    assert list(t) == [2.0, 3.0, 4.0, 5.0]
    assert list(found[1:]) == [0.61, 0.62, 0.63]
    assert _series(np.arange(3.0), np.array([np.nan, 0.6, np.nan])) is None
    assert _series(np.arange(2.0), np.array([np.nan, np.nan])) is None


def test_a_forecast_refuses_what_a_run_refuses(aerosim: Aerosim) -> None:
    text = "name: tabled\nterrain: {source: pine_mountain}\nflight: {lines: [{start_deg: [36.52, -84.38], end_deg: [36.52, -84.3]}]}\n"
    Path("flight.yaml").write_text(text + "estimation: {table: table.yaml}\n")
    assert "flight.yaml:4: estimation.table: no such file" in aerosim("check", "flight.yaml").err
    Path("table.yaml").write_text("rows: 3\n")
    assert "table.yaml:1: rows: 3 is not a list" in aerosim("check", "flight.yaml").err
    Path("flight.yaml").write_text(
        text
        + "control: {mode: schmelovsky_1988}\nestimation: {arithmetic: integer}\nccd_rows: {period_s: 0.01666667}\n"
    )
    assert "estimation.arithmetic: integer counts exposures in 16 bits" in aerosim("check", "flight.yaml").err
