from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from flights import scenario

from aerosim.report.source import Source
from aerosim.report.words import how_flown


def words(**sections: Any) -> str:
    """What is said of a run of two lines."""
    stub = SimpleNamespace(scenario=scenario(4.0, **sections), lines={}, count=lambda _: 2)
    return how_flown(cast("Source", stub))


def test_a_flight_tells_its_height_aircraft_and_air() -> None:
    found = words(
        aircraft={"model": "beaver"},
        flight={"airspeed_m_s": 55, "pilot": "navigator"},
        air={"wind": {"speed_m_s": 7, "from_deg": 20}, "turbulence": {"sigma_m_s": 0.7}},
    )
    assert found.startswith("2 lines at 3000 m above the mean terrain, 55 m/s true, by beaver, steered by word of")
    assert "wind 7 m/s from 20 deg, turbulence 0.7 m/s (sigma, dryden); camera 152 mm, 230 x 230 mm;" in found


def test_air_by_rules_and_by_height() -> None:
    found = words(
        air={
            "wind": {"profile": [{"height_m": 0, "speed_m_s": 1, "from_deg": 0}]},
            "slow_wind": {"model": "mesoscale"},
            "turbulence": {"model": "mil_f_8785c", "severity": "moderate"},
            "thermal_field": {"spacing_m": 2000},
        }
    )
    assert "wind by height, mesoscale wind (2.8 m/s over 100 km), turbulence by MIL-F-8785C, moderate" in found
    assert "thermals" in found


def test_a_replay_tells_its_file_and_no_planned_height() -> None:
    found = words(flight={"replay": "flown/today.csv"})
    assert found.startswith("2 lines of the trajectory today.csv; wind 0 m/s from 0 deg;")


def test_declared_faults_are_named() -> None:
    assert words().endswith("; mode pipelined.")
    mount = {"faults": {"encoder_bias_deg": 1.0}}
    both = words(mount=mount, ccd_rows={"faults": {"dead_px": [3]}})
    assert both.endswith("; mode pipelined; faults declared of the rows and the mount.")
    assert words(mount=mount).endswith("; mode pipelined; faults declared of the mount.")
