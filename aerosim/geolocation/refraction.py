"""Refraction: US Standard Atmosphere 1976, n - 1 proportional to density, layers along the ellipsoid.

The path is integrated through the layers from the tangent at the camera (`ray.bend`).  Uncorrected it displaces a
target by 25 m at 74 deg off-nadir from 12 km above ground of 3 km.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.geolocation.compiled import entry
from aerosim.geolocation.ray import NODES, TABLE_LOW, TABLE_STEP, bend, dropped, start

# n - 1 of visible light at sea level.
SEA_LEVEL = 277e-6
TABLE_HIGH = 80_000.0
# US Standard Atmosphere 1976, table 4: geopotential height of each layer's foot (m), its temperature (K) and lapse
# rate (K/m); gravity over the gas constant of air, K/m; radius that makes geometric height geopotential, m.
LAYERS = (
    (0.0, 288.15, -0.0065),
    (11_000.0, 216.65, 0.0),
    (20_000.0, 216.65, 0.001),
    (32_000.0, 228.65, 0.0028),
    (47_000.0, 270.65, 0.0),
    (51_000.0, 270.65, -0.0028),
    (71_000.0, 214.65, -0.002),
)
GRAVITY_OVER_GAS = 9.80665 / 287.05287
EARTH_RADIUS = 6_356_766.0


def density_ratio(height: ArrayLike) -> Array:
    """Density of the standard atmosphere over that at sea level.  height: geometric, m, any shape, below 84 km."""
    h = np.asarray(height, float)
    potential = EARTH_RADIUS * h / (EARTH_RADIUS + h)
    out = np.full(h.shape, np.nan)
    pressure = 1.0
    for k, (foot, temperature, lapse) in enumerate(LAYERS):
        inside = (potential >= foot) if k else np.isfinite(potential)
        out = np.where(inside, _pressure(potential, foot, temperature, lapse, pressure), out)
        at = temperature + lapse * (potential - foot)
        out = np.where(inside, out * LAYERS[0][1] / at, out)
        if k + 1 < len(LAYERS):
            pressure = float(_pressure(np.asarray(LAYERS[k + 1][0]), foot, temperature, lapse, pressure))
    return out


def _pressure(height: Array, foot: float, temperature: float, lapse: float, at_foot: float) -> Array:
    """Pressure over that at sea level within a layer.  height: geopotential, m."""
    rise = height - foot
    if lapse == 0.0:
        return np.asarray(at_foot * np.exp(-GRAVITY_OVER_GAS * rise / temperature))
    # far from its layer a formula may have no value; it is not used there
    ratio = np.maximum(1.0 + lapse * rise / temperature, 1e-6)
    return np.asarray(at_foot * ratio ** (-GRAVITY_OVER_GAS / lapse))


class Atmosphere:
    """Layers of air as a table of -dn/dh / n by height, which is all that bends a ray."""

    STANDARD: ClassVar[Atmosphere]
    NONE: ClassVar[Atmosphere]

    def __init__(self, sea_level: float = SEA_LEVEL) -> None:
        """sea_level: n - 1 at sea level.  Raises InputError unless it is from 0 to 0.001."""
        if not 0.0 <= sea_level <= 1e-3:
            raise InputError(f"n - 1 of {sea_level:g} at sea level", allowed="0 to 0.001; visible light 0.000277")
        self.sea_level = sea_level
        height = TABLE_LOW + TABLE_STEP * np.arange(int((TABLE_HIGH - TABLE_LOW) / TABLE_STEP) + 1)
        # central differences over a metre, so that the break at the tropopause stays in one step of the table
        slope = density_ratio(height + 0.5) - density_ratio(height - 0.5)
        self.table = np.ascontiguousarray(-sea_level * slope / (1.0 + sea_level * density_ratio(height)))

    def index(self, height: ArrayLike) -> Array:
        """Index of refraction by height, m."""
        return np.asarray(1.0 + self.sea_level * density_ratio(height))


Atmosphere.STANDARD = Atmosphere()
Atmosphere.NONE = Atmosphere(0.0)


def apparent(pos_e: ArrayLike, target_e: ArrayLike, atmosphere: Atmosphere | None = Atmosphere.STANDARD) -> Array:
    """Directions in which cameras see points: tangents of the bent rays at the cameras.

    pos_e, target_e: (n, 3), m.  atmosphere: None for straight rays.  Returns (n, 3), unit, in e.
    """
    pos, target = (np.ascontiguousarray(np.atleast_2d(np.asarray(p, float))) for p in (pos_e, target_e))
    pos, target = (np.ascontiguousarray(p) for p in np.broadcast_arrays(pos, target))
    out = np.empty(pos.shape)
    _apparent(pos, target, (atmosphere or Atmosphere.NONE).table, out)
    return out


@entry
def _apparent(pos: Array, target: Array, table: Array, out: Array) -> None:  # pragma: no cover - compiled
    down, nodes, los = np.empty(3), np.empty((4, NODES)), np.empty(3)
    for k in range(len(pos)):
        aim = target[k].copy()
        for _ in range(6):
            distance = 0.0
            for i in range(3):
                los[i] = aim[i] - pos[k, i]
                distance += los[i] * los[i]
            distance = np.sqrt(distance)
            for i in range(3):
                los[i] /= distance
            if table[0] == 0.0:
                break
            height, rise, radius = start(pos[k], los, down)
            lowest = (radius + height) * rise
            end = np.sqrt((radius + height) ** 2 + 2.0 * distance * lowest + distance**2) - radius
            # beyond the target, on the way down or up
            count = bend(
                height, rise, radius, table, min(height, end, 0.0) - 1500.0, max(height, end) + 200.0, nodes
            )
            if count < 2:
                break
            s = 0.0
            for i in range(3):
                s += (target[k, i] - pos[k, i]) * los[i]
            drop, _slope = dropped(nodes, count, s)
            moved = 0.0
            for i in range(3):
                new = target[k, i] - drop * down[i]
                moved += (new - aim[i]) ** 2
                aim[i] = new
            if moved < 1e-12:
                break
        for i in range(3):
            out[k, i] = los[i]
