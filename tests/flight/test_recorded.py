"""A flight from its recording is the same to the last bit, whatever camera looks at it, and ends alike."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flights import air, scenario
from flown_paths import columns_of, race_track, write_csv
from kept_flights import MadeUp, Memory, sortie

from aerosim.errors import RunFailure
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.interface import fresh, patience
from aerosim.flight.recorded import BLOCK, LATE_S, TAIL_S, RecordedFlight, record
from aerosim.flight.recording import from_bytes, pack, to_bytes, unpack
from aerosim.record import Record
from aerosim.scenario import from_mapping, with_overrides
from aerosim.scenario.build import build
from aerosim.scenario.ccd_rows import CcdRows
from aerosim.simulate import WATCH_S, simulate

CAMERAS: list[dict[str, Any]] = [
    {"control.mode": "pipelined"},
    {"control.mode": "fixed", "record.period_s": 0.1},
    {"control.mode": "schmelovsky_1988", "ccd_rows.period_s": 7 / 120},
    {"control.mode": "ideal", "frame_camera.shutter_delay_s": 1.3, "record.period_s": 1 / 120},
    {"mount.time_constant_s": 0.5, "mount.encoder_sigma_deg": 0.5, "ccd_rows.focal_px": 200},
    {"control.end_lap_pct": 80, "frame_camera.min_interval_s": 1, "record.period_s": 11 / 120},
]


def same(one: Record, other: Record) -> bool:
    """Equal telemetry, strips and photos, bit for bit."""
    assert (one.status, one.reason) == (other.status, other.reason)
    assert one.summary["telemetry_sha256"] == other.summary["telemetry_sha256"]
    for name in ("matches", "photos", "lines"):
        for key, column in getattr(one, name).items():
            np.testing.assert_array_equal(column, getattr(other, name)[key], err_msg=f"{name}.{key}")
    return True


@pytest.mark.parametrize(
    "sections",
    [
        {"air": air(8.0, 20.0, slow=1.0, turbulence=1.0)},
        {"air": air(5.0, 300.0, slow=0.5, turbulence=0.5), "flight": {"pilot": "navigator"}},
        pytest.param(
            {"air": {"thermal_field": {"spacing_m": 3000}}, "aircraft": {"model": "beech_99"},
             "flight": {"airspeed_m_s": 80.0}}, marks=pytest.mark.slow,
        ),
    ],
    ids=["turbulence", "navigator", "thermals"],
)  # fmt: skip
def test_one_flight_serves_every_camera(sections: dict[str, Any]) -> None:
    base, kept = scenario(2.5, back=True, **sections), Memory()
    for changes in CAMERAS if "pilot" not in sections.get("flight", {}) else CAMERAS[:3]:
        wanted = with_overrides(base, changes)
        assert same(simulate(wanted, flights=kept), simulate(wanted))
    assert kept.flown == 1


def replay(folder: Path) -> Any:
    """Two lines of a race track, carried to the land that ships."""
    file = write_csv(folder / "flight.csv", columns_of(race_track(rate=1.0)))
    part = {"file": str(file), "move_to_deg": [36.49, -84.3], "height_offset_m": 1500.0, "line_min_m": 3000.0}
    return from_mapping({
        "name": "again",
        "terrain": {"source": "pine_mountain"},
        "flight": {"replay": part, "run_in_s": 20},
        "air": air(6.0, 90.0, slow=0.5, turbulence=0.5),
        "record": {"exclude_first_s": 5, "rrd": False, "report": False},
    })  # fmt: skip


def test_a_replay_serves_every_camera(tmp_path: Path) -> None:
    base, kept = replay(tmp_path), Memory()
    for changes in CAMERAS[1:4]:
        wanted = with_overrides(base, changes)
        assert same(simulate(wanted, flights=kept), simulate(wanted))
    assert kept.flown == 1


@pytest.mark.parametrize("rate", [120, 200])
def test_an_aircraft_that_is_lost_is_lost_at_the_same_step(rate: int) -> None:
    """At 200 Hz the air is held for 5 steps, of which the 24 between two looks at the aircraft are no multiple."""
    base = scenario(10.0, aircraft={"fuel_kg": 1.0, "step_rate_hz": rate}, air=air(5.0, 0.0, turbulence=0.5))
    kept, found = Memory(), []
    for period in (1 / rate, 0.05, 0.35):
        wanted = with_overrides(base, {"record.period_s": period})
        direct = simulate(wanted)
        assert direct.status == "failed"
        assert "fuel used up" in direct.reason
        assert same(simulate(wanted, flights=kept), direct)
        found.append(direct.reason)
    assert kept.flown == 1
    assert len(set(found)) == 1


def test_the_ground_is_hit_at_the_same_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The land ends a flight in the loop, not in the air: the recording goes on, the run does not."""
    import aerosim.scenario.build as parts

    made = parts.GroundView.around
    wall = 2600.0

    def around(self: Any, lat: float, lon: float, reach: float, t: float) -> Any:
        spot = made(self, lat, lon, reach, t)
        return spot._replace(relief=spot.relief + np.float32(wall if lon > math.radians(-84.35) else 0.0))

    monkeypatch.setattr(parts.GroundView, "around", around)
    wanted = scenario(6.0, flight={"height_m": 2500.0})
    direct = simulate(wanted)
    assert "hit the ground" in direct.reason
    assert same(simulate(wanted, flights=Memory()), direct)


def test_a_loss_between_two_looks_is_found_at_the_same_step(folder: Path) -> None:
    """However a flight is cut into parts."""
    reasons = []
    for part in (1, 5, 24, 37):
        twin = Aircraft(folder, 120.0)
        twin.start(0.64, -1.47, 3000.0, 1.5, 69.44)
        twin.advance(30)
        twin._set("inertia/pointmass-weight-lbs", 0.0)
        with pytest.raises(RunFailure) as caught:  # noqa: PT012
            for _ in range(100):
                twin.advance(part)
        reasons.append(str(caught.value))
    assert set(reasons) == {f"aircraft lost at {48 / 120:.2f} s: fuel used up"}


def looked_at(flight: Any, cuts: list[int]) -> list[Any]:
    seen = []
    for steps in cuts:
        flight.advance(steps)
        values = [*flight.state(), *flight.air, flight.cross_track]
        seen.append((np.array(values).tobytes(), flight.line, flight.next_line, flight.phase, flight.done))
    return seen


def test_any_bits_come_back_at_any_step() -> None:
    """NaN and infinities among them; over the borders of blocks, one step at a time and many at once."""
    steps = 2 * BLOCK + 2000
    cuts = np.random.default_rng(3).integers(1, 40, 500).tolist()
    assert sum(cuts) > BLOCK
    kept = from_bytes(to_bytes(record(MadeUp(1, steps, lost=steps - 5), sortie("x", 1e3))))
    assert len(kept.blocks) == 3
    again, direct = RecordedFlight(kept), MadeUp(1, steps, lost=steps - 5)
    assert again.state() is not again.state()
    assert looked_at(again, [*cuts, BLOCK - 300]) == looked_at(direct, [*cuts, BLOCK - 300])
    assert again.plan == direct.plan
    for flight in (again, direct):
        with pytest.raises(RunFailure, match=f"aircraft lost at step {steps - 5}"):
            flight.advance(steps)


@pytest.mark.parametrize("rows", [1, 2, 3, 1000])
def test_packing_loses_nothing(rows: int) -> None:
    bits = np.random.default_rng(rows).integers(-(2**63), 2**63 - 1, (rows, 4))
    table = bits.view(np.float64)
    table[0] = [-0.0, math.nan, -math.inf, 5e-324]
    assert unpack(pack(table), table.shape).tobytes() == np.ascontiguousarray(table).tobytes()


def test_smooth_columns_take_few_bytes() -> None:
    """A parabola in steps of its last bit has constant second differences: nothing is left to be stored."""
    bits = 1000 + 3 * np.arange(50_000) + 2 * np.arange(50_000) ** 2
    table = (bits + np.float64(1.0).view(np.int64)).view(np.float64)[:, None]
    assert len(pack(table)) < table.nbytes / 1000


def test_a_flight_is_kept_as_long_as_a_loop_may_look() -> None:
    """After the end a loop looks once in a period of the rows; before it, until it has no patience any more."""
    longest = next(each.le for each in CcdRows.model_fields["period_s"].metadata if hasattr(each, "le"))
    assert longest < TAIL_S
    rate, planned = 120.0, 10.0
    done = record(MadeUp(2, 60_000, done=500), sortie("done", planned))
    assert done.last >= 500 + longest * rate
    assert done.last < 500 + 12 * rate
    never = record(MadeUp(2, 60_000), sortie("never", planned))
    # given up when it is seen to be late: at a look after WATCH_S, which may be a period away, then moved on
    assert never.last >= (patience(planned) + WATCH_S + 2 * longest) * rate
    assert never.last <= (patience(planned) + LATE_S) * rate + 1


def test_no_camera_makes_it_longer() -> None:
    flight = RecordedFlight(record(MadeUp(2, 60_000, done=500), sortie("done", 10.0)))
    with pytest.raises(RuntimeError, match="recorded to step"):
        flight.advance(50_000)


def test_damage_anywhere_is_found() -> None:
    whole = to_bytes(record(MadeUp(4, 3000, lost=2000), sortie("x", 100.0)))
    assert from_bytes(whole).failure
    rng = np.random.default_rng(1)
    for place in [0, 20, len(whole) - 1, *rng.integers(0, len(whole), 40).tolist()]:
        broken = bytearray(whole)
        broken[place] ^= 1 << int(rng.integers(8))
        with pytest.raises(ValueError, match="not a whole recording"):
            from_bytes(bytes(broken))
    for length in (0, 10, 40, len(whole) // 2, len(whole) - 1):
        with pytest.raises(ValueError, match="not a whole recording"):
            from_bytes(whole[:length])


def test_it_is_small_and_cheaper_than_flying() -> None:
    """Two thirds of the numbers' 192 bytes a step, and a fifth of JSBSim's time: wide of what is measured."""
    kept = Memory()
    wanted = scenario(10.0, air=air(8.0, 20.0, slow=1.0, turbulence=1.0))
    build(wanted, kept)
    data = kept.only()
    assert data.size / data.last < 110.0
    direct, again = build(wanted, fresh).flight, RecordedFlight(data)

    def timed(flight: Any) -> float:
        started = time.process_time()
        for _ in range(data.last // 6):
            flight.advance(6)
            flight.state()
        return time.process_time() - started

    assert timed(again) < 0.2 * timed(direct)
