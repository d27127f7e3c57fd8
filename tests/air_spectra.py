"""One-sided spectra of MIL-F-8785C, written from the standard, and what sampling and a record do to them."""

from __future__ import annotations

import math

import numpy as np

NAMES = ("u", "v", "w", "p", "q", "r")


def mil_spectra(name, omega, spectrum="dryden", sigma=2.88, length=533.4, speed=69.44, span=19.81):
    """Phi of one component, rad/s, lengths and sigmas equal in all axes."""
    base = sigma**2 * length / (math.pi * speed)
    if spectrum == "dryden":
        x2 = (length * omega / speed) ** 2
        along, across = 2.0 * base / (1.0 + x2), base * (1.0 + 3.0 * x2) / (1.0 + x2) ** 2
    else:
        x2 = (1.339 * length * omega / speed) ** 2
        along = 2.0 * base / (1.0 + x2) ** (5.0 / 6.0)
        across = base * (1.0 + 8.0 / 3.0 * x2) / (1.0 + x2) ** (11.0 / 6.0)
    wide = 1.0 + (4.0 * span * omega / (math.pi * speed)) ** 2
    narrow = 1.0 + (3.0 * span * omega / (math.pi * speed)) ** 2
    roll = sigma**2 / (speed * length) * 0.8 * (math.pi * length / (4.0 * span)) ** (1.0 / 3.0) / wide
    turn = (omega / speed) ** 2 * across
    return {"u": along, "v": across, "w": across, "p": roll, "q": turn / wide, "r": turn / narrow}[name]


def per_hz(name, hz, **kind):
    """The same by frequency, per Hz."""
    return 2.0 * math.pi * mil_spectra(name, 2.0 * math.pi * hz, **kind)


def folded(name, hz, rate, spectrum="dryden", images=20, **kind):
    """Spectrum per Hz of samples taken at a rate: all images of the frequency.

    Beyond `images` the spectra are powers of f, -2 or von Karman's -5/3, and the sum is an integral.
    """
    total = per_hz(name, hz, spectrum=spectrum, **kind)
    for k in range(1, images):
        total = total + per_hz(name, k * rate - hz, spectrum=spectrum, **kind)
        total = total + per_hz(name, k * rate + hz, spectrum=spectrum, **kind)
    power = 2.0 if spectrum == "dryden" or name == "p" else 5.0 / 3.0
    last = (images - 0.5) * rate
    return total + 2.0 * per_hz(name, last, spectrum=spectrum, **kind) * last / (power - 1.0) / rate


def periodogram(y, rate):
    """Frequencies (Hz, above 0) and one-sided densities per Hz of a record, under a Hann window."""
    window = np.hanning(len(y))
    power = np.abs(np.fft.rfft(y * window)) ** 2 * 2.0 / (rate * (window**2).sum())
    return np.fft.rfftfreq(len(y), 1.0 / rate)[1:], power[1:]


def bound(ordinates):
    """Largest deviation of a band's mean ratio: 4 sd, but not below 10 %.

    Under a Hann window over the whole record K ordinates count as K/1.944 independent ones (35/18, the sum of
    squared correlations), each with a relative sd of 1.
    """
    return max(0.10, 4.0 * math.sqrt(1.944 / ordinates))
