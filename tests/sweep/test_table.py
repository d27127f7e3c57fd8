"""runs.parquet: the same whatever order runs end in, typed, with units; written whole."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sweeps import bytes_of

from aerosim.errors import InputError
from aerosim.sweep import table as tables
from aerosim.sweep.table import metrics_of, parameters_of, read_table, runs_table, write_table
from aerosim.sweep.work import Result


def result(point: int, seed: int, status: str = "done", **summary: Any) -> Result:
    figures = {name.replace("__", "."): value for name, value in summary.items()}
    parameters = {"air.wind.speed_m_s": 2.5 * point, "control.mode": "fixed"}
    return Result(
        f"id{point}-{seed}", point, seed, status, "" if status == "done" else "lost", parameters, figures, 0.5
    )


KEYS = ["air.wind.speed_m_s", "control.mode"]
RUNS = [
    result(0, 1, crab__residual_rms_deg=0.25, photos__count=3, photos__end_lap_mean_pct=None),
    result(0, 2, status="failed"),
    result(1, 1, crab__residual_rms_deg=1.5, photos__count=4, photos__end_lap_mean_pct=None),
    result(1, 2, crab__residual_rms_deg=2, photos__count=5, photos__end_lap_mean_pct=None),
]


def test_one_row_per_point_and_seed_whatever_the_order() -> None:
    wanted = runs_table(RUNS, KEYS)
    for seed in range(5):
        mixed = random.Random(seed).sample(RUNS, len(RUNS))
        assert bytes_of(runs_table(mixed, KEYS)) == bytes_of(wanted)
    rows = wanted.to_pylist()
    assert [(row["point"], row["seed"]) for row in rows] == [(0, 1), (0, 2), (1, 1), (1, 2)]
    assert [row["status"] for row in rows] == ["done", "failed", "done", "done"]
    assert (
        rows[1] | {"reason": "lost", "wall_s": 0.5, "crab.residual_rms_deg": None, "photos.count": None} == rows[1]
    )


def test_columns_are_typed_and_carry_unit_and_role() -> None:
    table = runs_table(RUNS, KEYS)
    types = {field.name: field.type for field in table.schema}
    assert types["crab.residual_rms_deg"] == pa.float64()  # one whole number among them
    assert types["photos.count"] == pa.int64()
    assert types["photos.end_lap_mean_pct"] == pa.float64()  # never measured
    assert types["control.mode"] == pa.string()
    assert table.schema.field("crab.residual_rms_deg").metadata[b"unit"] == b"deg"
    assert table.schema.field("air.wind.speed_m_s").metadata[b"unit"] == b"m/s"
    assert parameters_of(table) == KEYS
    assert metrics_of(table) == ["crab.residual_rms_deg", "photos.count", "photos.end_lap_mean_pct"]


@given(
    st.lists(st.one_of(st.none(), st.booleans(), st.integers(-9, 9), st.text(max_size=3), st.lists(st.integers())))
)
def test_any_mixture_of_values_has_a_column(values: list[Any]) -> None:
    runs = [Result(str(k), k, 1, "done", "", {"key": value}) for k, value in enumerate(values)]
    found = runs_table(runs, ["key"])["key"].to_pylist()
    assert [value is None for value in found] == [value is None for value in values]
    assert len({type(value) for value in found if value is not None}) <= 1


def test_a_figure_named_as_a_varied_key_stays_apart() -> None:
    run = Result("a", 0, 1, "done", "", {"flight.lines": [[1, 2]]}, {"flight.lines": 2})
    table = runs_table([run], ["flight.lines"])
    assert table["flight.lines"].to_pylist() == ["[[1, 2]]"]
    assert table["summary.flight.lines"].to_pylist() == [2]


def test_written_and_read_again(tmp_path: Path) -> None:
    table = runs_table(RUNS, KEYS)
    write_table(tmp_path / "runs.parquet", table)
    assert bytes_of(read_table(tmp_path / "runs.parquet")) == bytes_of(table)
    assert [file.name for file in tmp_path.iterdir()] == ["runs.parquet"]


def test_a_full_disk_leaves_the_old_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import pyarrow.parquet as pq

    write_table(tmp_path / "runs.parquet", runs_table(RUNS[:1], KEYS))

    def full(_table: Any, file: Path, **_: Any) -> None:
        file.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(pq, "write_table", full)
    with pytest.raises(OSError, match="No space"):
        write_table(tmp_path / "runs.parquet", runs_table(RUNS, KEYS))
    assert tables.read_table(tmp_path / "runs.parquet").num_rows == 1
    assert [file.name for file in tmp_path.iterdir()] == ["runs.parquet"]


def test_no_table_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_table(tmp_path / "runs.parquet")
    (tmp_path / "runs.parquet").write_text("nothing")
    with pytest.raises(InputError, match="cannot be read"):
        read_table(tmp_path / "runs.parquet")
