"""Equation (2), Fig. 3, and what a trough says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aerosim.estimation.mad import Trough, judge, mad, padded, prepared, refine
from aerosim.raster import sample
from aerosim.signals import Reason
from aerosim.world.terrain import Terrain, find_terrain

from .texture import Ground, surface

U = 96


def direct(row1: NDArray[Any], row2: NDArray[Any], j: int, centre: bool) -> list[float]:
    """Equation (2) word by word, divided by u: index i + mu of row I, whose element 0 is a(-j)."""
    a = {index - j: float(value) for index, value in enumerate(row1)}
    u = len(row2)
    apart = sum(a[i] for i in range(u)) / u - sum(map(float, row2)) / u if centre else 0.0
    return [sum(abs(a[i + mu] - float(row2[i]) - apart) for i in range(u)) / u for mu in range(-j, j + 1)]


def test_table_of_the_study_exactly(vectors: dict[str, Any]) -> None:
    given_ = vectors["mad"]
    row1 = np.array(given_["row_I"], np.float32)
    rows2 = np.array(given_["row_II_exposures_1_to_5"], np.float32)
    found = np.array([mad(row1, row2) for row2 in rows2])
    assert (found * given_["u"] == np.array(given_["mad_by_exposure_and_shift"])).all()  # 32 pairs: no rounding
    step, k = np.unravel_index(found.argmin(), found.shape)
    assert (step + 1, k - given_["j"]) == (given_["minimum"]["n"], given_["minimum"]["mu"]) == (4, 3)


def test_row_means_inside_the_absolute_value(vectors: dict[str, Any]) -> None:
    given_ = vectors["mad"]
    row1, j = np.array(given_["row_I"], np.float32), given_["j"]
    for row2 in np.array(given_["row_II_exposures_1_to_5"], np.float32):
        found = mad(prepared(row1, j), prepared(row2 + 40.0, 0))
        # float32 sums of 32 numbers below 256: 32 x 256 x 6e-8 = 5e-4
        np.testing.assert_allclose(found, direct(row1, row2, j, centre=True), atol=5e-4)


def test_figure_3_on_the_shipped_orthophoto() -> None:
    """Row I keeps a strip; row II meets it at the fourth correlation, three pixels aside."""
    terrain = Terrain.open(*find_terrain("pine_mountain"), "file")
    pixel = 22.6  # m on the ground from 3000 m
    east0, north0 = (terrain.bounds[0] + terrain.bounds[2]) / 2.0, (terrain.bounds[1] + terrain.bounds[3]) / 2.0
    window = terrain.orthophoto(pixel).covering(
        east0 - 100 * pixel, north0 - 100 * pixel, east0 + 100 * pixel, north0 + 100 * pixel
    )

    def row(step: float, across: NDArray[np.float64]) -> NDArray[np.float32]:
        east = east0 + (across - 48.0) * pixel
        return np.asarray(sample(window, east, np.full(len(across), north0 + step * pixel)), np.float32)

    rng = np.random.default_rng(3)

    def noisy(grey: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.round(grey + 1.5 * rng.standard_normal(len(grey))).astype(np.float32)

    row1 = noisy(row(0.0, np.arange(-7.0, U + 7.0)))
    # flying north: exposure 4 of row II lies on the strip; three pixels to the east (right) since row I saw it
    found = np.array([mad(row1, noisy(row(e - 4.0, np.arange(0.0, U) + 3.0))) for e in range(1, 6)])
    trough = judge(found, steps_per_px=1.0)
    assert (trough.step + 1, trough.mu, trough.reason) == (4, 3, Reason.ACCEPTED)
    # what is left is the noise of two rows: E|N(0, 2 x (1.5^2 + 1/12))| = 1.72 grey levels, sd of the mean 0.13
    assert trough.value == pytest.approx(1.72, abs=0.55)


rows = st.integers(0, 2**32 - 1).map(np.random.default_rng)


@settings(deadline=None, max_examples=60)
@given(rng=rows, j=st.integers(0, 9), u=st.integers(24, 160), data=st.data())
def test_whole_shift_is_found_exactly(rng: np.random.Generator, j: int, u: int, data: st.DataObject) -> None:
    mu = data.draw(st.integers(-j, j))
    row1 = rng.integers(0, 256, u + 2 * j).astype(np.float32)
    row2 = row1[j + mu : j + mu + u]  # index in row I = index in row II + mu
    found = mad(row1, row2)
    assert found.shape == (2 * j + 1,)
    assert found[j + mu] == 0.0
    assert (np.delete(found, j + mu) > 0.0).all()


@settings(deadline=None, max_examples=60)
@given(rng=rows, gain=st.floats(0.2, 5.0), offset=st.floats(-50.0, 50.0), u=st.integers(8, 160))
def test_common_gain_scales_and_offset_falls_out(
    rng: np.random.Generator, gain: float, offset: float, u: int
) -> None:
    row1, row2 = (rng.integers(0, 256, n).astype(np.float32) for n in (u + 14, u))
    found = mad(prepared(row1, 7), prepared(row2, 0))
    brighter = np.float32(gain) * row1 + np.float32(offset), np.float32(gain) * row2
    # float32: a few roundings of numbers below 1400
    np.testing.assert_allclose(mad(prepared(brighter[0], 7), prepared(brighter[1], 0)), gain * found, atol=2e-3)
    np.testing.assert_allclose(mad(prepared(row1, 7, gain), prepared(row2, 0, gain)), gain * found, atol=2e-3)
    plain = mad(prepared(row1, 7, gain, centre=False), prepared(row2, 0, gain, centre=False))
    np.testing.assert_allclose(plain, np.array(direct(row1, row2, 7, centre=False)) * gain, atol=2e-3)


def test_offset_stays_without_the_row_means() -> None:
    row = np.full(U, 90.0, np.float32)
    assert mad(prepared(row + 15.0, 0, centre=False), prepared(row, 0, centre=False)) == pytest.approx([15.0])


def test_padded_extension_says_nothing_about_the_ground() -> None:
    row = np.random.default_rng(1).integers(0, 256, U + 14).astype(np.float32)
    other = row.copy()
    other[:7], other[-7:] = 3.0, 250.0
    assert (padded(row, 7) == padded(other, 7)).all()
    assert (padded(row, 7)[7:-7] == row[7:-7]).all()
    assert padded(row, 7)[:7] == pytest.approx(row[7:-7].mean())
    assert prepared(padded(row, 7), 7)[[0, -1]] == pytest.approx(0.0, abs=1e-4)
    assert (padded(row, 0) == row).all()


@pytest.mark.parametrize(("n", "mu"), [(20.0, 3.0), (22.0, -5.0), (19.0, 0.0), (21.0, 6.0)])
def test_known_whole_shift_of_a_texture(n: float, mu: float) -> None:
    found = surface(Ground(int(n)), n, mu, 41, 6.51, 1.5, 7)
    trough = judge(found, 6.51)
    assert (trough.step, trough.mu, trough.reason) == (n, mu, Reason.ACCEPTED)


@pytest.mark.parametrize(
    ("steps_per_px", "noise", "bound"), [(6.51, 0.0, 0.075), (6.51, 1.5, 0.075), (2.17, 1.5, 0.09)]
)
def test_fraction_is_found_in_sign_and_size(steps_per_px: float, noise: float, bound: float) -> None:
    """0.11 to 0.16 deg of drift in the study is 0.08 to 0.11 px.

    Measured on 150 grounds: 0.058 to 0.070 px in mu, 0.058 to 0.080 px in n.  The rms of 60 has a relative
    standard deviation of 9 %: the bound is 2 to 3 of them above.  Whole numbers, off by 1/sqrt(12) = 0.29 px,
    and a wrong sign miss it.
    """
    rng = np.random.default_rng(11)
    errors = []
    steps = 2 * round(4.0 * steps_per_px) + 1
    for trial in range(60):
        n, mu = steps // 2 + rng.uniform(-1.0, 1.0), rng.uniform(-5.5, 5.5)
        found = surface(Ground(trial), n, mu, steps, steps_per_px, noise, trial)
        trough = judge(found, steps_per_px)
        assert trough.reason is Reason.ACCEPTED
        whole = trough
        trough = refine(found, trough, steps_per_px)
        assert trough.value == whole.value
        errors.append(((trough.step - n) / steps_per_px, trough.mu - mu))
    rms_n, rms_mu = np.sqrt(np.mean(np.square(errors), axis=0))
    assert rms_mu < bound
    assert rms_n < bound + 0.01


@settings(deadline=None, max_examples=60)
@given(
    n=st.floats(14.5, 16.5), mu=st.floats(-4.4, 4.4), slant=st.floats(-0.6, 0.6), steps_per_px=st.floats(2.0, 16.0)
)
def test_a_paraboloid_is_found_exactly(n: float, mu: float, slant: float, steps_per_px: float) -> None:
    """The squared MAD of refine's model, also with a valley that runs aslant: nothing but rounding is left."""
    s, k = np.meshgrid((np.arange(31) - n) / steps_per_px, np.arange(-7, 8) - mu, indexing="ij")
    found = np.sqrt(9.0 + 4.0 * s * s + 5.0 * k * k + 2.0 * slant * 4.4 * s * k).astype(np.float32)
    trough = judge(found, steps_per_px)
    refined = refine(found, trough, steps_per_px)
    assert (refined.step, refined.mu) == pytest.approx((n, mu), abs=0.02)


def test_a_rim_or_a_saddle_leaves_whole_numbers() -> None:
    s, k = np.meshgrid(np.arange(31.0), np.arange(-7.0, 8.0), indexing="ij")
    bowl = np.hypot(s - 1.0, k) + 3.0
    at_rim = Trough(1.0, 0.0, 3.0, Reason.ACCEPTED)
    assert refine(bowl.astype(np.float32), at_rim, 6.51) == at_rim
    saddle = np.sqrt(400.0 + (s - 15.0) ** 2 - k**2).astype(np.float32)
    middle = Trough(15.0, 0.0, 20.0, Reason.ACCEPTED)
    assert refine(saddle, middle, 6.51) == middle


def bowl(n: float, mu: float, steps: int = 61, floor: float = 4.0) -> NDArray[np.float32]:
    """A trough on a plateau of 20 grey levels: its walls rise by 6 levels a pixel, 6.5 exposures a pixel."""
    s, k = np.meshgrid((np.arange(steps) - n) / 6.5, np.arange(-7.0, 8.0) - mu, indexing="ij")
    return np.minimum(floor + 6.0 * np.hypot(s, k), 20.0).astype(np.float32)


@pytest.mark.parametrize(
    ("n", "mu", "reason"),
    [
        (30, 0, Reason.ACCEPTED),
        (30, 7, Reason.BORDER_MU),
        (30, -7, Reason.BORDER_MU),
        (0, 2, Reason.BORDER_N),
        (60, 2, Reason.BORDER_N),
        (1, 6, Reason.ACCEPTED),
        (59, -6, Reason.ACCEPTED),
    ],
)
def test_minimum_at_the_boundary_is_discarded(n: int, mu: int, reason: Reason) -> None:
    trough = judge(bowl(n, mu), 6.5)
    assert trough == (n, mu, 4.0, reason)


def test_last_exposure_is_no_border_while_the_window_is_open() -> None:
    assert judge(bowl(60, 2), 6.5, complete=False).reason is Reason.ACCEPTED
    assert judge(bowl(0, 2), 6.5, complete=False).reason is Reason.BORDER_N


def test_open_window_asks_for_a_plainer_trough() -> None:
    shallow = bowl(30, 0, floor=9.0)  # mean / minimum about 2.1
    assert judge(shallow, 6.5).reason is Reason.ACCEPTED
    assert judge(shallow, 6.5, complete=False).reason is Reason.DEGENERATE


def test_flat_and_inclined_surfaces_have_no_trough() -> None:
    s, k = np.meshgrid(np.arange(61.0), np.arange(-7.0, 8.0), indexing="ij")
    dimple = np.full((61, 15), 10.0, np.float32)
    dimple[30, 7] = 8.0
    assert judge(dimple, 6.5).reason is Reason.DEGENERATE
    for plane in (10.0 + 0.1 * s + 0.2 * k, 30.0 - 0.1 * s - 0.2 * k, 10.0 + 0.1 * s, 10.0 + 0.2 * k):
        assert judge(plane.astype(np.float32), 6.5).reason in {Reason.BORDER_MU, Reason.BORDER_N}


def test_two_equal_troughs_are_ambiguous() -> None:
    deep, other = bowl(30, -3), bowl(30, 4)
    assert judge(np.minimum(deep, other + 0.1), 6.5).reason is Reason.AMBIGUOUS
    assert judge(np.minimum(deep, other + 2.0), 6.5).reason is Reason.ACCEPTED  # 6 / 4: more than 1.25
    later = np.minimum(bowl(15, 1), bowl(45, 1) + 0.5)
    assert judge(later, 6.5).reason is Reason.AMBIGUOUS


def test_a_lattice_is_ambiguous() -> None:
    """Fields of 9 pixels fit twice into the 15 shifts."""
    rng = np.random.default_rng(2)

    def row(along: float, across: NDArray[np.float64]) -> NDArray[np.float32]:
        grey = 110.0 + 25.0 * np.cos(2 * np.pi * across / 9.0) + 25.0 * np.cos(2 * np.pi * along / 9.0)
        return np.round(grey + 1.5 * rng.standard_normal(len(across))).astype(np.float32)

    row1 = prepared(row(0.0, np.arange(-7.0, 103.0)), 7)
    found = np.array([mad(row1, prepared(row((s - 30) / 6.5, np.arange(96.0) + 4.0), 0)) for s in range(61)])
    assert judge(found, 6.5).reason is Reason.AMBIGUOUS


def test_water_never_gives_a_confident_number() -> None:
    """Noise of 1.5 grey levels on an even grey, windows closed and open: 200 strips, none accepted."""
    rng = np.random.default_rng(4)
    for _ in range(200):
        row1 = prepared(np.round(60.0 + 1.5 * rng.standard_normal(110)).astype(np.float32), 7)
        rows2 = np.round(60.0 + 1.5 * rng.standard_normal((61, 96))).astype(np.float32)
        found = np.array([mad(row1, prepared(row2, 0)) for row2 in rows2])
        assert judge(found, 6.5).reason is not Reason.ACCEPTED
        assert judge(found, 6.5, complete=False).reason is not Reason.ACCEPTED
