"""Where lines of sight meet the ground: a surface of one height, or an elevation model; bent rays by default."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from aerosim.errors import InputError
from aerosim.frames import Array
from aerosim.geolocation import cells, march
from aerosim.geolocation.chain import Rays
from aerosim.geolocation.refraction import Atmosphere
from aerosim.geolocation.relief import POSSIBLE, Relief

STATUS = ("hit", "miss", "nodata", "outside", "not_converged")
HIT, MISS, NODATA, OUTSIDE, NOT_CONVERGED = range(5)
# Below this change of height, m, the iteration of the paper counts as converged.
CONVERGED = 1.0
# Rays that are followed at once: their state fits into a processor's cache.
BATCH = 1 << 15


class Hits(NamedTuple):
    """First points of the ground that n rays meet; NaN and 0 crossings for a status other than HIT.

    lat, lon: (n,), rad; height: ellipsoidal, m; distance: straight, from the projection centre, m; incidence: of
    the arriving ray to the ellipsoid's normal, rad; status: (n,), index into STATUS; crossings: how often the ray
    would go from above to below known ground; pos_e: (n, 3), m; arriving_e: (n, 3), unit, the ray at the target.
    """

    lat: Array
    lon: Array
    height: Array
    distance: Array
    incidence: Array
    status: NDArray[np.int8]
    crossings: NDArray[np.int64]
    pos_e: Array
    arriving_e: Array

    @property
    def names(self) -> list[str]:
        """Each ray's status as a word of STATUS."""
        return [STATUS[k] for k in self.status]


class HeightIteration(NamedTuple):
    """What the height iteration came to.

    hits: as of `on_height`, NOT_CONVERGED where the last change was a metre or more; change: (n,) that change, m;
    last: of all rays, converged or not, as of `on_height`.
    """

    hits: Hits
    change: Array
    last: Hits


def on_height(rays: Rays, height: ArrayLike, atmosphere: Atmosphere | None = Atmosphere.STANDARD) -> Hits:
    """Rays down to the surface of geodetic height exactly `height`.  Statuses are HIT and MISS.

    height: ellipsoidal, m, one or (n,).  atmosphere: None for straight rays.
    Raises InputError: rays or heights that are not finite, a height that no ground has.
    """
    pos, los = _checked(rays)
    level = np.ascontiguousarray(np.broadcast_to(np.asarray(height, float), len(pos)))
    if not ((level >= POSSIBLE[0]) & (level <= POSSIBLE[1])).all():
        raise InputError(
            "a height that no ground has", key="height", allowed=f"{POSSIBLE[0]:g} to {POSSIBLE[1]:g} m"
        )
    reals, whole = _state(len(pos))
    march.at_height(pos, los, (atmosphere or Atmosphere.NONE).table, level, reals, whole)
    return _hits(reals, whole)


def on_relief(rays: Rays, relief: Relief, atmosphere: Atmosphere | None = Atmosphere.STANDARD) -> Hits:
    """First points of an elevation model that rays meet on their way from its highest to its lowest height.

    HIT: from above to below known ground.  NODATA: lost in a void: out of it under the ground, or still over it
    when the ray leaves these heights.  OUTSIDE: lost off the raster: in over its edge under the ground, out over
    it above the ground, or never over it.  MISS: it never comes down to these heights, crosses them without
    touching known ground, or starts at or under the ground.  A ray that comes out of a void, or in over the edge,
    above known ground goes on as if nothing had been there.
    atmosphere: None for straight rays.  Raises InputError: rays that are not finite; a raster no longer readable.
    """
    pos, los = _checked(rays)
    reals, whole = _state(len(pos))
    table = (atmosphere or Atmosphere.NONE).table
    for first in range(0, len(pos), BATCH):
        pending = np.arange(first, min(first + BATCH, len(pos)))
        while len(pending):
            march.follow(pos, los, pending, table, relief.blocks, relief.grid, reals, whole)
            pending = pending[whole[pending, cells.WANTED] >= 0]
            wanted, rays_of = np.unique(whole[pending, cells.WANTED], return_counts=True)
            relief.load(wanted[np.argsort(-rays_of)])
    return _hits(reals, whole)


def by_height_iteration(
    rays: Rays, relief: Relief, iterations: int = 4, atmosphere: Atmosphere | None = None
) -> HeightIteration:
    """Compatibility mode: h <- elevation below the point at which the ray is at height h, from the mean height.

    It converges only where the tangent of the slope towards the ray times that of the incidence is below 1, and
    then not always to the first point of the ground: `on_relief` is the way.  Li et al. 2020 say that an elevation
    model is used with their four iterations, and nothing of how.  Raises InputError: less than one iteration.
    """
    if iterations < 1:
        raise InputError(f"{iterations} iterations", allowed="1 or more")
    height = np.full(len(rays.pos_e), 0.5 * (relief.low + relief.high))
    status = np.full(len(height), HIT, np.int8)
    for _ in range(iterations):
        found = on_height(rays, height, atmosphere)
        ground = relief.heights(found.lat, found.lon)
        status = np.where(found.status == MISS, MISS, np.where(np.isnan(ground), OUTSIDE, HIT)).astype(np.int8)
        change = np.abs(ground - height)
        height = np.where(status == HIT, ground, height)
    last = on_height(rays, height, atmosphere)
    status[(status == HIT) & ~(change < CONVERGED)] = NOT_CONVERGED
    return HeightIteration(_only(last, status), change, last)


def _only(hits: Hits, status: NDArray[np.int8]) -> Hits:
    """Hits of another status, without numbers where it is no hit."""
    lost = status != HIT
    changed = {
        name: np.where(lost if value.ndim == 1 else lost[:, None], np.nan, value)
        for name, value in hits._asdict().items()
        if name not in ("status", "crossings")
    }
    return hits._replace(status=status, crossings=np.where(lost, 0, hits.crossings), **changed)


def _checked(rays: Rays) -> tuple[Array, Array]:
    pos, los = (np.ascontiguousarray(np.atleast_2d(np.asarray(v, float))) for v in rays)
    if pos.shape != los.shape or pos.shape[-1] != 3:
        raise InputError(f"rays of shapes {pos.shape} and {los.shape}", allowed="(n, 3) each")
    length = np.linalg.norm(los, axis=-1, keepdims=True)
    if not (np.isfinite(pos).all() and np.isfinite(length).all() and (length > 0.0).all()):
        raise InputError("a ray is not of finite numbers, or has no direction")
    return pos, los / length


def _state(count: int) -> tuple[Array, NDArray[np.int64]]:
    reals = np.full((count, cells.REALS), np.nan)
    reals[:, cells.AT] = -1.0
    whole = np.zeros((count, cells.WHOLE), np.int64)
    whole[:, cells.STATUS] = -1
    return reals, whole


def _hits(reals: Array, whole: NDArray[np.int64]) -> Hits:
    status = whole[:, cells.STATUS].astype(np.int8)
    crossings = np.where(status == HIT, whole[:, cells.CROSSINGS], 0)
    return Hits(
        reals[:, cells.LAT],
        reals[:, cells.LON],
        reals[:, cells.HEIGHT],
        reals[:, cells.DISTANCE],
        reals[:, cells.INCIDENCE],
        status,
        crossings,
        reals[:, cells.POINT : cells.POINT + 3],
        reals[:, cells.ARRIVING : cells.ARRIVING + 3],
    )
