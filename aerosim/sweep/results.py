"""A sweep to be read: its table, its figures and what the statistics say of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aerosim.errors import InputError
from aerosim.sweep import folder
from aerosim.sweep.stoprule import LEVEL
from aerosim.sweep.table import metrics_of, parameters_of, read_table

if TYPE_CHECKING:
    import pyarrow as pa

    from aerosim.sweep.spec import SweepSpec
    from aerosim.sweep.stats import Difference, Effect, Mean


class Sweep:
    """A sweep directory that was opened."""

    def __init__(self, path: Path | str) -> None:
        """Raises InputError if there is no sweep."""
        self.path = Path(path)
        file = self.path / folder.SUMMARY
        try:
            self.summary: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        except FileNotFoundError as error:
            raise InputError(
                "is no finished sweep: it has no summary.json", where=str(self.path), allowed="--resume ends it"
            ) from error
        except (OSError, ValueError) as error:
            raise InputError(f"cannot be read: {error}", where=str(file)) from error

    def __repr__(self) -> str:
        """Where it is and how it stands."""
        told = ", ".join(f"{self.summary[key]} {key}" for key in ("points", "seeds", "done", "failed"))
        return f"Sweep({str(self.path)!r}: {told})"

    @cached_property
    def table(self) -> pa.Table:
        """One row per (point, seed): see runs_table."""
        return read_table(self.path / folder.TABLE)

    @property
    def parameters(self) -> list[str]:
        """The varied keys."""
        return parameters_of(self.table)

    @property
    def metrics(self) -> list[str]:
        """Figures of the runs that are numbers."""
        return metrics_of(self.table)

    @cached_property
    def spec(self) -> SweepSpec:
        """What was swept."""
        from aerosim.sweep.specfile import load_sweep

        return load_sweep(self.path / folder.SPEC)

    def means(self, metric: str, by: Sequence[str] | None = None, level: float = LEVEL) -> list[Mean]:
        """Means with confidence limits, for each combination of values of the keys `by` (default: all varied).

        Raises InputError for an unknown name.
        """
        from aerosim.sweep import stats

        return stats.means(self.table, metric, self.parameters if by is None else by, level)

    def paired(
        self,
        metric: str,
        key: str,
        a: Any,
        b: Any,
        by: Sequence[str] | None = None,
        level: float = LEVEL,
    ) -> list[Difference]:
        """Differences of the metric over common seeds, at value `a` of the key less at `b`.

        by: keys that they are told apart by (default: all others).  Raises InputError for an unknown name.
        """
        from aerosim.sweep import stats

        return stats.paired(self.table, metric, key, a, b, self.parameters, by, level)

    def effects(self, metric: str, level: float = LEVEL) -> list[Effect]:
        """Main effects of the varied keys on the metric.  Raises InputError for an unknown name."""
        from aerosim.sweep import stats

        return stats.effects(self.table, metric, self.parameters, level)

    def plot(self, metric: str, **axes: Any) -> Any:
        """Means of a metric over what was varied, with confidence bands: a matplotlib figure.

        axes: keys `x`, `curve` and `panel`, see aerosim.sweep.plotting.plot.  Raises InputError.
        """
        from aerosim.sweep.plotting import plot

        return plot(self.table, metric, **axes)


def open_sweep(path: Path | str) -> Sweep:
    """Open a sweep directory.  Raises InputError if it is none."""
    return Sweep(path)
