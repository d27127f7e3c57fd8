"""What goes wrong, in two kinds: an input that the user can mend, and a run that failed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path


@dataclass(eq=False)
class InputError(Exception):
    """Wrong input (exit 2), printed as one line ``where: key: problem (allowed)``.

    problem: what is wrong, without a full stop.  key: dotted scenario key, or an option's name.
    allowed: what would be right, or the nearest name.  where: ``file`` or ``file:line``.
    """

    problem: str
    key: str = ""
    allowed: str = ""
    where: str = ""

    def __str__(self) -> str:
        """One line, whatever a library's message brought along."""
        head = ": ".join(part for part in (self.where, self.key, self.problem) if part)
        line = f"{head} ({self.allowed})" if self.allowed else head
        return " ".join(line.split())

    def at(self, *, key: str = "", where: str = "") -> InputError:
        """The same error with key and place filled in where they were not known yet."""
        return replace(self, key=self.key or key, where=self.where or where)


class RunFailure(Exception):  # noqa: N818  (it is the run's end, recorded as such)
    """A run that cannot go on (exit 3): aircraft lost, terrain left, disk full.

    path: the directory that holds the record up to there, None if there is none.
    """

    path: Path | None = None


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in flight (exit 130).

    path: the directory that holds the record up to there, None if there is none.
    """

    path: Path | None = None
