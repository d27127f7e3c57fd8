"""Observers: what turns the devices' signals into drift and v/h.  The loop knows no more of them than this."""

from __future__ import annotations

from typing import Protocol

from aerosim.estimation.integer_strips import IntegerRecogniser
from aerosim.estimation.motion import UNKNOWN, MotionEstimator
from aerosim.estimation.strips import StripRecogniser
from aerosim.signals import Aids, MotionEstimate, MountReading, RowExposure, StripMatch, StripUse

Decided = tuple[StripMatch, StripUse]


class Observer(Protocol):
    """Drift and v/h out of rows, mount encoder and aids."""

    def opens(self) -> bool:
        """Whether the next exposure begins a strip: the moment to find the exposure time anew."""

    def switch(self, t: float) -> list[Decided]:
        """The rows are switched on or off at time t (s), the course is another: what was known is void.

        Returns the strips in flight, given up.
        """

    def feel(self, aids: Aids) -> None:
        """Take the readings of the other devices, at each exposure time, rows on or off."""

    def see(self, exposure: RowExposure, mount: MountReading) -> list[Decided]:
        """Take one exposure of both rows, after the aids of that moment; returns the strips that it decided."""

    def now(self) -> MotionEstimate:
        """What is believed now."""


class RowObserver:
    """Strips and two scalar filters: the instrument of 1988, and `pipelined`."""

    def __init__(self, recogniser: StripRecogniser | IntegerRecogniser, estimator: MotionEstimator) -> None:
        """Both are this observer's own."""
        self._recogniser, self._estimator = recogniser, estimator

    def opens(self) -> bool:
        """See Observer."""
        return self._recogniser.opens()

    def switch(self, t: float) -> list[Decided]:
        """See Observer."""
        given_up = [(match, self._estimator.add(match)) for match in self._recogniser.switch(t)]
        self._estimator.begin_line()
        return given_up

    def feel(self, aids: Aids) -> None:
        """Nothing but the rows counts."""

    def see(self, exposure: RowExposure, mount: MountReading) -> list[Decided]:
        """See Observer."""
        return [(match, self._estimator.add(match)) for match in self._recogniser.add(exposure, mount)]

    def now(self) -> MotionEstimate:
        """See Observer."""
        return self._estimator.now()


class ToldObserver:
    """Believes what it is told.  The strips of the rows are recognised and recorded, and change nothing."""

    def __init__(self, rows: RowObserver) -> None:
        """rows: recognises the strips."""
        self._rows = rows
        self._told = UNKNOWN

    def opens(self) -> bool:
        """See Observer."""
        return self._rows.opens()

    def switch(self, t: float) -> list[Decided]:
        """See Observer.  What is told does not depend on the rows."""
        return self._rows.switch(t)

    def feel(self, aids: Aids) -> None:
        """Keep what was told last."""
        if aids.told is not None:
            self._told = aids.told

    def see(self, exposure: RowExposure, mount: MountReading) -> list[Decided]:
        """See Observer."""
        return self._rows.see(exposure, mount)

    def now(self) -> MotionEstimate:
        """See Observer."""
        return self._told
