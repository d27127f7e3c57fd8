"""Rays to rugged elevation at 74 deg off-nadir, against a bare march and orthority; calibration of 4000 pictures.

Times are the processor's, not the clock's: a busy machine does not change the ratios.  orthority is timed where
it is installed; it brings a second OpenCV, so it is in no extra.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from affine import Affine
from numba import njit
from numpy.typing import NDArray

from aerosim import frames
from aerosim.frames import Array
from aerosim.geolocation import cells, ground
from aerosim.geolocation.calibrated import DEG, ControlPoints, Sigmas
from aerosim.geolocation.calibration import calibrate
from aerosim.geolocation.chain import ObliqueCamera, Poses, Rays, e_from_n, pixels
from aerosim.geolocation.march import follow
from aerosim.geolocation.refraction import Atmosphere
from aerosim.geolocation.relief import Relief
from aerosim.projection import Camera

SIZE, RAYS, ROUNDS = 2048, 30_000, 3
CORNER = Affine(1 / 3600, 0, 107.2, 0, -1 / 3600, 34.3)
OFF_NADIR, CAMERA = np.radians(74.0), 12_000.0
Heights = NDArray[np.float32]


def mountains() -> Heights:
    """468 to 4010 m, slopes of 18 deg in the mean and 30 deg at the ninth decile, cells of an arc-second."""
    rng = np.random.default_rng(3)
    spectrum = np.fft.rfft2(rng.standard_normal((SIZE, SIZE)))
    k = np.hypot(np.fft.fftfreq(SIZE)[:, None], np.fft.rfftfreq(SIZE)[None])
    spectrum *= np.exp(-((k / 0.1) ** 2)) / (k + 3.0 / SIZE) ** 2.2
    land = np.fft.irfft2(spectrum, (SIZE, SIZE))
    return np.asarray(468.0 + 3542.0 * (land - land.min()) / np.ptp(land), np.float32)


def rays_to(relief: Relief) -> Rays:
    """Rays that look at points of the relief from 12 km, from all sides."""
    rng = np.random.default_rng(1)
    lat, lon = np.radians(rng.uniform(33.88, 34.15, RAYS)), np.radians(rng.uniform(107.35, 107.62, RAYS))
    azimuth, height = rng.uniform(0, 2 * np.pi, RAYS), relief.heights(lat, lon)
    s, c = np.sin(OFF_NADIR), np.cos(OFF_NADIR)
    back = e_from_n(lat, lon, np.stack([s * np.cos(azimuth), s * np.sin(azimuth), np.full(RAYS, -c)], axis=-1))
    aim = frames.ecef_from_geodetic(lat, lon, height)
    far = np.zeros(RAYS)
    for _ in range(10):
        far += (CAMERA - frames.geodetic_from_ecef(aim + far[:, None] * back)[2]) / c
    return Rays(aim + far[:, None] * back, -back)


def processor(call: Callable[[], object]) -> float:
    """Least processor time of a call after the first, s."""
    call()
    times = []
    for _ in range(ROUNDS):
        begun = time.process_time()
        call()
        times.append(time.process_time() - begun)
    return min(times)


def curves(rays: Rays, low: float, high: float) -> Array:
    """(n, 3, 3): column, row, height of straight rays between two heights, quadratics in 0 to 1."""
    ends = [ground.on_height(rays, h, None).distance for h in (high, low)]
    values = []
    for t in (0.0, 0.5, 1.0):
        s = ends[0] + t * (ends[1] - ends[0])
        lat, lon, h = frames.geodetic_from_ecef(rays.pos_e + s[:, None] * rays.los_e)
        x, y = ~CORNER * (np.degrees(lon), np.degrees(lat))
        values.append(np.stack([x - 0.5, y - 0.5, h], axis=-1))
    a, b, c = values
    return np.ascontiguousarray(np.stack([a, -3.0 * a + 4.0 * b - c, 2.0 * (a - 2.0 * b + c)], axis=-1))


def tops(heights: Heights, side: int) -> Heights:
    """Greatest height of tiles with a cell around them."""
    padded = np.pad(heights, ((0, side), (0, side)), mode="edge")
    count = SIZE // side
    out = np.empty((count, count), np.float32)
    for i in range(count):
        for j in range(count):
            out[i, j] = padded[i * side : (i + 1) * side + 1, j * side : (j + 1) * side + 1].max()
    return out


@njit(error_model="numpy")
def bare_march(c: Array, z: Heights, top_64: Heights, top_8: Heights, out: Array) -> None:
    """Steps of half a cell over tiles of 64 and 8 cells that are passed, bisection at the first ground."""
    last = z.shape[0] - 1.001
    for k in range(len(c)):
        q = c[k]
        length = np.sqrt((q[0, 1] + q[0, 2]) ** 2 + (q[1, 1] + q[1, 2]) ** 2)
        step = 0.5 / length
        t = 0.0
        out[k] = np.nan
        while t <= 1.0:
            x = (q[0, 2] * t + q[0, 1]) * t + q[0, 0]
            y = (q[1, 2] * t + q[1, 1]) * t + q[1, 0]
            h = (q[2, 2] * t + q[2, 1]) * t + q[2, 0]
            if not (0.0 <= x <= last and 0.0 <= y <= last):
                break
            skipped = False
            for side in (64, 8):
                top = top_64[int(y) // 64, int(x) // 64] if side == 64 else top_8[int(y) // 8, int(x) // 8]
                # as far as the tile goes, in the parameter
                to_x = (side - x % side if q[0, 1] > 0.0 else x % side) / max(
                    abs(q[0, 1] + 2.0 * q[0, 2] * t), 1e-9
                )
                to_y = (side - y % side if q[1, 1] > 0.0 else y % side) / max(
                    abs(q[1, 1] + 2.0 * q[1, 2] * t), 1e-9
                )
                far = t + min(to_x, to_y) + 0.1 * step
                if (q[2, 2] * far + q[2, 1]) * far + q[2, 0] > top and h > top:
                    t = far
                    skipped = True
                    break
            if skipped:
                continue
            i, j = int(y), int(x)
            u, v = x - j, y - i
            g = (z[i, j] * (1 - u) + z[i, j + 1] * u) * (1 - v) + (z[i + 1, j] * (1 - u) + z[i + 1, j + 1] * u) * v
            if h < g:
                low, high = t - step, t
                for _ in range(12):
                    t = 0.5 * (low + high)
                    x = (q[0, 2] * t + q[0, 1]) * t + q[0, 0]
                    y = (q[1, 2] * t + q[1, 1]) * t + q[1, 0]
                    h = (q[2, 2] * t + q[2, 1]) * t + q[2, 0]
                    i, j = int(y), int(x)
                    u, v = x - j, y - i
                    top = z[i, j] * (1 - u) + z[i, j + 1] * u
                    g = top * (1 - v) + (z[i + 1, j] * (1 - u) + z[i + 1, j + 1] * u) * v
                    if h < g:
                        high = t
                    else:
                        low = t
                out[k] = 0.5 * (low + high)
                break
            t += step


def followed(rays: Rays, relief: Relief) -> None:
    """The march of this package on straight rays, its state not read out."""
    reals = np.full((RAYS, cells.REALS), -1.0)
    whole = np.full((RAYS, cells.WHOLE), -1)
    whole[:, : cells.STATUS] = 0
    table = Atmosphere.NONE.table
    follow(rays.pos_e, rays.los_e, np.arange(RAYS), table, relief.blocks, relief.grid, reals, whole)


def marching() -> None:
    """Print rates and ratios of rays to the relief."""
    values = mountains()
    slope = np.degrees(np.arctan(np.hypot(*np.gradient(values, 30.9, 25.6))))
    relief = Relief.of(values, CORNER, "EPSG:4326")
    rays = rays_to(relief)
    hits = ground.on_relief(rays, relief, None)
    behind = (hits.crossings > 1).mean()
    print(f"relief: slopes {slope.mean():.1f} deg in the mean, further slopes behind {behind:.1%} of the targets")
    ours = processor(lambda: ground.on_relief(rays, relief)) / RAYS
    straight = processor(lambda: ground.on_relief(rays, relief, None)) / RAYS
    kernel = processor(lambda: followed(rays, relief)) / RAYS
    c, out = curves(rays, relief.low, relief.high), np.empty(RAYS)
    top_64, top_8 = tops(values, 64), tops(values, 8)
    bare = processor(lambda: bare_march(c, values, top_64, top_8, out)) / RAYS
    found = c[:, 2, 0] + out * (c[:, 2, 1] + out * c[:, 2, 2])
    same = np.mean(np.abs(found - hits.height)[hits.status == ground.HIT] < 5.0)
    print(f"rays to the relief: {1e-6 / ours:.3f} M/s (goal 0.5), {1e-6 / straight:.3f} without refraction")
    print(f"  {kernel / ours:.2f} of our own march on straight rays, nothing read out (goal 0.75)")
    print(
        f"  {bare / ours:.2f} of a march that is given each ray as a parabola over the cells and stops at its "
        f"first ground ({1e-6 / bare:.3f} M/s, the same target for {same:.2%})"
    )
    orthority(values, ours)


def orthority(values: Heights, ours: float) -> None:
    """Print the ratio to orthority's routine on the same relief as a plane, off-nadir 74 deg too."""
    try:
        from orthority.camera import PinholeCamera
        from orthority.enums import Interp
    except ImportError:
        print("orthority is not installed: its row is left out")
        return
    cell = 28.0
    # the camera over the middle of the piece's edge, looking along x at 74 deg off-nadir
    middle = SIZE * cell / 2.0
    place = (middle - 9000.0 * np.tan(OFF_NADIR), middle, 11_000.0)
    camera = PinholeCamera(
        (4096, 4096), 1.5, sensor_size=(0.04096, 0.04096), xyz=place, opk=(0.0, -OFF_NADIR, -np.pi / 2)
    )
    ji = np.random.default_rng(2).uniform(0.0, 4095.0, (2, 300))
    transform = Affine(cell, 0.0, 0.0, 0.0, -cell, SIZE * cell)
    surface = camera._pixel_to_world_surf  # it has no public name
    theirs = processor(lambda: surface(ji, values, transform, interp=Interp.bilinear)) / 300
    print(
        f"orthority's surface routine: {1e-6 / theirs:.4f} M/s; ours is {theirs / ours:.0f} times that (goal 50)"
    )


def calibrating() -> None:
    """Print the time of a robust calibration of 4000 pictures."""
    count, rng = 4000, np.random.default_rng(5)
    camera = ObliqueCamera(Camera(150_000.0, 4096, 4096), (0.001, -0.001, 0.001), (1.2, -0.4, -2.1))
    point = frames.ecef_from_geodetic(34.0 * DEG, 107.5 * DEG, 3132.0)
    away, azimuth = rng.uniform(25e3, 45e3, count), rng.uniform(0, 2 * np.pi, count)
    side, sigmas = rng.choice([-1.0, 1.0], count), Sigmas()
    back = np.stack([-away * np.cos(azimuth), -away * np.sin(azimuth), np.full(count, -9000.0)], axis=-1)
    place = point + e_from_n(np.full(count, 34.0 * DEG), np.full(count, 107.5 * DEG), back)
    lat, lon, height = frames.geodetic_from_ecef(place)
    off, level = np.arctan(away / 9000.0), np.zeros(count)
    poses = Poses(lat, lon, height, azimuth + side * np.pi / 2, level, level, side * off, level)
    shown = pixels(camera, poses, np.broadcast_to(point, (count, 3)))
    # the sight is centred on the point; then the navigation errs
    pose = Poses(
        lat, lon, height, poses.heading + sigmas.heading * rng.standard_normal(count),
        sigmas.pitch * rng.standard_normal(count), sigmas.roll * rng.standard_normal(count), poses.alpha, level,
    )  # fmt: skip
    good = ((shown > 0.0) & (shown < 4095.0)).all(axis=1)
    pose, shown = pose.rows(good), shown[good]
    which = np.zeros(len(shown), int)
    control = ControlPoints(point[None], np.array([0.3]))
    took = processor(lambda: calibrate(camera, pose, shown, control, which, sigmas))
    print(f"robust calibration of {len(shown)} pictures: {took * 1e3:.0f} ms (goal 100)")


if __name__ == "__main__":
    marching()
    calibrating()
