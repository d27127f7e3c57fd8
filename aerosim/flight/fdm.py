"""A fresh JSBSim with a model loaded: silent, checked, one for each flight."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import jsbsim

from aerosim.errors import InputError

WARN = 3


class _Log(jsbsim.FGLogger):
    """Keeps JSBSim's warnings and errors, prints nothing."""

    def __init__(self, heard: Callable[[str], None]) -> None:
        super().__init__()
        self._heard = heard
        self._text = self._place = ""

    def file_location(self, filename: str, line: int) -> None:
        """File and line that a record is about."""
        self._place = f"{Path(filename).name}:{line}: "

    def message(self, text: str) -> None:
        """Part of a record."""
        self._text += text

    def flush(self) -> None:
        """End of a record."""
        if int(self.log_level) >= WARN and self._text.strip():
            self._heard(self._place + " ".join(self._text.split()))
        self._text = self._place = ""


@contextmanager
def _listening(heard: Callable[[str], None]) -> Iterator[None]:
    """Pass on what JSBSim warns of meanwhile, heard in the main thread alone.

    JSBSim keeps a logger for each thread and, when a thread ends, lets go of a Python one without holding the
    interpreter: the process then dies now and then.  So other threads keep JSBSim's own logger, which prints
    errors; with the debug level at 0 (of the whole process) a sound model says nothing.
    """
    base: Any = jsbsim.FGJSBBase
    base().debug_lvl = 0
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    log, before = _Log(heard), jsbsim.get_logger()
    jsbsim.set_logger(log)
    try:
        yield
    finally:
        jsbsim.set_logger(before)


def load(
    folder: Path, step_rate_hz: float, heard: Callable[[str], None] | None = None
) -> tuple[Any, tuple[str, ...]]:
    """JSBSim with the folder's model, and what it warned of.

    A folder bears its model's name.  heard: is told each warning at once, before JSBSim may end the process.
    Raises InputError when the model is missing or refused.
    """
    if not (folder / f"{folder.name}.xml").is_file():
        raise InputError(f"no aircraft model {folder.name}.xml", where=str(folder))
    if not 10.0 <= step_rate_hz <= 10_000.0:
        raise InputError(f"step rate of {step_rate_hz:g} Hz", allowed="10 to 10000 Hz")
    records: list[str] = []

    def keep(record: str) -> None:
        records.append(record)
        if heard is not None:
            heard(record)

    with _listening(keep):
        return _load(folder, 1.0 / step_rate_hz, records), tuple(records)


def _load(folder: Path, period: float, records: list[str]) -> Any:
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_dt(period)  # filters take their step while they are loaded
    # Not resolved: the model bears the name of the link.  Nothing is looked for outside the folder.
    here = Path(os.path.abspath(folder))
    paths = (str(here.parent), str(here / "Engines"), str(here / "Systems"))
    try:
        loaded = fdm.load_model_with_paths(folder.name, *paths, True)
    except jsbsim.BaseError as error:
        raise _refused(folder, records, str(error)) from error
    if not loaded:
        raise _refused(folder, records)
    fdm.disable_output()
    return fdm


def _refused(folder: Path, records: list[str], error: str = "") -> InputError:
    """What JSBSim had to say, each thing once."""
    said = list(dict.fromkeys(records))
    if error and not any(" ".join(error.split()) in record for record in said):
        said.append(error)
    return InputError(f"aircraft model refused: {' '.join(said)}", where=str(folder))


def nodes(fdm: Any, names: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """Nodes of properties.  JSBSim would make a missing one, or read it as 0, without a word: InputError here."""
    manager = fdm.get_property_manager()
    found = {name: manager.get_node(name) for name in names}
    missing = [name for name, node in found.items() if node is None]
    if missing:
        raise InputError(f"aircraft model lacks the property {missing[0]}", where=str(folder))
    return found
