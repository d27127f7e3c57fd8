"""A fresh JSBSim with a model loaded: silent, checked, one for each flight."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import jsbsim

from aerosim.errors import InputError

WARN = 3


class _Log(jsbsim.FGLogger):
    """Keeps JSBSim's warnings and errors, prints nothing."""

    def __init__(self) -> None:
        super().__init__()
        self.records: list[str] = []
        self._text = ""

    def message(self, text: str) -> None:
        """Part of a record."""
        self._text += text

    def flush(self) -> None:
        """End of a record."""
        if int(self.log_level) >= WARN and self._text.strip():
            self.records.append(" ".join(self._text.split()))
        self._text = ""


_thread = threading.local()


def _records() -> list[str]:
    """Records of this thread: JSBSim's logger belongs to a thread, its debug level to the process."""
    if not hasattr(_thread, "log"):
        _thread.log = _Log()
    base: Any = jsbsim.FGJSBBase
    base().debug_lvl = 0
    jsbsim.set_logger(_thread.log)
    records: list[str] = _thread.log.records
    return records


def load(folder: Path, step_rate_hz: float) -> tuple[Any, tuple[str, ...]]:
    """JSBSim with the folder's model, and what it warned of.

    A folder bears its model's name.  Raises InputError when the model is missing or refused.
    """
    if not (folder / f"{folder.name}.xml").is_file():
        raise InputError(f"no aircraft model {folder.name}.xml", where=str(folder))
    if not 10.0 <= step_rate_hz <= 10_000.0:
        raise InputError(f"step rate of {step_rate_hz:g} Hz", allowed="10 to 10000 Hz")
    records = _records()
    records.clear()
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_dt(1.0 / step_rate_hz)  # filters take their step while they are loaded
    root = str(folder.resolve().parent)
    try:
        loaded = fdm.load_model_with_paths(folder.name, root, root, root, True)
    except jsbsim.BaseError as error:
        raise InputError(f"aircraft model refused: {error} {' '.join(records)}", where=str(folder)) from error
    if not loaded:
        raise InputError(f"aircraft model refused: {' '.join(records)}", where=str(folder))
    fdm.disable_output()
    return fdm, tuple(records)


def nodes(fdm: Any, names: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """Nodes of properties.  JSBSim would make a missing one, or read it as 0, without a word: InputError here."""
    manager = fdm.get_property_manager()
    found = {name: manager.get_node(name) for name in names}
    missing = [name for name, node in found.items() if node is None]
    if missing:
        raise InputError(f"aircraft model lacks the property {missing[0]}", where=str(folder))
    return found
