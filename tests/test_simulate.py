"""The loop, closed: wind triangle, crab, v/h, end lap, modes, and that the same run is the same."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from flights import air, on_line, rms, scenario
from numpy.typing import NDArray

import aerosim
from aerosim.record import Record, Run
from aerosim.scenario import Scenario
from aerosim.simulate import simulate

GUSTY = air(10.0, 0.0, slow=0.5, turbulence=0.35)
SPACING, FOCAL, PERIOD = 39.7, 132.6, 0.05  # px, px, s: the camera of 1988, the default
FLIGHT = [
    "t_s",
    "lat_deg",
    "lon_deg",
    "height_m",
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
    "drift_true_deg",
    "line",
    "cross_track_m",
]


def triangle(tel: dict[str, NDArray[Any]]) -> float:
    """Drift (deg) of an aircraft that holds its track in the recorded mean wind; wind from the left is positive.

    Of the wind's velocity only the part across the track, positive to the right, has to be headed off.
    """
    track = np.radians(tel["track_deg"])
    across = -np.sin(track) * tel["wind_north_m_s"] + np.cos(track) * tel["wind_east_m_s"]
    return float(np.degrees(np.arcsin(across.mean() / tel["airspeed_m_s"].mean())))


def telemetry(run: Run) -> dict[str, NDArray[Any]]:
    return {name: run.telemetry[name].to_numpy() for name in run.telemetry.column_names}


@pytest.mark.parametrize(("line", "sign"), [(0, 1.0), (1, -1.0)])
def test_drift_is_the_wind_triangle(crosswind: Run, line: int, sign: float) -> None:
    tel = telemetry(crosswind)
    here = tel["line"] == line
    tel = {name: column[here] for name, column in tel.items()}
    drift = float(tel["drift_true_deg"].mean())
    assert drift == pytest.approx(triangle(tel), abs=0.1)
    # nominal: asin(10/69.44) = 8.28 deg; slow wind of 0.5 m/s moves a line's mean by some tenths of a degree
    assert sign * drift == pytest.approx(8.28, abs=1.0)


def test_summary_tells_the_same_drift(crosswind: Run) -> None:
    tel = telemetry(crosswind)
    sizes = []
    for line in (0, 1):
        here = tel["line"] == line
        late = here & (tel["t_s"] >= tel["t_s"][here][0] + 60.0)
        sizes.append(abs(tel["drift_true_deg"][late].mean()))
    assert crosswind.summary["flight"]["drift_mean_deg"] == pytest.approx(np.mean(sizes), rel=1e-9)


def test_crab_is_turned_out(crosswind: Run) -> None:
    summary = crosswind.summary
    assert summary["crab"]["residual_rms_deg"] < summary["flight"]["drift_mean_deg"] / 4.0
    assert summary["crab"]["accepted_pct"] > 80.0
    tel = telemetry(crosswind)
    crab = tel["drift_true_deg"] - tel["mount_yaw_deg"]
    assert tel["crab_true_deg"] == pytest.approx(crab, abs=1e-9)


def test_end_lap_is_kept(crosswind: Run) -> None:
    assert crosswind.summary["photos"]["end_lap_mean_pct"] == pytest.approx(60.0, rel=0.015)


def test_accepted_n_is_the_closed_form(crosswind: Run) -> None:
    m = {name: crosswind.matches[name].to_numpy() for name in ("n", "n_true", "crab_true_deg", "vh_true_per_s")}
    good = crosswind.matches["accepted"].to_numpy()
    # (1): along the rows' axis the ground moves by d in n exposures
    closed = SPACING / (FOCAL * PERIOD * m["vh_true_per_s"] * np.cos(np.radians(m["crab_true_deg"])))
    assert good.sum() > 400
    assert np.median(m["n"][good] / closed[good]) == pytest.approx(1.0, abs=0.015)
    assert m["n_true"][good] == pytest.approx(closed[good], rel=1e-12)


def test_calm_leaves_the_instrument_alone() -> None:
    still = simulate(scenario(air=air(0.0, 0.0)))
    assert still.status == "done"
    assert abs(on_line(still, "drift_true_deg")).max() < 0.2
    assert rms(on_line(still, "crab_true_deg", after=20.0)) < 0.4
    for name in ("wind_north_m_s", "wind_east_m_s", "wind_down_m_s", "gust_u_m_s", "gust_v_m_s", "gust_w_m_s"):
        assert not still.telemetry[name].any(), name
    assert on_line(still, "airspeed_m_s").mean() == pytest.approx(69.44, abs=0.1)


@pytest.fixture(scope="module")
def from_north() -> Record:
    return simulate(scenario(air=air(10.0, 0.0)))


def test_wind_from_the_other_side_turns_all_signs(from_north: Record) -> None:
    from_south = simulate(scenario(air=air(10.0, 180.0)))
    nominal = np.degrees(np.arcsin(10.0 / 69.44))
    # flying east, north is left: wind from the left drifts to the right, and the camera turns right
    for record, sign in ((from_north, 1.0), (from_south, -1.0)):
        assert sign * on_line(record, "drift_true_deg").mean() == pytest.approx(nominal, abs=0.1)
        assert sign * on_line(record, "drift_est_deg", after=20.0).mean() == pytest.approx(nominal, abs=0.3)
        assert sign * on_line(record, "mount_yaw_deg", after=20.0).mean() == pytest.approx(nominal, abs=0.3)
        # the first strip was seen before the mount had turned: mu = d tan(drift) = 5.8 px to the right
        first = np.flatnonzero(record.matches["accepted"])[0]
        assert sign * record.matches["mu_px"][first] == pytest.approx(
            SPACING * np.tan(np.radians(nominal)), abs=1.0
        )


@pytest.mark.parametrize(("from_deg", "ground_speed"), [(90.0, 59.44), (270.0, 79.44)])
def test_wind_along_the_line_changes_only_the_speed(from_deg: float, ground_speed: float) -> None:
    record = simulate(scenario(air=air(10.0, from_deg)))
    assert abs(on_line(record, "drift_true_deg").mean()) < 0.05
    assert rms(on_line(record, "crab_true_deg", after=20.0)) < 0.4
    speed = np.hypot(on_line(record, "v_north_m_s"), on_line(record, "v_east_m_s"))
    assert speed.mean() == pytest.approx(ground_speed, abs=0.15)
    # 3000 m above the mean ground, whose relief along this line averages out to about a per cent
    assert np.median(on_line(record, "vh_true_per_s")) == pytest.approx(ground_speed / 3000.0, rel=0.04)
    ratio = on_line(record, "vh_est_per_s", after=20.0) / on_line(record, "vh_true_per_s", after=20.0)
    assert np.median(ratio) == pytest.approx(1.0, abs=0.02)
    # and the photos follow: their time apart is the base over this speed, base = 0.4 x 230/152 x height
    photos = record.photos
    late = (photos["line"] == 0) & np.isfinite(photos["end_lap_pct"])
    assert photos["end_lap_pct"][late].mean() == pytest.approx(60.0, abs=1.5)
    planned = 0.4 * 230.0 / 152.0 * 3000.0 / ground_speed
    assert np.median(photos["interval_s"][late]) == pytest.approx(planned, rel=0.05)


@pytest.fixture(scope="module")
def gusty() -> Record:
    return simulate(scenario(4.0, air=GUSTY))


def test_the_same_run_is_the_same(gusty: Record) -> None:
    again = simulate(scenario(4.0, air=GUSTY))
    assert again.summary["telemetry_sha256"] == gusty.summary["telemetry_sha256"]
    for name, column in gusty.matches.items():
        np.testing.assert_array_equal(again.matches[name], column, err_msg=name)
    other = simulate(scenario(4.0, air=GUSTY).model_copy(update={"seed": 2}))
    assert other.summary["telemetry_sha256"] != gusty.summary["telemetry_sha256"]
    n = min(len(other.telemetry["t_s"]), len(gusty.telemetry["t_s"]))
    assert not np.array_equal(other.telemetry["gust_u_m_s"][:n], gusty.telemetry["gust_u_m_s"][:n])


def test_the_same_run_is_the_same_in_another_process(gusty: Record) -> None:
    code = (
        "import sys, flights; from aerosim.simulate import simulate\n"
        f"record = simulate(flights.scenario(4.0, air={GUSTY!r}))\n"
        "print(record.summary['telemetry_sha256'])"
    )
    path = [entry for entry in sys.path if entry.endswith("tests")]
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = {path!r}\n{code}"],
        capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    assert done.stdout.strip() == gusty.summary["telemetry_sha256"]


def test_what_is_kept_for_the_viewer_changes_nothing(gusty: Record) -> None:
    kept = simulate(scenario(4.0, air=GUSTY, record={"rrd": True}))
    assert kept.rows
    assert kept.summary["telemetry_sha256"] == gusty.summary["telemetry_sha256"]


@pytest.mark.parametrize("rows", [{"noise_grey": 6.0}, {"pixels_px": 80}])
def test_the_rows_leave_the_air_alone(gusty: Record, rows: dict[str, Any]) -> None:
    """Other noise, and other numbers drawn for it: gusts and wind stay as they were, bit for bit."""
    other = simulate(scenario(4.0, air=GUSTY, ccd_rows=rows))
    for name in FLIGHT:
        np.testing.assert_array_equal(other.telemetry[name], gusty.telemetry[name], err_msg=name)
    assert not np.array_equal(other.telemetry["mount_yaw_deg"], gusty.telemetry["mount_yaw_deg"])


def test_turbulence_leaves_the_slow_wind_alone(gusty: Record) -> None:
    smooth = simulate(scenario(4.0, air=air(10.0, 0.0, slow=0.5)))
    n = min(len(smooth.telemetry["t_s"]), len(gusty.telemetry["t_s"]))
    for name in ("wind_north_m_s", "wind_east_m_s"):
        np.testing.assert_array_equal(smooth.telemetry[name][:n], gusty.telemetry[name][:n], err_msg=name)
        assert np.ptp(smooth.telemetry[name]) > 0.1


MODES = ("fixed", "ideal", "schmelovsky_1988", "pipelined")


@pytest.fixture(scope="module")
def modes() -> dict[str, Record]:
    return {mode: simulate(scenario(10.0, air=GUSTY, control={"mode": mode})) for mode in MODES}


def test_the_flight_does_not_depend_on_the_camera(modes: dict[str, Record]) -> None:
    for mode in MODES[1:]:
        for name in FLIGHT:
            np.testing.assert_array_equal(
                modes[mode].telemetry[name], modes["fixed"].telemetry[name], err_msg=name
            )


def test_a_fixed_mount_leaves_the_drift_as_crab(modes: dict[str, Record]) -> None:
    tel = modes["fixed"].telemetry
    assert not tel["mount_yaw_deg"].any()
    np.testing.assert_array_equal(tel["crab_true_deg"], tel["drift_true_deg"])
    # its photos keep the planned interval, 0.4 x 230/152 x 3000 m / 69.44 m/s
    np.testing.assert_allclose(
        modes["fixed"].photos["interval_s"], 0.4 * 230.0 / 152.0 * 3000.0 / 69.44, rtol=1e-3
    )


def test_told_the_truth_it_is_best(modes: dict[str, Record]) -> None:
    left = {mode: rms(on_line(modes[mode], "crab_true_deg", after=30.0)) for mode in MODES}
    assert left["ideal"] < left["pipelined"] < left["fixed"] / 4.0
    assert left["schmelovsky_1988"] < left["fixed"] / 4.0
    # what the oracle's mount leaves is its lag and delay times the yaw rate: 0.15 s x 0.12 deg/s
    assert left["ideal"] < 0.1
    photos, tel = modes["ideal"].photos, modes["ideal"].telemetry
    vh = np.interp(photos["t_s"], tel["t_s"], tel["vh_true_per_s"])
    # the interval is that of a command up to one rows' period and the shutter's delay ago
    np.testing.assert_allclose(photos["interval_s"], 0.4 * 230.0 / 152.0 / vh, rtol=0.02)


def test_the_paper_takes_one_strip_at_a_time(modes: dict[str, Record]) -> None:
    paper, now = modes["schmelovsky_1988"].matches, modes["pipelined"].matches
    begins, ends = paper["t_row1_s"], paper["t_decided_s"]
    assert (begins[1:] >= ends[:-1]).all()
    good = paper["accepted"]
    # n = 259 exposures of 50 ms: 12.9 s; on the line, with the wind across, within the relief
    assert np.median((paper["t_row2_s"] - begins)[good]) == pytest.approx(12.9, rel=0.1)
    assert np.array_equal(paper["mu_px"][good], np.round(paper["mu_px"][good]))
    assert np.array_equal(paper["n"][good], np.round(paper["n"][good]))
    assert (now["t_row1_s"][1:] < now["t_decided_s"][:-1]).sum() > 50
    assert len(now["strip"]) > 8 * len(paper["strip"])
    # on the airframe the rows see the drift, whatever the mount does
    drift = on_line(modes["schmelovsky_1988"], "drift_true_deg").mean()
    assert np.median(paper["crab_true_deg"][good]) == pytest.approx(drift, abs=0.7)
    assert np.median(paper["angle_deg"][good]) == pytest.approx(drift, abs=1.5)  # a pixel is 1.44 deg


def test_the_paper_forgets_slowly(modes: dict[str, Record]) -> None:
    used = modes["schmelovsky_1988"].matches
    gains = used["gain_drift"][used["accepted"]]
    q = [1.0]
    while len(q) < len(gains):
        q.append((q[-1] + 0.01) / (q[-1] + 0.01 + 1.0))  # (15) with the printed gamma
    # the filter starts anew with the line's run-in only
    np.testing.assert_allclose(gains, q, rtol=1e-12)


def test_the_public_names_work_in_any_order() -> None:
    """The module `aerosim.simulate` is bound over the function of that name when it is first imported."""
    code = (
        "import aerosim\n"
        "assert aerosim.run\n"
        "for _ in range(2):\n"
        "    try: aerosim.simulate(None)\n"
        "    except AttributeError as error: assert 'NoneType' in str(error), error\n"
        "from aerosim import simulate\n"
        "assert callable(simulate) and callable(aerosim.load_scenario) and callable(aerosim.open_run)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
    assert isinstance(aerosim.load_scenario("calm"), Scenario)


def test_progress_is_told() -> None:
    told: list[tuple[float, float]] = []
    record = simulate(scenario(2.0), lambda now, planned: told.append((now, planned)))
    times = [now for now, _ in told]
    assert times == sorted(times)
    assert len({planned for _, planned in told}) == 1
    assert told[0][1] == pytest.approx(record.summary["flight"]["duration_s"], rel=0.05)


@pytest.mark.parametrize("by_user", [True, False])
def test_an_interrupt_in_compiled_code_is_one_too(by_user: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python raises SystemError from it when a compiled function returns with the interrupt pending."""
    import importlib

    loop = importlib.import_module("aerosim.simulate")

    def stopped(*_: Any) -> None:
        raise SystemError("returned a result with an exception set") from (
            KeyboardInterrupt() if by_user else ValueError("of ours")
        )

    monkeypatch.setattr(loop, "_loop", stopped)
    if by_user:
        assert simulate(scenario(4.0)).status == "interrupted"
    else:
        with pytest.raises(SystemError):
            simulate(scenario(4.0))
