"""What an aircraft can fly: its limits file and the standard atmosphere."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from aerosim.errors import InputError
from aerosim.frames import GRAVITY

DENSITY_0 = 1.225


def density(height: float) -> float:
    """Density of the standard atmosphere below 11 km, kg/m3.  height: m.  ICAO Doc 7488."""
    temperature = 288.15 - 0.0065 * height
    exponent = GRAVITY / (287.05287 * 0.0065)
    ratio: float = (temperature / 288.15) ** (exponent - 1.0)
    return DENSITY_0 * ratio


@dataclass(frozen=True)
class Limits:
    """Limits of an aircraft as its file `limits.yaml` gives them; the names carry the units."""

    model: str
    wing_area_m2: float
    lift_max: float
    stall_margin: float
    equivalent_airspeed_max_m_s: float
    height_max_m: float
    height_min_m: float
    alpha_max_deg: float
    mass_empty_kg: float
    fuel_kg: float
    fuel_max_kg: float

    @classmethod
    def read(cls, path: Path) -> Limits:
        """Limits from a file.  Raises InputError for a file that is missing or not complete."""
        from ruamel.yaml import YAML
        from ruamel.yaml.error import YAMLError

        try:
            found = YAML(typ="safe").load(path)
        except (OSError, YAMLError) as error:
            raise InputError(f"limits of the aircraft cannot be read: {error}", where=str(path)) from error
        names = [f.name for f in fields(cls)]
        if not isinstance(found, dict) or sorted(found) != sorted(names):
            raise InputError("limits of the aircraft are not complete", allowed=", ".join(names), where=str(path))
        wrong = [n for n in names[1:] if not isinstance(found[n], int | float) or not np.isfinite(found[n])]
        if wrong:
            raise InputError(f"{wrong[0]} is not a number", where=str(path))
        return cls(**found)

    def check_fuel(self, fuel: float) -> None:
        """Raise InputError for fuel (kg) that the aircraft cannot carry."""
        if not 0.0 < fuel <= self.fuel_max_kg:
            raise InputError(
                f"fuel of {fuel:g} kg cannot be carried", allowed=f"above 0 to {self.fuel_max_kg:g} kg"
            )

    def lift(self, height: float, airspeed: float, mass: float) -> float:
        """Lift coefficient of level flight.  height: m, airspeed: true, m/s, mass: kg."""
        return 2.0 * mass * GRAVITY / (density(height) * airspeed**2 * self.wing_area_m2)

    def stall_speed(self, height: float, mass: float) -> float:
        """True airspeed of the stall in level flight, m/s.  height: m, mass: kg."""
        lift = density(height) * self.wing_area_m2 * self.lift_max
        return float(np.sqrt(2.0 * mass * GRAVITY / lift))

    def speed_range(self, height: float, mass: float) -> tuple[float, float]:
        """Slowest and fastest true airspeed, m/s.  height: m, mass: kg."""
        fastest = self.equivalent_airspeed_max_m_s * float(np.sqrt(DENSITY_0 / density(height)))
        return self.stall_margin * self.stall_speed(height, mass), fastest

    def check_speed(self, height: float, airspeed: float, mass: float) -> None:
        """Raise InputError for a height (m) or true airspeed (m/s) outside the limits at this mass (kg)."""
        if not self.height_min_m <= height <= self.height_max_m:
            allowed = f"{self.height_min_m:g} to {self.height_max_m:g} m"
            raise InputError(f"{self.model} cannot fly at {height:g} m", allowed=allowed)
        low, high = self.speed_range(height, mass)
        if not low <= airspeed <= high:
            side = "faster than it may fly" if airspeed > high else "too near its stall"
            raise InputError(
                f"airspeed of {airspeed:g} m/s at {height:g} m is {side} ({self.model}, {mass:.0f} kg)",
                allowed=f"{np.ceil(10 * low) / 10:g} to {np.floor(10 * high) / 10:g} m/s",
            )
