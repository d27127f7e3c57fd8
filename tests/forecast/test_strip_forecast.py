"""Forecast of strips over made land: what each kind of texture and relief does to them."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.forecast.strip_forecast import Eye, _formal, prospect
from aerosim.raster import Window

EYE = Eye(96, 7, 39.7, 132.6, 1.0, 1.0, 1.5, 255.0, None, (0.6, 1.6), True, True)
PIXEL = 22.624  # m on the ground, 3000 m below
CELL, HALF = 10.0, 2500.0
NORTH = np.array([0.0, 1.0])


def window(surface):
    """5 km of a function of easting and northing around the strip."""
    count = round(HALF / CELL)
    x, y = np.meshgrid(np.arange(-count, count + 1) * CELL, np.arange(count, -count - 1, -1) * CELL)
    return Window.of(np.broadcast_to(surface(x, y), x.shape), -HALF, HALF, CELL, -CELL)


def fractal(x, y, seed=1, contrast=25.0):
    """Texture of all wavelengths above 45 m, power as 1/f: contrast is its standard deviation."""
    shape = np.broadcast(x, y).shape
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(shape[0]), np.fft.fftfreq(shape[1]), indexing="ij"))
    spectrum = np.fft.fft2(np.random.default_rng(seed).standard_normal(shape)) * np.exp(-((f / 0.2) ** 4))
    grey = np.real(np.fft.ifft2(spectrum / np.maximum(f, 0.005)))
    return 110.0 + contrast * grey / grey.std()


def strip(ortho, relief=lambda x, y: 0.0 * x, eye=EYE, ahead=NORTH, place=(0.0, 0.0), height=3000.0):
    return prospect(eye, window(ortho), window(relief), np.array(place), np.array(ahead), height)


def test_good_land():
    found = [strip(lambda x, y, s=seed: fractal(x, y, s)) for seed in range(5)]
    assert min(each.accepted for each in found) > 0.95
    # study, fractal land with noise of 1.5: quadratic surface 0.11 to 0.16 deg; here with 0.08 px of floor
    assert np.median([np.degrees(each.sd_angle) for each in found]) == pytest.approx(0.14, abs=0.04)


def test_water_is_not_recognised():
    found = strip(lambda x, y: 60.0 + 0.0 * x)
    assert found.accepted < 0.01
    assert found.flat == pytest.approx(1.0)
    assert found.sd_angle > 1.0


def test_less_contrast_or_more_noise_is_worse():
    clear, pale, noisy = (
        strip(fractal),
        strip(lambda x, y: fractal(x, y, contrast=6.0)),
        strip(fractal, eye=EYE._replace(noise_grey=6.25)),
    )
    assert clear.flat > 1.5 * pale.flat
    assert clear.rival > 1.3 * pale.rival
    # a quarter of the contrast or four times the noise (and rounding): the same to a few per cent
    assert noisy.flat == pytest.approx(pale.flat, rel=0.08)
    assert noisy.sd_angle == pytest.approx(pale.sd_angle, rel=0.08)


def test_a_darker_land_is_exposed_longer_until_the_longest_exposure():
    def found(level, exposure=None):
        return strip(lambda x, y: level / 110.0 * fractal(x, y), eye=EYE._replace(exposure=exposure))

    # half as bright, exposed twice as long
    assert found(55.0).flat == pytest.approx(found(110.0).flat, rel=1e-6)
    assert found(20.0).flat < 0.95 * found(110.0).flat
    assert found(55.0, exposure=0.01).flat < found(55.0).flat


def test_repeated_rows_and_lattices_are_ambiguous():
    def lattice(x, y):
        return 110.0 + 25.0 * np.cos(2 * np.pi * x / (5 * PIXEL)) * np.cos(2 * np.pi * y / (5 * PIXEL))

    found = strip(lattice)
    # the land next to it looks the same: only the quarter of a pixel between both differs
    assert found.rival < 1.1
    assert found.accepted < 0.2


def test_stripes_along_the_flight_say_nothing_of_v_over_h():
    def across(x, y):
        return fractal(x, 0.0 * y, 3)[:1] + 0.0 * y

    along, turned = strip(across), strip(across, ahead=(1.0, 0.0))
    assert along.sd_vh > 5.0 * along.sd_angle
    # flown over the other way, the same land has no shift but a v/h
    assert turned.sd_angle > 5.0 * turned.sd_vh
    assert max(along.accepted, turned.accepted) < 0.1


def test_relief_under_the_row_makes_the_trough_weaker():
    """A valley along the track: heights of 300 m across the row, 4 px of n between its sides (39.7 x 300/3000)."""
    flat = strip(fractal)
    valley = strip(fractal, relief=lambda x, y: 150.0 * np.tanh(x / 300.0))
    slope = strip(fractal, relief=lambda x, y: 0.1 * y)
    assert valley.flat < 0.75 * flat.flat
    assert valley.rival < 0.75 * flat.rival
    # heights that do not change across the row change nothing
    assert slope.flat == pytest.approx(flat.flat, rel=0.02)


def test_no_land_no_forecast():
    assert np.isnan(strip(fractal, place=(1800.0, 0.0))).all()
    assert np.isnan(strip(fractal, relief=lambda x, y: np.where(x > 500.0, np.nan, 0.0))).all()


def test_formal_error_by_hand():
    """Grey slopes of +-1 a pixel along and across, in a pattern of four that is orthogonal to the rotation."""
    along = np.tile([1.0, 1.0, -1.0, -1.0], 24)
    across = np.tile([1.0, -1.0, 1.0, -1.0], 24)
    sd_mu, sd_n = _formal(np.stack([along, across]), 3.0)
    # residual / sqrt(sum of squares); the arm of the rotation brings 0.1 %
    assert (sd_mu, sd_n) == pytest.approx((3.0 / np.sqrt(96.0), 3.0 / np.sqrt(96.0)), rel=2e-3)
