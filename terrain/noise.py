"""Random fields of wanted wavelengths, without any lattice."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import fft

Field = NDArray[np.float32]


def band(shape: tuple[int, int], pixel: float, short: float, long: float, seed: int, slope: float = 1.0) -> Field:
    """Gaussian noise of wavelengths from short to long (m), unit variance, growing as wavelength**slope."""
    rng = np.random.default_rng(seed)
    white = rng.standard_normal(shape, dtype=np.float32)
    spectrum = fft.rfft2(white, workers=2)
    fy = fft.fftfreq(shape[0], pixel).astype(np.float32)[:, None]
    fx = fft.rfftfreq(shape[1], pixel).astype(np.float32)[None, :]
    f = np.hypot(fx, fy)
    f[0, 0] = 1.0
    gain = f**-slope / (1.0 + (f * short) ** 8) / (1.0 + 1.0 / (f * long) ** 8)
    gain[0, 0] = 0.0
    field = fft.irfft2(spectrum * gain, s=shape, workers=2).astype(np.float32)
    return np.asarray(field / field.std(), np.float32)


def ramp(values: Field, low: float, high: float) -> Field:
    """Smooth step from 0 at low to 1 at high."""
    t = np.clip((values - low) / (high - low), 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t), np.float32)
