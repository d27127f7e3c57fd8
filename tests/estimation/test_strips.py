"""Recognition of strips on a ground that moves by a known n and mu."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
import pytest
from numpy.typing import NDArray

from aerosim.estimation.mad import judge, refine
from aerosim.estimation.strips import StripParameters, StripRecogniser
from aerosim.signals import MountReading, Reason, RowExposure, StripMatch

from .texture import Ground

U, J, SPACING, PERIOD = 96, 7, 39.7, 0.05
N, MU = 97.4, 2.3
PLANNED = 100.0  # 2.5 exposures a pixel; the window of n is 60 to 160
FIRST, LAST = 60, 160
SETTLE = 6  # two pixels of ground motion, in exposures


def parameters(**change: object) -> StripParameters:
    par = StripParameters(
        pixels=U,
        max_shift=J,
        spacing_px=SPACING,
        planned_n=PLANNED,
        search=(0.6, 1.6),
        period=20,
        mean_subtracted=True,
        subpixel=True,
        padded=False,
    )
    return par._replace(**change)  # type: ignore[arg-type]


def flight(n: float, mu: float, count: int, seed: int = 0) -> list[RowExposure]:
    """Exposures of rows d apart over a ground that passes from one to the other in n exposures.

    The camera moves on by d and to the right by mu px in that time: index in row I = index in row II + mu.
    """
    ground = Ground(seed)
    made = []
    for k in range(count):
        ahead, right = k * SPACING / n, k * mu / n
        row1 = ground.row(ahead + SPACING / 2.0, right + np.arange(-J, U + J))
        row2 = ground.row(ahead - SPACING / 2.0, right + np.arange(U))
        made.append(RowExposure(k, k * PERIOD, row1.astype(np.float32), row2.astype(np.float32), 0.01, 0))
    return made


def yaw_at(k: int) -> float:
    return 0.1 * math.sin(0.3 * k)


def follow(recogniser: StripRecogniser, exposures: Iterable[RowExposure]) -> list[StripMatch]:
    found = []
    for exposure in exposures:
        found += recogniser.add(exposure, MountReading(exposure.t, yaw_at(exposure.number)))
    return found


def converted(
    exposures: list[RowExposure], times: Callable[[int], float] = lambda _: 0.01, noise: float = 1.5
) -> list[RowExposure]:
    """As a converter with noise reads them, in whole grey levels, each exposed for its own time (s)."""
    rng = np.random.default_rng(9)

    def read(row: NDArray[np.float32], exposure: float) -> NDArray[np.float32]:
        noisy = row * exposure / 0.01 + noise * rng.standard_normal(len(row))
        return np.clip(np.round(noisy), 0, 255).astype(np.float32)

    return [
        e._replace(
            row1=read(e.row1, times(e.number)), row2=read(e.row2, times(e.number)), exposure=times(e.number)
        )
        for e in exposures
    ]


@pytest.fixture(scope="module")
def flown() -> list[RowExposure]:
    return flight(N, MU, 420)


@pytest.fixture(scope="module")
def matches(flown: list[RowExposure]) -> list[StripMatch]:
    return follow(StripRecogniser(parameters()), flown)


def numbers(found: list[StripMatch]) -> NDArray[np.float64]:
    return np.array([(m.n, m.mu) for m in found])


def test_each_strip_is_found(matches: list[StripMatch]) -> None:
    assert [m.strip for m in matches] == list(range(len(matches)))
    assert [m.number1 for m in matches] == [20 * i for i in range(len(matches))]
    assert len(matches) == 16  # the last kept at 300, met at 397.4, decided before 420
    assert {m.reason for m in matches} == {Reason.ACCEPTED}
    error = numbers(matches) - [N, MU]
    # refine: 0.07 px rms in either; the largest of 16 below 3.5 of them
    assert np.abs(error[:, 1]).max() < 0.25
    assert np.abs(error[:, 0]).max() < 0.25 * PLANNED / SPACING


@pytest.mark.parametrize(("n", "mu"), [(75.0, -4.0), (88.5, 5.6), (110.3, -0.4), (140.0, 1.0)])
def test_other_speeds_and_sides(n: float, mu: float) -> None:
    found = follow(StripRecogniser(parameters()), flight(n, mu, round(n) + 60, seed=3))
    assert {m.reason for m in found} == {Reason.ACCEPTED}
    assert np.mean([m.mu for m in found]) == pytest.approx(mu, abs=0.2)
    assert np.mean([m.n for m in found]) == pytest.approx(n, rel=0.005)


def test_times_are_those_of_the_exposures(matches: list[StripMatch]) -> None:
    for m in matches:
        assert m.t_row1 == pytest.approx(m.number1 * PERIOD)
        assert m.t_row2 == pytest.approx((m.number1 + m.n) * PERIOD)
        assert m.t_decided == pytest.approx((m.number1 + m.first_n + len(m.surface) - 1) * PERIOD)


def test_yaw_at_both_exposures_between_two_by_interpolation(matches: list[StripMatch]) -> None:
    readings = [yaw_at(k) for k in range(420)]
    for m in matches:
        assert m.yaw1 == readings[m.number1]
        assert m.yaw2 == pytest.approx(np.interp(m.number1 + m.n, np.arange(420), readings), abs=1e-12)


def test_decision_waits_until_the_minimum_was_left_behind(matches: list[StripMatch]) -> None:
    for m in matches:
        lowest = int(np.unravel_index(m.surface.argmin(), m.surface.shape)[0])
        assert len(m.surface) - 1 - lowest == SETTLE


def test_surface_is_equation_2(flown: list[RowExposure], matches: list[StripMatch]) -> None:
    m = matches[3]
    row1 = flown[m.number1].row1.astype(float)
    row1 -= row1[J:-J].mean()
    assert m.first_n == FIRST
    for step, row in enumerate(m.surface):
        row2 = flown[m.number1 + FIRST + step].row2.astype(float)
        direct = [np.abs(row1[k : k + U] - (row2 - row2.mean())).mean() for k in range(2 * J + 1)]
        np.testing.assert_allclose(row, direct, atol=2e-4)


def test_early_decision_is_the_late_one(flown: list[RowExposure], matches: list[StripMatch]) -> None:
    """The whole window of each strip, by hand: nothing that comes later is lower."""
    spp = PLANNED / SPACING
    for m in matches[:12]:
        row1 = flown[m.number1].row1
        row1 = row1 - row1[J:-J].mean()
        rows2 = np.array([flown[m.number1 + n].row2 for n in range(FIRST, LAST + 1)])
        rows2 -= rows2.mean(axis=1, keepdims=True)
        whole = np.stack([np.abs(row1[k : k + U] - rows2).mean(axis=1) for k in range(2 * J + 1)], axis=1)
        late = refine(whole, judge(whole, spp), spp)
        assert late.reason is Reason.ACCEPTED
        assert (late.step + FIRST, late.mu) == pytest.approx((m.n, m.mu), abs=1e-3)


def test_one_at_a_time(flown: list[RowExposure]) -> None:
    recogniser = StripRecogniser(parameters(period=None))
    began, found = [], []
    for exposure in flown:
        if recogniser.opens():
            began.append(exposure.number)
        found += follow(recogniser, [exposure])
    assert [m.number1 for m in found] == began[: len(found)]
    assert len(found) == 4
    for m, following in zip(found, began[1:], strict=False):
        assert following == round(m.t_decided / PERIOD) + 1  # the rows are free after the decision
    assert {m.reason for m in found} == {Reason.ACCEPTED}
    assert (np.abs(numbers(found) - [N, MU]).max(axis=0) < [0.63, 0.25]).all()


def test_pipelined_opens_each_period(flown: list[RowExposure]) -> None:
    recogniser = StripRecogniser(parameters(period=7))
    began = []
    for exposure in flown[:100]:
        if recogniser.opens():
            began.append(exposure.number)
        follow(recogniser, [exposure])
    assert began == list(range(0, 100, 7))


@pytest.mark.parametrize("period", [1, 7, 10, 160, 200])
def test_water_fills_all_slots_and_never_counts(period: int) -> None:
    """Nothing is decided early, so every strip stays to the end of its window, and is then refused."""
    rng = np.random.default_rng(6)
    grey = np.round(60.0 + 1.5 * rng.standard_normal((450, 2 * U + 2 * J))).astype(np.float32)
    exposures = [RowExposure(k, k * PERIOD, r[: U + 2 * J], r[U + 2 * J :], 0.01, 0) for k, r in enumerate(grey)]
    found = follow(StripRecogniser(parameters(period=period)), exposures)
    assert [m.number1 for m in found] == list(range(0, 450 - LAST, period))
    for m in found:
        assert m.reason not in {Reason.ACCEPTED, Reason.TIMEOUT}
        assert round(m.t_decided / PERIOD) == m.number1 + LAST
        assert m.surface.shape == (LAST - FIRST + 1, 2 * J + 1)
        assert m.t_row2 == pytest.approx((m.number1 + m.n) * PERIOD)  # also where it lies a whole window back


def test_switching_gives_strips_in_flight_up(flown: list[RowExposure]) -> None:
    recogniser = StripRecogniser(parameters())
    assert recogniser.switch(0.0) == []
    assert follow(recogniser, flown[:90]) == []
    given_up = recogniser.switch(4.5)
    assert [m.strip for m in given_up] == [0, 1, 2, 3, 4]
    for m in given_up:
        assert m.reason is Reason.TIMEOUT
        assert (m.t_row1, m.t_decided) == (pytest.approx(m.number1 * PERIOD), 4.5)
        assert np.isnan([m.n, m.mu, m.mad_min, m.t_row2, m.yaw2]).all()
        assert m.surface.shape == (0, 2 * J + 1)
    assert recogniser.opens()
    # on again later: new strips, nothing left of the old ones
    found = follow(recogniser, flown[205:])
    assert [m.strip for m in found[:3]] == [5, 6, 7]
    assert found[0].number1 == 205
    assert {m.reason for m in found} == {Reason.ACCEPTED}
    assert numbers(found).mean(axis=0) == pytest.approx([N, MU], abs=0.3)


def test_missing_pixels_lose_the_strips_that_look_for_theirs(flown: list[RowExposure]) -> None:
    """Strips kept at 0, 20, … 80; blind from 95 to 101: those of 0, 20 and 40 are in their windows by then."""
    blind = [e._replace(missing=3) if 95 <= e.number <= 101 else e for e in flown]
    recogniser = StripRecogniser(parameters())
    found = follow(recogniser, blind[:102])
    assert [(m.number1, round(m.t_decided / PERIOD)) for m in found] == [(0, 95), (20, 95), (40, 100)]
    assert {m.reason for m in found} == {Reason.OUTSIDE_TERRAIN}
    assert np.isnan([[m.n, m.mu, m.t_row2] for m in found]).all()
    # 100 would have begun a strip: the first sight of ground does
    assert recogniser.opens()
    found = follow(recogniser, blind[102:])
    assert [m.number1 for m in found[:4]] == [60, 80, 102, 122]
    assert {m.reason for m in found} == {Reason.ACCEPTED}


def test_padded_extension_is_not_looked_at(flown: list[RowExposure]) -> None:
    rng = np.random.default_rng(8)

    def other_edges(e: RowExposure) -> RowExposure:
        row1 = e.row1.copy()
        row1[:J], row1[-J:] = rng.uniform(0, 255, J), rng.uniform(0, 255, J)
        return e._replace(row1=row1)

    par = parameters(padded=True)
    found = follow(StripRecogniser(par), flown)
    same = follow(StripRecogniser(par), [other_edges(e) for e in flown])
    assert (numbers(found) == numbers(same)).all()
    assert {m.reason for m in found} == {Reason.ACCEPTED}
    # a shift of 2.3 px leaves 94 of 96 pairs on the ground: the place is right, if a little drawn to zero
    assert np.abs(numbers(found).mean(axis=0) - [N, MU]).max() < 0.5


def test_exposure_times_scale_out(flown: list[RowExposure]) -> None:
    """Rows exposed for 4 to 8 ms, another time each second, quantised: as good as with one time."""
    found = follow(StripRecogniser(parameters()), converted(flown, lambda k: 0.004 + 0.001 * (k // 20 % 5)))
    assert len(found) == 16
    assert {m.reason for m in found} == {Reason.ACCEPTED}
    error = numbers(found) - [N, MU]
    assert np.sqrt((error[:, 1] ** 2).mean()) < 0.15
    assert np.sqrt((error[:, 0] ** 2).mean()) < 0.15 * PLANNED / SPACING
    # without noise, the same to rounding
    scaled = [
        e._replace(row1=e.row1 * t, row2=e.row2 * t, exposure=0.01 * t)
        for e in flown
        for t in [np.float32(0.5 + e.number % 3)]
    ]
    plain = follow(StripRecogniser(parameters()), flown)
    np.testing.assert_allclose(numbers(follow(StripRecogniser(parameters()), scaled)), numbers(plain), atol=2e-3)


def test_noise_and_whole_grey_levels(flown: list[RowExposure]) -> None:
    found = follow(StripRecogniser(parameters()), converted(flown))
    assert {m.reason for m in found} == {Reason.ACCEPTED}
    error = numbers(found) - [N, MU]
    # refine draws 2.3 px by 0.1 to the whole 2; about that it scatters by less than 0.07 px
    assert np.sqrt((error[:, 1] ** 2).mean()) < 0.13
    assert error[:, 1].std() < 0.07
    assert np.sqrt((error[:, 0] ** 2).mean()) < 0.11 * PLANNED / SPACING


def test_dark_level_falls_out_with_the_row_means(flown: list[RowExposure]) -> None:
    darker = [e._replace(row2=e.row2 - 15.0) for e in flown]
    with_means = follow(StripRecogniser(parameters()), darker)
    np.testing.assert_allclose(
        numbers(with_means), numbers(follow(StripRecogniser(parameters()), flown)), atol=2e-3
    )
    without = follow(StripRecogniser(parameters(mean_subtracted=False)), darker)
    assert min(m.mad_min for m in without) > 10.0  # the 15 grey levels stay in every difference
    assert max(m.mad_min for m in with_means) < 10.0


def test_whole_numbers_without_subpixel(flown: list[RowExposure]) -> None:
    found = follow(StripRecogniser(parameters(subpixel=False)), flown)
    assert {m.reason for m in found} == {Reason.ACCEPTED}
    values = numbers(found)
    assert (values == np.round(values)).all()
    assert (values[:, 1] == 2.0).all()
    assert np.abs(values[:, 0] - N).max() < 2.0
