"""Lines flown in Dryden turbulence: what the autopilots make of it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from aerosim.flight.aircraft import Aircraft
from aerosim.flight.jsbsim_flight import JsbsimFlight
from aerosim.flight.plan import FlightPlan, Line
from aerosim.truth import AirState

Vector = NDArray[np.float64]

HEIGHT = 3000.0
LENGTH = 533.4  # m, 1750 ft
CROSSWIND = 8.0
STEP_HZ, HOLD = 120, 3
AIR_S = HOLD / STEP_HZ
SETTLE_S = 30.0
SAMPLE = 6  # steps from sample to sample
EARTH = 6378137.0


class Rms(NamedTuple):
    """Root mean squares on a line: m, rad, rad/s, m/s.

    *_max: greatest, rad/s; roll_change: of roll over 10 s, rms and 95 %, rad; fuel: flow, kg/s.
    """

    across: float
    height: float
    roll: float
    pitch: float
    heading: float
    p: float
    q: float
    r: float
    p_max: float
    q_max: float
    r_max: float
    roll_change: float
    roll_change_95: float
    airspeed: float
    fuel: float


class Gusts:
    """Dryden turbulence of MIL-F-8785C around a steady wind, made whole by Fourier's series.

    Each filter of the standard takes white noise of unit intensity; p has a noise of its own, q and r follow from
    w and v as the rotation of the air.  sigma: m/s; airspeed: m/s; span: m; wind: to the north and east, m/s.
    """

    def __init__(
        self,
        sigma: float,
        airspeed: float,
        span: float,
        seconds: float,
        seed: int,
        wind: tuple[float, float] = (-CROSSWIND, 0.0),
    ) -> None:
        count = 2 * round(seconds / AIR_S / 2.0)
        rng = np.random.default_rng(seed)
        s = 2j * np.pi * np.fft.rfftfreq(count, AIR_S)
        tau, v = LENGTH / airspeed, airspeed
        along = sigma * math.sqrt(2.0 * tau) / (1.0 + tau * s)
        across = sigma * math.sqrt(tau) * (1.0 + math.sqrt(3.0) * tau * s) / (1.0 + tau * s) ** 2
        tau_p, tau_r = 4.0 * span / (math.pi * v), 3.0 * span / (math.pi * v)
        power = 0.8 * math.pi * sigma**2 / (v * LENGTH) * (math.pi * LENGTH / (4.0 * span)) ** (1.0 / 3.0)
        rolling = math.sqrt(power) / (1.0 + tau_p * s)
        white = [np.fft.rfft(rng.standard_normal(count) / math.sqrt(AIR_S)) for _ in range(4)]
        series = [
            along * white[0],
            across * white[1],
            across * white[2],
            rolling * white[3],
            -s / v / (1.0 + tau_p * s) * across * white[2],
            s / v / (1.0 + tau_r * s) * across * white[1],
        ]
        columns = [np.fft.irfft(each, count) for each in series]
        steady = np.tile([*wind, 0.0], (count, 1))
        self.states = [AirState._make(row) for row in np.column_stack([steady, *columns]).tolist()]

    def at(self, index: int, where: Callable[[], tuple[float, float, float]]) -> AirState:
        """State of the air, the same everywhere."""
        return self.states[index]


def fly_line(folder: Path, airspeed: float, sigma: float, seconds: float, seed: int = 1) -> Vector:
    """A line flown east at 3000 m in a crosswind from the north and turbulence of a sigma (m/s).

    Returns (n, 10), 20 a second: cross-track, height error (m), roll, pitch, heading (rad), p, q, r (rad/s),
    airspeed (m/s), fuel (kg), without the first half minute.
    """
    aircraft = Aircraft(folder, float(STEP_HZ))
    lat, lon = math.radians(51.0), 0.2
    ground = airspeed * (seconds + SETTLE_S + 60.0)
    line = Line((lat, lon), (lat, lon + ground / (EARTH * math.cos(lat))))
    air = Gusts(sigma, airspeed, aircraft.span, seconds + SETTLE_S + 30.0, seed)
    flight = JsbsimFlight(aircraft, FlightPlan([line], HEIGHT, airspeed, run_in_s=5.0), air, HOLD)
    rows = []
    for _ in range(round((seconds + SETTLE_S) * STEP_HZ / SAMPLE)):
        flight.advance(SAMPLE)
        s = flight.state()
        attitude = (s.roll, s.pitch, s.heading, s.p, s.q, s.r)
        rows.append((flight.cross_track, s.height - HEIGHT, *attitude, s.airspeed, aircraft.fuel))
    return np.array(rows)[round(SETTLE_S * STEP_HZ / SAMPLE) :]


def summary(rows: Vector) -> Rms:
    """Root mean squares of a flown line; angles, heading and airspeed about their means."""
    centred = rows - rows.mean(axis=0)
    centred[:, [0, 1, 5, 6, 7]] = rows[:, [0, 1, 5, 6, 7]]
    rms = np.sqrt(np.mean(centred**2, axis=0))
    apart = round(10.0 * STEP_HZ / SAMPLE)
    change = np.abs(rows[apart:, 2] - rows[:-apart, 2])
    flow = (rows[0, 9] - rows[-1, 9]) * STEP_HZ / SAMPLE / (len(rows) - 1)
    change_rms, change_95 = np.sqrt(np.mean(change**2)), np.quantile(change, 0.95)
    found = [*rms[:8], *np.abs(rows[:, 5:8]).max(axis=0), change_rms, change_95, rms[8], flow]
    return Rms._make(float(v) for v in found)
