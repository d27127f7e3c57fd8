from __future__ import annotations

import math

import numpy as np
import pytest

from aerosim.flight.aircraft import Aircraft
from aerosim.flight.modes import linearise, modes

AIRSPEED = 69.4

# Eigenvalues of the full nonlinear equations on the same coefficients, solved outside this project's code, at
# 3000 m, density 0.9091 kg/m3, 69.4 m/s, constant power.  The wrong sign of Ixz gives a dutch roll of 2.02 / 0.26,
# the phugoid of constant thrust has a damping of 0.070.
EXPECTED = {
    "short_period": 3.27,
    "short_period_damping": 0.641,
    "phugoid": 0.163,
    "phugoid_damping": 0.116,
    "dutch_roll": 2.00,
    "dutch_roll_damping": 0.244,
    "roll_s": 0.178,
    "spiral_s": 60.6,
}


@pytest.fixture
def jacobian(twin: Aircraft) -> np.ndarray:
    trim = twin.start(math.radians(51.0), 0.2, 3000.0, 1.0, AIRSPEED)
    return linearise(twin, trim, AIRSPEED)


def test_modes_are_those_of_the_coefficients(jacobian: np.ndarray) -> None:
    found = modes(jacobian)._asdict()
    assert found == pytest.approx(EXPECTED, rel=0.01)


def test_modes_of_the_whole_matrix_agree_with_the_two_sides(jacobian: np.ndarray) -> None:
    # The sides are coupled only through the bank against the Earth's rotation, 0.05 deg.
    found = modes(jacobian)
    whole = np.abs(np.linalg.eigvals(jacobian))
    for value in (found.short_period, found.phugoid, found.dutch_roll, 1.0 / found.roll_s, 1.0 / found.spiral_s):
        assert np.abs(whole - value).min() < 0.02 * value


def test_yawing_moment_rolls_the_way_of_the_product_of_inertia(jacobian: np.ndarray) -> None:
    # Etkin's equations with the integral of x z, written out for a yaw rate alone: L = Clr, N = Cnr.
    ixx, izz, ixz = 16039.3, 35807.4, 1102.8
    rolling, yawing = 0.06, -0.18
    expected = (izz * rolling + ixz * yawing) / (ixx * yawing + ixz * rolling)
    assert jacobian[3, 5] / jacobian[5, 5] == pytest.approx(expected, rel=0.01)


def test_level_one_of_mil_f_8785c(jacobian: np.ndarray) -> None:
    # Class II, category B, level 1, as heli-air.net quotes tables 10.1 to 10.3.
    found = modes(jacobian)
    assert found.roll_s <= 1.4
    assert found.dutch_roll_damping >= 0.08
    assert found.dutch_roll * found.dutch_roll_damping >= 0.15
    assert found.dutch_roll >= 0.4
    assert found.spiral_s > 0.0


def test_linearising_wants_still_air(twin: Aircraft) -> None:
    trim = twin.start(0.9, 0.2, 3000.0, 1.0, AIRSPEED, (3.0, 0.0, 0.0))
    with pytest.raises(ValueError, match="still air"):
        linearise(twin, trim, AIRSPEED)
