"""Dryden and von Karman gusts against the one-sided spectra of MIL-F-8785C, their rms, and the rates' signs."""

import math
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from air_spectra import NAMES, bound, folded, mil_spectra, per_hz, periodogram
from scipy.integrate import quad
from scipy.signal import butter, lfilter, sosfiltfilt

from aerosim.rng import generator
from aerosim.world.air import AIR_RATE_HZ
from aerosim.world.dryden import dryden_processes
from aerosim.world.turbulence import Turbulence
from aerosim.world.von_karman import von_karman_processes

SIGMA, SPEED, SPAN = 2.88, 69.44, 19.81
KINDS = {"dryden": (dryden_processes, 533.4), "von_karman": (von_karman_processes, 762.0)}
BANDS = (0.1, 0.3, 1.0, 3.0, 10.0)  # Hz
LOW_BANDS = (0.003, 0.01, 0.03, 0.1)


def processes(spectrum, rng_of, rate=AIR_RATE_HZ, *, sigma=SIGMA, length=None, speed=SPEED, span=SPAN):
    make, usual = KINDS[spectrum]
    air = Turbulence.equal(spectrum, sigma, length or usual)
    return make(air, speed, span, 1.0 / rate, rng_of)


def series(spectrum, seed, steps, rate=AIR_RATE_HZ, **kind):
    made = processes(spectrum, partial(generator, seed), rate, **kind)
    return dict(zip(("u", "v", "r", "w", "q", "p"), np.hstack([each.draw(steps) for each in made]).T, strict=True))


class Impulse:
    """Stands for a generator: a start of zeros, then one unit number in one column of the first step."""

    def __init__(self, column):
        self.column, self.started = column, False

    def standard_normal(self, shape):
        out = np.zeros(shape)
        if self.started:
            out[0, self.column] = 1.0
        self.started = True
        return out


def exact_spectra(spectrum, rate, steps):
    """Frequencies and densities per Hz of the samples, from their answers to unit numbers: no chance in it."""
    total = dict.fromkeys(NAMES, 0.0)
    for column in range(10):
        made = processes(spectrum, lambda name, column=column: Impulse(column), rate)
        for names, process in zip(("u", "vr", "wq", "p"), made, strict=True):
            if column < len(process.covariance):
                power = np.abs(np.fft.rfft(process.draw(steps), axis=0)) ** 2 * 2.0 / rate
                total.update((name, total[name] + each) for name, each in zip(names, power.T, strict=True))
    return np.fft.rfftfreq(steps, 1.0 / rate)[1:], {name: each[1:] for name, each in total.items()}


@pytest.fixture(scope="module", params=list(KINDS))
def spectrum(request):
    return request.param


@pytest.fixture(scope="module")
def exact(spectrum):
    return exact_spectra(spectrum, AIR_RATE_HZ, 2**16)


@pytest.mark.parametrize("name", NAMES)
def test_samples_have_the_standards_spectrum(spectrum, exact, name):
    # Sampling folds down what is above 20 Hz.  The rational filters of von Karman are within 1.4 %, but fall
    # faster than the formula above 54 Hz: too little is folded down from there, 2 % at 3 Hz, 8 % at 20 Hz.
    hz, found = exact
    rational = spectrum == "von_karman" and name != "p"
    for low, high, tolerance in ((0.01, 3.0, 0.02), (3.0, 19.9, 0.08)):
        inside = (hz > low) & (hz < high)
        wanted = folded(name, hz[inside], AIR_RATE_HZ, spectrum=spectrum, length=KINDS[spectrum][1])
        assert found[name][inside] == pytest.approx(wanted, rel=tolerance if rational else 0.001)


@pytest.mark.parametrize("name", NAMES)
def test_what_an_aircraft_feels_has_the_standards_spectrum(spectrum, exact, name):
    # A state held for T = 1/40 s has the samples' spectrum times sinc^2(fT).  For a tail of f^-2 the fold is
    # 1/sinc^2, so that both cancel; of the f^(-5/3) of von Karman 7 % remain up to 10 Hz.  q and r have next to
    # nothing below 0.01 Hz, and the images add 1 to 7 % to that.
    hz, found = exact
    for low, high in pairwise((*LOW_BANDS, *BANDS[1:])):
        inside = (hz >= low) & (hz < high)
        felt = found[name][inside] * np.sinc(hz[inside] / AIR_RATE_HZ) ** 2
        wanted = per_hz(name, hz[inside], spectrum=spectrum, length=KINDS[spectrum][1])
        tolerance = 0.02 if low >= 0.01 and high <= 3.0 else 0.07
        assert felt.sum() == pytest.approx(wanted.sum(), rel=tolerance), f"{low}-{high} Hz"


@pytest.fixture(scope="module")
def long_runs(spectrum):
    """Twice 40 minutes."""
    return [series(spectrum, seed, round(2400.0 * AIR_RATE_HZ)) for seed in (1, 2)]


def ratios(runs, name, rate, band, **kind):
    low, high = band
    found = []
    for run in runs:
        hz, power = periodogram(run[name], rate)
        inside = (hz >= low) & (hz < high)
        found.append(power[inside] / folded(name, hz[inside], rate, **kind))
    return np.concatenate(found)


@pytest.mark.parametrize("name", NAMES)
def test_drawn_spectrum_in_bands(spectrum, long_runs, name):
    # Two times 2400 s have 3360 ordinates from 0.3 to 1 Hz and more above: bound 10 %.  Below there are 960, 336,
    # 96 and 34 (18, 30, 57 and 96 %): there the next test is the sharp one.
    for band in pairwise((*LOW_BANDS, *BANDS[1:])):
        found = ratios(long_runs, name, AIR_RATE_HZ, band, spectrum=spectrum, length=KINDS[spectrum][1])
        assert found.mean() == pytest.approx(1.0, abs=bound(len(found))), band


@pytest.mark.parametrize("name", NAMES)
def test_drawn_spectrum_in_low_bands(spectrum, name, low_runs):
    # The processes are exact at any step, so long waves are looked at in records of 4.4 days, sampled each 4 s:
    # 2660 ordinates from 0.003 to 0.01 Hz (bound 11 %), 7600 and more above (10 %).
    for band in pairwise(LOW_BANDS):
        found = ratios([low_runs], name, 0.25, band, spectrum=spectrum, length=KINDS[spectrum][1])
        assert found.mean() == pytest.approx(1.0, abs=bound(len(found))), band


@pytest.fixture(scope="module")
def low_runs(spectrum):
    return series(spectrum, 3, 95_000, rate=0.25)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("rate", [40.0, 240.0])
def test_rms_does_not_depend_on_the_rate(spectrum, name, rate):
    # Of the stationary process itself; filters of von Karman lack 0.2 % of u, v, w, and up to 3 % of q and r,
    # whose spectra fall only with f^(-5/3): of them 2 % lie above the 54 Hz where the filters end.
    kind = {"spectrum": spectrum, "length": KINDS[spectrum][1]}
    pieces = [0.0, 0.01, 0.1, 1.0, 10.0, 1e2, 1e3, 1e5]
    wanted = sum(quad(lambda o: float(mil_spectra(name, o, **kind)), a, b)[0] for a, b in pairwise(pieces))
    made = processes(spectrum, partial(generator, 1), rate)
    index, row = {"u": (0, 0), "v": (1, 0), "r": (1, 1), "w": (2, 0), "q": (2, 1), "p": (3, 0)}[name]
    found = made[index].output_covariance[row, row]
    assert found == pytest.approx(wanted, rel=0.002 if spectrum == "dryden" else 0.03)
    if name in "uvw":
        assert found == pytest.approx(SIGMA**2, rel=0.003)


@pytest.mark.parametrize(("rate_gust", "gust", "sign", "chord"), [("q", "w", -1.0, 4.0), ("r", "v", 1.0, 3.0)])
def test_rate_gusts_are_the_rotation_of_the_air(spectrum, rate_gust, gust, sign, chord):
    # x forward: d/dx = (1/V) d/dt of what the aircraft meets is along its path, so air that sinks ahead (w grows)
    # turns nose down: q = -dw/dx; air that goes right ahead turns right: r = +dv/dx.
    run = series(spectrum, 4, 480 * 300, rate=480.0)
    slope = np.gradient(run[gust], 1.0 / 480.0) / SPEED
    tau = chord * SPAN / (math.pi * SPEED)
    k = 2.0 * tau * 480.0
    filtered = lfilter([1.0 / (1.0 + k), 1.0 / (1.0 + k)], [1.0, (1.0 - k) / (1.0 + k)], slope)  # 1/(1 + tau s)
    smooth = butter(4, 5.0, output="sos", fs=480.0)
    wanted, found = (sosfiltfilt(smooth, y)[4800:-4800] for y in (sign * filtered, run[rate_gust]))
    assert np.std(found - wanted) < 0.01 * np.std(wanted)


def test_the_axes_are_independent(long_runs):
    # Steps of u, v, w, p from sample to sample are nearly white: correlations have an sd of 1/sqrt(N).
    steps = np.array([np.diff(long_runs[0][name]) for name in "uvwp"])
    found = np.corrcoef(steps) - np.eye(4)
    assert np.abs(found).max() < 5.0 / math.sqrt(steps.shape[1])


def test_other_length_speed_and_span(spectrum):
    # Low and slow: L 150 m, V 45 m/s, b 12 m; from 0.1 to 3 Hz.
    kind = {"length": 150.0, "speed": 45.0, "span": 12.0, "sigma": 1.0}
    run = series(spectrum, 5, round(2400 * AIR_RATE_HZ), **kind)
    for name in NAMES:
        found = ratios([run], name, AIR_RATE_HZ, (0.1, 3.0), spectrum=spectrum, **kind)
        assert found.mean() == pytest.approx(1.0, abs=bound(len(found))), name


def test_unequal_axes_go_where_they_belong(spectrum):
    # sigma and length of u and v, then of w, whose they are for p, too: variance of p over sigma_w^2 from the
    # integral of Phi_p, pi/2 times its level over its time constant.
    made = KINDS[spectrum][0](
        Turbulence(spectrum, 3.0, 2.0, 800.0, 300.0), SPEED, SPAN, 0.025, partial(generator, 1)
    )
    u, v, w, p = (process.output_covariance[0, 0] for process in made)
    assert (u, v, w) == pytest.approx((9.0, 9.0, 4.0), rel=0.005)
    level = 4.0 / (SPEED * 300.0) * 0.8 * (math.pi * 300.0 / (4.0 * SPAN)) ** (1.0 / 3.0)
    assert p == pytest.approx(level * math.pi / 2.0 * math.pi * SPEED / (4.0 * SPAN), rel=1e-6)
    for process, length in zip(made, (800.0, 800.0, 300.0), strict=False):
        steps = process.draw(400_000)[:, 0]
        # integral of the correlation is half of the spectrum's level: L/V for u, L/(2V) for v and w
        lag = np.fft.irfft(np.abs(np.fft.rfft(steps, 2 * len(steps))) ** 2)[:8000] / len(steps)
        integral = (lag.sum() - lag[0] / 2.0) * 0.025 / lag[0]
        wanted = length / SPEED * (1.0 if process is made[0] else 0.5)
        # D = 10^4 s, up to lag M = 200 s: var = 4 M T^2/D at most, sd 0.28 T for u
        assert integral == pytest.approx(wanted, abs=1.2 * length / SPEED)
