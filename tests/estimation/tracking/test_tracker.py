"""The observer of mode `best` on a plane whose every point is known: signs, roll, turns, loss and return."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerosim.estimation.tracking.lag_filter import WalkModel
from aerosim.estimation.tracking.rays import Rays
from aerosim.estimation.tracking.strips import StripSetup
from aerosim.estimation.tracking.tracker import Tracker, TrackerParameters
from aerosim.signals import Aids, InertialReading, MountReading, Reason, RowExposure, StripMatch

PIXELS, MARGIN, SPACING, FOCAL, PERIOD = 64, 7, 39.7, 132.6, 0.05
HEIGHT, SPEED = 1200.0, 70.0
VH = SPEED / HEIGHT
DEG = math.radians(1.0)


def texture() -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """Grey values of the plane, waves of 8 to 60 pixels of the rows, any direction."""
    rng = np.random.default_rng(4)
    length = rng.uniform(8.0, 60.0, 40) * HEIGHT / FOCAL
    course, phase = rng.uniform(0, 2 * np.pi, 40), rng.uniform(0, 2 * np.pi, 40)
    kx, ky = 2 * np.pi / length * np.cos(course), 2 * np.pi / length * np.sin(course)

    def grey(north: np.ndarray, east: np.ndarray) -> np.ndarray:
        waves = np.cos(np.multiply.outer(north, kx) + np.multiply.outer(east, ky) + phase)
        return np.asarray(110.0 + 6.0 * waves.sum(-1))

    return grey


@dataclass
class Flight:
    """Straight over the plane; attitude and mount as functions of time, rad."""

    track: float = 0.0
    heading: Callable[[float], float] = lambda t: 0.0
    roll: Callable[[float], float] = lambda t: 0.0
    pitch: Callable[[float], float] = lambda t: 0.0
    mount: Callable[[float], float] = lambda t: 0.0
    aiding: str = "none"
    blind: Callable[[float], bool] = lambda t: False
    gyro_start: float = 2.0
    gyro_drift: float = 0.0
    pitch_drift: float = 0.0
    lever: float = 0.0
    distortion: float = 0.0
    believed: float = 0.0
    strips: list[StripMatch] = field(default_factory=list)

    def fly(self, seconds: float) -> Tracker:
        tracker = Tracker(parameters(self.aiding, bent(self.believed), self.lever))
        grey, rng = texture(), np.random.default_rng(2)
        for k in range(round(seconds / PERIOD)):
            t = k * PERIOD
            if self.aiding != "none":
                tracker.feel(Aids(self._reading(t)))
            rows = [np.round(r + rng.normal(0, 1.5, r.shape)).astype(np.float32) for r in self._rows(grey, t)]
            if self.blind(t):
                rows = [np.full_like(r, 90.0) for r in rows]
            exposure = RowExposure(k, t, rows[0], rows[1], 0.01, 0)
            self.strips += [m for m, _ in tracker.see(exposure, MountReading(t, self.mount(t)))]
        return tracker

    def _reading(self, t: float) -> InertialReading:
        roll, pitch = self.roll(t), self.pitch(t)
        level = (roll, pitch) if self.aiding in ("bank", "imu") else (math.nan, math.nan)
        nan = math.nan
        if self.aiding != "imu":
            force = (nan, nan, nan)
        else:  # at rest but for gravity: the specific force of straight flight
            mat = Rotation.from_euler("ZYX", [0.0, pitch, roll]).as_matrix()
            force = tuple((mat.T @ [0.0, 0.0, -9.80665]).tolist())
        drifted = roll + self.gyro_drift * t
        nosed = pitch + self.pitch_drift * t
        return InertialReading(t, drifted, nosed, self.heading(t) + self.gyro_start, *level, *force)

    def _rows(self, grey: Callable[[np.ndarray, np.ndarray], np.ndarray], t: float) -> list[np.ndarray]:
        """Grey values of row I and row II: rays turned by scipy, met with the plane."""
        attitude = Rotation.from_euler("ZYX", [self.heading(t), self.pitch(t), self.roll(t)])
        turned = attitude * Rotation.from_euler("Z", self.mount(t))
        out = []
        for x, y in bent(self.distortion):
            rays = turned.apply(np.column_stack([x, y, np.full(len(x), FOCAL)]))
            ground = HEIGHT * rays[:, :2] / rays[:, 2:]
            way = SPEED * t
            out.append(grey(ground[:, 0] + way * math.cos(self.track), ground[:, 1] + way * math.sin(self.track)))
        return out


def bent(k1: float) -> Rays:
    """Rays of optics whose image is a simple power of the ideal one: ideal radius r (1 - k1 r^2)."""
    rows = []
    for x, y in Rays.straight(PIXELS, MARGIN, SPACING):
        rows.append(np.stack([x, y]) * (1.0 - k1 * (x**2 + y**2) / FOCAL**2))
    return Rays(*rows)


def parameters(aiding: str, rays: Rays, lever: float = 0.0) -> TrackerParameters:
    n = SPACING / (FOCAL * PERIOD * VH)
    return TrackerParameters(
        StripSetup(PIXELS, MARGIN, SPACING, FOCAL, PERIOD, 0.0, n, (0.6, 1.6), 2, rays),
        planned_vh=VH * 1.05,  # 5 % beside the truth
        planned_height=HEIGHT,
        aiding=aiding,  # type: ignore[arg-type]
        track=WalkModel(0.001 * DEG**2, 1e-5, 100.0)
        if lever == 0.0
        else WalkModel(0.001 * DEG**2, 9.81 / SPEED * 0.3 * DEG, 1e4, 9.81 / SPEED * 0.03 * DEG, lever),
        vh=WalkModel(1e-6, 1e-5, 100.0)
        if lever == 0.0
        else WalkModel(1e-7, 9.81 / SPEED * 0.3 * DEG, 1e4, 9.81 / SPEED * 0.03 * DEG, lever),
        block=0.5,
        floor_track=((0.1 if aiding == "none" else 0.01) * DEG) ** 2,
        floor_vh=(1e-3 if aiding == "none" else 3e-4) ** 2,
        noise_track=(0.3 * DEG) ** 2,
        noise_vh=0.003**2,
        scatter_track=(1.0 * DEG) ** 2,
        scatter_vh=0.01**2,
        gyro_drift=10.0 * DEG / 3600.0,
        level_sigma=0.1 * DEG,
        level_time=60.0,
    )


# With rows of 64 px and 1.5 grey levels of noise a strip has some 0.1 to 0.2 deg; half a minute of them far less.
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_track_to_the_right_is_a_positive_drift(side: float) -> None:
    """Rows along the nose, no aid: drift = track - heading."""
    now = Flight(track=0.3 + side * 5 * DEG, heading=lambda t: 0.3).fly(30.0).now()
    assert now.valid
    assert now.drift == pytest.approx(side * 5 * DEG, abs=0.1 * DEG)
    assert now.vh == pytest.approx(VH, rel=0.004)


def test_rows_on_a_turned_camera_tell_the_same_drift() -> None:
    """The mount has turned by 4 of 6 deg: the rows see the rest, the encoder adds the 4."""
    now = Flight(track=6 * DEG, mount=lambda t: 4 * DEG).fly(15.0).now()
    assert now.drift == pytest.approx(6 * DEG, abs=0.1 * DEG)


@pytest.mark.parametrize("aiding", ["gyro", "bank", "imu"])
def test_roll_and_pitch_are_taken_out_with_a_gyro(aiding: str) -> None:
    """1.5 deg of roll and 1 deg of pitch, a swing each 4 s: without a gyro read as 5 deg of drift."""

    def swing(size: float, lag: float) -> Callable[[float], float]:
        return lambda t: size * DEG * math.sin(2 * math.pi * (t - lag) / 4.0)

    flight = Flight(track=2 * DEG, roll=swing(0.75, 0.0), pitch=swing(0.5, 1.0), aiding=aiding)
    if aiding == "imu":
        # straight flight with a swinging wing: no bank acts on the track
        now = flight.fly(20.0).now()
        assert now.drift == pytest.approx(2 * DEG, abs=0.12 * DEG)
    accepted = [m for m in (flight.strips or _flown(flight)) if m.reason is Reason.ACCEPTED][10:]
    angles = np.array([m.angle for m in accepted])
    assert len(angles) > 50
    assert np.degrees(angles).mean() == pytest.approx(2.0, abs=0.05)
    assert np.degrees(angles).std() < 0.3


def _flown(flight: Flight) -> list[StripMatch]:
    flight.fly(20.0)
    return flight.strips


def test_without_a_gyro_roll_is_read_as_drift() -> None:
    flight = Flight(track=2 * DEG, roll=lambda t: 0.75 * DEG * math.sin(2 * math.pi * t / 4.0))
    flight.fly(20.0)
    angles = np.degrees([m.angle for m in flight.strips if m.reason is Reason.ACCEPTED][10:])
    assert angles.std() > 0.8


def test_a_nose_that_yaws_moves_the_drift_at_once_with_a_gyro() -> None:
    """Track estimate less gyro heading: what the nose does shows without the rows' delay."""
    flight = Flight(track=1 * DEG, heading=lambda t: 0.0 if t < 19.9 else 2 * DEG, aiding="gyro")
    now = flight.fly(20.0).now()
    assert now.drift == pytest.approx(-1 * DEG, abs=0.1 * DEG)


def test_over_water_the_estimate_is_held_and_comes_back() -> None:
    """20 s without a pattern: flagged, uncertain more and more, right again within two strip times."""
    span = SPACING / (FOCAL * VH)
    flight = Flight(track=3 * DEG, blind=lambda t: 15.0 < t < 35.0)
    held = flight.fly(34.9).now()
    before = Flight(track=3 * DEG).fly(14.9).now()
    assert held.valid
    assert held.held
    assert held.sigma_drift > 1.5 * before.sigma_drift
    assert held.drift == pytest.approx(3 * DEG, abs=0.3 * DEG)
    assert not [m for m in flight.strips if m.reason is Reason.ACCEPTED and m.t_decided > 15.0 + span + 1.0]
    flight = Flight(track=3 * DEG, blind=lambda t: 15.0 < t < 35.0)
    back = flight.fly(35.0 + 2.0 * span).now()
    assert not back.held
    assert back.drift == pytest.approx(3 * DEG, abs=0.15 * DEG)


def test_nothing_is_claimed_before_strips_agree() -> None:
    flight = Flight(track=3 * DEG, blind=lambda t: True)
    now = flight.fly(15.0).now()
    assert not now.valid
    assert {m.reason for m in flight.strips} <= {Reason.DEGENERATE, Reason.SKIPPED}


def test_every_strip_is_recorded_also_those_that_are_not_searched() -> None:
    """While nothing is known each fourth strip is worth a long search; the others are told to be skipped."""
    flight = Flight(blind=lambda t: True)
    tracker = flight.fly(20.0)
    told = flight.strips + [m for m, _ in tracker.switch(20.0)]
    assert sorted(m.strip for m in told) == list(range(200))  # 400 exposures, a strip each second one
    skipped = [m for m in told if m.reason is Reason.SKIPPED]
    assert all(m.strip % 4 for m in skipped)
    waiting = SPACING / (FOCAL * VH / 1.05) * 1.6 + PERIOD  # 1.6 times the planned n is the end of the search
    assert len(skipped) == pytest.approx(0.75 * (20.0 - waiting) / 0.1, abs=4)


def test_a_window_beside_the_middle_says_where_it_lies() -> None:
    """Roll of row I's look moves the window; the surface's least element is at the strip's shift all the same."""
    flight = Flight(track=1 * DEG, roll=lambda t: DEG * math.sin(2 * math.pi * t / 4.0), aiding="gyro")
    flight.fly(18.0)
    good = [m for m in flight.strips if m.reason is Reason.ACCEPTED and m.t_decided > 12.0]
    assert {m.centre for m in good} >= {-2, 2}
    for m in good:
        step, k = np.unravel_index(np.argmin(m.surface), m.surface.shape)
        assert m.centre - m.surface.shape[1] // 2 + k == pytest.approx(m.mu, abs=1.5)
        assert m.first_n + step == pytest.approx(m.n, abs=5.0)


def test_another_line_begins_anew() -> None:
    tracker = Flight(track=3 * DEG).fly(15.0)
    assert tracker.now().valid
    given_up = tracker.switch(15.0)
    assert {m.reason for m, _ in given_up} == {Reason.TIMEOUT}
    assert not tracker.now().valid


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_camera_that_turns_between_the_rows_finds_its_strips_aslant(side: float) -> None:
    """The mount turns by 0.6 deg/s, 8 deg from row I to row II: 11 exposures at the row's end."""
    flight = Flight(mount=lambda t: side * (t - 10.0) * 0.6 * DEG)
    now = flight.fly(16.0).now()
    assert now.drift == pytest.approx(0.0, abs=0.25 * DEG)
    # those that were followed, from the moment on at which the track was known
    decided = [m.reason for m in flight.strips if m.t_decided > 10.0]
    assert len(decided) > 40
    assert np.mean([reason is Reason.ACCEPTED for reason in decided]) > 0.9


def test_distortion_that_is_known_costs_nothing() -> None:
    """k1 = 0.5, 8 deg of crab: read wrong, unless the optics are calibrated.

    To first order row I and row II are k1 (y^2 + x^2)/f^2 nearer in the mean than they are thought to be: with
    y^2 = 64^2/12 and x = 39.7/2 that is 2.1 % of v/h.  A shift is k1 (3 y^2 + x^2)/f^2 = 4 % larger, which leaves
    1.9 % of the angle, 0.15 deg.  The strips scatter by 0.2 deg and 0.5 %, some 25 of them apart enough to be
    independent: the means of two flights differ by 0.06 deg and 0.15 %, at most twice as much.
    """

    def seen(distortion: float, believed: float) -> tuple[float, float]:
        flight = Flight(track=20 * DEG, mount=lambda t: 12 * DEG, distortion=distortion, believed=believed)
        flight.fly(18.0)
        good = [m for m in flight.strips if m.reason is Reason.ACCEPTED]
        assert len(good) > 60
        return float(np.degrees(np.mean([m.angle for m in good]))), float(np.mean([m.vh for m in good])) / VH

    ideal, known, unknown = seen(0.0, 0.0), seen(0.5, 0.5), seen(0.5, 0.0)
    assert unknown[0] - ideal[0] == pytest.approx(0.15, abs=0.12)
    assert unknown[1] - ideal[1] == pytest.approx(0.021, abs=0.006)
    assert known[0] == pytest.approx(ideal[0], abs=0.12)
    assert known[1] == pytest.approx(ideal[1], abs=0.003)


def test_a_nose_that_points_up_is_a_positive_pitch() -> None:
    now = Flight(track=1 * DEG, pitch=lambda t: 2 * DEG, aiding="gyro").fly(12.0).now()
    assert now.pitch == pytest.approx(2 * DEG, abs=1e-9)
    assert Flight(track=1 * DEG, pitch=lambda t: 2 * DEG).fly(12.0).now().pitch == 0.0


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_roll_gyro_that_drifts_is_found_out_by_its_accelerations(side: float) -> None:
    """0.03 deg/s: a strip of 5.1 s is off by f/d 5.1 s 0.03 deg/s = 0.5 deg, and stays so.

    But the same roll feigns a turn that grows, g roll/V, and the strips do not turn.  Where the filter knows that
    both are one (its lever is height/g), the offset is known too.
    """
    errors = []
    for lever in (0.0, HEIGHT / 9.81):
        flight = Flight(track=2 * DEG, aiding="gyro", gyro_drift=side * 0.03 * DEG, lever=lever)
        errors.append((flight.fly(45.0).now().drift - 2 * DEG) / DEG)
    ignored, known = errors
    assert ignored * side > 0.3
    assert abs(known) < 0.12


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_pitch_gyro_that_drifts_does_not_tilt_the_trigger(side: float) -> None:
    """0.01 deg/s, of which the vertical has shown little when the strips agree: 0.4 deg by the end if believed."""
    flight = Flight(aiding="imu", pitch_drift=side * 0.01 * DEG, lever=HEIGHT / 9.81)
    tracker = flight.fly(45.0)
    assert tracker.now().pitch == pytest.approx(0.0, abs=0.08 * DEG)
    assert tracker.now().vh == pytest.approx(VH, rel=0.004)
