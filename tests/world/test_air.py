"""The air along the flight: signs of the wind, slow wind, one generator each, blocks without seams."""

import math
from functools import partial

import numpy as np
import pytest

from aerosim.rng import generator
from aerosim.world.air import BLOCK, Air, make_air, wind_n

DT = 1.0 / 120.0


def air(seed=1, *, steady=(0.0, 0.0, 0.0), slow=0.0, gust=0.0, dt=DT, time_constant=120.0):
    return make_air(steady, slow, time_constant, gust, 533.4, 69.44, 19.81, dt, partial(generator, seed))


def table(made, steps):
    return np.array([made.at(step) for step in range(steps)])


class Counter:
    """A source whose columns are the step, times one factor each."""

    def __init__(self, *factors):
        self.factors, self.step = np.array(factors), 0

    def draw(self, steps):
        out = np.arange(self.step, self.step + steps)[:, None] * self.factors
        self.step += steps
        return out


@pytest.mark.parametrize(
    ("from_deg", "goes_to"), [(0, (-10, 0, 0)), (90, (0, -10, 0)), (180, (10, 0, 0)), (270, (0, 10, 0))]
)
def test_wind_is_named_by_where_it_comes_from(from_deg, goes_to):
    # A north wind blows to the south, a west wind to the east.
    assert wind_n(10.0, math.radians(from_deg)) == pytest.approx(goes_to, abs=1e-12)


def test_steady_wind_alone_is_constant():
    made = air(steady=(3.0, -4.0, 0.0))
    for step in (0, 1, BLOCK - 1, BLOCK, 3 * BLOCK + 17, 20_000):
        assert made.at(step) == (3.0, -4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def test_slow_wind_has_its_sigma_and_time_constant():
    # D/T = 4000: sd of a variance sqrt(2 T/D) = 2.2 %, of the correlation at T at most sqrt(T/D) = 1.6 %, of a
    # correlation of two independent ones sqrt(T/D); 4.5 of them.
    time_constant, steps = 10.0, 40_000
    made = table(air(7, steady=(5.0, -2.0, 0.0), slow=1.5, dt=1.0, time_constant=time_constant), steps)
    slow = made[:, :2] - (5.0, -2.0)
    assert not made[:, 2:].any()
    lag = round(time_constant)
    for component in slow.T:
        variance = float(np.mean(component**2))
        assert variance == pytest.approx(1.5**2, rel=0.10)
        assert np.mean(component[lag:] * component[:-lag]) / variance == pytest.approx(math.exp(-1.0), abs=0.07)
    assert abs(np.mean(slow[:, 0] * slow[:, 1])) / 1.5**2 < 0.07


def test_one_component_does_not_move_another():
    both, slow, gusts = (table(air(3, slow=s, gust=g), 1500) for s, g in ((1.0, 0.7), (1.0, 0.0), (0.0, 0.7)))
    assert np.array_equal(both[:, :3], slow[:, :3])
    assert np.array_equal(both[:, 3:], gusts[:, 3:])
    assert np.abs(slow[:, :2]).min() > 0.0
    assert not slow[:, 3:].any()
    assert not gusts[:, :3].any()


def test_same_seed_same_air_other_seed_other_air():
    first, again, other = (table(air(seed, slow=1.0, gust=1.0), 1500) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    changes = np.delete(first != other, 2, axis=1)
    assert changes.all()


def test_gusts_scale_with_sigma_and_keep_their_shape():
    small, large = (table(air(5, gust=sigma), 600)[:, 3:] for sigma in (0.5, 2.0))
    assert large == pytest.approx(4.0 * small, rel=1e-9)


def test_columns_go_to_their_names():
    made = Air(
        (0.0, 0.0, -1.0), [Counter(10), Counter(20)], [Counter(1), Counter(2, 3), Counter(4, 5), Counter(6)]
    )
    # sources give u; v, r; w, q; p
    state = made.at(2)
    assert (state.u, state.v, state.w) == (2, 4, 8)
    assert (state.p, state.q, state.r) == (12, 10, 6)
    assert (state.wind_north, state.wind_east, state.wind_down) == (20, 40, -1)


def test_no_step_is_lost_or_doubled_at_the_border_of_a_block():
    made = Air((0.0, 0.0, 0.0), [], [Counter(1), Counter(1, 1), Counter(1, 1), Counter(1)])
    steps = [0, 0, BLOCK - 1, BLOCK - 1, BLOCK, BLOCK, BLOCK + 1, 2 * BLOCK - 1, 2 * BLOCK, 7 * BLOCK + 3]
    assert [made.at(step).u for step in steps] == steps


def test_a_span_is_the_states_one_by_one():
    single, spans = air(4, slow=1.0, gust=0.5), air(4, slow=1.0, gust=0.5)
    step = 0
    for count in (1, 6, BLOCK - 9, 6, 1, 2 * BLOCK + 5, 6):
        found = spans.span(step, count)
        assert found == [single.at(k) for k in range(step, step + count)]
        step += count


def test_a_span_may_skip_ahead_but_no_step_comes_back():
    made = Air((0.0, 0.0, 0.0), [], [Counter(1), Counter(1, 1), Counter(1, 1), Counter(1)])
    assert [state.u for state in made.span(3 * BLOCK - 2, 4)] == [3 * BLOCK + k for k in (-2, -1, 0, 1)]
    for past in (made.at, lambda step: made.span(step, 1)):
        with pytest.raises(IndexError, match="step 5 is gone"):
            past(5)


def test_rate_gusts_have_the_sign_of_a_turning_air():
    # Where w grows along the path the air turns nose down (q < 0), where v grows it turns right (r > 0); a step is
    # far shorter than the span filter, so compare after 0.5 s means.
    made = table(air(9, gust=1.0), 120 * 240).reshape(-1, 60, 9).mean(axis=1)
    v, w, q, r = made[:, 4], made[:, 5], made[:, 7], made[:, 8]
    assert np.corrcoef(np.gradient(w), q)[0, 1] < -0.8
    assert np.corrcoef(np.gradient(v), r)[0, 1] > 0.8
