"""Grey values and heights of synthetic land at any place of a map, from the place and a seed alone."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from aerosim.frames import Array

GREY = (48.0, 235.0)  # 0 means no data, and JPEG is off by up to two dozen grey levels at edges
RELIEF_WAVE = 6000.0  # m
RELIEF_CELLS = 3  # octaves below it


@njit(cache=True)
def _bits(x: int, y: int, seed: int) -> int:  # pragma: no cover - compiled
    """52 random bits for each lattice point and seed."""
    h = np.uint64(x) * np.uint64(0x9E3779B97F4A7C15) ^ np.uint64(y) * np.uint64(0xC2B2AE3D27D4EB4F)
    h ^= np.uint64(seed) * np.uint64(0x165667B19E3779F9)
    h = (h ^ (h >> np.uint64(33))) * np.uint64(0xFF51AFD7ED558CCD)
    h = (h ^ (h >> np.uint64(33))) * np.uint64(0xC4CEB9FE1A85EC53)
    return np.int64((h ^ (h >> np.uint64(33))) >> np.uint64(12))  # type: ignore[return-value]


@njit(cache=True)
def _share(x: int, y: int, seed: int) -> float:  # pragma: no cover - compiled
    """A number from 0 to 1 for each lattice point and seed."""
    part: float = _bits(x, y, seed) / 4503599627370496.0
    return part


@njit(cache=True)
def _noise(x: float, y: float, wave: float, seed: int) -> float:  # pragma: no cover - compiled
    """Smooth noise of one wavelength, mean 0, variance about 1, its lattice turned by the seed."""
    turn = 2.399963 * seed
    c, s = np.cos(turn), np.sin(turn)
    u, v = (c * x - s * y) / (0.5 * wave), (s * x + c * y) / (0.5 * wave)
    i, j = np.floor(u), np.floor(v)
    u, v = u - i, v - j
    fu, fv = u * u * u * (u * (6.0 * u - 15.0) + 10.0), v * v * v * (v * (6.0 * v - 15.0) + 10.0)
    p, q = int(i), int(j)
    upper = (1.0 - fu) * _share(p, q, seed) + fu * _share(p + 1, q, seed)
    lower = (1.0 - fu) * _share(p, q + 1, seed) + fu * _share(p + 1, q + 1, seed)
    value: float = ((1.0 - fv) * upper + fv * lower - 0.5) * 4.75
    return value


@njit(cache=True)
def _parcel(x: float, y: float, size: float, seed: int) -> float:  # pragma: no cover - compiled
    """The grey of the nearest of scattered points, -1 to 1: patches with sharp edges."""
    i, j = int(np.floor(x / size)), int(np.floor(y / size))
    best, a, b = 1e30, i, j
    for p in range(i - 1, i + 2):
        for q in range(j - 1, j + 2):
            bits = _bits(p, q, seed)
            du = x / size - p - (bits & 67108863) / 67108864.0
            dv = y / size - q - (bits >> 26) / 67108864.0
            if du * du + dv * dv < best:
                best, a, b = du * du + dv * dv, p, q
    return 2.0 * _share(a, b, seed + 1) - 1.0


@njit(cache=True)
def texture(
    rows: int, cols: int, west: float, north: float, pixel: float, low: float, high: float, seed: int
) -> NDArray[np.uint8]:  # pragma: no cover - compiled
    """Grey values (rows, cols): patches of two sizes, noise at octaves from high down to two pixels (m)."""
    grey = np.empty((rows, cols), np.uint8)
    for r in range(rows):
        y = north - (r + 0.5) * pixel
        for c in range(cols):
            x = west + (c + 0.5) * pixel
            bend = 0.15 * high * _noise(x, y, 2.0 * high, seed + 90)
            value = 112.0 + 38.0 * _parcel(x + bend, y - bend, 0.5 * high, 1000 + seed)
            value += 26.0 * _parcel(x - bend, y + bend, 3.0 * low, 2000 + seed)
            wave, octave = high, 0
            while wave >= 2.0 * pixel:
                value += (7.0 if wave >= low else 4.0) * _noise(x, y, wave, seed + 101 + octave)
                wave, octave = 0.5 * wave, octave + 1
            grey[r, c] = np.uint8(min(max(value, GREY[0]), GREY[1]))
    return grey


@njit(cache=True)
def relief(
    rows: int, cols: int, west: float, north: float, pixel: float, seed: int
) -> Array:  # pragma: no cover - compiled
    """Heights (rows, cols) of mean 0 and standard deviation about 1, hills some kilometres wide."""
    found = np.empty((rows, cols))
    for r in range(rows):
        y = north - (r + 0.5) * pixel
        for c in range(cols):
            x = west + (c + 0.5) * pixel
            total, weight, wave = 0.0, 1.0, RELIEF_WAVE
            for octave in range(RELIEF_CELLS):
                total += weight * _noise(x, y, wave, seed + 301 + octave)
                weight, wave = 0.35 * weight, 0.5 * wave
            found[r, c] = total / 1.066
    return found
