"""A user's own aircraft, tried in a process of its own: JSBSim may end or hang the process on a bad model."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from aerosim.errors import InputError
from aerosim.flight.own.limitscheck import check_limits
from aerosim.flight.own.xmlcheck import Source, check_xml, refusal

TIME_LIMIT_S = 20.0
MEMORY_LIMIT = 4 << 30
PRINT_LIMIT = 8 << 20
WORDS_MAX = 300  # characters of JSBSim's last words in a message
MARK = "aerosim-probe "
PROGRAM = """
import json, sys
sys.path[:] = json.loads(sys.argv[1])
from aerosim.flight.own.probe import main
main(sys.argv[2:])
"""
STAGES = {
    "start": "before it was loaded",
    "load": "while it was loaded",
    "trim": "while it was trimmed",
    "fly": "in its first seconds of flight",
}
CRASHES = {
    "SIGSEGV": "as functions that call each other without an end do",
    "SIGKILL": "as a model that fills the memory does",
}

_known: dict[str, InputError | None] = {}


def check_model(folder: Path, step_rate_hz: float, fuel_kg: float | None = None) -> None:
    """Raise InputError if a folder's model cannot be flown: place in its files, what is wrong, what is needed.

    folder: bears its model's name.  step_rate_hz: of the flight.  fuel_kg: None, or more than the aircraft can
    carry, tries what the limits file says.  A process tries a model once, as long as its files stay the same.
    """
    folder = Path(os.path.abspath(folder))
    sources = check_xml(folder)
    limits, content = check_limits(folder)
    if fuel_kg is not None and not 0.0 < fuel_kg <= limits.fuel_max_kg:
        fuel_kg = None
    digest = hashlib.sha256(repr((str(folder), step_rate_hz, fuel_kg)).encode() + content)
    for path, source in sources.items():
        digest.update(repr(str(path)).encode() + source.content)
    key = digest.hexdigest()
    if key not in _known:
        _known[key] = _probe(folder, step_rate_hz, fuel_kg, list(sources.values()))
    if (found := _known[key]) is not None:
        raise InputError(found.problem, allowed=found.allowed)


@dataclass(frozen=True)
class _End:
    """How a probe ended: return code (None: too late), its last stage, its verdict if there is one, last words."""

    code: int | None
    stage: str
    verdict: dict[str, str] | None
    words: str


def _probe(folder: Path, rate: float, fuel: float | None, sources: list[Source]) -> InputError | None:
    """Try a model.  Returns what is wrong with it."""
    end = _run([str(folder), repr(float(rate)), "-" if fuel is None else repr(float(fuel))])
    if end.code == 0 and end.verdict is not None:
        problem = end.verdict["problem"]
        return refusal(_place(problem, folder, sources), problem, end.verdict["allowed"]) if problem else None
    if end.code is None:
        problem = f"JSBSim did not end within {TIME_LIMIT_S:g} s {STAGES[end.stage]}"
        return refusal(folder.name, problem, "a model that steps in microseconds")
    what = f"exit code {end.code}"
    with contextlib.suppress(ValueError):
        what = signal.Signals(-end.code).name
    words = f": {end.words}" if end.words else f", {CRASHES[what]}" if what in CRASHES else ""
    return refusal(_place(end.words, folder, sources), f"JSBSim crashed ({what}) {STAGES[end.stage]}{words}")


def _place(words: str, folder: Path, sources: list[Source]) -> str:
    """File and line where a property that a message names is read or made, or the folder."""
    named = {word.strip(".,:;()\"'") for word in words.split()}
    for source in sources:
        for element in source.root.walk():
            if "/" in (text := element.text.strip().lstrip("-")) and text in named:
                return f"{source.place}:{element.line}"
    return folder.name


def _run(arguments: list[str]) -> _End:
    """Run the probe, and end it with all its children when it is late."""
    # The parent's own modules, wherever they came from; one thread each, or the memory limit would be theirs.
    path = [*filter(None, sys.path), str(Path(__file__).resolve().parents[2])]
    single = dict.fromkeys(
        ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
    )
    environment = {**os.environ, **single, "PYTHONIOENCODING": "utf-8", "JSBSIM_DEBUG": "0"}
    with tempfile.TemporaryFile() as said:
        child = subprocess.Popen(
            [sys.executable, "-P", "-c", PROGRAM, json.dumps(path), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=subprocess.STDOUT,
            env=environment,
            start_new_session=True,
        )
        try:
            code: int | None = child.wait(TIME_LIMIT_S)
        except subprocess.TimeoutExpired:
            code = None
        finally:
            _end(child)
        return _heard(code, said)


def _end(child: subprocess.Popen[bytes]) -> None:
    """End a probe that still runs, with its process group where there are any."""
    if child.poll() is None:
        with contextlib.suppress(ProcessLookupError):
            if hasattr(os, "killpg"):
                os.killpg(child.pid, signal.SIGKILL)
            else:
                child.kill()
        child.wait()


def _heard(code: int | None, said: IO[bytes]) -> _End:
    said.seek(0)
    lines = said.read(PRINT_LIMIT).decode("utf-8", "replace").splitlines()
    stage, verdict, words = "start", None, []
    for line in lines:
        if not line.startswith(MARK):
            words.append(line.strip())
            continue
        told = json.loads(line[len(MARK) :])
        stage, verdict = told.get("stage", stage), told.get("verdict", verdict)
    return _End(code, stage, verdict, _last_words(words))


def _last_words(lines: list[str]) -> str:
    """What JSBSim said last: of an exception its text, else the last line."""
    for line in reversed(lines):
        if line.startswith("what():"):
            return line.removeprefix("what():").strip()[:WORDS_MAX]
    return next((line for line in reversed(lines) if line), "")[:WORDS_MAX]


def _tell(**what: object) -> None:
    """Word to the parent, at once: the process may be gone the next moment."""
    print(MARK + json.dumps(what), flush=True)


def _bound() -> None:
    """No memory without limit, no core file, no endless text, where the system can do that.

    And no endless time: whoever started this may have died before it could end it.
    """
    try:
        import resource
    except ImportError:
        return
    for kind, wanted in (
        (resource.RLIMIT_AS, MEMORY_LIMIT),
        (resource.RLIMIT_CORE, 0),
        (resource.RLIMIT_FSIZE, PRINT_LIMIT),
        (resource.RLIMIT_CPU, round(2.0 * TIME_LIMIT_S)),
    ):
        _, hard = resource.getrlimit(kind)
        least = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(kind, (least, hard))


def main(arguments: list[str]) -> None:
    """The probe itself: folder, step rate in Hz, fuel in kg or `-`."""
    _bound()
    from aerosim.flight.own.tryout import try_out

    folder, rate, fuel = arguments
    verdict = {"problem": "", "allowed": ""}
    try:
        with contextlib.redirect_stdout(sys.stderr):
            try_out(Path(folder), float(rate), None if fuel == "-" else float(fuel), _stage, _said)
    except InputError as error:
        verdict = {"problem": error.problem, "allowed": error.allowed}
    _tell(verdict=verdict)


def _stage(name: str) -> None:
    _tell(stage=name)


def _said(record: str) -> None:
    print(record, flush=True)
