"""Short flights over the terrain that ships, for the tests of the loop and of the run directory."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerosim.record import Record
from aerosim.scenario import Scenario, from_mapping

WEST, NORTH = -84.38, 36.52
KM_PER_DEG = 89.6  # of longitude, at this latitude


def scenario(km: float = 10.0, back: bool = False, **sections: dict[str, Any]) -> Scenario:
    """One line east of `km`, and one back west if wanted; calm, without pictures, unless a section says else."""
    east = WEST + km / KM_PER_DEG
    lines = [{"start_deg": [NORTH, WEST], "end_deg": [NORTH, east]}]
    if back:
        lines.append({"start_deg": [NORTH + 0.02, east], "end_deg": [NORTH + 0.02, WEST]})
    data: dict[str, Any] = {
        "name": "short",
        "terrain": {"source": "pine_mountain"},
        "flight": {"lines": lines, "run_in_s": 20},
        "record": {"exclude_first_s": 20, "rrd": False, "report": False},
    }
    for key, values in sections.items():
        data[key] = {**data.get(key, {}), **values}
    return from_mapping(data)


def air(speed: float, from_deg: float, slow: float = 0.0, turbulence: float = 0.0) -> dict[str, Any]:
    """Section `air`: wind (m/s, deg), standard deviations of slow wind and turbulence (m/s)."""
    return {
        "wind": {"speed_m_s": speed, "from_deg": from_deg},
        "slow_wind": {"sigma_m_s": slow},
        "turbulence": {"sigma_m_s": turbulence},
    }


def on_line(record: Record, name: str, line: int = 0, after: float = 0.0) -> NDArray[Any]:
    """A column of the telemetry on one line, without its first `after` seconds."""
    tel = record.telemetry
    here = tel["line"] == line
    return np.asarray(tel[name][here & (tel["t_s"] >= tel["t_s"][here][0] + after)])


def rms(values: NDArray[Any]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
