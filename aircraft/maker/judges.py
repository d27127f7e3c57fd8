"""What modes are judged by: a standard's limits, and an aircraft whose motions were measured."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

from maker.linear import Motions


class Judged(Protocol):
    """A trim whose modes are judged."""

    @property
    def equations(self) -> Motions:
        """Its modes."""

    @property
    def height(self) -> float:
        """m."""

    @property
    def airspeed(self) -> float:
        """m/s."""


class Verdict(NamedTuple):
    """One figure, what is allowed, and whether it is inside."""

    name: str
    value: float
    low: float
    high: float

    @property
    def inside(self) -> bool:
        """Whether the value is allowed."""
        return self.low <= self.value <= self.high


def level_one(m: Motions) -> list[Verdict]:
    """MIL-F-8785C, class II, category B, level 1, as heli-air.net quotes tables 10.1 to 10.3.

    A spiral may double its bank in no less than 20 s: a rate of at most ln 2 / 20 per s.
    """
    return [
        Verdict("roll time constant, s", m.roll_s, 0.0, 1.4),
        Verdict("dutch roll damping", m.dutch_roll_damping, 0.08, math.inf),
        Verdict("dutch roll damping times frequency, rad/s", m.dutch_roll * m.dutch_roll_damping, 0.15, math.inf),
        Verdict("dutch roll frequency, rad/s", m.dutch_roll, 0.4, math.inf),
        Verdict("spiral, growth of the bank, 1/s", -1.0 / m.spiral_s, -math.inf, math.log(2.0) / 20.0),
    ]


def measured(m: Motions) -> list[Verdict]:
    """Against the measured Cessna Citation II (TU Delft, course AE3212, two flights near this point).

    Its own published derivatives miss its measured flights by 8 % in dutch-roll period, 20 % in phugoid period and
    a factor of two in damping: the ranges are the measured ones, widened by that.
    """
    phugoid = (math.log(2.0) / (79.0 * 2.0 * math.pi / 41.0), math.log(2.0) / (69.0 * 2.0 * math.pi / 41.0))

    def period(frequency: float, damping: float) -> float:
        return 2.0 * math.pi / (frequency * math.sqrt(1.0 - damping**2))

    return [
        Verdict("dutch roll period, s", period(m.dutch_roll, m.dutch_roll_damping), 3.3 * 0.92, 3.4 * 1.08),
        Verdict("dutch roll damping", m.dutch_roll_damping, 0.08 / 2.0, 0.13 * 2.0),
        Verdict("phugoid period, s", period(m.phugoid, m.phugoid_damping), 41.0 * 0.8, 41.0 * 1.2),
        Verdict("phugoid damping", m.phugoid_damping, phugoid[0] / 2.0, phugoid[1] * 2.0),
    ]


def table(verdicts: list[Verdict]) -> str:
    """Rows of verdicts."""

    def allowed(v: Verdict) -> str:
        if math.isinf(v.high):
            return f"{v.low:.3g} and more"
        return f"at most {v.high:.3g}" if v.low in (0.0, -math.inf) else f"{v.low:.3g} to {v.high:.3g}"

    rows = [f"| {v.name} | {v.value:.3g} | {allowed(v)} | {'yes' if v.inside else 'no'} |" for v in verdicts]
    return "\n".join(["| | value | allowed | inside |", "|---|---|---|---|", *rows, ""])


def judges(at: Judged) -> str:
    """Text and tables of both judges."""
    return f"""
### Judged at {at.height:g} m and {at.airspeed:g} m/s

MIL-F-8785C, class II, category B, level 1 (as heli-air.net quotes its tables):

{table(level_one(at.equations))}
A measured twin, though a heavier jet, the Cessna Citation II (TU Delft, course AE3212: dutch roll 3.3 to 3.4 s,
damping 0.08 to 0.13, phugoid 41 s, half in 69 to 79 s, spiral -51 s in one flight).  Its ranges are widened by
what a derivative model of that very aircraft misses them by: 8 % of the dutch roll's period, 20 % of the
phugoid's, a factor of two in damping.  It is another, heavier aircraft at the same lift coefficient: "yes" says
that the motions are those of the class, "no" that this aircraft moves otherwise than a Citation, not that it is
wrong.  The spiral is stable here and unstable there; under the autopilot neither matters.

{table(measured(at.equations))}"""
