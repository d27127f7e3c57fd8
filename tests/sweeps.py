"""What the tests of sweeps share: a run of a third of a second, and tables without wall times."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flights import scenario

from aerosim.scenario import Scenario, to_yaml
from aerosim.sweep.spec import SweepSpec, make_spec
from aerosim.sweep.vary import varied

WALL = ("wall_s", "speed.wall_s", "speed.fdm_wall_s", "speed.real_time_factor")
WIND = "air.wind.speed_m_s"
MODES = {WIND: [0, 6], "control.mode": ["fixed", "pipelined"]}


def tiny(**sections: Mapping[str, Any]) -> Scenario:
    """One line of 1.2 km in turbulence: 20 s of flight."""
    data: dict[str, Any] = {
        "flight": {"run_in_s": 5},
        "record": {"exclude_first_s": 1},
        "air": {"turbulence": {"sigma_m_s": 0.5}},
    }
    return scenario(1.2, **{**data, **{key: {**data.get(key, {}), **each} for key, each in sections.items()}})


def tiny_file(folder: Path, **sections: Mapping[str, Any]) -> Path:
    file = folder / "tiny.yaml"
    file.write_text(to_yaml(tiny(**sections)), encoding="utf-8")
    return file


def spec(vary: Mapping[str, Any] = MODES, base: Scenario | None = None, **settings: Any) -> SweepSpec:
    return make_spec(base or tiny(), {key: varied(each) for key, each in vary.items()}, **settings)


def same(one: Any, other: Any) -> bool:
    """Whether two tables are equal bit for bit, names, types and metadata too, wall times aside."""
    one, other = (
        table.drop_columns([name for name in WALL if name in table.column_names]) for table in (one, other)
    )
    return bool(one.equals(other, check_metadata=True)) and bytes_of(one) == bytes_of(other)


def bytes_of(table: Any) -> bytes:
    """The table as a stream: NaN and -0.0 count too."""
    import pyarrow as pa

    sink = pa.BufferOutputStream()
    with pa.ipc.new_stream(sink, table.schema) as writer:
        writer.write_table(table.combine_chunks())
    return bytes(sink.getvalue())


def files(out: Path) -> dict[str, tuple[int, int]]:
    """When the runs' files were written, and which they are: a run done twice shows."""
    return {file.name: (file.stat().st_mtime_ns, file.stat().st_ino) for file in (out / "runs").glob("[!.]*.json")}
