"""The fixed-point instrument against plain Python whole numbers, the study's vectors and the real instrument."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerosim.estimation import fixed_point as fp
from aerosim.estimation.integer_strips import IntegerRecogniser, judge_sums
from aerosim.estimation.kalman import (
    ScalarFilter,
    Series,
    next_gain_riccati,
    stationary_gain,
)
from aerosim.estimation.mad import judge, mad, padded, prepared
from aerosim.estimation.strips import StripParameters, StripRecogniser
from aerosim.signals import MountReading, Reason, RowExposure, StripMatch

from .texture import Ground

DEG = math.pi / 180.0


# --- the independent model: plain int, no numpy, written from the formats of the docstring alone ---


def half_up(numerator: int, denominator: int) -> int:
    """Nearest whole number, halves upwards, by exact fractions."""
    return math.floor(Fraction(numerator, denominator) + Fraction(1, 2))


def model_sums(row1: list[int], row2: list[int], subtracted: bool) -> list[int]:
    u = len(row2)
    j = (len(row1) - u) // 2
    offset = half_up(sum(row1[j : j + u]) - sum(row2), u) if subtracted else 0
    return [sum(abs(row1[k + i] - row2[i] - offset) for i in range(u)) for k in range(2 * j + 1)]


def model_least(surface: list[list[int]]) -> tuple[int, int]:
    best, place = None, (0, 0)
    for step, sums in enumerate(surface):
        for k, value in enumerate(sums):
            if best is None or value < best:
                best, place = value, (step, k)
    return place


def model_riccati(q: int, gamma: int) -> int:
    return half_up((q + gamma) * 32768, q + gamma + 32768)


def model_filter(
    observed: list[int], gamma: int, series: Series, low: int, high: int
) -> tuple[list[int], list[int]]:
    """Gains (Q15) and states of (16), all in units of the last bit."""
    limit = math.isqrt(gamma * gamma + 4 * gamma * 32768)
    q_inf = (limit - gamma + 1) // 2
    gains, states = [32768], [min(max(observed[0], low), high)]
    for each in observed[1:]:
        y = min(max(each, low), high)
        q = model_riccati(gains[-1], gamma) if series == "riccati" else (gains[-1] + q_inf) // 2
        step = half_up(q * (y - states[-1]), 32768)
        gains.append(q)
        states.append(min(max(states[-1] + step, low), high))
    return gains, states


rngs = st.integers(0, 2**32 - 1).map(np.random.default_rng)


# --- (2) ---


def test_sums_of_the_study(vectors: dict[str, Any]) -> None:
    given_ = vectors["mad"]
    row1 = np.array(given_["row_I"], np.uint8)
    found = np.array(
        [fp.mad_sums(row1, np.array(row, np.uint8), False) for row in given_["row_II_exposures_1_to_5"]]
    )
    assert found.tolist() == given_["mad_by_exposure_and_shift"]
    step, k = fp.least(found)
    assert (step + 1, k - given_["j"], int(found[step, k])) == (4, 3, 56)
    trough = judge_sums(found, near=2, complete=True)
    assert (trough.step + 1, trough.mu, trough.value, trough.reason) == (4, 3, 56, Reason.ACCEPTED)


@settings(deadline=None, max_examples=40)
@given(rng=rngs, j=st.integers(1, 9), u=st.integers(20, 128), subtracted=st.booleans(), full=st.booleans())
def test_sums_are_those_of_plain_whole_numbers(
    rng: np.random.Generator, j: int, u: int, subtracted: bool, full: bool
) -> None:
    row1, row2 = (rng.integers(0, 256, n).astype(np.uint8) for n in (u + 2 * j, u))
    if full:  # the largest sums that there are
        row1, row2 = np.where(row1 > 127, 255, 0).astype(np.uint8), np.where(row2 > 127, 255, 0).astype(np.uint8)
    assert fp.mad_sums(row1, row2, subtracted).tolist() == model_sums(row1.tolist(), row2.tolist(), subtracted)


def test_the_largest_sum_fits_into_its_word() -> None:
    """Rows of 128 pixels whose means differ by 255 and whose edges are reversed: the word of 16 bits is not full.

    |a - b - D| is at most 255 + 255, 128 of them are 65280.
    """
    row1, row2 = np.full(142, 255, np.uint8), np.zeros(128, np.uint8)
    row1[:7] = row1[-7:] = 0
    sums = fp.mad_sums(row1, row2, True)
    assert sums.tolist() == model_sums(row1.tolist(), row2.tolist(), True)
    assert sums.max() == 7 * 255
    assert 128 * 510 < 2**16


@settings(deadline=None, max_examples=40)
@given(rng=rngs, u=st.integers(20, 128), subtracted=st.booleans(), pad=st.booleans())
def test_sums_against_the_real_ones(rng: np.random.Generator, u: int, subtracted: bool, pad: bool) -> None:
    """Without means and padding the same to float32's rounding of the quotient.

    The rounded difference of the means moves each pair by at most 1/2, a rounded padding pixel by another 1/2 (at
    most |mu| of the pairs): mean over the pairs at most 1/2 + |mu|/(2 u).
    """
    row1, row2 = (rng.integers(0, 256, n).astype(np.uint8) for n in (u + 14, u))
    real1, real2 = row1.astype(np.float32), row2.astype(np.float32)
    whole = fp.mad_sums(fp.padded_bytes(row1, 7) if pad else row1, row2, subtracted) / u
    real = mad(
        prepared(padded(real1, 7) if pad else real1, 7, centre=subtracted), prepared(real2, 0, centre=subtracted)
    )
    mu = np.abs(np.arange(-7, 8))
    bound = 0.5 * subtracted + mu / (2.0 * u) * pad
    assert (np.abs(whole - real) <= bound + 2e-4).all()


@settings(deadline=None, max_examples=40)
@given(rng=rngs, j=st.integers(1, 9), u=st.integers(24, 128), dark=st.integers(-60, 60), data=st.data())
def test_shifts_are_found_and_dark_levels_fall_out(
    rng: np.random.Generator, j: int, u: int, dark: int, data: st.DataObject
) -> None:
    mu = data.draw(st.integers(-j, j))
    row1 = rng.integers(60, 196, u + 2 * j).astype(np.uint8)
    row2 = row1[j + mu : j + mu + u]  # index in row I = index in row II + mu
    sums = fp.mad_sums(row1, row2, False)
    assert sums[j + mu] == 0
    assert (np.delete(sums, j + mu) > 0).all()
    # a dark level moves the mean by a whole number: to the last bit nothing is left of it
    darker = (row2.astype(int) + dark).astype(np.uint8)
    assert (fp.mad_sums(row1, darker, True) == fp.mad_sums(row1, row2, True)).all()


def test_padding_is_the_rounded_mean() -> None:
    row = np.array([9, 9, 1, 2, 2, 1, 200, 200], np.uint8)
    assert fp.padded_bytes(row, 2).tolist() == [2, 2, 1, 2, 2, 1, 2, 2]  # 1.5 goes up
    assert (fp.padded_bytes(row, 0) == row).all()
    assert row[0] == 9


def test_mean_difference_rounds_halves_upwards() -> None:
    ends = np.zeros(2, np.uint8)
    for a, b, wanted in [([1, 0], [0, 0], 1), ([0, 0], [1, 0], 0), ([3, 0], [0, 0], 2), ([0, 0], [3, 0], -1)]:
        assert fp.mean_difference(np.array(a, np.uint8), np.array(b, np.uint8), 0) == wanted
        assert fp.mean_difference(
            np.concatenate([ends, np.array(a, np.uint8), ends]), np.array(b, np.uint8), 2
        ) == (wanted)


# --- the minimum ---


@settings(deadline=None, max_examples=40)
@given(rng=rngs, steps=st.integers(1, 40), top=st.integers(1, 60))
def test_the_first_of_equal_sums_counts(rng: np.random.Generator, steps: int, top: int) -> None:
    surface = rng.integers(0, top + 1, (steps, 15)).astype(np.uint16)
    assert fp.least(surface) == model_least(surface.tolist())


@settings(deadline=None, max_examples=60)
@given(rng=rngs, steps=st.integers(3, 60), spread=st.integers(1, 4000), complete=st.booleans())
def test_the_same_verdict_as_in_real_numbers(
    rng: np.random.Generator, steps: int, spread: int, complete: bool
) -> None:
    """Sums up to 2^24 are exact in float32 and u falls out, so place and reason are equal, ties included."""
    surface = (rng.integers(0, spread + 1, (steps, 15)) + rng.integers(1, 3000)).astype(np.uint16)
    at = rng.integers(0, steps), rng.integers(0, 15)
    surface[at] = surface[at] // rng.integers(1, 5)
    whole = judge_sums(surface, 13, complete)
    real = judge(surface.astype(np.float32), 6.5, complete)
    assert whole[:2] == real[:2]
    mean, value = surface.mean(), float(surface[int(whole.step), int(whole.mu) + 7])
    rivals = [1.8, 2.5] if value == 0 else [abs(mean / value - b) for b in (1.8, 2.5)]
    if min(rivals) > 1e-5:  # the real one sums in floating point: not judged on its last bits
        assert whole.reason == real.reason


# --- (15), (17) ---

gammas = st.integers(0, fp.GAMMA_MAX)


@settings(max_examples=100)
@given(q=st.integers(0, 32768), gamma=gammas)
def test_gain_15_is_rounded_once(q: int, gamma: int) -> None:
    found = fp.next_gain_riccati(q, gamma)
    assert found == model_riccati(q, gamma)
    exact = next_gain_riccati(q / 32768, gamma / 32768) * 32768
    assert abs(found - exact) <= 0.5 + 1e-9
    # the division of the time: 32 bits over 17
    assert ((q + gamma) << 15) + (q + gamma + 32768) // 2 < 2**32


@given(gamma=gammas)
def test_limit_by_the_whole_root(gamma: int) -> None:
    """isqrt cuts off up to 1, halved and rounded: at most one unit off, and never above 1."""
    found = fp.stationary_gain(gamma)
    assert abs(found - stationary_gain(gamma / 32768) * 32768) <= 1.0
    assert found <= 32768


def test_series_of_the_paper(vectors: dict[str, Any]) -> None:
    """gamma 0.01 is 328/32768 = 0.010010; the gains stay within the bound of the docstring of the real ones."""
    gain = vectors["gain"]
    gamma = fp.to_gain(gain["gamma"])
    assert gamma == 328
    whole, bound = fp.ONE, 0.0
    for q, following in zip(gain["series_15"], gain["series_15"][1:], strict=False):
        slope = 1.0 / (1.0 + min(q, whole / fp.ONE) + gain["gamma"]) ** 2
        # gamma itself is rounded: df/dgamma = df/dq
        bound = slope * (bound + 0.5) + 0.5
        whole = fp.next_gain_riccati(whole, gamma)
        assert abs(whole - following * fp.ONE) <= bound
    whole = fp.ONE
    limit = fp.stationary_gain(gamma)
    assert round(limit / fp.ONE, 4) == 0.0952  # of 0.010010; the paper's 0.01 gives 0.0951
    for following in gain["series_17"][1:]:
        whole = fp.next_gain_halving(whole, limit)
        # the limit: 1 unit, and rounding of gamma (0.32 units) x d q_inf/d gamma (4.52); the shift: 1/2 + 1/4 …
        assert abs(whole - following * fp.ONE) <= 1.0 + 0.32 * 4.52 + 1.0
    assert whole == limit


@given(gamma=gammas, start=st.integers(0, 32768))
def test_halving_ends_at_its_limit_or_one_unit_short(gamma: int, start: int) -> None:
    limit = fp.stationary_gain(gamma)
    q = start
    for _ in range(20):
        q = fp.next_gain_halving(q, limit)
    assert q == limit if start >= limit else q in {limit, limit - 1}


# --- (16) ---


@settings(deadline=None, max_examples=60)
@given(
    gamma=st.floats(0.0, 1.9),
    seen=st.lists(st.floats(-12.0, 12.0), min_size=2, max_size=60),
    series=st.sampled_from(["riccati", "halving"]),
)
def test_drift_filter_is_the_model_and_near_the_real_one(gamma: float, seen: list[float], series: Series) -> None:
    """To the bit as plain whole numbers have it; within the bound derived in FixedFilter of the real filter."""
    observed = [y * DEG for y in seen]
    whole = fp.drift_filter(25.0 * DEG**2, series)
    stepped = fp.to_gain(gamma)
    real = ScalarFilter(stepped / fp.ONE, 25.0 * DEG**2, series)
    units = [math.floor(y / fp.DRIFT_UNIT + 0.5) for y in observed]
    gains, states = model_filter(units, stepped, series, -(2**15), 2**15 - 1)
    error_q = error_x = 0.0
    for k, y in enumerate(observed):
        before, innovation = real.gain, abs(y - real.estimate) / fp.DRIFT_UNIT
        was = whole.gain
        whole.gamma = gamma
        whole.update(y)
        real.update(y)
        assert (round(whole.gain * fp.ONE), round(whole.estimate / fp.DRIFT_UNIT)) == (gains[k], states[k])
        if k == 0:
            error_x = 0.5
        else:
            slope = 1.0 / (1.0 + min(before, was) + stepped / fp.ONE) ** 2
            error_q = error_q * slope + 0.5 if series == "riccati" else error_q / 2.0 + 1.0
            error_x = (1 - whole.gain) * error_x + whole.gain / 2 + error_q / fp.ONE * innovation + 0.5
        assert abs(whole.gain - real.gain) * fp.ONE <= error_q + 1e-6
        assert abs(whole.estimate - real.estimate) / fp.DRIFT_UNIT <= error_x + 1e-6
        assert whole.variance == pytest.approx(whole.gain * 25.0 * DEG**2)


@settings(deadline=None, max_examples=60)
@given(gamma=st.floats(0.0, 1.9), seen=st.lists(st.integers(1, 1100), min_size=2, max_size=40))
def test_n_filter_is_the_model_and_saturates(gamma: float, seen: list[int]) -> None:
    whole = fp.n_filter("riccati")
    whole.gamma = gamma
    gains, states = model_filter([64 * n for n in seen], fp.to_gain(gamma), "riccati", 0, 2**16 - 1)
    for k, n in enumerate(seen):
        whole.update(float(n))
        assert (round(whole.gain * fp.ONE), round(whole.estimate * 64)) == (gains[k], states[k])
        assert whole.estimate <= fp.N_MAX + 63 / 64
    # the product of the time: signed 32 bits
    assert fp.ONE * (2**16 - 1) + (fp.ONE >> 1) < 2**31


def test_filter_16_of_the_study(vectors: dict[str, Any]) -> None:
    """The ten observations as degrees: within 3 units of 1/256 deg of the study's estimates.

    error_q is below 2.1 units of Q15 (5.5 at the limit), times at most 3 deg of innovation 768 units: 0.05; gamma
    off by 1e-5 moves q by 5e-5 at most: 0.04 units a step; rounding 1/2 a step, summed with (1 - q): below 2.5.
    """
    given_ = vectors["filter_16"]
    whole = fp.drift_filter(25.0 * DEG**2, "riccati")
    whole.gamma = given_["gamma"]
    for y, estimate in zip(given_["y"], given_["estimate"], strict=True):
        whole.update(y * DEG)
        assert abs(whole.estimate / DEG - estimate) < 3.0 / 256.0


def test_a_drift_beyond_its_word_stays_at_its_end() -> None:
    whole = fp.drift_filter(1.0, "riccati")
    whole.update(200.0 * DEG)
    assert whole.estimate / DEG == pytest.approx(127.99609375)
    whole.restart()
    assert math.isnan(whole.estimate)
    assert whole.gain == 1.0
    whole.update(-200.0 * DEG)
    assert whole.estimate / DEG == pytest.approx(-128.0)


def test_small_innovations_stall() -> None:
    """What fixed point costs: below half a unit a step is lost.  q 0.0952: 5 units, 0.02 deg, move nothing."""
    whole = fp.drift_filter(1.0, "riccati")
    whole.gamma = 0.01
    for _ in range(200):
        whole.update(0.0)
    whole.update(5 * fp.DRIFT_UNIT)
    assert whole.estimate == 0.0
    whole.update(6 * fp.DRIFT_UNIT)
    assert whole.estimate == pytest.approx(fp.DRIFT_UNIT)


# --- whole strips ---

PAR = StripParameters(
    pixels=96,
    max_shift=7,
    spacing_px=39.7,
    planned_n=50.0,
    search=(0.6, 1.6),
    period=None,
    mean_subtracted=False,
    subpixel=False,
    padded=False,
)


def exposures(seed: int, n: float, mu: float, count: int) -> list[RowExposure]:
    """Rows of 8 bits with noise over a ground that passes in n exposures, mu px to the right."""
    ground, rng = Ground(seed), np.random.default_rng(seed)

    def read(along: float, across: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        grey = ground.row(along, across) + 1.5 * rng.standard_normal(len(across))
        return np.clip(np.round(grey), 0, 255).astype(np.float32)

    out = []
    for k in range(count):
        ahead, right = k * 39.7 / n, k * mu / n
        row1 = read(ahead + 19.85, right + np.arange(-7.0, 103.0))
        row2 = read(ahead - 19.85, right + np.arange(96.0))
        out.append(RowExposure(k, k * 0.05, row1, row2, 0.01, 0))
    return out


def follow(recogniser: StripRecogniser | IntegerRecogniser, seen: list[RowExposure]) -> list[StripMatch]:
    out = []
    for e in seen:
        out += recogniser.add(e, MountReading(e.t, 0.01 * e.number))
    return [*out, *recogniser.switch(99.0)]


def same(one: StripMatch, other: StripMatch) -> None:
    for name in ("strip", "number1", "t_row1", "t_row2", "t_decided", "n", "mu", "yaw1", "yaw2", "first_n"):
        np.testing.assert_equal(getattr(one, name), getattr(other, name), name)
    assert one.reason is other.reason


@pytest.mark.parametrize(("seed", "n", "mu"), [(1, 50.0, 0.0), (2, 44.4, 3.3), (3, 60.7, -5.1), (4, 95.0, 0.0)])
def test_strips_without_means_are_those_of_the_real_instrument(seed: int, n: float, mu: float) -> None:
    """All is exact then: the same strips, places, reasons and times, also where nothing is found (n = 95)."""
    seen = exposures(seed, n, mu, 190)
    blind = [e._replace(missing=3) if 85 <= e.number < 100 else e for e in seen]
    for rows in (seen, blind):
        whole, real = (follow(kind(PAR), rows) for kind in (IntegerRecogniser, StripRecogniser))
        assert len(whole) == len(real) > 2
        for one, other in zip(whole, real, strict=True):
            same(one, other)
            assert one.mad_min == pytest.approx(other.mad_min, rel=1e-6, nan_ok=True)
            np.testing.assert_allclose(one.surface, other.surface, rtol=1e-6)
        reasons = [m.reason for m in whole]
        assert (Reason.ACCEPTED in reasons) == (n < 90.0)
        assert reasons[-1] is Reason.TIMEOUT
        assert (Reason.OUTSIDE_TERRAIN in reasons) == (rows is blind and n < 90.0)


@pytest.mark.parametrize("pad", [False, True])
def test_strips_with_means_differ_by_the_rounding_only(pad: bool) -> None:
    """The whole surface within 1/2 + |mu|/(2 u) grey levels; so the place differs only where two are that near."""
    par = PAR._replace(mean_subtracted=True, padded=pad)
    seen = exposures(5, 52.3, 2.4, 130)
    whole, real = (follow(kind(par), seen)[:-1] for kind in (IntegerRecogniser, StripRecogniser))
    bound = 0.5 + pad * np.abs(np.arange(-7, 8)) / 192.0 + 2e-4
    assert [m.number1 for m in whole][:1] == [m.number1 for m in real][:1]
    one, other = whole[0], real[0]
    steps = min(len(one.surface), len(other.surface))
    assert (np.abs(one.surface[:steps] - other.surface[:steps]) <= bound).all()
    assert {m.reason for m in whole} == {Reason.ACCEPTED}
    assert max(abs(m.n - 52.3) for m in whole) <= 1.3
    assert {m.mu for m in whole} <= {2.0, 3.0}


def test_one_strip_at_a_time_and_the_same_again() -> None:
    seen = exposures(6, 50.0, 1.0, 130)
    first, second = IntegerRecogniser(PAR), IntegerRecogniser(PAR)
    assert first.opens()
    first.add(seen[0], MountReading(0.0, 0.0))
    assert not first.opens()
    rest = [m for e in seen[1:] for m in first.add(e, MountReading(e.t, 0.01 * e.number))]
    for one, other in zip(rest, follow(second, seen), strict=False):
        same(one, other)
        assert (one.surface == other.surface).all()
        assert one.yaw2 == pytest.approx(0.01 * (one.number1 + one.n))
