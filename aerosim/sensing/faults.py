"""Devices that fail: rows and a mount with declared faults.  Sound devices know nothing of this."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from aerosim.sensing.ccd_rows import CcdRows, RowParameters, Spot
from aerosim.sensing.mount import Mount, MountParameters
from aerosim.signals import MountReading, RowExposure
from aerosim.truth import CameraPose


class RowFaults(NamedTuple):
    """What is wrong with the rows.  Times of the simulation, s.

    gain_step: of the amplifier of both rows, as a part, from gain_step_at on.  dead: pixels of row II that read 0.
    blind: the row that reads 0, from blind_from until blind_until.
    """

    gain_step: float = 0.0
    gain_step_at: float = 0.0
    dead: tuple[int, ...] = ()
    blind: Literal["none", "row1", "row2"] = "none"
    blind_from: float = 0.0
    blind_until: float = math.inf


class FaultyRows(CcdRows):
    """Rows with faults.

    A strip in flight at a gain step has row I from before it and row II from after it.  The automatic exposure
    follows the gain with the next strip; a blind row does not move it.
    """

    def __init__(
        self, parameters: RowParameters, faults: RowFaults, start_height: float, rng: np.random.Generator
    ) -> None:
        """See CcdRows."""
        super().__init__(parameters, start_height, rng)
        self._faults = faults
        self._dead = np.array(faults.dead, np.intp)
        self._stepped = False

    def expose(self, pose: CameraPose, spot: Spot, ahead: bool = True) -> RowExposure:
        """See CcdRows."""
        faults = self._faults
        if not self._stepped and pose.t >= faults.gain_step_at:
            self._stepped = True
            self._amplify(1.0 + faults.gain_step)
        before = self._light
        made = super().expose(pose, spot, ahead)
        made.row2[self._dead] = 0.0
        if faults.blind != "none" and faults.blind_from <= pose.t < faults.blind_until:
            getattr(made, faults.blind)[:] = 0.0
            self._light = before if faults.blind == "row2" else self._light
        return made


class MountFaults(NamedTuple):
    """What is wrong with the mount.  s, of the simulation; rad.

    stuck_from, stuck_until: it does not turn.  encoder_bias: added to every reading.
    """

    stuck_from: float = math.inf
    stuck_until: float = math.inf
    encoder_bias: float = 0.0


class FaultyMount(Mount):
    """A mount with faults.  While it sticks its commands pass by; then it turns to the one that is due."""

    def __init__(
        self, parameters: MountParameters, faults: MountFaults, dt: float, rng: np.random.Generator
    ) -> None:
        """See Mount.  Its time begins with its first step."""
        super().__init__(parameters, dt, rng)
        self._bias = faults.encoder_bias
        self._sticks = tuple(_steps(at, dt) for at in (faults.stuck_from, faults.stuck_until))
        self._step = 0

    def advance(self, command: float, steps: int) -> None:
        """See Mount."""
        first, last = self._sticks
        end = self._step + steps
        for until, stuck in ((first, False), (last, True), (math.inf, False)):
            part = int(min(until, end)) - self._step
            if part <= 0:
                continue
            self._step += part
            self._turn(command, part, 0.0 if stuck else self._most)

    def read(self, t: float) -> MountReading:
        """See Mount."""
        reading = super().read(t)
        return reading._replace(yaw=reading.yaw + self._bias)


def _steps(at: float, dt: float) -> float:
    """First step at or after a time (s)."""
    return math.ceil(at / dt - 1e-6) if math.isfinite(at) else math.inf
