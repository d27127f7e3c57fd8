"""When strips are believed: at the start, against a belief, long after one."""

from __future__ import annotations

import math

from aerosim.estimation.tracking.supervisor import AGREE_ANEW, BOUNDS_S, SILENT_S, State, Supervisor

WITHIN = (math.radians(2.0), 0.04)
DEG = math.radians(1.0)


def locked(t: float = 0.0) -> Supervisor:
    guard = Supervisor()
    for k in range(3):
        guard.found(t - 2.0 + k, 0.0, 0.0, WITHIN)
    assert guard.state is State.LOCKED
    return guard


def offered(
    guard: Supervisor, t: float, tracks_deg: list[float], log_vh: float = 0.0
) -> list[tuple[float, float] | None]:
    """Strips a quarter of a second apart from t on, against the belief of 0."""
    return [guard.found(t + 0.25 * k, a * DEG, log_vh, WITHIN, (0.0, 0.0)) for k, a in enumerate(tracks_deg)]


def test_three_that_agree_over_a_while_begin() -> None:
    guard = Supervisor()
    assert guard.found(0.0, 3 * DEG, 0.1, WITHIN) is None
    assert guard.found(1.0, 3.5 * DEG, 0.1, WITHIN) is None
    assert guard.state is State.SEEKING
    assert guard.found(2.0, 2.5 * DEG, 0.1, WITHIN) == (3 * DEG, 0.1)
    assert guard.state is State.LOCKED


def test_neighbours_that_see_the_same_ground_are_no_witnesses() -> None:
    guard = Supervisor()
    assert not any(guard.found(0.1 * k, 0.0, 0.0, WITHIN) for k in range(8))
    assert guard.found(0.8, 0.0, 0.0, WITHIN) is not None


def test_against_a_belief_more_must_agree() -> None:
    found = offered(locked(), 10.0, [5.0] * AGREE_ANEW)
    assert found[:-1] == [None] * (AGREE_ANEW - 1)
    assert found[-1] == (5 * DEG, 0.0)


def test_a_minority_is_not_believed() -> None:
    """Stripes read all over the place: five of twelve agree by chance."""
    scattered = [-12.0, 5.0, 9.0, 5.0, -6.0, 5.0, 13.0, -9.0, 5.0, -14.0, 0.0, 5.0]
    assert not any(offered(locked(), 10.0, scattered))


def test_what_no_camera_can_have_done_is_not_believed_until_all_is_long_ago() -> None:
    guard = locked()
    assert not any(offered(guard, 10.0, [20.0] * 20))
    assert not any(offered(guard, 20.0, [5.0] * 20, log_vh=math.log(1.3)))
    assert any(offered(guard, BOUNDS_S + 1.0, [20.0] * 20))  # never lost for good


def test_held_without_an_accepted_strip_and_back_with_one() -> None:
    guard = locked()
    guard.watch(SILENT_S - 0.1)
    assert guard.state is State.LOCKED
    guard.watch(SILENT_S + 0.1)
    assert guard.state is State.HELD
    guard.strip(SILENT_S + 1.0, False)
    assert guard.state is State.HELD
    guard.strip(SILENT_S + 2.0, True)
    assert guard.state is State.LOCKED
