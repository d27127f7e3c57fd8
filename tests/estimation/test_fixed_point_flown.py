"""The instrument of 1988 flown in whole and in real numbers over the same ground."""

from __future__ import annotations

import numpy as np
import pytest
from flights import air, on_line, rms, scenario

from aerosim.errors import InputError
from aerosim.record import Record
from aerosim.scenario.build import build
from aerosim.simulate import simulate

WIND = air(8.0, 0.0, slow=0.5, turbulence=0.35)


def flown(arithmetic: str, km: float = 9.0, **estimation: object) -> Record:
    """Rows on the airframe: what they see does not depend on the estimate, so both see the same."""
    return simulate(
        scenario(
            km,
            air=WIND,
            flight={"run_in_s": 60},
            control={"mode": "schmelovsky_1988"},
            ccd_rows={"extension": "imaged" if estimation else "padded"},
            estimation={"arithmetic": arithmetic, **estimation},
        )
    )


def test_the_same_strips_and_an_estimate_within_the_rounding() -> None:
    """Without row means all sums are exact: the same strips, to the last one.

    The estimates then differ by the filters alone.  The bound derived in FixedFilter, held at its limit q 0.095:
    a step adds q/2 + 1/2 = 0.55 units and e_q |y - x| = 5.5/32768 x 2560 (10 deg) = 0.43, divided by q: 10.3 units
    of 1/256 deg = 0.040 deg; gamma, 328 for 327.68 units, adds e_q of 0.32 x 4.5 units: 0.1/q, 0.005 deg.
    """
    whole, real = (flown(kind, mean_subtracted=False) for kind in ("integer", "real"))
    assert len(whole.matches["n"]) > 8
    assert whole.matches["accepted"].sum() > 5
    for name in ("t_row1_s", "n", "mu_px", "reason"):
        np.testing.assert_array_equal(whole.matches[name], real.matches[name])
    drift = [on_line(each, "drift_est_deg") for each in (whole, real)]
    assert 0.0 < np.nanmax(np.abs(drift[0] - drift[1])) < 0.045
    vh = [on_line(each, "vh_est_per_s") for each in (whole, real)]
    # n: 0.55/q + e_q x 100 exposures x 64/q = 17 units of 1/64, of some 220 exposures
    assert np.nanmax(np.abs(vh[0] / vh[1] - 1.0)) < 17.0 / 64.0 / 200.0


@pytest.mark.slow
def test_whole_numbers_cost_nothing_that_counts() -> None:
    """As the paper has it, with row means and padding: strips may differ where two places are nearly equal."""
    whole, real = flown("integer"), flown("real")
    crab = [rms(on_line(each, "crab_true_deg", after=20.0)) for each in (whole, real)]
    # one strip that is a pixel off (1.44 deg) moves the estimate by q = 0.1 to 0.2 of it
    assert crab[0] == pytest.approx(crab[1], abs=0.3)
    assert whole.summary["crab"]["accepted_pct"] == pytest.approx(real.summary["crab"]["accepted_pct"], abs=15.0)
    again = flown("integer")
    assert again.summary["telemetry_sha256"] == whole.summary["telemetry_sha256"]


def test_more_exposures_than_its_word_holds() -> None:
    """n 259 at 50 ms; at 10 ms 1295, searched up to 2072."""
    wanted = scenario(
        9.0,
        control={"mode": "schmelovsky_1988"},
        estimation={"arithmetic": "integer"},
        ccd_rows={"period_s": 1 / 120},
    )
    with pytest.raises(
        InputError, match=r"arithmetic: integer counts exposures in 16 bits, up to 1023, and 2\d\d\d"
    ):
        build(wanted)
