"""The layer rule of the design, from the imports of every module."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import aerosim

PACKAGE = Path(aerosim.__file__).parent

GEOMETRY = {
    "errors",
    "rng",
    "assets",
    "crew",
    "frames",
    "projection",
    "raster",
    "rasterfile",
    "datum",
    "tangent",
    "polygon",
}
RECORD = {"recorder", "record", "rundir"}
STAGES = {"world", "flight", "sensing", "estimation", "control"}
LOOP = STAGES | RECORD | {"signals", "truth", "scenario", "scenario.build", "metrics", "report"}
CALLED = {
    "aerosim",
    "scenario",
    "world",
    "flight",
    "formats",
    "metrics",
    "report",
    "forecast",
    "simulate",
    "sweep",
    "tune",
}

# part -> what it may import besides itself.  A part is a module or a folder right below aerosim/;
# scenario.build is its own part: the only place that maps a scenario to the stages' parameters.
ALLOWED: dict[str, set[str]] = {
    **dict.fromkeys(GEOMETRY, GEOMETRY),
    "signals": GEOMETRY,
    "truth": GEOMETRY,
    "scenario": GEOMETRY,
    "scenario.build": GEOMETRY | STAGES | {"scenario", "formats"},
    # files of other programs: their geometry and nothing else
    "formats": GEOMETRY,
    "world": GEOMETRY | {"truth"},
    "flight": GEOMETRY | {"truth"},
    "sensing": GEOMETRY | {"signals", "truth"},
    "estimation": GEOMETRY | {"signals"},
    "control": GEOMETRY | {"signals"},
    "geolocation": GEOMETRY,
    **dict.fromkeys(RECORD, GEOMETRY | RECORD | {"signals", "truth", "scenario"}),
    "metrics": GEOMETRY | RECORD | {"signals", "truth"},
    "report": GEOMETRY | RECORD | {"metrics"},
    "forecast": GEOMETRY | {"scenario", "scenario.build", "world", "flight", "metrics", "formats"},
    "tune": GEOMETRY | RECORD | {"scenario", "estimation"},
    "simulate": GEOMETRY | LOOP,
    "sweep": GEOMETRY | RECORD | {"scenario", "scenario.build", "flight", "metrics", "simulate", "report"},
    # the verbs: thin, but they may call everything that a Python user can
    "cli": GEOMETRY | RECORD | CALLED,
    "__main__": {"cli"},
    # public names, imported when first asked for
    "aerosim": {"record", "scenario", "simulate", "sweep"},
}

# (module, imported module): why the rule's spirit holds.  Each must still be in use.
EXCEPTIONS: dict[tuple[str, str], str] = {
    ("metrics.strips", "estimation.motion"): (
        "what a strip says by itself is the estimator's reading of it, and no second formula"
    ),
    ("report.source", "scenario"): "the scenario of the run that is drawn, out of its directory",
    ("report.source", "scenario.build"): "opens the terrain that the record names, to draw it",
    ("report.source", "world.terrain"): "the type of that terrain",
    ("report.plan_map", "forecast"): "the plan that is drawn, its ways and footprints",
    ("report.track_map", "forecast"): "the plan that is drawn, and what the rows will make of its land",
    ("forecast.strip_forecast", "estimation.mad"): "what makes a trough is the recogniser's judgement",
    ("forecast.strip_forecast", "sensing.ccd_rows"): "where automatic exposure brings the rows, and its limits",
}


def modules(package: Path = PACKAGE) -> dict[str, Path]:
    """Every module by its dotted name below aerosim; the package itself is ``aerosim``."""
    found = {}
    # an installed package carries the scripts that made its data; they are not of the package
    for file in sorted(f for f in package.rglob("*.py") if "_data" not in f.parts):
        parts = file.relative_to(package).with_suffix("").parts
        found[".".join(part for part in parts if part != "__init__") or "aerosim"] = file
    return found


MODULES = modules()


def imported(source: str, module: str, is_package: bool, known: set[str]) -> Iterator[str]:
    """Modules of aerosim that a source text imports, wherever in the text, also for types only."""

    def named(full: str) -> str | None:
        head, _, rest = full.partition(".")
        return (rest or "aerosim") if head == "aerosim" else None

    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (name for alias in node.names if (name := named(alias.name)))
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                here = ["aerosim", *([] if module == "aerosim" else module.split("."))]
                above = here[: len(here) - node.level + is_package]
                base = ".".join([*above, *([base] if base else [])])
            if (name := named(base)) is None:
                continue
            for alias in node.names:
                below = alias.name if name == "aerosim" else f"{name}.{alias.name}"
                yield below if below in known else name
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "__import__")):
            for each in node.args:
                if isinstance(each, ast.Constant) and isinstance(each.value, str) and (name := named(each.value)):
                    yield name


def part_of(module: str) -> str:
    inside_build = module == "scenario.build" or module.startswith("scenario.build.")
    return "scenario.build" if inside_build else module.split(".", maxsplit=1)[0]


def excepted(module: str, other: str) -> bool:
    return (module, other) in EXCEPTIONS or (module, part_of(other)) in EXCEPTIONS


def offences(module: str, source: str, is_package: bool = False) -> list[str]:
    """Imports of a module that the rule forbids, as ``module imports other``."""
    mine = part_of(module)
    return [
        f"{module} imports {other}"
        for other in sorted(set(imported(source, module, is_package, set(MODULES))))
        if part_of(other) != mine and part_of(other) not in ALLOWED[mine] and not excepted(module, other)
    ]


@pytest.mark.parametrize("module", MODULES)
def test_layer_rule(module: str) -> None:
    assert part_of(module) in ALLOWED, "a new part of the package: say what it may import"
    file = MODULES[module]
    assert offences(module, file.read_text(encoding="utf-8"), file.name == "__init__.py") == []


@pytest.mark.parametrize("module", sorted({module for module, _ in EXCEPTIONS}))
def test_exceptions_are_still_needed(module: str) -> None:
    file = MODULES[module]
    used = set(imported(file.read_text(encoding="utf-8"), module, False, set(MODULES)))
    assert {other for one, other in EXCEPTIONS if one == module} <= used | {part_of(each) for each in used}


@pytest.mark.parametrize(
    ("module", "source"),
    [
        ("estimation.mad", "from aerosim.truth import AircraftState"),
        ("estimation.mad", "def f():\n    from aerosim.world.terrain import Terrain"),
        ("estimation.motion", "if TYPE_CHECKING:\n    from aerosim.sensing import oracle"),
        ("estimation.motion", "from ..truth import AircraftState"),
        ("estimation.motion", "from .. import truth"),
        ("control.law", "import aerosim.flight.plan as plan"),
        ("control.law", "from aerosim.estimation.motion import StripMotion"),
        ("control.law", "importlib.import_module('aerosim.world.air')"),
        ("geolocation.chain", "from aerosim import truth"),
        ("flight.guidance", "from aerosim.scenario import Scenario"),
        ("flight.guidance", "from aerosim.world.air import Air"),
        ("flight.guidance", "from aerosim.sensing.mount import Mount"),
        ("frames", "from aerosim.world.terrain import Terrain"),
        ("raster", "from aerosim.signals import Grey"),
        ("signals", "from aerosim.truth import CameraPose"),
        ("scenario.mount", "from aerosim.sensing.mount import Mount"),
        ("scenario.mount", "from aerosim.scenario.build import build"),
        ("world.air", "from aerosim.scenario.air import Air"),
        ("sensing.mount", "from aerosim.estimation.motion import MotionEstimator"),
        ("record", "from aerosim.metrics.summary import summarise"),
        ("rundir", "from aerosim.report.page import write_report"),
        ("metrics.summary", "from aerosim.world.terrain import Terrain"),
        ("report.page", "from aerosim.simulate import simulate"),
        ("report.page", "from aerosim import simulate"),
        ("forecast.check", "from aerosim.simulate import simulate"),
        ("forecast.check", "from aerosim.estimation.strips import StripRecogniser"),
        ("cli.flights", "from aerosim.estimation.strips import StripRecogniser"),
    ],
)
def test_a_bad_import_is_found(module: str, source: str) -> None:
    assert len(offences(module, source)) == 1


def test_a_good_import_is_none() -> None:
    source = "from aerosim.signals import Grey\nfrom . import kalman\nfrom aerosim import frames\nimport numpy"
    assert offences("estimation.strips", source) == []
    assert offences("estimation", "from . import mad", is_package=True) == []


def test_only_the_command_line_and_sweeps_call_the_loop() -> None:
    callers = {part for part, allowed in ALLOWED.items() if "simulate" in allowed}
    assert callers == {"aerosim", "cli", "sweep"}


def test_data_flows_one_way() -> None:
    """No part of the chain may import a later one, whatever the table above allows."""
    chain = [{"scenario"}, {"world"}, {"flight"}, {"sensing"}, {"estimation"}, {"control"}, RECORD, {"metrics"}]
    chain += [{"forecast"}, {"report"}, {"simulate"}, {"cli"}]
    for place, parts in enumerate(chain):
        later = set().union(*chain[place + 1 :])
        for part in parts:
            assert not ALLOWED[part] & later, part
    order = {part: place for place, parts in enumerate(chain) for part in parts}
    for module, other in EXCEPTIONS:
        if part_of(other) != "scenario.build":
            assert order[part_of(other)] < order[part_of(module)]


def test_belief_loads_no_truth() -> None:
    """Seen from a fresh process, where an import by any means shows."""
    code = (
        "import sys, aerosim.estimation.motion, aerosim.estimation.strips, aerosim.control.law\n"
        "print(*sorted(m for m in sys.modules if m.startswith('aerosim.')))"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert {part_of(name.removeprefix("aerosim.")) for name in loaded} <= GEOMETRY | {
        "signals",
        "estimation",
        "control",
    }
