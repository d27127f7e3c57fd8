"""The table of docs/modes.md: made of sweeps, put between its marks; what the sweeps that make it say."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aerosim.scenario import with_overrides
from aerosim.scenario.build.journey import journey_of
from aerosim.scenario.build.land import terrain_of
from aerosim.sweep.order import flight_order
from aerosim.sweep.spec import SweepSpec
from aerosim.sweep.specfile import load_sweep, shipped_sweeps, sweep_text
from aerosim.sweep.table import runs_table, write_table
from aerosim.sweep.work import Result, scenario_of

ROOT = Path(__file__).parents[2]
SIGMAS = (0, 0.35, 0.7, 1.4, 2.88)
SLOW = "air.slow_wind.sigma_m_s"


@pytest.fixture(scope="module")
def script() -> Any:
    found = importlib.util.spec_from_file_location("modes_table", ROOT / "docs" / "modes_table.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


@cache
def specs() -> dict[str, SweepSpec]:
    files = shipped_sweeps()
    names = {name: files[name] for name in ("modes", "modes_relief")}
    return {
        name: load_sweep(file)
        for name, file in {**names, "modes_real": ROOT / "benchmarks" / "modes_real.yaml"}.items()
    }


def crab(values: Mapping[str, Any]) -> float:
    """Made up: 0.05 deg and a tenth of the turbulence with imu, which is too much at 2.88 m/s only for others."""
    by = {"imu": 0.05, "bank": 0.1, "gyro": 0.12, "none": 0.4}.get(values.get("estimation.aiding"), 1.0)
    return float(by * (1.0 + 3.5 * values["air.turbulence.sigma_m_s"] / 2.88))


def made(folder: Path, spec: SweepSpec, seeds: int = 3, crab: Any = crab) -> Path:
    """A sweep directory with made-up figures: seeds differ by a tenth, pipelined loses its lock once."""
    results = []
    for point in spec.points:
        for seed in range(1, seeds + 1):
            lost = point.values["control.mode"] == "pipelined" and point.number % 5 == 4 and seed == 2
            few = 49.0 if point.number in (0, 84) and seed == 1 else 90.0
            summary = {
                "crab.residual_rms_deg": crab(point.values) * (1.0 + 0.1 * (seed - 2)),
                "crab.accepted_pct": few, "crab.bad_pct": 1.0, "crab.silent_end_s": 99.0 if lost else 2.0,
                "vh.error_rms_pct": 0.5, "photos.end_lap_error_rms_pct": 0.25,
            }  # fmt: skip
            name = f"{point.number}-{seed}"
            results.append(Result(name, point.number, seed, "done", "", point.values, summary))
    folder.mkdir()
    (folder / "sweep.yaml").write_text(sweep_text(spec), encoding="utf-8")
    (folder / "summary.json").write_text(json.dumps({"failed": 0}))
    write_table(folder / "runs.parquet", runs_table(results, list(spec.vary)))
    return folder


def test_tables_between_their_marks(script: Any, tmp_path: Path) -> None:
    found = specs()
    page = tmp_path / "page.md"
    page.write_text(
        "<!-- modes -->\nold\n<!-- end of modes -->\nkept\n<!-- modes_relief -->\n<!-- end of modes_relief -->\n"
    )
    sweeps = [made(tmp_path / name, found[name]) for name in ("modes", "modes_relief")]
    script.main([*map(str, sweeps), "--page", str(page)])
    text = page.read_text()
    assert "old" not in text
    assert "\nkept\n<!-- modes_relief -->\n3 seeds" in text
    # Student's t of two degrees 4.303 by a spread of a tenth over sqrt(3) is 0.248 of the mean
    imu = "0.050 ± 0.012 | 0.071 ± 0.018 | 0.093 ± 0.023 | 0.135 ± 0.034 | 0.225 ± 0.056"
    assert f"\n| best, imu | {imu} |\n" in text
    # 0.4 (1 + 3.5 sigma / 2.88): asked are 0.5, 0.75, 1, 1.7, 3.2; gyro is above 0.45 at 2.88 of 1.0 nowhere
    assert "\n| best, none | 0.400 ± 0.099 | 0.57 ± 0.14 | 0.74 ± 0.18 | 1.08 ± 0.27 | 1.80 ± 0.45 |\n" in text
    assert "\n| *asked of best, gyro and best, bank* | 0.15 | 0.2 | 0.25 | 0.45 | 1 |\n" in text
    # end lap 0.25 is more than 0.1 and 0.15, less than 0.3
    assert text.count("\n| best, imu | **0.250** | **0.250** | **0.250** | **0.250** | 0.250 |\n") == 2
    # point 0 is fixed, which uses no strips, point 84 best with bank;
    # of 2 winds x 5 strengths the point numbers of pipelined are 30 to 39: 34 and 39 lose it in seed 2
    rule = "no accepted strip in the last 30 s, or fewer than 50 % accepted"
    assert f"Lock lost ({rule}): pipelined 2 of 30, best, bank 1 of 30 runs; of all others, none." in text
    assert "`best` leaves less crab than `pipelined` at every point." in text
    assert "Half widths, median and widest: crab residual 24.8 and 24.8 % (100 of 100 above 5 %)" in text
    relief = text[text.index("<!-- modes_relief -->") :]
    assert "asked" not in relief
    assert "**0.250" not in relief
    assert (tmp_path / "images" / "modes.png").stat().st_size > 5000
    assert script.main([str(sweeps[0]), "--page", str(page)]) is None
    assert page.read_text() == text  # again: the same


def test_where_best_is_worse_than_pipelined_is_told(script: Any, tmp_path: Path) -> None:
    worse = {"estimation.aiding": "none", "air.turbulence.sigma_m_s": 1.4, SLOW: 4.45}

    def other(values: Mapping[str, Any]) -> float:
        return 3.0 if worse.items() <= values.items() else crab(values)

    sweep = script.open_sweep(made(tmp_path / "modes", specs()["modes"], crab=other))
    told = 3.0 - 1.0 * (1.0 + 3.5 * 1.4 / 2.88)
    wanted = f"Worse than `pipelined`: best, none at 1.4 m/s in slow wind of 4.45 m/s by {told:.3f} deg."
    assert script.against_pipelined(sweep) == [wanted]
    assert "| **3.00 ± 0.75** |" in "\n".join(script.table(sweep, script.METRICS[0], 4.45))


def test_a_page_without_a_place_is_refused(script: Any, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("nothing\n")
    sweep = made(tmp_path / "modes", specs()["modes"])
    with pytest.raises(SystemExit, match=r"page.md: has no place for modes \(<!-- modes --> and"):
        script.main([str(sweep), "--page", str(page)])
    with pytest.raises(SystemExit, match="is no finished sweep"):
        script.main([str(tmp_path), "--page", str(page)])
    assert page.read_text() == "nothing\n"


def test_the_page_has_a_place_for_each_sweep(script: Any) -> None:
    page = (ROOT / "docs" / "modes.md").read_text(encoding="utf-8")
    for name, spec in specs().items():
        assert spec.scenario.name == name
        assert script.replaced(page, name, "x", "page") != page


def test_the_sweeps_fly_what_the_page_says() -> None:
    found = specs()
    sizes = {name: len(spec.points) for name, spec in found.items()}
    assert sizes == {"modes": 100, "modes_relief": 21, "modes_real": 60}
    for spec in found.values():
        slow, flight = spec.scenario.air.slow_wind, spec.scenario.flight
        for sigma, walk in zip(spec.vary.get(SLOW, (slow.sigma_m_s,)), (0.0225, 0.225), strict=False):
            b2 = 2.0 * np.degrees(sigma / flight.airspeed_m_s) ** 2 / slow.time_constant_s
            assert b2 == pytest.approx(walk, rel=0.01)
        assert spec.scenario.air.wind.speed_m_s == 10.0
        best = next(t for t in spec.tasks(Path()) if t.parameters.get("estimation.aiding") == "imu")
        assert scenario_of(best).navigation.imu.level_error_deg == 0.1
        route = spec.scenario.flight.lines[0]
        assert np.hypot(
            111.2e3 * (route.end_deg[0] - route.start_deg[0]),
            111.2e3 * (route.end_deg[1] - route.start_deg[1]) * np.cos(np.radians(route.start_deg[0])),
        ) == pytest.approx(23.3e3, rel=0.005)
    assert found["modes"].vary["air.turbulence.sigma_m_s"] == SIGMAS
    # ten flights a seed serve all hundred points
    order, shared = flight_order(found["modes"])
    first = [(point.values[SLOW], point.values["air.turbulence.sigma_m_s"]) for _, point in list(order)[:10]]
    assert shared
    assert len(set(first)) == 10


@pytest.mark.slow
def test_drift_walks_as_the_page_says() -> None:
    """Structure function of the drift at 13 s, of eight flights without turbulence, in the stronger slow wind.

    Less the curvature of the exponential it is b2, 10 % less as the nose follows a second late (measured 0.203
    +- 0.010): within four of these standard errors.
    """
    base = specs()["modes"].scenario
    terrain, found = terrain_of(base), []
    for seed in range(1, 9):
        flight = journey_of(with_overrides(base, {SLOW: 4.45, "seed": seed}), terrain).flight
        drift = []
        while not flight.done:
            flight.advance(12)  # 0.1 s
            state = flight.state()
            if flight.line >= 0:
                drift.append(np.arctan2(state.v_east, state.v_north) - state.heading)
        steps = np.degrees(np.unwrap(drift)[130:] - np.unwrap(drift)[:-130])
        found.append(np.mean(steps**2) / (120.0 * (1.0 - np.exp(-13.0 / 120.0))))
    assert np.mean(found) == pytest.approx(0.203, abs=0.04)
