"""The observer of mode `best`: rows and inertial unit in, drift and v/h of this moment out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from aerosim.estimation.motion import UNKNOWN, UNUSED
from aerosim.estimation.observer import Decided
from aerosim.estimation.tracking.channel import GATE, Channel
from aerosim.estimation.tracking.geometry import PUSHED, TIME, TURNED
from aerosim.estimation.tracking.lag_filter import WalkModel
from aerosim.estimation.tracking.levelling import Levelled
from aerosim.estimation.tracking.strips import Strips, StripSetup, Window
from aerosim.estimation.tracking.supervisor import State, Supervisor
from aerosim.estimation.tracking.yaw_rate import YawRate
from aerosim.frames import GRAVITY
from aerosim.signals import (
    Aids,
    MotionEstimate,
    MountReading,
    Reason,
    RowExposure,
    StripMatch,
    StripUse,
)

SLANT, SLANT_FROM = math.radians(4.0), math.radians(1.0)  # looked for from such a scatter of blocks on
Aiding = Literal["none", "gyro", "bank", "imu"]


@dataclass(frozen=True)
class TrackerParameters:
    """What mode `best` assumes.

    planned_vh: 1/s; planned_height: above the mean land, m (it makes a speed of v/h).  aiding: what the inertial
    unit gives.  track, vh: models of what wanders beyond the accelerations (rad, shares).  block: s, in which
    strips are taken together; floor_*, noise_*: least and first variance of a block.  scatter_*: of strips that
    agree, before the noise is known.  gyro_drift (rad/s), level_sigma (rad), level_time (s): the unit's data
    sheet.
    """

    strips: StripSetup
    planned_vh: float
    planned_height: float
    aiding: Aiding
    track: WalkModel
    vh: WalkModel
    block: float
    floor_track: float
    floor_vh: float
    noise_track: float
    noise_vh: float
    scatter_track: float
    scatter_vh: float
    gyro_drift: float
    level_sigma: float
    level_time: float


class Tracker:
    """Follows every strip through a window around its prediction, and the track through a filter with delay."""

    def __init__(self, parameters: TrackerParameters) -> None:
        """Nothing is known before three strips agree."""
        par = self._par = parameters
        setup = par.strips
        self._strips = Strips(setup)
        self._log_planned = math.log(par.planned_vh)
        span = setup.planned_n * setup.period
        step = max(1, round(span / 26.0 / setup.period)) * setup.period
        reach = setup.search[1] * span + 4.0
        # without a gyro drift is followed; it wanders with the heading, of which a strip has the two end values
        blind = par.aiding == "none"
        self._track = Channel(par.track, step, reach, par.floor_track, par.noise_track, ends=blind)
        self._speed = Channel(par.vh, step, reach, par.floor_vh, par.noise_vh)
        self._roll = Levelled(par.gyro_drift, par.level_sigma, par.level_time)
        self._pitch = Levelled(par.gyro_drift, par.level_sigma, par.level_time)
        self._yaw_rate = YawRate()
        self._angles = (0.0, 0.0, 0.0)  # roll, pitch, yaw in the gyro's frame
        self._void()

    def _void(self) -> None:
        self._guard = Supervisor()
        self._turn = self._push = 0.0  # what accelerations say since the line began: rad, log
        self._turned = self._pushed = 0.0  # their integrals
        self._t = math.nan
        self._block_ends = math.nan
        self._beyond = 0
        self._seek = 0.0
        self._fresh = False

    # what the loop calls

    def opens(self) -> bool:
        """See Observer."""
        return self._strips.opens()

    def switch(self, t: float) -> list[Decided]:
        """See Observer."""
        given_up: list[Decided] = [(match, UNUSED) for match in self._strips.give_up(t)]
        self._void()
        return given_up

    def feel(self, aids: Aids) -> None:
        """Take the inertial unit's reading: attitude, and what the accelerations do to track and speed."""
        unit = aids.inertial
        if unit is None:
            return
        roll = self._roll(unit.t, unit.roll, unit.level_roll)
        pitch = self._pitch(unit.t, unit.pitch, unit.level_pitch)
        self._angles = (roll, pitch, unit.yaw)
        self._yaw_rate(unit.t, unit.yaw)
        span = unit.t - self._t if not math.isnan(self._t) else 0.0
        self._t = unit.t
        if span <= 0.0 or self._guard.state is State.SEEKING or self._par.aiding == "gyro":
            return
        speed = math.exp(self._log_vh(unit.t)) * self._par.planned_height
        ahead, right = self._accelerations(roll, pitch, unit.accel_x, unit.accel_y, unit.accel_z)
        drift = self._track_now(unit.t) - unit.yaw
        across = right * math.cos(drift) - ahead * math.sin(drift)
        along = ahead * math.cos(drift) + right * math.sin(drift)
        turn, push = across / speed * span, along / speed * span
        self._turned += (self._turn + 0.5 * turn) * span
        self._pushed += (self._push + 0.5 * push) * span
        self._turn += turn
        self._push += push

    def _accelerations(self, roll: float, pitch: float, x: float, y: float, z: float) -> tuple[float, float]:
        """Level acceleration ahead and to the right of the nose, m/s^2; a bank alone turns as g tan(bank)."""
        if self._par.aiding == "bank":
            return 0.0, GRAVITY * math.tan(roll)
        sr, cr, sp, cp = math.sin(roll), math.cos(roll), math.sin(pitch), math.cos(pitch)
        return cp * x + sp * (sr * y + cr * z), cr * y - sr * z

    def see(self, exposure: RowExposure, mount: MountReading) -> list[Decided]:
        """See Observer."""
        t = exposure.t
        state = self._guard.state
        self._strips.keep(exposure, (t, *self._angles, mount.yaw, self._turned, self._pushed))
        if state is State.SEEKING:
            closed = self._strips.closed_unknown(exposure.number)
        else:
            closed = self._strips.closed(exposure.number, *self._beliefs(t), self._width(t))
        decided = [self._decide(slot, exposure, mount.yaw, state) for slot in closed]
        if state is not State.SEEKING and t >= self._block_ends:
            self._block_ends += self._par.block
            if self._guard.doubtful:
                self._track.filter.inflate(self._track.noise)
                self._speed.filter.inflate(self._speed.noise)
            taken = [self._track.close(t), self._speed.close(t)]
            self._fresh = self._fresh or all(taken)
        self._guard.watch(t)
        return [each for each in decided if each is not None]

    def now(self) -> MotionEstimate:
        """See Observer."""
        if self._guard.state is State.SEEKING:
            return UNKNOWN._replace(seek=self._seek)
        _, pitch, yaw = self._angles
        t = self._strips.t
        level = self._par.strips.level
        pitch = pitch + level if self._par.aiding != "none" else 0.0
        vh = math.exp(self._log_vh(t))
        return MotionEstimate(
            t,
            math.remainder(self._track_now(t) - yaw, 2.0 * math.pi),
            vh,
            math.sqrt(self._track.filter.now(t)[1]),
            vh * math.sqrt(self._speed.filter.now(t)[1]),
            True,
            held=self._guard.state is State.HELD,
            pitch=pitch,
            yaw_rate=self._yaw_rate.rate,
        )

    # beliefs

    def _track_now(self, t: float) -> float:
        return self._track.filter.now(t)[0] + self._turn

    def _log_vh(self, t: float) -> float:
        return self._speed.filter.now(t)[0] + self._push

    def _beliefs(self, t: float) -> tuple[float, float]:
        """Track and v/h less what has been turned and pushed since."""
        return self._track.filter.now(t)[0], math.exp(self._speed.filter.now(t)[0])

    def _width(self, t: float) -> Window:
        """Window of the next strips, from what they are expected to scatter."""
        setup = self._par.strips
        t1 = t - setup.planned_n * setup.period
        wide = 2.0 if self._guard.doubtful else 1.0
        along = wide * 4.0 * self._speed.spread(t1, t) * setup.spacing_px
        across = wide * 4.0 * self._track.spread(t1, t) * setup.spacing_px
        # a gust that yaws the nose turns an unaided camera by about as much as its strips scatter
        blind = self._par.aiding == "none" and self._track.noise > SLANT_FROM**2
        return Window(
            min(max(along + 1.0, 1.85), 0.35 * setup.spacing_px),
            min(max(math.ceil(across) + 3, setup.max_shift), 2 * setup.max_shift),
            SLANT if blind else 0.0,
        )

    # strips

    def _decide(self, slot: int, exposure: RowExposure, yaw: float, state: State) -> Decided | None:
        found = self._strips.recognise(slot, exposure, final=state is not State.SEEKING)
        if found is None:
            return None  # looked for again when its window is complete
        match, first, second = found
        if match.reason is Reason.SKIPPED:
            return match, UNUSED
        t = exposure.t
        if first is None or second is None:
            self._look_beyond(match, yaw)
            self._guard.strip(t, False)
            return match, UNUSED
        self._beyond = 0
        t1, t2 = float(first[TIME]), float(second[TIME])
        track = match.track - float(second[TURNED] - first[TURNED]) / (t2 - t1)
        speed = math.log(match.vh) - float(second[PUSHED] - first[PUSHED]) / (t2 - t1)
        if state is State.SEEKING:
            self._try_start(t, track, speed)
            return match, UNUSED
        track += 2.0 * math.pi * round((self._track.filter.now(t)[0] - track) / (2.0 * math.pi))
        off = max(
            abs(self._track.surprise(t1, t2, track)),
            abs(self._speed.surprise(t1, t2, speed)),
        )
        if off > GATE:
            self._guard.strip(t, False)
            if self._guard.doubtful or self._guard.state is State.HELD:
                self._try_start(t, track, speed)
            return match._replace(reason=Reason.UNEXPECTED), UNUSED
        self._guard.strip(t, True)
        self._track.add(t1, t2, track)
        self._speed.add(t1, t2, speed)
        return match, self._use(t)

    def _use(self, t: float) -> StripUse:
        """What the filters did last, told once for each block."""
        if not self._fresh:
            return UNUSED
        self._fresh = False
        vh = math.exp(self._log_vh(t))
        return StripUse(
            math.nan,  # a matrix's doing: no scalar gain could be replayed
            math.nan,
            self._track.innovation,
            self._speed.innovation,
            self._track.filter.now(t)[1],
            vh * vh * self._speed.filter.now(t)[1],
        )

    def _try_start(self, t: float, track: float, speed: float) -> None:
        """Believe three strips that agree."""
        par = self._par
        within = 4.0 * math.sqrt(par.scatter_track), 4.0 * math.sqrt(par.scatter_vh)
        now = (self._track.filter.now(t)[0], self._speed.filter.now(t)[0])
        belief = None if self._guard.state is State.SEEKING else now
        agreed = self._guard.found(t, track, speed, within, belief)
        if agreed is None:
            return
        self._track.start(t, agreed[0], par.scatter_track)
        self._speed.start(t, agreed[1], par.scatter_vh)
        self._block_ends = t + par.block

    def _look_beyond(self, match: StripMatch, yaw: float) -> None:
        """Minima beyond the same end of the rows, one after the other, say where to turn."""
        if match.reason is not Reason.BORDER_MU or self._guard.state is not State.SEEKING:
            return
        side = 1 if match.mu > 0.0 else -1
        self._beyond = self._beyond + side if self._beyond * side > 0 else side
        if abs(self._beyond) >= 3:
            self._seek = (match.yaw1 + match.yaw2) / 2.0 + math.atan2(match.mu, self._par.strips.spacing_px)
            self._beyond = 0
