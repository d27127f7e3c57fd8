"""What is varied: forms of values, points, names of runs, the sweep file, what is refused."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sweeps import MODES, WIND, spec, tiny, tiny_file

from aerosim.errors import InputError
from aerosim.scenario import load, shipped, with_overrides
from aerosim.sweep.order import flight_order
from aerosim.sweep.spec import Point, make_spec
from aerosim.sweep.specfile import find_sweep, load_sweep, shipped_sweeps, sweep_text
from aerosim.sweep.start import asked_for
from aerosim.sweep.table import runs_table
from aerosim.sweep.vary import Range, parse_vary, steps, varied
from aerosim.sweep.work import Result, scenario_of


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("0,5,10", (0, 5, 10)),
        (" fixed, pipelined", ("fixed", "pipelined")),
        ("true,null,1e-3", (True, None, 0.001)),
        ("[1,2],[3,4]", ((1, 2), (3, 4))),
        ("{a: 1},{a: 2}", ({"a": 1}, {"a": 2})),
        ("0:20:5", (0, 5, 10, 15, 20)),
        ("0:0.3:0.1", (0.0, 0.1, 0.2, 0.3)),
        ("5:-5:-2.5", (5.0, 2.5, 0.0, -2.5, -5.0)),
        ("0:9:4", (0, 4, 8)),
        ("3:3:1", (3,)),
        ("-1..2.5", Range(-1.0, 2.5)),
        ("1:30", None),
    ],
)
def test_forms_of_values(text: str, values: Any) -> None:
    if values is None:
        with pytest.raises(InputError, match="1:30 has no step"):
            parse_vary(f"a.b={text}")
        return
    assert parse_vary(f"a.b={text}") == ("a.b", values)
    assert repr(parse_vary(f"a.b={text}")[1]) == repr(values)  # 0 is not 0.0


@given(st.integers(-1000, 1000), st.integers(1, 40), st.integers(1, 400), st.integers(0, 3))
def test_steps_are_exact_decimals(first: int, count: int, step: int, digits: int) -> None:
    """Against whole numbers of the last digit: no step adds up its rounding."""
    low, high, by = (round(k / 10**digits, digits) for k in (first, first + count * step, step))
    assert steps(low, high, by) == tuple(round((first + k * step) / 10**digits, digits) for k in range(count + 1))


@pytest.mark.parametrize(
    ("value", "values"),
    [
        ([1, 2], (1, 2)),
        (range(3), (0, 1, 2)),
        (np.array([0.5, 1.5]), (0.5, 1.5)),
        ([np.float64(2.5)], (2.5,)),
        ({"from": 0, "to": 1, "step": 0.5}, (0.0, 0.5, 1.0)),
        ({"from": 0, "to": 1}, Range(0.0, 1.0)),
    ],
)
def test_values_from_python_and_yaml(value: Any, values: Any) -> None:
    assert varied(value) == values


def test_a_grid_is_the_product_and_a_list_goes_in_step() -> None:
    keys = {WIND: [0, 5, 10], "control.mode": ["fixed", "ideal"]}
    made = [tuple(point.values.values()) for point in spec(keys).points]
    assert made == list(itertools.product(*keys.values()))
    keys["control.mode"].append("pipelined")
    made = [tuple(point.values.values()) for point in spec(keys, sampling="list").points]
    assert made == list(zip(*keys.values(), strict=True))
    assert [point.number for point in spec(keys, sampling="list").points] == [0, 1, 2]


def test_a_latin_hypercube_meets_every_part_of_every_range_once() -> None:
    keys: dict[str, Any] = {WIND: {"from": 2, "to": 12}, "air.wind.from_deg": {"from": 0, "to": 360}}
    one = spec(keys, sampling="latin_hypercube", samples=50)
    for key, (low, high) in ((WIND, (2, 12)), ("air.wind.from_deg", (0, 360))):
        values = [point.values[key] for point in one.points]
        counts, _ = np.histogram(values, bins=50, range=(low, high))
        assert (counts == 1).all()
    # unrelated order of two keys: |rho| < 4 / sqrt(49) would be met by chance 1 in 15 000
    pairs = np.array([list(point.values.values()) for point in one.points]).T
    assert abs(np.corrcoef(pairs)[0, 1]) < 4 / 7
    other = spec(keys, sampling="latin_hypercube", samples=50, sampling_seed=2)
    assert other.points[0].values[WIND] != one.points[0].values[WIND]


def test_a_key_more_leaves_the_hypercube_of_the_others() -> None:
    keys: dict[str, Any] = {WIND: {"from": 2, "to": 12}}
    first = spec(keys, sampling="latin_hypercube", samples=8)
    more = spec({"control.mode": ["fixed", "ideal"], **keys}, sampling="latin_hypercube", samples=8)
    assert [p.values[WIND] for p in more.points] == [p.values[WIND] for p in first.points]
    modes = [p.values["control.mode"] for p in more.points]
    assert modes.count("fixed") == modes.count("ideal") == 4


BOTH = (
    {"control.mode": ("fixed", "ideal"), WIND: (0, 5)},
    {"control.mode": ("pipelined",), "estimation.gain": ("riccati", "halving")},
)


def test_several_grids_are_flown_one_after_the_other() -> None:
    """Each point has the keys of its own grid; where a key is not varied the scenario's own value is flown."""
    made = make_spec(tiny(), BOTH, seeds=2)
    wanted = [
        dict(zip(grid, values, strict=True)) for grid in BOTH for values in itertools.product(*grid.values())
    ]
    assert [point.values for point in made.points] == wanted
    assert list(made.vary) == ["control.mode", WIND, "estimation.gain"]
    assert made.vary["control.mode"] == ("fixed", "ideal", "pipelined")
    assert made.size == 12
    assert not made.is_grid
    assert spec().is_grid
    flown = [scenario_of(task) for task in made.tasks(Path("x"))][:6]
    assert [each.estimation.gain for each in flown] == ["riccati"] * 5 + ["halving"]
    assert [each.air.wind.speed_m_s for each in flown] == [0, 5, 0, 5, 0, 0]  # tiny has no wind
    table = runs_table(
        [Result(t.id, t.point, t.seed, "done", "", t.parameters) for t in made.tasks(Path("x"))], list(made.vary)
    )
    assert table["estimation.gain"].to_pylist() == [None] * 8 + ["riccati"] * 2 + ["halving"] * 2
    order, shared = flight_order(made)
    assert shared
    assert sorted(order, key=lambda run: (run[0], run[1].number)) == list(made.runs())


def test_files_of_one_grid_leave_the_others_their_own(tmp_path: Path) -> None:
    """A file that one grid replaces is still read by the points of the other: it counts with what is in it."""
    for name in ("a", "b"):
        (tmp_path / f"{name}.geojson").write_text(
            '{"type": "LineString", "coordinates": [[-84.38, 36.52], [-84.36, 36.52]]}'
        )
    base = tiny(flight={"file": str(tmp_path / "a.geojson"), "lines": None})
    grids = ({"flight.file": (str(tmp_path / "b.geojson"),)}, {WIND: (1,)})
    assert sorted(Path(name).name for name in make_spec(base, grids).inputs) == ["a.geojson", "b.geojson"]
    assert [Path(name).name for name in make_spec(base, grids[:1]).inputs] == ["b.geojson"]


def test_several_grids_in_a_file_come_back_from_the_directory(tmp_path: Path) -> None:
    tiny_file(tmp_path)
    (tmp_path / "s.yaml").write_text(
        f"scenario: tiny.yaml\nvary:\n  - {{control.mode: [fixed, ideal], {WIND}: [0, 5]}}\n"
        "  - control.mode: [pipelined]\n    estimation.gain: [riccati, halving]\n"
    )
    found = load_sweep(tmp_path / "s.yaml")
    assert found == make_spec(load(tmp_path / "tiny.yaml"), BOTH)
    (tmp_path / "sweep.yaml").write_text(sweep_text(found))
    again = load_sweep(tmp_path / "sweep.yaml")
    assert [task.id for task in again.tasks(Path("x"))] == [task.id for task in found.tasks(Path("x"))]
    more = asked_for(tmp_path / "s.yaml", {"air.turbulence.sigma_m_s": [0, 1]}, {}, {}).spec
    assert len(more.points) == 12  # joined to each grid


def test_seeds_are_the_same_at_all_points_and_tasks_come_in_whole_seeds() -> None:
    tasks = list(spec(seeds=3).tasks(Path("out")))
    assert [task.seed for task in tasks] == [1] * 4 + [2] * 4 + [3] * 4
    assert [task.point for task in tasks] == [0, 1, 2, 3] * 3
    assert len({task.id for task in tasks}) == 12


def test_a_task_flies_the_scenario_with_its_values() -> None:
    """Against the loader's own overrides: the mode's defaults follow the new mode, paths and all."""
    base = load("crosswind")
    for task in spec({"control.mode": ["schmelovsky_1988", "ideal"]}, base).tasks(Path("out")):
        mode = task.parameters["control.mode"]
        asked = {"control.mode": mode, "seed": 1, "record.rrd": False, "record.report": False}
        assert scenario_of(task) == with_overrides(base, asked)
        assert scenario_of(task).ccd_rows.mounted_on == ("airframe" if mode == "schmelovsky_1988" else "camera")


def test_the_name_of_a_run_follows_what_decides_it() -> None:
    def names(*args: Any, **kwargs: Any) -> list[str]:
        return [task.id for task in spec(*args, **kwargs).tasks(Path("x"))]

    one = names()
    assert names(seeds=2)[:4] == one  # more seeds leave the first
    assert names({**MODES, WIND: [0, 6, 12]})[:4] == one  # more values too
    assert not set(names(base=tiny(flight={"height_m": 3100}))) & set(one)
    assert not set(names({**MODES, WIND: [1, 7]})) & set(one)


@settings(max_examples=30, deadline=None)
@given(
    st.lists(st.floats(0, 50, allow_subnormal=False), min_size=1, max_size=5, unique=True),
    st.floats(2000.0, 4000.0),
    st.integers(1, 9),
)
def test_the_file_in_the_directory_is_the_same_sweep(
    tmp_path_factory: pytest.TempPathFactory, winds: list[float], height: float, seeds: int
) -> None:
    """All names of runs agree: what resumes from the directory flies nothing again."""
    one = spec({WIND: winds, "control.mode": ["fixed", "ideal"]}, tiny(flight={"height_m": height}), seeds=seeds)
    file = tmp_path_factory.mktemp("again") / "sweep.yaml"
    file.write_text(sweep_text(one), encoding="utf-8")
    again = load_sweep(file)
    assert [task.id for task in again.tasks(Path("x"))] == [task.id for task in one.tasks(Path("x"))]
    assert [point.values for point in again.points] == [point.values for point in one.points]


def test_a_sweep_file_says_the_same_as_the_options(tmp_path: Path) -> None:
    tiny_file(tmp_path)
    (tmp_path / "sweep of mine.yaml").write_text(
        "scenario: tiny.yaml\nset: {flight.run_in_s: 6}\nvary:\n"
        f"  {WIND}: {{from: 0, to: 6, step: 6}}\n  control.mode: [fixed, pipelined]\n"
        "seeds: 12\nstop_when: crab.residual_rms_deg:0.5\nkeep: records\n"
    )
    found = load_sweep(tmp_path / "sweep of mine.yaml")
    wanted = asked_for(
        tmp_path / "tiny.yaml",
        MODES,
        {"seeds": 12, "stop_when": "crab.residual_rms_deg:0.5", "keep": "records"},
        {"flight.run_in_s": 6},
    ).spec
    assert found == wanted
    assert find_sweep(tmp_path / "sweep of mine.yaml") is not None
    assert find_sweep(tmp_path / "tiny.yaml") is None
    changed = asked_for(tmp_path / "sweep of mine.yaml", {WIND: [1]}, {"seeds": 10}, {}).spec
    assert (changed.seeds, [p.values[WIND] for p in changed.points]) == (10, [1, 1])


def test_paths_among_the_values_are_relative_to_the_file(tmp_path: Path) -> None:
    tiny_file(tmp_path)
    (tmp_path / "s.yaml").write_text("scenario: tiny.yaml\nvary: {flight.replay: [a.csv, null]}\n")
    found = [point.values["flight.replay"] for point in load_sweep(tmp_path / "s.yaml").points]
    assert found == [str(tmp_path / "a.csv"), None]


@pytest.mark.parametrize("name", shipped_sweeps())
def test_a_shipped_sweep_is_one(name: str) -> None:
    found = asked_for(name, {}, {}, {})
    assert found.spec.points
    assert found.out == Path("sweeps") / name
    assert name not in shipped()


def flown(order: Iterable[tuple[int, Point]]) -> list[tuple[int, Any]]:
    return [(seed, point.values[WIND]) for seed, point in order]


def test_points_that_share_a_flight_are_found_and_kept_apart() -> None:
    one = spec({"control.mode": ["fixed", "ideal", "pipelined"], WIND: [0, 4, 8, 12]}, seeds=2)
    order, shared = flight_order(one, 2)
    found = list(order)
    assert shared
    assert sorted(found) == sorted(one.runs())
    assert [seed for seed, _ in found] == [1] * 12 + [2] * 12
    # each mode of all flights before the next mode: neighbours are never of the same flight
    assert all(a != b for a, b in itertools.pairwise(flown(found)))
    assert not flight_order(spec({WIND: [0, 4, 8]}))[1]


@pytest.mark.parametrize("workers", [1, 2, 3, 7, 40])
@pytest.mark.parametrize("seeds", [1, 2, 5, 12])
@pytest.mark.parametrize("winds", [1, 2, 3, 70])
def test_workers_side_by_side_fly_different_flights(workers: int, seeds: int, winds: int) -> None:
    one = spec(
        {"control.mode": ["fixed", "ideal", "pipelined"], WIND: [k / 10 for k in range(winds)]}, seeds=seeds
    )
    found = list(flight_order(one, workers)[0])
    assert sorted(found) == sorted(one.runs())
    assert len(set(flown(found[:workers]))) == min(workers, seeds * winds)
    # a rule for stopping waits for no more seeds than are needed for that
    last, late = 0, 0
    for seed, _ in found:
        last = max(last, seed)
        late = max(late, last - seed)
    assert late <= 2 * (-(-workers // winds) - 1)


@pytest.mark.parametrize(
    ("vary", "shared"),
    [
        ({"frame_camera.focal_mm": [150, 300]}, True),
        ({"control.end_lap_pct": [40, 50]}, True),
        ({"terrain.outside": ["fail", "mask"]}, False),
        ({"aircraft.model": ["beech_99", "survey_twin"]}, False),
        ({"air": [{}, {"wind": {"speed_m_s": 3}}]}, False),
    ],
)
def test_which_keys_part_flights(vary: dict[str, Any], shared: bool) -> None:
    assert flight_order(spec(vary))[1] == shared


def test_camera_and_end_lap_part_flights_over_an_area() -> None:
    for vary in ({"frame_camera.focal_mm": [150, 300]}, {"control.end_lap_pct": [40, 50]}):
        assert not flight_order(spec(vary, load("block_area")))[1]
    assert flight_order(spec({"control.mode": ["fixed", "ideal"]}, load("block_area")))[1]


# what is wrong, and what the one line says
WRONG: list[tuple[dict[str, Any], dict[str, Any], str]] = [
    ({"air.wind.speed": [1]}, {}, "vary air.wind.speed: unknown key, without its unit .did you mean speed_m_s?"),
    ({"air.wnd.speed_m_s": [1]}, {}, "vary air.wnd: unknown key .did you mean wind?"),
    ({WIND: [5, -1]}, {}, f"vary {WIND}: -1 is out of range"),
    ({"control.mode": ["fixd"]}, {}, "did you mean fixed?"),
    ({WIND: []}, {}, f"vary {WIND}: has no values"),
    ({WIND: 5}, {}, f"vary {WIND}: 5 is no list"),
    ({WIND: {"from": 0, "to": 5, "step": -1}}, {}, "a step of -1 does not lead from 0 to 5"),
    ({WIND: {"from": 0, "to": 5, "step": 0}}, {}, "a step of 0 does not lead from 0 to 5"),
    ({WIND: {"from": 5, "to": 5}}, {"samples": 3}, "5..5 is no range"),
    ({WIND: {"from": 0, "to": 5}}, {}, f"vary {WIND}: 0 to 5 has no step"),
    ({WIND: {"from": 0, "to": 5}}, {"sampling": "latin_hypercube"}, "samples: how many points is not said"),
    ({WIND: {"from": 0, "too": 5}}, {}, "is no range of values"),
    ({WIND: {"from": 0, "to": 1e9, "step": 1}}, {}, "has 1000000001 values .at most 10000"),
    ({WIND: [1, 1.0]}, {}, "points 0 and 1 are the same"),
    ({}, {}, "vary: nothing is varied"),
    ({WIND: [1, 2], "control.mode": ["fixed"]}, {"sampling": "list"}, "a list takes as many values of each key"),
    ({WIND: range(1000), "air.wind.from_deg": range(359)}, {}, "vary: 359000 points are too many .1 to 100000"),
    ({WIND: range(100)}, {"seeds": 100_000}, "seeds: 100 points with 100000 seeds are 10000000 runs"),
    ({WIND: [1]}, {"seeds": 0}, "seeds: 0 is no number of seeds"),
    ({WIND: [1]}, {"seeds": 2.5}, "seeds: 2.5 is no number of seeds"),
    ({WIND: [1]}, {"sampling": "grit"}, "sampling: 'grit' is not known .grid | list | latin_hypercube"),
    ({WIND: [1]}, {"keep": "all"}, "keep: 'all' is not known"),
    ({WIND: [1]}, {"samples": 3, "sampling": "grid"}, "samples: is of no use for a grid"),
    ({WIND: [1]}, {"stop_when": "crab"}, "--stop-when: 'crab' is no rule"),
    ({"seed": [1, 2]}, {}, "vary seed: cannot be varied"),
    ({"flight.lines.4.start_deg": [[1, 2]]}, {}, "the list has no element '4'"),
]


@pytest.mark.parametrize(("vary", "fields", "says"), WRONG)
def test_what_is_wrong_is_said_at_once(vary: dict[str, Any], fields: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError) as found:
        asked_for(tiny(), vary, fields, {})
    line = str(found.value)
    assert says.replace(" .", " (") in line
    assert "\n" not in line


def test_a_clash_of_values_names_the_point() -> None:
    """Each value is right by itself: the rows' period must be a whole number of steps."""
    with pytest.raises(InputError) as found:
        make_spec(tiny(), {"aircraft.step_rate_hz": (120, 90)})
    assert "aircraft.step_rate_hz" in str(found.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "scenario: tiny.yaml\nvary:\n  air.wind.spd_m_s: [0]\n",
            "s.yaml:3: air.wind.spd_m_s: unknown key",
        ),
        (
            "scenario: tiny.yaml\nvary:\n  air.wind.speed_m_s: [0, -9]\n",
            "s.yaml:3: air.wind.speed_m_s: -9 is",
        ),
        (
            "scenario: tiny.yaml\nvary:\n  air.wind.speed_m_s: []\n",
            "s.yaml:3: vary.air.wind.speed_m_s: has no",
        ),
        ("scenario: tiny.yaml\nvery:\n  a: [1]\n", "s.yaml:2: very: unknown key (did you mean vary?)"),
        ("scenario: tinny.yaml\nvary: {a: [1]}\n", "s.yaml:1: scenario: tinny.yaml: no such scenario"),
        ("vary: {a: [1]}\n", "scenario: no scenario is named"),
        ("scenario: tiny.yaml\nseeds: 0\nvary:\n  air.wind.speed_m_s: [0]\n", "s.yaml:2: seeds: 0 is no number"),
        ("scenario: tiny.yaml\nvary:\n", "s.yaml:2: vary: nothing is varied"),
        ("scenario: tiny.yaml\nvary: [1]\n", "s.yaml:2: vary.0: is no grid"),
        ("scenario: tiny.yaml\nvary: []\n", "s.yaml:2: vary: is an empty list"),
        ("scenario: tiny.yaml\nvary: 3\n", "s.yaml:2: vary: is no mapping"),
        ("scenario: tiny.yaml\nvary:\n  - seeds: []\n", "s.yaml:3: vary.0.seeds: has no values"),
        (
            "scenario: tiny.yaml\nvary:\n  - air.wind.speed_m_s: [0]\n  - air.wind.spd_m_s: [0]\n",
            "s.yaml:4: air.wind.spd_m_s: unknown key",
        ),
        (
            "scenario: tiny.yaml\nvary:\n  - air.wind.speed_m_s: [0]\n  - air.wind.speed_m_s: [0]\n",
            "points 0 and 1 are the same",
        ),
        (
            "scenario: tiny.yaml\nsampling: list\nvary:\n  - control.mode: [fixed]\n  - control.mode: [ideal]\n",
            "s.yaml:2: sampling: list does not go with several grids",
        ),
        (
            "scenario: tiny.yaml\nvary:\n  - air.wind.speed_m_s: {from: 0, to: 1}\n  - control.mode: [fixed]\n",
            "air.wind.speed_m_s: 0 to 1 has no step",
        ),
        ("sweep: 7\nscenario: tiny.yaml\nvary: {a: [1]}\n", "s.yaml:1: sweep: 7 is no known layout"),
        ("scenario: tiny.yaml\nset:\n  air.wnd: 1\nvary: {a: [1]}\n", "s.yaml:3: air.wnd: unknown key"),
        ("scenario: tiny.yaml\nstop_when: x\nvary: {a: [1]}\n", "s.yaml:2: stop_when: 'x' is no rule"),
    ],
)
def test_a_wrong_sweep_file_is_told_with_its_line(tmp_path: Path, text: str, says: str) -> None:
    tiny_file(tmp_path)
    (tmp_path / "s.yaml").write_text(text)
    with pytest.raises(InputError) as found:
        load_sweep(tmp_path / "s.yaml")
    assert says in str(found.value)
