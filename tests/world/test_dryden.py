"""Dryden gusts against the one-sided spectra of MIL-F-8785C, their rms, and the sign of the rate gusts."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import butter, lfilter, sosfiltfilt

from aerosim.rng import generator
from aerosim.world.dryden import dryden_processes

SIGMA, LENGTH, SPEED, SPAN, RATE = 2.88, 533.4, 69.44, 19.81, 120.0
NAMES = ("u", "v", "w", "p", "q", "r")
BANDS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)  # Hz


def mil_spectra(omega, sigma=SIGMA, length=LENGTH, speed=SPEED, span=SPAN):
    """Phi of MIL-F-8785C in rad/s, one-sided, lengths equal in all axes."""
    x = length * omega / speed
    phi_u = 2.0 * sigma**2 * length / (math.pi * speed) / (1.0 + x**2)
    phi_w = sigma**2 * length / (math.pi * speed) * (1.0 + 3.0 * x**2) / (1.0 + x**2) ** 2
    phi_p = sigma**2 / (speed * length) * 0.8 * (math.pi * length / (4.0 * span)) ** (1.0 / 3.0)
    wide = 1.0 + (4.0 * span * omega / (math.pi * speed)) ** 2
    narrow = 1.0 + (3.0 * span * omega / (math.pi * speed)) ** 2
    rate = (omega / speed) ** 2 * phi_w
    return {"u": phi_u, "v": phi_w, "w": phi_w, "p": phi_p / wide, "q": rate / wide, "r": rate / narrow}


def series(seed, duration, rate=RATE, sigma=SIGMA, length=LENGTH, speed=SPEED, span=SPAN):
    made = dryden_processes(sigma, length, speed, span, 1.0 / rate, lambda name: generator(seed, name))
    u, v, r, w, q, p = np.hstack([process.draw(round(duration * rate)) for process in made]).T
    return {"u": u, "v": v, "w": w, "p": p, "q": q, "r": r}


@pytest.fixture(scope="module")
def long_runs():
    """Twice 40 minutes."""
    return [series(seed, 2400.0) for seed in (1, 2)]


@pytest.mark.parametrize("name", NAMES)
def test_spectrum_in_bands(long_runs, name):
    # Mean over a band of periodogram over formula.  Under a Hann window over the whole record K ordinates count as
    # K / 1.944 independent ones (35/18, the sum of squared correlations), each with a relative sd of 1.  Bounds:
    # 4 sd, but not below 10 %; sampling at 120 Hz folds 2 % into the highest band.
    ratios = []
    for run in long_runs:
        y = run[name]
        window = np.hanning(len(y))
        power = np.abs(np.fft.rfft(y * window)) ** 2 * 2.0 / (RATE * (window**2).sum())
        hz = np.fft.rfftfreq(len(y), 1.0 / RATE)
        ratios.append((hz[1:], power[1:] / (2.0 * math.pi * mil_spectra(2.0 * math.pi * hz[1:])[name])))
    for low, high in pairwise(BANDS):
        inside = np.concatenate([ratio[(hz >= low) & (hz < high)] for hz, ratio in ratios])
        bound = max(0.10, 4.0 * math.sqrt(1.944 / len(inside)))
        assert inside.mean() == pytest.approx(1.0, abs=bound), f"{low}-{high} Hz"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("rate", [60.0, 240.0])
def test_rms_does_not_depend_on_the_rate(name, rate):
    # Variance of a sample variance: 2/D int R^2 dtau = (2 pi/D) int Phi^2 domega for a one-sided Phi in rad/s.
    def squared(omega):
        return mil_spectra(np.array(omega))[name] ** 2

    duration = 2400.0
    top = 2.0 * math.pi * 1000.0
    pieces = [0.0, 0.05, 0.5, 5.0, 50.0, top]
    variance, square = (
        sum(quad(f, a, b, limit=200)[0] for a, b in pairwise(pieces))
        for f in (lambda omega: mil_spectra(np.array(omega))[name], squared)
    )
    bound = 4.0 * math.sqrt(2.0 * math.pi * square / duration)
    found = float(np.mean(series(3, duration, rate)[name] ** 2))
    # what lies above `top` of q and r, whose spectra fall with 1/omega^2: 0.3 %
    assert found == pytest.approx(variance, abs=bound + 0.003 * variance)
    if name in "uvw":
        assert variance == pytest.approx(SIGMA**2, rel=2e-3)


@pytest.mark.parametrize(("rate_gust", "gust", "sign", "chord"), [("q", "w", -1.0, 4.0), ("r", "v", 1.0, 3.0)])
def test_rate_gusts_are_the_rotation_of_the_air(rate_gust, gust, sign, chord):
    # x forward: d/dx = (1/V) d/dt of what the aircraft meets is along its path, so air that sinks ahead (w grows)
    # turns nose down: q = -dw/dx; air that goes right ahead turns right: r = +dv/dx.
    run = series(4, 300.0, rate=480.0)
    slope = np.gradient(run[gust], 1.0 / 480.0) / SPEED
    tau = chord * SPAN / (math.pi * SPEED)
    k = 2.0 * tau * 480.0
    filtered = lfilter([1.0 / (1.0 + k), 1.0 / (1.0 + k)], [1.0, (1.0 - k) / (1.0 + k)], slope)  # 1/(1 + tau s)
    smooth = butter(4, 5.0, output="sos", fs=480.0)
    wanted, found = (sosfiltfilt(smooth, y)[4800:-4800] for y in (sign * filtered, run[rate_gust]))
    assert np.std(found - wanted) < 0.01 * np.std(wanted)


def test_the_axes_are_independent(long_runs):
    # Steps of u, v, w, p from sample to sample are white but for a percent: correlations have an sd of 1/sqrt(N).
    steps = np.array([np.diff(long_runs[0][name]) for name in "uvwp"])
    found = np.corrcoef(steps) - np.eye(4)
    assert np.abs(found).max() < 5.0 / math.sqrt(steps.shape[1])


def test_other_length_speed_and_span():
    # Low and slow: L 150 m, V 45 m/s, b 12 m; from 0.1 to 3 Hz, bounds as above.
    kind = {"length": 150.0, "speed": 45.0, "span": 12.0, "sigma": 1.0}
    run = series(5, 2400.0, **kind)
    for name in NAMES:
        y = run[name]
        window = np.hanning(len(y))
        power = np.abs(np.fft.rfft(y * window)) ** 2 * 2.0 / (RATE * (window**2).sum())
        hz = np.fft.rfftfreq(len(y), 1.0 / RATE)
        inside = (hz > 0.1) & (hz < 3.0)
        ratio = power[inside] / (2.0 * math.pi * mil_spectra(2.0 * math.pi * hz[inside], **kind)[name])
        assert ratio.mean() == pytest.approx(1.0, abs=4.0 * math.sqrt(1.944 / inside.sum())), name
