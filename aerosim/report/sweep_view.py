"""What is drawn of a sweep: its numbers, already found, and the words for its keys and metrics."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from aerosim.record import UNITS, unit_of
from aerosim.report.figures import FIGURES, Figure


class Known(Protocol):
    """A number with its confidence limits; all in the metric's unit, NaN where it is not known."""

    @property
    def values(self) -> dict[str, Any]:
        """Values of the varied keys that it is for."""

    @property
    def mean(self) -> float:
        """Mean over the seeds."""

    @property
    def half_width(self) -> float:
        """Half width of the confidence interval."""

    @property
    def seeds(self) -> int:
        """Seeds that it rests on."""

    @property
    def missing(self) -> int:
        """Seeds left out because there is no value."""

    @property
    def failed(self) -> int:
        """Seeds left out because a run failed."""


class Compared(Known, Protocol):
    """A paired difference."""

    @property
    def standard_error(self) -> float:
        """Of the paired mean."""

    @property
    def unpaired_standard_error(self) -> float:
        """What it would be without common seeds."""


class Main(Protocol):
    """A main effect, in the metric's unit."""

    @property
    def key(self) -> str:
        """The varied key."""

    @property
    def value(self) -> Any:
        """Its value; of a slope, the lowest and highest."""

    @property
    def kind(self) -> str:
        """Level or slope."""

    @property
    def effect(self) -> float:
        """Mean of the effect."""

    @property
    def half_width(self) -> float:
        """Half width of its confidence interval."""


class Axes(NamedTuple):
    """Which keys a plot shows: along x, one curve each, one panel each; "" for none.  rest: averaged over."""

    x: str
    curve: str
    panel: str
    rest: tuple[str, ...]


class Pair(NamedTuple):
    """Differences of two values of the compared key: `a` less `b`."""

    a: Any
    b: Any
    differences: Sequence[Compared]
    overall: Compared


@dataclass(frozen=True)
class MetricView:
    """All that is told about one metric.

    means: at each point.  drawn: means by the keys that are drawn.  pairs: of neighbouring values of the compared
    key, told apart by the other drawn keys.  notes: what could not be found, and why.
    """

    figure: Figure
    means: Sequence[Known]
    drawn: Sequence[Known]
    pairs: Sequence[Pair] = ()
    effects: Sequence[Main] = ()
    notes: Sequence[str] = ()


@dataclass(frozen=True)
class SweepView:
    """All that is told about a sweep.

    varied: values of each key in their order.  grid: whether all combinations were flown.  status: words about
    how it ended.  runs, done, failed: rows of the table; planned: runs of the whole sweep.  reasons: failed runs
    by reason and place.  wall_s: time of all runs together.  text: sweep.yaml.  others: metrics told in a table.
    """

    name: str
    purpose: str
    status: str
    varied: Mapping[str, Sequence[Any]]
    grid: bool
    points: int
    seeds: int
    runs: int
    planned: int
    failed: int
    reasons: Sequence[tuple[str, int, str]]
    wall_s: float
    level: float
    axes: Axes
    compared: str
    metrics: Sequence[MetricView]
    text: str
    others: Sequence[MetricView] = field(default=())


def figure_of(path: str) -> Figure:
    """Name, unit and meaning of a metric; made of its path if the reports do not know it."""
    known = next((figure for figure in FIGURES if figure.path == path), None)
    return known or Figure(path, path, unit_of(path), 4, "")


def word(key: str) -> str:
    """A dotted key in words without its unit: ``air.wind.speed_m_s`` is wind speed."""
    suffix = next((suffix for suffix in UNITS if key.endswith(suffix)), "")
    return " ".join(key.removesuffix(suffix).split(".")[-2:]).replace("_", " ")


def axis(key: str) -> str:
    """A key in words with its unit, for an axis."""
    unit = unit_of(key)
    return f"{word(key)} [{unit}]" if unit else word(key)


def told(key: str, value: Any) -> str:
    """A value as in a scenario, with the unit of its key: ``10 m/s``; four digits of a number drawn by lot."""
    if value is None or isinstance(value, bool):
        return "null" if value is None else str(value).lower()
    if isinstance(value, float):
        value = f"{value:.6g}" if f"{value:.6g}" == repr(value) or value.is_integer() else f"{value:.4g}"
    unit = unit_of(key)
    return f"{value} {unit}" if unit else f"{value}"


def less(key: str, pair: Pair) -> str:
    """Two values that are compared, in words: ``10 m/s less 5 m/s``."""
    return f"{told(key, pair.a)} less {told(key, pair.b)}"


def is_number(value: Any) -> bool:
    """Whether a value is a number, not true or false."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def limits(figure: Figure, known: Known) -> str:
    """Mean and half width as text, with as many digits as the half width is worth; a dash if not known."""
    return with_limits(known.mean, known.half_width, figure.digits)


def with_limits(mean: float, half_width: float, digits: int) -> str:
    """``1.234 ± 0.012``: two digits of the half width; without limits, as many as asked for."""
    if mean != mean:  # noqa: PLR0124
        return "–"
    if half_width != half_width or half_width <= 0.0:  # noqa: PLR0124
        return f"{mean:.{digits}f}" + ("" if half_width == 0.0 else " (one seed)")
    places = max(0, 1 - _exponent(half_width))
    return f"{mean:.{places}f} ± {half_width:.{places}f}"


def _exponent(value: float) -> int:
    return int(f"{value:e}".partition("e")[2])
