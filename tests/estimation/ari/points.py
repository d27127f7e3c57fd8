"""Processes at which ARI filters are tried: those behind the 1988 paper's tables, and others never tuned on.

The paper prints sigmas and correlations only; the coefficients reproduce its tables 3 to 5 (docs/ari.md).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerosim.estimation.ari import simulate_ari


class Point(NamedTuple):
    """a, d, sigma_n, sigma_e of a process, and the length of its strips."""

    a: tuple[float, ...]
    d: int
    sigma_n: float
    sigma_e: float
    n: int

    @property
    def order(self) -> tuple[int, int]:
        return len(self.a), self.d

    def series(self, seed: int, n: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Truth and observations."""
        rng = np.random.default_rng(seed)
        return simulate_ari(n or self.n, self.a, self.d, self.sigma_n, self.sigma_e, rng=rng)


SHUTTLE_A = (-0.2447621, -0.21425168, 0.53319748, 0.00196017, -0.3804406, 0.39290783)
POINTS = {
    "gps_x": Point((-0.31823754, 0.63867057, -0.57521724, 0.0975253, -0.20966707), 2, 0.018, 0.02416414, 130),
    "gps_y": Point((-1.5371978, 2.28613446, -1.48797759, 0.86498408, -0.10987943), 2, 0.010, 0.00215021, 130),
    "shuttle_120": Point(SHUTTLE_A, 1, 0.006, 0.0019, 120),
    "shuttle_400": Point(SHUTTLE_A, 1, 0.006, 0.0019, 400),
    "falcon_yaw": Point((-0.74145450, 0.38044451), 2, 0.0023, 0.0005, 600),
    "falcon_roll": Point((-1.186, 0.350), 2, 0.0030, 0.00163, 600),
}
# nothing was tuned on these
HELD_OUT = {
    "falcon_pitch": Point((-0.29812376, 0.30906997), 2, 0.0035, 0.0013, 600),
    "shuttle_pitch": Point(
        (-1.34089649, 0.87992294, 0.27689874, -1.19676848, 1.3082085, -0.43646876), 1, 0.0048, 0.0012, 400
    ),
    "made_up": Point((-0.6, 0.1, -0.2), 1, 1.0, 0.6, 300),
}
