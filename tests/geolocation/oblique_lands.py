"""Reliefs and rays for the tests of geolocation, and a march by brute force that shares nothing with the code."""

import numpy as np
from affine import Affine
from pyproj import CRS, Transformer

from aerosim import frames
from aerosim.geolocation.chain import Rays, e_from_n
from aerosim.geolocation.relief import Relief

GEODETIC = Affine(1 / 3600, 0, 107.4, 0, -1 / 3600, 34.1)
UTM = Affine(30, 0, 480_000, 0, -30, 3_780_000)
TURNED = Affine.translation(480_000, 3_780_000) * Affine.rotation(25) * Affine.scale(30, -30)
GRIDS = {
    "geographic": (GEODETIC, "EPSG:4326"),
    "utm": (UTM, "EPSG:32648"),
    "turned": (TURNED, "EPSG:32648"),
}


def mountains(size=400, seed=3, low=500.0, high=2900.0, exponent=2.2):
    """Heights of a power-law spectrum, m, (size, size)."""
    rng = np.random.default_rng(seed)
    spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
    k = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None])
    spectrum *= np.exp(-((k / 0.2) ** 2)) / (k + 2.0 / size) ** exponent
    land = np.fft.irfft2(spectrum, (size, size))
    return (low + (high - low) * (land - land.min()) / np.ptp(land)).astype(np.float32)


def relief_of(values, grid="geographic", **options):
    transform, crs = GRIDS[grid]
    return Relief.of(values, transform, crs, **options)


def sights(values, grid, count, off_nadir, seed, camera=9000.0, around=0.9):
    """Straight rays at an off-nadir angle (rad) at the mean height, aimed at and around the raster."""
    transform, crs = GRIDS[grid]
    rng = np.random.default_rng(seed)
    rows, cols = values.shape
    at = 0.5 + (rng.random((count, 2)) - 0.5) * around
    x, y = transform * (at[:, 0] * cols, at[:, 1] * rows)
    lon, lat = Transformer.from_crs(crs, "EPSG:4326", always_xy=True).transform(x, y)
    lat, lon, azimuth = np.radians(lat), np.radians(lon), rng.uniform(0, 2 * np.pi, count)
    off = np.broadcast_to(off_nadir, count)
    towards = np.stack([np.sin(off) * np.cos(azimuth), np.sin(off) * np.sin(azimuth), -np.cos(off)], axis=-1)
    back = e_from_n(lat, lon, towards)
    aim = frames.ecef_from_geodetic(lat, lon, np.nanmean(values))
    s = np.zeros(count)
    for _ in range(20):
        s += (camera - frames.geodetic_from_ecef(aim + s[:, None] * back)[2]) / np.cos(off)
    return Rays(aim + s[:, None] * back, -back)


def ground_at(values, grid, lat, lon):
    """Heights (NaN in voids) and whether points are on the raster, through PROJ and the bilinear formula."""
    transform, crs = GRIDS[grid]
    lon_deg, lat_deg = np.degrees(lon), np.degrees(lat)
    if not CRS(crs).is_geographic:
        lon_deg, lat_deg = Transformer.from_crs("EPSG:4326", crs, always_xy=True).transform(lon_deg, lat_deg)
    x, y = ~transform * (lon_deg, lat_deg)
    x, y = x - 0.5, y - 0.5
    rows, cols = values.shape
    on = (x >= 0) & (y >= 0) & (x <= cols - 1) & (y <= rows - 1)
    j, i = np.clip(np.floor(x).astype(int), 0, cols - 2), np.clip(np.floor(y).astype(int), 0, rows - 2)
    x, y = x - j, y - i
    z = values.astype(float)
    height = (z[i, j] * (1 - x) + z[i, j + 1] * x) * (1 - y) + (z[i + 1, j] * (1 - x) + z[i + 1, j + 1] * x) * y
    return np.where(on, height, np.nan), on


def brute(rays, values, grid, step=3.0, shift=0.0):
    """Status, distance of the first hit (m; NaN) and crossings of straight rays, by small steps in ECEF.

    shift: of the heights between which the ray is followed, m.
    """
    low, high = float(np.nanmin(values)) - shift, float(np.nanmax(values)) + shift
    return [_one(rays.pos_e[k], rays.los_e[k], values, grid, low, high, step) for k in range(len(rays.pos_e))]


def _one(pos, los, values, grid, low, high, step):  # noqa: PLR0912
    far = np.arange(0.0, 80_000.0, 200.0)
    rough = frames.geodetic_from_ecef(pos + far[:, None] * los)[2]
    inside = np.flatnonzero((rough < high + 300.0) & (rough > low - 300.0))
    if not len(inside):
        return "miss", np.nan, 0
    s = np.arange(far[max(inside[0] - 1, 0)], far[min(inside[-1] + 1, len(far) - 1)], step)
    lat, lon, h = frames.geodetic_from_ecef(pos + s[:, None] * los)
    first = 0 if rough[0] <= high else np.argmax(h <= high)
    if rough[0] > high and not (h <= high).any():
        return "miss", np.nan, 0
    ground, on = ground_at(values, grid, lat, lon)
    above = h - ground
    was, found, crossings, rough_start = "above", np.nan, 0, rough[0] <= high
    for k in range(first, len(s)):
        if h[k] < low or (h[k] > high and k > first + 1):
            break
        if not on[k]:
            if crossings:
                break
            was = "off"
        elif np.isnan(above[k]):
            was = "void"
        elif above[k] < 0.0:
            if rough_start and k == first:
                return "miss", np.nan, 0
            if was == "above":
                crossings += 1
                if crossings == 1:
                    before = above[k - 1] if k else 0.0
                    found = s[k] - step * above[k] / (above[k] - before)
            elif not crossings and was in ("void", "off"):
                return {"void": "nodata", "off": "outside"}[was], np.nan, 0
            was = "under"
        else:
            was = "above"
    if crossings:
        return "hit", found, crossings
    return {"above": "miss", "under": "miss", "void": "nodata", "off": "outside"}[was], np.nan, 0
