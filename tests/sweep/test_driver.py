"""The driver: identical tables for any number of workers, after any death, with any order of endings."""

from __future__ import annotations

import random
import subprocess
import sys
import time
from collections.abc import Generator, Iterator
from pathlib import Path

import numpy as np
import pytest
from sweeps import MODES, WIND, files, same, spec, tiny, tiny_file

import aerosim
from aerosim.errors import InputError, Interrupted, RunFailure
from aerosim.sweep import driver
from aerosim.sweep.driver import drive
from aerosim.sweep.executor import LocalExecutor
from aerosim.sweep.results import Sweep
from aerosim.sweep.stoprule import StopRule
from aerosim.sweep.work import Result, Task


class Shuffled:
    """Runs that end in any order, some of them ahead; their figures follow from point and seed only."""

    def __init__(self, order: int, ahead: int, fail: frozenset[int] = frozenset()) -> None:
        self.rng, self.workers, self.fail, self.flown = random.Random(order), ahead, fail, 0

    def run(self, tasks: Iterator[Task]) -> Generator[Result, None, None]:
        held: list[Task] = []
        while True:
            while len(held) < self.workers and (task := next(tasks, None)) is not None:
                held.append(task)
            if not held:
                return
            task = held.pop(self.rng.randrange(len(held)))
            self.flown += 1
            value = float(np.random.default_rng([task.point, task.seed]).normal(task.point, 1.0))
            failed = task.point in self.fail
            yield Result(
                task.id, task.point, task.seed, "failed" if failed else "done", "lost" if failed else "",
                task.parameters, {} if failed else {"crab.residual_rms_deg": value}, 0.1,
            )  # fmt: skip


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    return aerosim.sweep(tiny(), MODES, seeds=2, out=tmp_path_factory.mktemp("one") / "sweep of one", workers=1)


def test_one_row_for_each_point_and_seed(reference: Sweep) -> None:
    rows = reference.table.select(["point", "seed", "status", *MODES]).to_pylist()
    assert [(row["point"], row["seed"]) for row in rows] == [(p, s) for p in range(4) for s in (1, 2)]
    assert {row["status"] for row in rows} == {"done"}
    assert (reference.path / "report.html").is_file()
    assert reference.summary["done"] == reference.summary["runs"] == 8
    wind, calm = (reference.means("flight.drift_mean_deg", by=[WIND])[k].mean for k in (1, 0))
    assert abs(wind) > abs(calm) + 3  # wind of 6 m/s abeam: asin(6 / 69.44) = 4.96 deg


@pytest.mark.parametrize("workers", [0, 2])
def test_the_same_table_for_any_number_of_workers(reference: Sweep, tmp_path: Path, workers: int) -> None:
    found = aerosim.sweep(tiny(), MODES, seeds=2, out=tmp_path / "s", workers=workers)
    assert same(found.table, reference.table)


def kills(folder: Path, vary: list[str], seeds: int, count: int, most: int) -> tuple[Path, int]:
    """Kill -9 of the driver at random moments, `count` times; returns its directory, after the last resume."""
    rng, out = random.Random(60), folder / "killed"
    command = [sys.executable, "-m", "aerosim", "sweep", str(tiny_file(folder)), "--seeds", str(seeds), "-q"]
    command += [*(f"--vary={each}" for each in vary), "--workers", "2", "--out", str(out), "--resume"]
    seen: dict[str, tuple[int, int]] = {}
    killed = 0
    for _ in range(count):
        more, wait = len(seen) + rng.randint(0, most), rng.uniform(0.0, 0.4) + (rng.random() < 0.3) * rng.random()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        while process.poll() is None and len(files(out)) < more:
            time.sleep(0.01)
        time.sleep(wait)
        killed += process.poll() is None
        process.kill()
        process.wait()
        time.sleep(0.1)
        now = files(out)
        assert {name: now[name] for name in seen} == seen, "a finished run was flown again"
        seen = now
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    now = files(out)
    assert {name: now[name] for name in seen} == seen, "a finished run was flown again"
    return out, killed


def check_kills(folder: Path, winds: list[int], seeds: int, count: int, most: int) -> None:
    vary = [f"{WIND}={','.join(map(str, winds))}", "control.mode=fixed,pipelined"]
    out, killed = kills(folder, vary, seeds, count, most)
    assert killed == count
    base = folder / "tiny.yaml"
    whole = aerosim.sweep(base, {**MODES, WIND: winds}, seeds=seeds, out=folder / "whole", workers=2)
    assert same(Sweep(out).table, whole.table)
    assert len(files(out)) == 2 * len(winds) * seeds


def test_a_killed_driver_goes_on(tmp_path: Path) -> None:
    check_kills(tmp_path, [0, 6], 3, 2, 3)


@pytest.mark.slow
def test_ten_kills_of_sixty_runs(tmp_path: Path) -> None:
    check_kills(tmp_path, [0, 3, 6], 10, 10, 4)


def test_nothing_is_flown_twice_and_more_seeds_join(tmp_path: Path) -> None:
    first = drive(spec(seeds=2), tmp_path / "s", Shuffled(1, 3))
    before = files(first.path)
    idle = Shuffled(2, 3)
    again = drive(spec(seeds=2), tmp_path / "s", idle, resume=True)
    assert (idle.flown, files(again.path)) == (0, before)
    more = Shuffled(3, 3)
    longer = drive(spec(seeds=3), tmp_path / "s", more, resume=True)
    assert (more.flown, longer.table.num_rows) == (4, 12)
    assert same(longer.table, drive(spec(seeds=3), tmp_path / "t", Shuffled(4, 1)).table)


def test_a_damaged_file_is_flown_anew(tmp_path: Path) -> None:
    first = drive(spec(), tmp_path / "s", Shuffled(1, 2))
    next((first.path / "runs").glob("*.json")).write_text("{")
    one = Shuffled(1, 2)
    assert same(drive(spec(), tmp_path / "s", one, resume=True).table, first.table)
    assert one.flown == 1


def test_failed_runs_are_rows_and_are_retried_if_wanted(tmp_path: Path) -> None:
    first = drive(spec(seeds=2), tmp_path / "s", Shuffled(1, 2, frozenset({1})))
    failed = [row for row in first.table.to_pylist() if row["status"] == "failed"]
    assert [(row["point"], row["seed"], row["reason"]) for row in failed] == [(1, 1, "lost"), (1, 2, "lost")]
    assert first.summary["reasons"] == [{"reason": "lost", "runs": 2}]
    idle, again = Shuffled(1, 2), Shuffled(1, 2)
    assert drive(spec(seeds=2), tmp_path / "s", idle, resume=True).summary["failed"] == 2
    mended = drive(spec(seeds=2), tmp_path / "s", again, resume=True, retry_failed=True)
    assert (idle.flown, again.flown, mended.summary["failed"]) == (0, 2, 0)
    assert same(mended.table, drive(spec(seeds=2), tmp_path / "t", Shuffled(9, 1)).table)


def test_the_rule_for_stopping_does_not_see_who_is_quicker(tmp_path: Path) -> None:
    rule = StopRule("crab.residual_rms_deg", 0.5)
    ended = [
        drive(spec(seeds=200, stop_when=rule), tmp_path / f"s{k}", Shuffled(k, ahead))
        for k, ahead in enumerate((1, 2, 7, 40))
    ]
    seeds = {each.summary["seeds"] for each in ended}
    assert len(seeds) == 1
    assert (
        10 <= seeds.pop() < 60
    )  # theory: (1.96 / 0.5)^2 = 15 seeds for one point; the worst of four takes longer
    assert all(same(each.table, ended[0].table) for each in ended)
    assert ended[0].summary["stopped_early"]
    idle = Shuffled(1, 3)
    again = drive(spec(seeds=200, stop_when=rule), tmp_path / "s3", idle, resume=True)
    assert idle.flown == 0
    assert same(again.table, ended[0].table)


def test_points_that_stop_by_themselves_do_not_see_who_is_quicker(tmp_path: Path) -> None:
    """Means 0 to 3 with deviations of 1: each point is flown until its own mean is known, and no longer."""
    rule = StopRule("crab.residual_rms_deg", 0.5, each=True)
    fliers = [Shuffled(k, ahead) for k, ahead in enumerate((1, 7, 40))]
    ended = [drive(spec(seeds=200, stop_when=rule), tmp_path / f"s{k}", flier) for k, flier in enumerate(fliers)]
    assert all(same(each.table, ended[0].table) for each in ended)
    flown = np.unique(ended[0].table["point"].to_pylist(), return_counts=True)[1]
    for point, count in enumerate(flown):
        x = np.array([np.random.default_rng([point, seed]).normal(point, 1.0) for seed in range(1, 201)])
        alone = StopRule("crab.residual_rms_deg", 0.5)
        assert count == alone.first(x[None, :], [{}])
    assert len(set(flown)) > 1
    summary = ended[0].summary
    assert (summary["runs"], summary["done"], summary["seeds"]) == (flown.sum(), flown.sum(), flown.max())
    assert fliers[0].flown <= flown.sum() + 1
    told = f"Points stopped after {flown.min()} to {flown.max()} of 200 seeds"
    assert told in (ended[0].path / "report.html").read_text()
    idle = Shuffled(1, 3)
    assert same(drive(spec(seeds=200, stop_when=rule), tmp_path / "s2", idle, resume=True).table, ended[0].table)
    assert idle.flown == 0
    # a harder rule goes on from there, at the points that need it
    harder = StopRule("crab.residual_rms_deg", 0.4, each=True)
    more = drive(spec(seeds=200, stop_when=harder), tmp_path / "s2", idle, resume=True)
    whole = drive(spec(seeds=200, stop_when=harder), tmp_path / "new", Shuffled(5, 2))
    assert same(more.table, whole.table)


def test_a_point_that_never_stops_by_itself_is_flown_to_the_last_seed(tmp_path: Path) -> None:
    rule = StopRule("crab.residual_rms_deg", 0.05, relative=True, each=True)  # of a mean of 0 at point 0
    ended = drive(spec(seeds=30, stop_when=rule), tmp_path / "s", Shuffled(3, 2, frozenset({1})))
    flown = np.unique(ended.table["point"].to_pylist(), return_counts=True)[1]
    assert flown.tolist() == [30, 30, 30, 30]
    assert not ended.summary["stopped_early"]
    assert ended.summary["failed"] == 30


def test_interrupted_it_keeps_its_table_and_goes_on(tmp_path: Path) -> None:
    def stop(ended: float, _: float) -> None:
        if ended >= 3:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted) as found:
        drive(spec(seeds=2), tmp_path / "s", Shuffled(1, 2), progress=stop)
    assert found.value.path == tmp_path / "s"
    left = Sweep(tmp_path / "s")
    assert (left.summary["status"], left.table.num_rows) == ("interrupted", 3)
    rest = Shuffled(5, 2)
    done = drive(spec(seeds=2), tmp_path / "s", rest, resume=True)
    assert rest.flown == 5
    assert same(done.table, drive(spec(seeds=2), tmp_path / "t", Shuffled(9, 1)).table)


def test_a_full_disk_stops_it_and_it_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written = driver.write_result

    def full(out: Path, result: Result) -> None:
        if result.seed == 2:
            raise OSError(28, "No space left on device")
        written(out, result)

    monkeypatch.setattr(driver, "write_result", full)
    with pytest.raises(RunFailure, match="No space left on device; --resume goes on") as found:
        drive(spec(seeds=2), tmp_path / "s", Shuffled(1, 1))
    assert found.value.path == tmp_path / "s"
    monkeypatch.undo()
    rest = Shuffled(1, 1)
    assert drive(spec(seeds=2), tmp_path / "s", rest, resume=True).summary["done"] == 8
    assert rest.flown == 4


def test_directories_that_are_not_this_sweeps(tmp_path: Path) -> None:
    drive(spec(), tmp_path / "s", Shuffled(1, 2))
    with pytest.raises(InputError, match=r"--out: .* exists \(another directory, or --resume"):
        drive(spec(), tmp_path / "s", Shuffled(1, 2))
    with pytest.raises(InputError, match=r"holds another sweep: vary.air.wind.speed_m_s differs"):
        drive(spec({**MODES, WIND: [0, 7]}), tmp_path / "s", Shuffled(1, 2), resume=True)
    with pytest.raises(InputError, match=r"holds another sweep: scenario.flight.run_in_s differs"):
        drive(spec(base=tiny(flight={"run_in_s": 7})), tmp_path / "s", Shuffled(1, 2), resume=True)
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years")
    with pytest.raises(InputError, match="is no sweep"):
        drive(spec(), tmp_path / "mine", Shuffled(1, 2), resume=True)
    text = (tmp_path / "s" / "sweep.yaml").read_text()
    (tmp_path / "s" / "sweep.yaml").write_text(text.replace("aerosim: ", "aerosim: 9"))
    with pytest.raises(InputError, match=r"was made by aerosim"):
        drive(spec(), tmp_path / "s", Shuffled(1, 2), resume=True)


def test_two_drivers_do_not_share_a_directory(tmp_path: Path) -> None:
    def second(ended: float, _: float) -> None:
        if ended == 1:
            with pytest.raises(InputError, match="is in use"):
                drive(spec(), tmp_path / "s", Shuffled(1, 2), resume=True)

    assert drive(spec(), tmp_path / "s", Shuffled(1, 2), progress=second).summary["done"] == 4


def test_wrong_land_is_told_before_anything_is_left(tmp_path: Path) -> None:
    far = tiny(flight={"lines": [{"start_deg": [10, 10], "end_deg": [10, 10.1]}]})
    with pytest.raises(InputError):
        drive(spec(base=far), tmp_path / "s", LocalExecutor(1))
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize(
    ("rule", "seeds", "says"),
    [
        ("crab.residual_deg:1", 20, "is no number of summary.json .did you mean crab.residual"),
        ("crab.residual_rms_deg:1", 5, "5 seeds are too few for a rule"),
        ("crab.residual_rms_deg[control.mode=fixed,best]:1", 20, "no two points differ only in"),
    ],
)
def test_a_rule_that_cannot_hold(tmp_path: Path, rule: str, seeds: int, says: str) -> None:
    with pytest.raises(InputError, match=says):
        drive(spec(seeds=seeds, stop_when=StopRule.parse(rule)), tmp_path / "s", Shuffled(1, 2))
    assert not (tmp_path / "s").exists()
