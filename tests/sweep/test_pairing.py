"""What common seeds are worth, on flights: two modes in the same gusts."""

from __future__ import annotations

from pathlib import Path

import pytest
from flights import air, scenario

import aerosim
from aerosim.sweep.results import Sweep

MODE = "control.mode"


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    """Twelve seeds of one line, with slow wind and some turbulence; a camera that stays, one that is turned."""
    out: Path = tmp_path_factory.mktemp("paired") / "two modes"
    flight = scenario(14.0, air=air(5.0, 0.0, slow=2.0, turbulence=0.7))
    return aerosim.sweep(flight, {MODE: ["fixed", "pipelined"]}, seeds=12, out=out, workers=0)


@pytest.mark.parametrize("metric", ["vh.error_rms_pct", "vh.strip_error_rms_pct"])
def test_pairing_halves_the_standard_error(swept: Sweep, metric: str) -> None:
    """Both modes' rows see the same ground through the same roll and pitch: most of the scatter is common.

    Paired over unpaired is sqrt(1 - r) for equal variances: at most a half asks for r of at least 0.75.  Metrics
    that the controller itself makes (crab) share little, whatever the seeds: they are not claimed.
    """
    (d,) = swept.paired(metric, MODE, "fixed", "pipelined")
    print(
        f"{metric}: paired {d.standard_error:.4f}, unpaired {d.unpaired_standard_error:.4f}, r {d.correlation:.2f}"
    )
    assert d.seeds == 12
    assert d.standard_error <= 0.5 * d.unpaired_standard_error


def test_the_flight_is_the_same(swept: Sweep) -> None:
    (d,) = swept.paired("flight.roll_rms_deg", MODE, "fixed", "pipelined")
    assert (d.mean, d.standard_error) == (0.0, 0.0)
    assert d.unpaired_standard_error > 0.0
