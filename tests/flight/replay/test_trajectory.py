"""Trajectory files: what is read, what is refused and where, what is cut away."""

# ruff: noqa: E501  (tables of messages, one a line)

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from flown_paths import columns_of, race_track, write_csv
from hypothesis import given, settings
from hypothesis import strategies as st

from aerosim.errors import InputError
from aerosim.flight.replay.trajectory import Trajectory, read_trajectory, step_of
from aerosim.flight.replay.trajectory_pieces import flown_pieces, moved
from aerosim.frames import WGS84_A, ecef_from_geodetic, wrap_pi

HEAD = "t_s,latitude_deg,longitude_deg,height_m"
ROWS = ["0,47.00,11,1500", "10,47.01,11,1500", "20,47.02,11,1500", "30,47.03,11,1500", "40,47.04,11,1500"]


def file_of(tmp_path: Path, *rows: str, head: str = HEAD) -> Path:
    path = tmp_path / "flight.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def refused(path: Path) -> InputError:
    with pytest.raises(InputError) as caught:
        read_trajectory(path)
    assert "\n" not in str(caught.value)
    return caught.value


def test_units_are_those_of_the_columns(tmp_path: Path) -> None:
    head = (
        "time_utc,latitude_deg,longitude_deg,barometric_altitude_ft,groundspeed_kt,track_deg,vertical_rate_ftpmin"
    )
    rows = [f"2024-05-01T10:00:{10 * k:02d}Z,47.0{k},11,5000,{120 + k},359,-600" for k in range(5)]
    found = read_trajectory(file_of(tmp_path, *rows, head=head), height_offset=10.0)
    assert np.diff(found.t) == pytest.approx(10.0)
    assert found.height == pytest.approx(5000 * 0.3048 + 10.0)
    assert found.speed[0] == pytest.approx(120 * 1852 / 3600)
    assert found.climb[0] == pytest.approx(-600 * 0.3048 / 60)
    assert found.track[0] == pytest.approx(math.radians(359))
    assert found.pressure
    assert any("pressure altitude" in note and "+10 m" in note for note in found.notes)


def test_time_without_a_zone_is_utc(tmp_path: Path) -> None:
    head = "time_utc,latitude_deg,longitude_deg,height_m"
    rows = [f"2024-05-01T10:00:0{k}.5,47.00{k},11,1500" for k in range(5)]
    zoned = [f"2024-05-01T12:00:0{k}.5+02:00,47.00{k},11,1500" for k in range(5)]
    notes = [read_trajectory(file_of(tmp_path, *each, head=head)).notes for each in (rows, zoned)]
    assert notes[0] == notes[1] == ("time_utc: counted from the first row, 1714557600.500 s",)


def test_seconds_since_1970_are_counted_from_the_first_row(tmp_path: Path) -> None:
    rows = [f"{1714557600.5 + 10 * k},47.0{k},11,1500" for k in range(5)]
    assert read_trajectory(file_of(tmp_path, *rows)).t == pytest.approx([0.0, 10.0, 20.0, 30.0, 40.0])


def test_parquet_says_the_same_as_csv(tmp_path: Path) -> None:
    columns = columns_of(race_track(rate=1.0))
    csv = read_trajectory(write_csv(tmp_path / "a.csv", columns))
    pq.write_table(pa.table(columns), tmp_path / "a.parquet")
    parquet = read_trajectory(tmp_path / "a.parquet")
    assert parquet.lat == pytest.approx(csv.lat, abs=1e-12)
    assert parquet.t == pytest.approx(csv.t)
    stamps = pa.array((columns["t_s"] * 1e6).astype("int64"), pa.timestamp("us"))
    named = pa.table({"time_utc": stamps, **{k: v for k, v in columns.items() if k != "t_s"}})
    pq.write_table(named, tmp_path / "b.parquet")
    assert np.diff(read_trajectory(tmp_path / "b.parquet").t) == pytest.approx(np.diff(csv.t), abs=1e-5)


def test_columns_that_nobody_knows_are_noted(tmp_path: Path) -> None:
    rows = [f"{row},abc" for row in ROWS]
    found = read_trajectory(file_of(tmp_path, *rows, head=f"{HEAD},callsign"))
    assert "columns not used: callsign" in found.notes


def test_equal_rows_are_dropped_and_noted(tmp_path: Path) -> None:
    found = read_trajectory(file_of(tmp_path, *ROWS[:2], ROWS[1], *ROWS[2:]))
    assert len(found) == 5
    assert any("1 repeated rows dropped" in note and ":4" in note for note in found.notes)
    # the place of what is wrong after it is still that of the file
    wrong = refused(file_of(tmp_path, *ROWS[:2], ROWS[1], *ROWS[2:], "50,48,11,1500"))
    assert wrong.where.endswith(":8")


@pytest.mark.parametrize(
    ("rows", "line", "said"),
    [
        ([*ROWS, "35,47.05,11,1500"], 7, "time runs backwards: 35 s after 40 s"),
        ([*ROWS, "40,47.05,11,1500"], 7, "two positions at 40 s"),
        ([*ROWS, "50,nan,11,1500"], 7, "latitude_deg is empty or not a number (NaN)"),
        ([*ROWS, "50,47.05,,1500"], 7, "longitude_deg is empty or not a number (NaN)"),
        ([*ROWS, "50,47.05,11,inf"], 7, "height_m is infinite"),
        ([*ROWS, "50,48.05,11,1500"], 7, "jump of 112433 m in 10 s, 11243 m/s (up to 400 m/s)"),
        ([*ROWS, "50,47.05,11,9500"], 7, "jump of +8000 m in height in 10 s"),
        ([*ROWS, "50,49000,11,1500"], 7, "latitude_deg is 49000, which cannot be (-90 to 90; are latitude and longitude swapped?)"),
        ([*ROWS, "50,47.05,11,49000"], 7, "height_m is 49000, which cannot be"),
        ([*ROWS, "50,47.05,11"], 7, "3 cells under 4 columns"),
        ([*ROWS, "50,47.05,11,high"], 7, "height_m is 'high', no number"),
        ([*ROWS, "50,47,05,11,1500"], 7, "5 cells under 4 columns (cells parted by commas, decimal points)"),
    ],
)  # fmt: skip
def test_bad_rows_are_named_with_their_line(tmp_path: Path, rows: list[str], line: int, said: str) -> None:
    error = refused(file_of(tmp_path, *rows))
    assert error.where.endswith(f"flight.csv:{line}")
    assert said in str(error)


def test_a_spike_of_a_second_is_a_jump(tmp_path: Path) -> None:
    columns = columns_of(race_track(rate=1.0))
    columns["latitude_deg"][50] += 0.002  # 222 m at 1 Hz: 220 m/s more, and the other way round a second later
    error = refused(write_csv(tmp_path / "flight.csv", columns))
    assert "the velocity changes by" in str(error)
    assert error.where.endswith((":51", ":52"))


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("t_s,lat,longitude_deg,height_m", "no column latitude_deg (there are t_s, lat, longitude_deg, height_m; is lat a latitude_deg?)"),
        ("timestamp,latitude_deg,longitude_deg,height_m", "no column t_s or time_utc (there are timestamp"),
        ("t_s,latitude_deg,longitude_deg,altitude_km", "no column height_m or"),
        ("t_s,latitude_deg,longitude_deg,height_km", "column 'height_km' has the unknown unit 'km' (height_m)"),
        ("t_s,latitude_deg,longitude_deg,height", "column 'height' does not say its unit (height_m)"),
        ("t_s,latitude_deg,longitude_deg,barometric_altitude_fl", "has the unknown unit 'fl' (barometric_altitude_m or barometric_altitude_ft)"),
        ("t_s,latitude_deg,latitude_deg,height_m", "column 'latitude_deg' stands twice"),
        ("t_s;latitude_deg;longitude_deg;height_m", "semicolons between the columns"),
    ],
)  # fmt: skip
def test_bad_columns_are_named(tmp_path: Path, head: str, said: str) -> None:
    error = refused(file_of(tmp_path, *ROWS, head=head))
    assert error.where.endswith("flight.csv:1")
    assert said in str(error)


def test_two_heights_are_one_too_many(tmp_path: Path) -> None:
    rows = [f"{row},4900" for row in ROWS]
    assert "say the same" in str(refused(file_of(tmp_path, *rows, head=f"{HEAD},barometric_altitude_ft")))


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "the trajectory file is empty"),
        (b"\n\n", "the trajectory file is empty"),
        (b"\x89PNG\x00\x01\xff", "is no text file"),
        (HEAD.encode(), "a trajectory of no points (4 and more)"),
        (f"{HEAD}\n{ROWS[0]}\n".encode(), "a trajectory of one point (4 and more)"),
    ],
)  # fmt: skip
def test_files_that_are_none(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "flight.csv"
    path.write_bytes(content)
    assert said in str(refused(path))


def test_a_parquet_file_that_is_none(tmp_path: Path) -> None:
    path = tmp_path / "flight.parquet"
    path.write_text("t_s\n")
    assert "cannot be read as Parquet" in str(refused(path))
    assert f"no trajectory file {tmp_path / 'none.csv'}" in str(refused(tmp_path / "none.csv"))


def test_swapped_coordinates_are_seen_in_the_track(tmp_path: Path) -> None:
    track = race_track(rate=0.2)
    columns = columns_of(track) | {"track_deg": np.degrees(np.arctan2(track.vel_n[:, 1], track.vel_n[:, 0])) % 360}
    # north and east of a course of 0 or 180 deg are swapped: tracks of 90 and 270 deg
    columns["latitude_deg"], columns["longitude_deg"] = columns["longitude_deg"], columns["latitude_deg"]
    assert "latitude and longitude not swapped" in str(refused(write_csv(tmp_path / "flight.csv", columns)))


@pytest.mark.parametrize(
    ("name", "factor", "said"),
    [
        ("groundspeed_kt", 1.0, "groundspeed_kt is 30.9 m/s where the positions make 60 m/s, 0.514 times as much: are its numbers in m/s?"),
        ("groundspeed_m_s", 3600.0 / 1852.0, "1.94 times as much: are its numbers in kt?"),
        ("groundspeed_m_s", 3.6, "3.6 times as much: are its numbers in km/h?"),
        ("groundspeed_kt", 3.6, "are its numbers in km/h?"),
        ("groundspeed_m_s", 1.3, "1.3 times as much (the velocity"),
    ],
)  # fmt: skip
def test_ground_speeds_of_another_unit_are_refused(tmp_path: Path, name: str, factor: float, said: str) -> None:
    columns = columns_of(race_track(rate=0.2))
    columns[name] = np.full_like(columns["t_s"], 60.0 * factor)
    assert said in str(refused(write_csv(tmp_path / "flight.csv", columns)))


@pytest.mark.parametrize(
    ("name", "factor", "said"),
    [
        ("vertical_rate_ftpmin", 1.0, "0.00508 times as much: are its numbers in m/s?"),
        ("vertical_rate_m_s", -1.0, "-1 times as much: is it positive downwards?"),
        ("vertical_rate_m_s", 3.28084, "3.28 times as much: are its numbers in ft/s?"),
        ("vertical_rate_m_s", 1.0, ""),
    ],
)  # fmt: skip
def test_vertical_rates_that_are_none_are_refused(tmp_path: Path, name: str, factor: float, said: str) -> None:
    columns = columns_of(race_track(rate=0.2))
    # Up at 5 m/s and down again: whatever the way.
    t = columns["t_s"]
    half = t < t[-1] / 2.0
    columns["height_m"] = 1500.0 + 5.0 * np.minimum(t, t[-1] - t)
    columns[name] = np.where(half, 5.0, -5.0) * factor
    path = write_csv(tmp_path / "flight.csv", columns)
    if said:
        assert said in str(refused(path))
    else:
        read_trajectory(path)


def test_velocities_a_little_off_stay(tmp_path: Path) -> None:
    # A tenth too fast, stamps seconds late, a receiver's whole numbers: no other unit.
    columns = columns_of(race_track(rate=0.2))
    rng = np.random.default_rng(1)
    columns["t_s"] = columns["t_s"] + rng.uniform(0.0, 2.0, len(columns["t_s"]))
    columns["groundspeed_kt"] = np.round(1.1 * 60.0 * 3600.0 / 1852.0 + rng.normal(0.0, 3.0, len(columns["t_s"])))
    assert np.isfinite(trajectory(tmp_path, columns).speed).all()


def test_orthometric_heights_need_a_geoid(tmp_path: Path) -> None:
    path = file_of(tmp_path, *ROWS, head=HEAD.replace("height_m", "orthometric_height_m"))
    assert "refer to a geoid" in str(refused(path))
    found = read_trajectory(path, undulation=lambda lat, lon: 40.0 + 0.0 * lat)
    assert found.height == pytest.approx(1540.0)


@given(
    step=st.sampled_from([1.0, 5.0, 25.0, 100.0, 0.5]),
    seed=st.integers(0, 50),
)
@settings(max_examples=25, deadline=None)
def test_quantisation_is_found(step: float, seed: int) -> None:
    """Height of a climb and a cruise, rounded."""
    rng = np.random.default_rng(seed)
    value = np.cumsum(rng.normal(0.0, 40.0 * step / 25.0, 400)) + 3000.0
    rounded = np.round(value / step) * step
    # of a walk with steps of 1.6 quanta a fifth of all changes is one quantum
    assert step_of(rounded) == pytest.approx(step)


def test_a_continuous_column_has_its_decimals() -> None:
    value = np.round(np.cumsum(np.random.default_rng(1).normal(0.0, 3.0, 500)), 3)
    assert step_of(value) == pytest.approx(0.001)
    assert step_of(np.full(10, 5.0)) == 0.0
    assert step_of(np.arange(0.0, 1000.0, 10.0), decimal=True) == 1.0


def trajectory(tmp_path: Path, columns: dict[str, np.ndarray]) -> Trajectory:
    return read_trajectory(write_csv(tmp_path / "flight.csv", columns))


def test_a_long_gap_breaks_the_flight_and_a_short_one_does_not(tmp_path: Path) -> None:
    columns = columns_of(race_track(rate=0.2))
    t = columns["t_s"]
    keep = ~((t > 20.0) & (t < 80.0))  # on the straight: the speed across it agrees
    found = trajectory(tmp_path, {name: values[keep] for name, values in columns.items()})
    assert len(flown_pieces(found, 120.0)[0]) == 1
    pieces, notes = flown_pieces(found, 30.0)
    assert [len(piece) for piece in pieces] == [len(t[t > 75.0])]  # the first 5 points are too few to fly
    assert "gap of 60 s before" in notes[0]


def test_a_gap_that_hides_a_turn_breaks_the_flight(tmp_path: Path) -> None:
    columns = columns_of(race_track(rate=0.5))
    t = columns["t_s"]
    keep = ~((t > 92.0) & (t < 170.0))  # the half circle: 63 s, seen as a speed of 30 instead of 60 m/s
    found = trajectory(tmp_path, {name: values[keep] for name, values in columns.items()})
    pieces, notes = flown_pieces(found, 120.0)
    assert len(pieces) == 2
    assert "does not fit the speed beside it" in notes[0]


def test_parts_on_the_ground_are_left_out(tmp_path: Path) -> None:
    track = race_track(rate=0.2)
    stand = 30
    columns = {
        name: np.concatenate([np.full(stand, values[0]), values]) for name, values in columns_of(track).items()
    }
    columns["t_s"][:stand] = np.arange(-stand, 0) * 5.0
    columns["groundspeed_kt"] = np.concatenate([np.zeros(stand), np.full(len(track.t), 116.6)])
    pieces, notes = flown_pieces(trajectory(tmp_path, columns), 120.0)
    assert len(pieces) == 1
    assert pieces[0].t[0] == pytest.approx(0.0, abs=10.0)
    assert any("on the ground" in note for note in notes)
    columns = {name: values[:stand] for name, values in columns.items()}
    columns["t_s"] = columns["t_s"] + 0.0
    with pytest.raises(InputError, match="nothing of it is flown"):
        flown_pieces(trajectory(tmp_path, columns), 120.0)


def test_carried_to_another_place_it_keeps_its_shape_and_azimuths(tmp_path: Path) -> None:
    track = race_track(rate=0.5)
    azimuth = np.degrees(np.arctan2(track.vel_n[:, 1], track.vel_n[:, 0])) % 360.0
    columns = columns_of(track) | {"track_deg": azimuth, "heading_deg": azimuth}
    found = trajectory(tmp_path, columns)
    to = (math.radians(-33.0), math.radians(151.0))
    there = moved(found, (found.lat[0], found.lon[0]), to)
    assert (there.lat[0], there.lon[0]) == pytest.approx(to, abs=1e-12)
    assert there.height == pytest.approx(found.height)
    # distances of all points from one another, in space
    for k in (0, len(found) // 2):
        here, new = (ecef_from_geodetic(p.lat, p.lon, p.height) for p in (found, there))
        # heights are kept: over 6 km the Earth's curvature differs by d^2/2 (1/R1 - 1/R2) < 3 cm
        assert np.linalg.norm(new - new[k], axis=1) == pytest.approx(
            np.linalg.norm(here - here[k], axis=1), abs=0.03
        )
    # azimuths turn with the meridians' convergence, so they still are those of the way
    north = np.diff(there.lat) * WGS84_A
    east = np.diff(there.lon) * WGS84_A * np.cos(there.lat[:-1])
    # 2.4 km to the east they have turned by 2.4/6371 (tan 47 + tan 33) = 6e-4 rad against the old place
    for straight in (slice(0, 40), slice(-40, -1)):
        way = np.arctan2(east, north)[straight]
        assert wrap_pi(way - there.track[:-1][straight]) == pytest.approx(0.0, abs=2e-4)
    assert there.heading is not None
    assert wrap_pi(there.heading - there.track) == pytest.approx(0.0, abs=1e-9)
    assert there.track[0] == pytest.approx(found.track[0], abs=1e-9)
