"""The verdict."""

from __future__ import annotations

from math import inf, nan

import pytest

from aerosim.metrics.expect import check_expect
from aerosim.scenario.expect import Limit

SUMMARY = {
    "crab": {"residual_rms_deg": 2.0, "settle_s": None, "strips": 3},
    "notes": {"crab.settle_s": "never settled"},
}


@pytest.mark.parametrize(
    ("limit", "line"),
    [
        (Limit(max=2.0), ""),
        (Limit(min=2.0), ""),
        (Limit(min=1, max=3), ""),
        (Limit(max=1.99), "crab.residual_rms_deg is 2, above max 1.99"),
        (Limit(min=2.01), "crab.residual_rms_deg is 2, below min 2.01"),
    ],
)
def test_limits_are_inclusive(limit: Limit, line: str) -> None:
    assert check_expect(SUMMARY, {"crab.residual_rms_deg": limit}) == ([line] if line else [])


def test_what_was_not_measured_is_not_met() -> None:
    lines = check_expect(SUMMARY, {"crab.settle_s": Limit(max=1e9), "vh.error_rms_pct": Limit(min=-1e9)})
    assert lines == ["crab.settle_s was not measured: never settled", "vh.error_rms_pct was not measured"]


@pytest.mark.parametrize("value", [nan, "2.0", True, [2.0], {}])
def test_what_is_no_number_is_not_met(value: object) -> None:
    assert check_expect({"crab": {"strips": value}}, {"crab.strips": Limit(min=-1e300, max=1e300)})


def test_infinity_is_outside_every_finite_limit() -> None:
    assert check_expect({"crab": {"strips": inf}}, {"crab.strips": Limit(max=1e300)})
