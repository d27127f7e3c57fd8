"""What a sweep costs beside its runs: start, overhead of a run, two cores against one, the ten-thousandth result.

Prints ratios to the limits and ends with 1 if one is exceeded.  Start and efficiency are times of a clock: they
mean nothing while other programs are at work.  `python benchmarks/sweep.py overhead` measures one.
"""

from __future__ import annotations

import json
import logging
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Generator, Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

from aerosim.scenario import load_scenario, with_overrides
from aerosim.simulate import simulate
from aerosim.sweep.book import Book
from aerosim.sweep.driver import drive
from aerosim.sweep.executor import LocalExecutor
from aerosim.sweep.spec import SweepSpec, make_spec
from aerosim.sweep.stoprule import StopRule
from aerosim.sweep.vary import varied
from aerosim.sweep.work import Result, Task, result_file, run_one, scenario_of, write_result

EFFICIENCY_LEAST = 0.9
OVERHEAD_LIMIT = 0.05
START_LIMIT_S = 2.0
GROWTH_LIMIT = 1.25  # of the time per result: constant, and what a busy machine adds
PLANNED = 10_000
PAIRS, ROUNDS, EMPTY, APPENDED = 12, 3, 600, 200
WIND, MODE = "air.wind.speed_m_s", "control.mode"
OWN_FLIGHTS = ["--vary", f"{WIND}=0:9.75:0.25"]  # 40 runs, each with a flight of its own
ONE_FLIGHT = ["--vary", f"{MODE}=fixed,schmelovsky_1988,pipelined,ideal", "--seeds", "10"]
HALVES = ["0:4.75:0.25", "5:9.75:0.25"]
FIRST = """
import os, sys, time
from aerosim.cli.app import call
from aerosim.sweep import start

class First:
    workers = 2

    def run(self, tasks):
        next(tasks)
        print(time.monotonic(), time.process_time(), flush=True)
        os._exit(0)

start.executor_of = lambda *_: First()
sys.exit(call(sys.argv[1:]))
"""


def yardstick() -> float:
    """Processor time of a bare loop, s: by it seconds of different machines, and of a busy one, are compared."""

    def once() -> float:
        began, total = time.process_time(), 0
        for k in range(30_000):
            total += k & 7
        return time.process_time() - began

    return min(once() for _ in range(100)) * 100


def command(*args: str) -> list[str]:
    """Command line of a sweep of the scenario crosswind."""
    return [sys.executable, "-m", "aerosim", "sweep", "crosswind", "-q", *args]


def start(*vary: str) -> tuple[float, float]:
    """From the command to the first run that is handed over: wall and processor time, s, the least of some."""
    found = []
    for _ in range(ROUNDS):
        with tempfile.TemporaryDirectory() as folder:
            began = time.monotonic()
            args = ["sweep", "crosswind", "-q", *vary, "--out", f"{folder}/s"]
            told = subprocess.run([sys.executable, "-c", FIRST, *args], check=True, capture_output=True, text=True)
            at, busy = map(float, told.stdout.split())
            found.append((at - began, busy))
    wall, processor = zip(*found, strict=True)
    return min(wall), min(processor)


class Beside:
    """Flies each run twice in this process: bare, and as the sweep does."""

    workers = 1

    def __init__(self) -> None:
        self.ratios: list[float] = []

    def bare(self, task: Task) -> float:
        scenario = scenario_of(task)
        began = time.process_time()
        simulate(scenario)
        return time.process_time() - began

    def run(self, tasks: Iterator[Task]) -> Generator[Result, None, None]:
        bare = first = 0.0
        for number, task in enumerate(tasks):
            if number % 2:  # in turn: neither has always the warmer memory
                bare = self.bare(task)
            began = time.process_time()
            yield run_one(task)
            first = time.process_time() - began
            if not number % 2:
                bare = self.bare(task)
            self.ratios.append(first / bare)


def grid(vary: dict[str, Any], **settings: Any) -> SweepSpec:
    """A sweep of the scenario crosswind."""
    return make_spec(load_scenario("crosswind"), {key: varied(each) for key, each in vary.items()}, **settings)


def overhead() -> float:
    """Processor time that a sweep adds to a run, of the run: the median of pairs."""
    executor = Beside()
    scenario = with_overrides(load_scenario("crosswind"), {"record.rrd": False, "record.report": False})
    simulate(scenario)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "s"
        drive(
            grid({WIND: {"from": 0, "to": PAIRS / 4 - 0.25, "step": 0.25}}), out, executor, cache=out / "flights"
        )
    return statistics.median(executor.ratios) - 1.0


def wall(*commands: list[str]) -> float:
    """Wall time of commands at the same time, s."""
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        running = [
            subprocess.Popen([*each, "--out", f"{folder}/{k}"], stdout=subprocess.DEVNULL)
            for k, each in enumerate(commands)
        ]
        if any(process.wait() for process in running):
            raise SystemExit("a sweep failed")
        return time.perf_counter() - began


def efficiency(vary: list[str]) -> float:
    """Whole command in one process over twice that on two workers, starts and reports included."""
    serial, two = wall(command(*vary, "--workers", "0")), wall(command(*vary, "--workers", "2"))
    return serial / (2.0 * two)


def machine() -> float:
    """The same of two commands that know nothing of each other, half of the runs each: what the machine gives."""
    serial = wall(command(*OWN_FLIGHTS, "--workers", "0"))
    both = [command("--vary", f"{WIND}={half}", "--workers", "0") for half in HALVES]
    return serial / (2.0 * wall(*both))


def made_up(task: Task) -> Result:
    """A result of as many figures as a run has."""
    figures = {f"section.figure_{k}": 0.1 * (task.seed % 7) + k for k in range(59)}
    values = {**figures, "crab.residual_rms_deg": float(task.seed % 11)}
    return Result(task.id, task.point, task.seed, "done", "", task.parameters, values, 1.0)


def appending(there: int, rule: str | None) -> float:
    """Processor time in which a result is written and counted when so many are there, s: the median."""
    settings = {"stop_when": StopRule.parse(rule)} if rule else {}
    spec = grid({WIND: [0, 5, 10, 15]}, seeds=2 * PLANNED // 4, **settings)
    book, times = Book(spec), []
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        (out / "runs").mkdir()
        for number, task in enumerate(islice(spec.tasks(out), there + APPENDED)):
            result = made_up(task)
            if number < there:
                result_file(out, task.id).write_text("there")
                book.add(result)
                continue
            began = time.process_time()
            write_result(out, result)
            book.add(result)
            times.append(time.process_time() - began)
    return statistics.median(times)


def growth(rule: str | None) -> tuple[float, float]:
    """Time per result with 10,000 there over that with 100, and the former, s."""
    late = min(appending(PLANNED, rule) for _ in range(ROUNDS))
    return late / min(appending(100, rule) for _ in range(ROUNDS)), late


def handing() -> float:
    """Time from a result to the next of runs that end at once, on two workers of this machine, s."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "runs").mkdir()
        wrong = json.dumps({"name": "empty"})
        tasks = (Task(f"{k:024x}", k, 1, wrong, {}, folder) for k in range(EMPTY))
        at = [time.perf_counter() for _ in LocalExecutor(2).run(tasks)]
    return (at[-1] - at[EMPTY // 3]) / (len(at) - 1 - EMPTY // 3)


class Told:
    """Prints figures and remembers whether one is over its limit."""

    def __init__(self) -> None:
        self.over = False

    def most(self, text: str, value: float, limit: float) -> None:
        self.over |= value > limit
        print(f"{text}, {value / limit:.2f} of the limit", flush=True)

    def least(self, text: str, value: float, least: float) -> None:
        self.over |= value < least
        print(f"{text}: {value:.2f}, at least {least}", flush=True)


def starts(told: Told) -> None:
    for name, vary in {
        "1000 points, 10 seeds": ["--vary", f"{WIND}=0:19.98:0.02", "--seeds", "10"],
        "10000 points": [
            "--vary",
            f"{WIND}=0:9.996:0.004",
            "--vary",
            f"{MODE}=fixed,schmelovsky_1988,pipelined,ideal",
        ],
    }.items():
        seconds, processor = start(*vary)
        text = f"start of {PLANNED} runs, {name}: {seconds:.2f} s ({processor:.2f} s of processor)"
        told.most(text, seconds, START_LIMIT_S)


def overheads(told: Told) -> None:
    part = overhead()
    told.most(f"a run in a sweep / the same run alone: 1 {part:+.3f}", part, OVERHEAD_LIMIT)
    print(f"handing over, telling and writing of an empty run, two workers: {handing() * 1e3:.2f} ms a run")


def efficiencies(told: Told) -> None:
    own, shared, two = efficiency(OWN_FLIGHTS), efficiency(ONE_FLIGHT), machine()
    print(f"two commands that know nothing of each other, half of the runs each: {two:.2f} of twice one")
    told.least("efficiency on two cores, 40 runs with flights of their own", own, EFFICIENCY_LEAST)
    told.least("efficiency on two cores, 10 flights with 4 controllers each", shared, EFFICIENCY_LEAST)


def growths(told: Told) -> None:
    for name, rule in {"no rule": None, "a rule for stopping": "crab.residual_rms_deg:1e-6"}.items():
        ratio, late = growth(rule)
        text = f"time per result at {PLANNED} / at 100, {name}: {ratio:.2f} ({late * 1e3:.2f} ms)"
        told.most(text, ratio, GROWTH_LIMIT)


def main() -> None:
    """Print the figures."""
    logging.getLogger("aerosim").setLevel(logging.WARNING)
    parts = {"start": starts, "overhead": overheads, "efficiency": efficiencies, "growth": growths}
    told = Told()
    with suppress(AttributeError):  # not on every system
        print(f"{os.getloadavg()[0]:.1f} processes were at work in the last minute, on {os.cpu_count()} cores")
    for name in sys.argv[1:] or parts:
        parts[name](told)
    print(f"3 million turns of a bare Python loop take {yardstick():.2f} s of processor here and now")
    sys.exit(told.over)


if __name__ == "__main__":
    main()
