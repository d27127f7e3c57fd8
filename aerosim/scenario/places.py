"""Where each key of a scenario was written: line of the file, or the option that set it."""

from __future__ import annotations

from dataclasses import dataclass, field

from aerosim.errors import InputError

Path = tuple[str | int, ...]


def dotted(path: Path) -> str:
    """Key as it is written in messages and after --set."""
    return ".".join(str(part) for part in path)


@dataclass
class Places:
    """Lines and overriding options by dotted key.

    file: as shown in messages.  lines: of each key in the file, from 1.  options: key -> option that set it.
    """

    file: str = ""
    lines: dict[str, int] = field(default_factory=dict)
    options: dict[str, str] = field(default_factory=dict)

    def _nearest(self, key: str) -> tuple[int, str]:
        around = [key]
        while "." in around[-1]:
            around.append(around[-1].rpartition(".")[0])
        for part in around:  # an option replaces all that the file has below its key
            if part in self.options:
                return 0, self.options[part]
        made = next((option for name, option in self.options.items() if name.startswith(f"{key}.")), "")
        if made and key not in self.lines:
            return 0, made
        return next((self.lines[part] for part in around if part in self.lines), 1 if self.file else 0), ""

    def line(self, key: str) -> int:
        """Line to sort by: past all lines if an option set the key, last if it and its section are not written."""
        line, option = self._nearest(key)
        written = any(key == name or key.startswith(f"{name}.") for name in self.lines)
        return 10**9 if option else line if written else 10**9 + 1

    def where(self, key: str) -> str:
        """``file:line``, or the option that set the key, or "" if neither is known."""
        line, option = self._nearest(key)
        return option.strip() or (f"{self.file}:{line}" if self.file else "")

    def error(self, key: str, problem: str, allowed: str = "") -> InputError:
        """Error about a key, with its place."""
        _, option = self._nearest(key)
        if option:  # an option that names the key ends in a blank: `--set air.wind.speed_m_s`
            shown = option + key if option.endswith(" ") else option.strip()
            return InputError(problem, key=shown, allowed=allowed)
        return InputError(problem, key=key, allowed=allowed, where=self.where(key))
