"""The observer of mode `best`: rows and inertial unit in, drift and v/h of this moment out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from aerosim.estimation.motion import UNKNOWN, UNUSED
from aerosim.estimation.observer import Decided
from aerosim.estimation.tracking.belief import Belief, UnaidedBelief
from aerosim.estimation.tracking.channel import GATE, Channel
from aerosim.estimation.tracking.geometry import PUSHED, TIME, TURNED
from aerosim.estimation.tracking.lag_filter import LagFilter, WalkModel
from aerosim.estimation.tracking.levelling import Levelled
from aerosim.estimation.tracking.strips import Strips, StripSetup, Window
from aerosim.estimation.tracking.supervisor import State, Supervisor
from aerosim.estimation.tracking.sway_filter import SwayFilter
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
ROLL_S, PITCH_S = 1.5, 4.0  # of an unaided camera: study of JSBSim flights in docs/best.md
SHARP = 0.1  # of what strips are expected to scatter: a trough need not be sharper
SOON = 0.3  # of the window's half: most strips lie before it and need not wait for the rest
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
        span = setup.planned_n * setup.period
        step = max(1, round(span / 26.0 / setup.period)) * setup.period
        self._belief = _belief(par, step, setup.search[1] * span + 4.0)
        self._roll = Levelled(par.gyro_drift, par.level_sigma, par.level_time)
        self._pitch = Levelled(par.gyro_drift, par.level_sigma, par.level_time)
        self._yaw_rate = YawRate()
        self._angles = (0.0, 0.0, 0.0)  # roll, pitch, yaw in the gyro's frame
        self._void()

    def _void(self) -> None:
        self._roll.release()
        self._pitch.release()
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
        if span <= 0.0 or self._guard.state is State.SEEKING:
            return
        believed = self._belief.now(unit.t)
        speed = math.exp(believed.log_vh + self._push) * self._par.planned_height
        ahead, right = self._accelerations(roll, pitch, unit.accel_x, unit.accel_y, unit.accel_z)
        drift = believed.track + self._turn - unit.yaw
        across = right * math.cos(drift) - ahead * math.sin(drift)
        along = ahead * math.cos(drift) + right * math.sin(drift)
        turn, push = across / speed * span, along / speed * span
        self._turned += (self._turn + 0.5 * turn) * span
        self._pushed += (self._push + 0.5 * push) * span
        self._turn += turn
        self._push += push

    def _accelerations(self, roll: float, pitch: float, x: float, y: float, z: float) -> tuple[float, float]:
        """Level acceleration ahead and to the right of the nose, m/s^2; a bank alone turns as g tan(bank)."""
        if self._par.aiding != "imu":
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
            closed = self._strips.closed(exposure.number, *self._expected(t))
        decided = [self._decide(slot, exposure, mount.yaw, state) for slot in closed]
        if state is not State.SEEKING and t >= self._block_ends:
            self._block_ends += self._par.block
            if self._guard.doubtful:
                self._belief.doubt()
            self._fresh = self._belief.close(t) or self._fresh
        self._guard.watch(t)
        return [each for each in decided if each is not None]

    def now(self) -> MotionEstimate:
        """See Observer."""
        if self._guard.state is State.SEEKING:
            return UNKNOWN._replace(seek=self._seek)
        _, pitch, yaw = self._angles
        t = self._strips.t
        level = self._par.strips.level
        believed = self._belief.now(t)
        vh = math.exp(believed.log_vh + self._push)
        pitch = pitch + level if self._par.aiding != "none" else 0.0
        if self._par.aiding == "imu":  # what feigns a push is a pitch
            pitch -= self._belief.feigned_push * vh * self._par.planned_height / GRAVITY
        return MotionEstimate(
            t,
            math.remainder(believed.track + self._turn - yaw, 2.0 * math.pi),
            vh,
            math.sqrt(believed.var_track),
            vh * math.sqrt(believed.var_log_vh),
            True,
            held=self._guard.state is State.HELD,
            pitch=pitch,
            yaw_rate=self._yaw_rate.rate,
        )

    def _expected(self, t: float) -> tuple[float, float, Window]:
        """Track and v/h as the next strip will show them, less what has been turned and pushed; its window."""
        setup = self._par.strips
        now = self._belief.now(t)
        next_ = self._belief.strip(t - setup.spacing_px / setup.focal_px * math.exp(-now.log_vh), t)
        wide = 3.0 * setup.spacing_px
        if self._par.aiding != "none":  # no tilt hides in them: the course now is what the window follows
            next_ = next_._replace(track=now.track, log_vh=now.log_vh)
            wide = (8.0 if self._guard.doubtful else 4.0) * setup.spacing_px
        along, across = wide * math.sqrt(next_.var_log_vh), wide * math.sqrt(next_.var_track)
        # a gust that yaws the nose turns an unaided camera by about as much as its strips scatter
        blind = self._par.aiding == "none" and self._belief.first.scatter > SLANT_FROM**2
        along = min(max(along + 1.0, 1.85), 0.35 * setup.spacing_px)
        half = min(max(math.ceil(across) + 3, setup.max_shift), 2 * setup.max_shift)
        soon, tolerance = (
            max(SOON * along, min(along, 1.85)),
            SHARP * setup.spacing_px * math.sqrt(next_.var_track),
        )
        window = Window(along, half, soon, SLANT if blind else 0.0, tolerance)
        return next_.track, math.exp(next_.log_vh), window

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
        if self._belief.surprise(t1, t2, track, speed) > GATE:
            self._guard.strip(t, False)
            if self._guard.doubtful or self._guard.state is State.HELD:
                self._try_start(t, track, speed)
            return match._replace(reason=Reason.UNEXPECTED), UNUSED
        self._guard.strip(t, True)
        self._belief.add(t1, t2, track, speed)
        return match, self._use(t)

    def _use(self, t: float) -> StripUse:
        """What the filters did last, told once for each block."""
        if not self._fresh:
            return UNUSED
        self._fresh = False
        believed = self._belief.now(t)
        vh = math.exp(believed.log_vh + self._push)
        return StripUse(
            math.nan,  # a matrix's doing: no scalar gain could be replayed
            math.nan,
            *self._belief.innovations,
            believed.var_track,
            vh * vh * believed.var_log_vh,
        )

    def _try_start(self, t: float, track: float, speed: float) -> None:
        """Believe three strips that agree."""
        par = self._par
        # strips of one moment agree in a tilt that they share: they may be as far off as strips have scattered
        scatter = (
            max(par.scatter_track, self._belief.first.scatter),
            max(par.scatter_vh, self._belief.second.scatter),
        )
        within = 4.0 * math.sqrt(par.scatter_track), 4.0 * math.sqrt(par.scatter_vh)
        now = self._belief.now(t)
        belief = None if self._guard.state is State.SEEKING else (now.track, now.log_vh)
        agreed = self._guard.found(t, track, speed, within, belief)
        if agreed is None:
            return
        self._belief.start(t, *agreed, scatter)
        if par.aiding in ("bank", "imu"):
            self._roll.hold()
        if par.aiding == "imu":
            self._pitch.hold()
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


def _belief(par: TrackerParameters, step: float, reach: float) -> Belief:
    """Filters with lags of `step` (s) that reach back by `reach`, s."""
    if par.aiding != "none":
        return Belief(
            Channel(LagFilter(par.track, step, reach), par.floor_track, par.noise_track),
            Channel(LagFilter(par.vh, step, reach), par.floor_vh, par.noise_vh),
        )
    # drift wanders with the heading, of which a strip has the two end values
    right = SwayFilter(par.track.walk, step, reach, par.noise_track, ROLL_S, ends=True)
    ahead = SwayFilter(par.vh.walk, step, reach, par.noise_vh, PITCH_S, ends=False)
    return UnaidedBelief(
        Channel(right, par.floor_track, par.noise_track),
        Channel(ahead, par.floor_vh, par.noise_vh),
        par.planned_vh,
    )
