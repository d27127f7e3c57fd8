"""Refraction: against the eikonal equation through the standard atmosphere, and its published table."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aerosim import frames
from aerosim.errors import InputError
from aerosim.geolocation.chain import Rays
from aerosim.geolocation.ground import on_height
from aerosim.geolocation.refraction import Atmosphere, apparent, density_ratio


def test_density_of_the_published_table():
    """US Standard Atmosphere 1976, table I: density in kg/m^3 over 1.2250."""
    table = {
        0: 1.2250,
        1000: 1.1117,
        5000: 0.73643,
        11_000: 0.36480,
        15_000: 0.19476,
        20_000: 0.088910,
        30_000: 0.018410,
    }
    assert density_ratio(list(table)) * 1.225 == pytest.approx(list(table.values()), rel=2e-4)


def traced(pos, los, height):
    """Where a ray comes to a height: d(n t)/ds = grad n, integrated to 1e-11, layers along the ellipsoid."""

    def index(h):
        return 1.0 + 277e-6 * float(density_ratio(h))

    def rates(_s, state):
        lat, lon, h = frames.geodetic_from_ecef(state[:3])
        up = -frames.mat_ne(float(lat), float(lon))[2]
        return np.concatenate([state[3:] / index(h), (index(h + 0.5) - index(h - 0.5)) * up])

    def there(_s, state):
        return frames.geodetic_from_ecef(state[:3])[2] - height

    there.terminal = True
    start = np.concatenate([pos, los * index(frames.geodetic_from_ecef(pos)[2])])
    return solve_ivp(rates, (0.0, 3e5), start, rtol=1e-11, atol=1e-6, max_step=2000.0, events=there).y_events[0][
        0
    ][:3]


@pytest.mark.parametrize(
    ("off_nadir", "camera", "height", "uncorrected"),
    # the last column: studied before this code was written, m
    [
        (70, 12_000.0, 3100.0, 12.5),
        (74, 12_000.0, 3100.0, 24.7),
        (80, 12_000.0, 3100.0, 107.0),
        (80, 15_400.0, 1000.0, 269.0),
    ],
)
def test_displacement_is_removed(off_nadir, camera, height, uncorrected):
    """At least 95 % of it was asked for; the integrator leaves less than 0.2 %."""
    lat, lon, off, az = np.radians([34.0, 107.5, off_nadir, 40.0])
    pos = frames.ecef_from_geodetic(lat, lon, camera)
    los = frames.mat_ne(lat, lon).T @ [np.sin(off) * np.cos(az), np.sin(off) * np.sin(az), np.cos(off)]
    true = traced(pos, los, height)
    rays = Rays(pos[None], los[None])
    straight = np.linalg.norm(on_height(rays, height, None).pos_e[0] - true)
    bent = np.linalg.norm(on_height(rays, height).pos_e[0] - true)
    assert straight == pytest.approx(uncorrected, rel=0.02)
    assert bent < 0.002 * straight
    # and the way back: the direction in which the camera sees that point, 1e-7 rad
    assert apparent(pos, true)[0] == pytest.approx(los, abs=5e-7)


def test_down_is_where_it_bends_to():
    """A ray that bends down meets the ground nearer than a straight one; straight down nothing bends."""
    pos = frames.ecef_from_geodetic(0.6, 0.1, 9000.0)[None]
    down = frames.mat_ne(0.6, 0.1)[2][None]
    assert on_height(Rays(pos, down), 0.0).distance == pytest.approx(
        on_height(Rays(pos, down), 0.0, None).distance
    )
    slant = (frames.mat_ne(0.6, 0.1).T @ [np.sin(1.3), 0.0, np.cos(1.3)])[None]
    assert on_height(Rays(pos, slant), 0.0).distance < on_height(Rays(pos, slant), 0.0, None).distance - 5.0


def test_bad_atmosphere():
    for bad in (-1e-4, 1.000277, np.nan):
        with pytest.raises(InputError, match="at sea level"):
            Atmosphere(bad)
