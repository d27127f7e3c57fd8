"""Least squares on grey values: known shifts of a known ground."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.estimation.tracking.fine import Fine, fine
from aerosim.estimation.tracking.window import surface

PIXELS, MARGIN, STEPS_PER_PX = 96, 7, 6.5
TURN = 0.03


def ground(rng: np.random.Generator):
    """A smooth random ground (px): sum of waves from 8 to 80 px of any direction, some 20 grey levels."""
    length = rng.uniform(8.0, 80.0, 60)
    course, phase = rng.uniform(0, 2 * np.pi, 60), rng.uniform(0, 2 * np.pi, 60)
    kx, ky = 2 * np.pi / length * np.cos(course), 2 * np.pi / length * np.sin(course)
    size = np.sqrt(length) / np.sqrt(length).std() * 2.2

    def grey(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 110.0 + (size * np.cos(np.multiply.outer(x, kx) + np.multiply.outer(y, ky) + phase)).sum(-1)

    return grey


def flown(
    rng: np.random.Generator, step: float, mu: float, slope: float = 0.0, gain: float = 1.0, offset: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Row I, and a ring of 64 exposures of row II that meets it at `step`, shifted by mu, turned by `slope`.

    With 1.5 grey levels of noise and whole grey levels.
    """
    grey = ground(rng)
    i = np.arange(-MARGIN, PIXELS + MARGIN, dtype=float)
    row1 = grey(i, np.zeros_like(i))
    j = np.arange(PIXELS, dtype=float)
    exposures = np.arange(64, dtype=float)
    # pixel j of row II sees the ground of row I when the exposure is step + slope (j - middle)
    late = (exposures[:, None] - step - slope * (j - (PIXELS - 1) / 2.0)) / STEPS_PER_PX
    rows2 = gain * grey(np.broadcast_to(j + mu, late.shape), -late) + offset

    def read(values: np.ndarray) -> np.ndarray:
        return np.round(values + rng.normal(0.0, 1.5, values.shape)).astype(np.float32)

    return read(row1), read(rows2)


def find(row1: np.ndarray, rows2: np.ndarray, mask: np.ndarray | None = None, slope: float = 0.0) -> Fine:
    """MAD minimum, then least squares."""
    weights = np.ones(PIXELS, np.float32) if mask is None else mask.astype(np.float32)
    bow = np.zeros(PIXELS)
    found = surface(row1, rows2, weights, 8, 48, 0, MARGIN, slope, bow)
    step, k = np.unravel_index(np.argmin(found), found.shape)
    return Fine(*fine(row1, rows2, weights, 8.0 + step, float(k - MARGIN), slope, bow, STEPS_PER_PX))


def test_a_known_shift_is_recovered_to_a_twentieth_of_a_pixel() -> None:
    """120 grounds, any shift within +-6 px: 0.05 px rms in mu, 0.06 px along the track.

    With 120 cases an rms is known to 1/sqrt(240) = 6.5 %: so much above is allowed, three times.
    """
    rng = np.random.default_rng(3)
    errors, told = [], []
    for _ in range(120):
        mu, step = rng.uniform(-6.0, 6.0), rng.uniform(20.0, 44.0)
        best = find(*flown(rng, step, mu, gain=rng.uniform(0.7, 1.4), offset=rng.uniform(-20.0, 20.0)))
        assert best.ok
        errors.append((best.mu - mu, (best.step - step) / STEPS_PER_PX))
        told.append((best.sd_mu, best.sd_step / STEPS_PER_PX))
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert (rms < np.array([0.05, 0.06]) * (1.0 + 3.0 * 0.065)).all()
    # the sd that it tells: standardised errors of 120 cases, within the 99.9 % bound of chi2 (0.63 ... 1.5)
    # times 4: what the splines smooth away differs between the rows, which no residual tells
    assert 0.63 < np.mean(np.square(np.array(errors)[:, 0] / np.array(told)[:, 0])) < 4.0 * 1.5


@pytest.mark.parametrize("mu", [-4.0, 4.0])
def test_sign(mu: float) -> None:
    """mu > 0: index in row I = index in row II + mu."""
    best = find(*flown(np.random.default_rng(1), 30.0, mu))
    assert best.mu == pytest.approx(mu, abs=0.2)
    assert best.step == pytest.approx(30.0, abs=1.5)


@pytest.mark.parametrize("turned_deg", [-3.0, 3.0])
def test_a_turn_between_the_rows_is_found_and_does_no_harm(turned_deg: float) -> None:
    """3 deg turn pixels at the row's end by 2.5 px, 16 exposures: looked for with the known slope."""
    slope = np.radians(turned_deg) * STEPS_PER_PX
    rng = np.random.default_rng(7)
    row1, rows2 = flown(rng, 32.0, 1.3, slope=slope)
    best = find(row1, rows2, slope=slope)
    assert best.ok
    # the slope's scatter over grounds is 0.012: three times that, and at the row's end 2 of 16 exposures
    assert best.slope == pytest.approx(slope, abs=0.04)
    assert best.mu == pytest.approx(1.3, abs=0.15)
    # a third of it is not known beforehand, and found
    other = find(row1, rows2, slope=0.7 * slope)
    assert other.slope == pytest.approx(slope, abs=0.04)


def test_another_gain_and_offset_change_nothing() -> None:
    plain = find(*flown(np.random.default_rng(9), 30.0, 2.0))
    other = find(*flown(np.random.default_rng(9), 30.0, 2.0, gain=1.3, offset=-15.0))
    # the noise is the same in grey levels, so a little smaller beside the ground
    assert other.mu == pytest.approx(plain.mu, abs=0.03)
    assert other.step == pytest.approx(plain.step, abs=0.2)


def test_pixels_left_out_do_not_count() -> None:
    rng = np.random.default_rng(11)
    row1, rows2 = flown(rng, 30.0, 2.0)
    rows2[:, 40:44] = 255.0
    mask = np.ones(PIXELS)
    mask[40:44] = 0.0
    best = find(row1, rows2, mask)
    assert best.ok
    assert best.mu == pytest.approx(2.0, abs=0.15)


def test_noise_alone_is_not_taken_for_ground() -> None:
    rng = np.random.default_rng(13)
    row1 = rng.normal(0.0, 1.5, PIXELS + 2 * MARGIN).astype(np.float32)
    rows2 = rng.normal(0.0, 1.5, (64, PIXELS)).astype(np.float32)
    weights = np.ones(PIXELS, np.float32)
    best = Fine(*fine(row1, rows2, weights, 30.0, 0.0, 0.0, np.zeros(PIXELS), STEPS_PER_PX))
    assert not best.ok or best.sd_mu > 0.12
