"""The air along the flight: columns, blocks without seams, places asked for only when needed."""

import numpy as np
import pytest

from aerosim.world.air import BLOCK, Air
from aerosim.world.gusts import CosineGust

DT = 1.0 / 40.0


def nowhere():
    raise AssertionError("the place was asked for")


class Counter:
    """A source whose columns are the step, times one factor each."""

    def __init__(self, *factors):
        self.factors, self.step = np.array(factors), 0

    def draw(self, steps):
        out = np.arange(self.step, self.step + steps)[:, None] * self.factors
        self.step += steps
        return out


class Tilted:
    """A wind that is the place."""

    def __init__(self):
        self.asked = []

    def at(self, t, lat, lon, height):
        self.asked.append(t)
        return lat, lon, height


def test_columns_go_to_their_names():
    made = Air(
        DT,
        (0.0, 0.0, -1.0),
        slow=[Counter(10), Counter(20)],
        turbulence=[Counter(1), Counter(2, 3), Counter(4, 5), Counter(6)],
    )
    # sources give u; v, r; w, q; p
    state = made.at(2, nowhere)
    assert (state.u, state.v, state.w) == (2, 4, 8)
    assert (state.p, state.q, state.r) == (12, 10, 6)
    assert (state.wind_north, state.wind_east, state.wind_down) == (20, 40, -1)


def counting():
    return Air(DT, turbulence=[Counter(1), Counter(1, 1), Counter(1, 1), Counter(1)])


def test_no_step_is_lost_or_doubled_at_the_border_of_a_block():
    made = counting()
    steps = [0, 0, BLOCK - 1, BLOCK - 1, BLOCK, BLOCK, BLOCK + 1, 2 * BLOCK - 1, 2 * BLOCK, 7 * BLOCK + 3]
    assert [made.at(step, nowhere).u for step in steps] == steps


def test_a_step_of_the_block_may_be_asked_again_but_none_before_it():
    made = counting()
    assert made.at(3 * BLOCK + 5, nowhere).u == 3 * BLOCK + 5
    assert made.at(3 * BLOCK, nowhere).u == 3 * BLOCK
    with pytest.raises(IndexError, match=f"step {3 * BLOCK - 1} is gone"):
        made.at(3 * BLOCK - 1, nowhere)
    with pytest.raises(IndexError, match="step 5 is gone"):
        made.at(5, nowhere)


def test_single_gusts_come_at_their_time():
    made = Air(DT, (1.0, 2.0, 0.0), times=[CosineGust(10.0, 4.0, 3.0, 0.0, -1.0)])
    # steps of 25 ms: the peak at 12 s is step 480
    assert made.at(400, nowhere)[:3] == (1.0, 2.0, 0.0)
    assert made.at(480, nowhere)[:3] == pytest.approx((4.0, 2.0, -1.0))
    assert made.at(440, nowhere)[:3] == pytest.approx((2.5, 2.0, -0.5))


def test_wind_by_place_is_added_once_a_step_at_its_time():
    tilted, asked = Tilted(), []

    def where():
        asked.append(1)
        return 0.5, -0.25, 1000.0 + len(asked)

    made = Air(
        DT, (1.0, 2.0, 3.0), places=[tilted], turbulence=[Counter(1), Counter(1, 1), Counter(1, 1), Counter(1)]
    )
    first = made.at(4, where)
    assert first[:4] == (1.5, 1.75, 1004.0, 4.0)
    assert made.at(4, where) == first
    assert made.at(BLOCK + 3, where)[:4] == (1.5, 1.75, 1005.0, BLOCK + 3)
    assert made.at(4 + BLOCK, where).wind_down == 1006.0
    assert made.at(BLOCK + 3, where).wind_down == 1005.0
    assert tilted.asked == pytest.approx([0.1, (BLOCK + 3) * DT, (BLOCK + 4) * DT])
