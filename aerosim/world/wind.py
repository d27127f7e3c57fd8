"""The mean wind by height: steady, a profile of levels, or a power law with veer."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise
from math import cos, radians, sin
from typing import NamedTuple

from aerosim.errors import InputError

Wind = tuple[float, float, float]


def wind_n(speed: float, from_azimuth: float) -> Wind:
    """Velocity of the air in n (m/s) of a wind that comes FROM an azimuth (rad, clockwise from north)."""
    return -speed * cos(from_azimuth), -speed * sin(from_azimuth), 0.0


class Level(NamedTuple):
    """Wind at one height: ellipsoidal, m; speed, m/s; azimuth that it comes FROM, rad."""

    height: float
    speed: float
    from_azimuth: float


class WindField:
    """Mean wind by height, the same everywhere and always at one height.

    uniform: whether it is the same at all heights.
    """

    def __init__(
        self,
        levels: Sequence[Level],
        *,
        ground: float = 0.0,
        exponent: float = 0.0,
        reference_agl: float = 3000.0,
        veer: float = 0.0,
    ) -> None:
        """levels: one is a steady wind, whatever its height; more are a profile, by rising height.

        ground: ellipsoidal height of the ground, m; exponent: of the power law (h/reference_agl)**exponent of the
        speed over the height above ground, at which (reference_agl, m) the one level's wind holds; veer: turn
        of the wind, rad per m upwards, positive clockwise.  The last four are for a steady wind only.
        Raises InputError: no level, heights that do not rise, or a profile with shear.
        """
        if not levels:
            raise InputError("has no level", key="air.wind.profile", allowed="at least one")
        for below, above in pairwise(levels):
            if not below.height < above.height:
                raise InputError(
                    f"level at {above.height:g} m follows one at {below.height:g} m",
                    key="air.wind.profile",
                    allowed="heights that rise",
                )
        if len(levels) > 1 and (exponent or veer):
            raise InputError(
                "shear on top of a wind profile", key="air.shear", allowed="one of both: put it into the levels"
            )
        self._heights = [level.height for level in levels]
        self._winds = [wind_n(level.speed, level.from_azimuth) for level in levels]
        self._ground, self._exponent, self._reference, self._veer = ground, exponent, reference_agl, veer
        self.uniform = not (exponent or veer) and len(set(self._winds)) == 1

    def at(self, height: float) -> Wind:
        """Velocity of the air in n (m/s) at an ellipsoidal height (m).

        Between levels north and east are linear in height: that has no jump where the wind turns by more than half
        a circle or dies down, which an interpolated direction has.  Below and above the levels it is constant.
        The power law gives calm at and below the ground.
        """
        if len(self._heights) == 1:
            return self._winds[0] if self.uniform else self._sheared(height)
        above = bisect_right(self._heights, height)
        if above == 0 or above == len(self._heights):
            return self._winds[0 if above == 0 else -1]
        low, high = self._heights[above - 1 : above + 1]
        (north0, east0, _), (north1, east1, _) = self._winds[above - 1 : above + 1]
        part = (height - low) / (high - low)
        return north0 + part * (north1 - north0), east0 + part * (east1 - east0), 0.0

    def _sheared(self, height: float) -> Wind:
        agl = height - self._ground
        factor = max(agl / self._reference, 0.0) ** self._exponent if self._exponent else 1.0
        turn = self._veer * (agl - self._reference)
        north, east, _ = self._winds[0]
        c, s = factor * cos(turn), factor * sin(turn)
        return c * north - s * east, s * north + c * east, 0.0


def steady_wind(speed: float, from_deg: float) -> WindField:
    """The same wind everywhere.  speed: m/s; from_deg: azimuth that it comes FROM, deg."""
    return WindField([Level(0.0, speed, radians(from_deg))])
