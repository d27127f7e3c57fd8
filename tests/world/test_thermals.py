"""Thermals: profile and zero mean, places on the globe, drift, and a random field without end or seams."""

import math

import numpy as np
import pytest
from pyproj import Geod

from aerosim.errors import InputError
from aerosim.world.local import LocalPlane
from aerosim.world.thermals import Thermal, ThermalCells, ThermalField, Thermals

LAT, LON = math.radians(47.0), math.radians(8.0)


def plane(drift=(0.0, 0.0), height=0.0):
    return LocalPlane(LAT, LON, height, drift)


def beside(north, east):
    """A point so many metres away, by geodesics of another library."""
    lon, lat, _ = Geod(ellps="WGS84").fwd(
        8.0, 47.0, math.degrees(math.atan2(east, north)), math.hypot(north, east)
    )
    return math.radians(lat), math.radians(lon)


def test_profile_by_distance():
    # up = strength (1 - s) exp(-s), s = (r/R)^2: full at the centre, nothing at R, most sink exp(-2) at sqrt(2) R
    wind = Thermals([Thermal(LAT, LON, 300.0, 3.0)], plane())
    for part, up in (
        (0.0, 3.0),
        (0.5, 3.0 * 0.75 * math.exp(-0.25)),
        (1.0, 0.0),
        (2.0**0.5, -3.0 * math.exp(-2.0)),
    ):
        for direction in (0.3, 2.0, 4.4):
            place = beside(300.0 * part * math.cos(direction), 300.0 * part * math.sin(direction))
            north, east, down = wind.at(0.0, *place, 0.0)
            assert (north, east) == (0.0, 0.0)
            assert down == pytest.approx(-up, abs=2e-4)


def test_as_much_sinks_as_rises():
    wind = Thermals([Thermal(LAT, LON, 300.0, 3.0)], plane())
    metres = np.arange(-1500.0, 1500.0, 20.0)
    radius_n, radius_e = plane()._north, plane()._east
    down = [wind.at(0.0, LAT + x / radius_n, LON + y / radius_e, 0.0)[2] for x in metres for y in metres]
    assert max(down) > 0.3
    assert min(down) == pytest.approx(-3.0)
    # int of the core alone is pi R^2 strength exp(-1)
    assert abs(sum(down) * 400.0) < 1e-4 * math.pi * 300.0**2 * 3.0


def test_they_stand_or_drift_with_the_wind():
    carried = Thermals([Thermal(LAT, LON, 300.0, 3.0)], plane((5.0, -2.0)))
    standing = Thermals([Thermal(LAT, LON, 300.0, 3.0)], plane())
    later = beside(500.0, -200.0)
    assert carried.at(100.0, *later, 0.0)[2] == pytest.approx(-3.0, abs=1e-3)
    assert standing.at(100.0, LAT, LON, 0.0)[2] == pytest.approx(-3.0)
    assert abs(standing.at(100.0, *later, 0.0)[2]) < 0.3


def cells(seed=1, field=None):
    return ThermalCells(field or ThermalField(1e-6, 200.0, 2.0), plane(), np.random.default_rng(seed))


def along(wind, metres):
    radius = plane()._north
    return np.array([wind.at(0.0, LAT + x / radius, LON, 0.0)[2] for x in metres])


def test_field_is_the_same_wherever_one_comes_first():
    metres = np.arange(-20e3, 20e3, 100.0)
    there, back = along(cells(), metres), along(cells(), metres[::-1])[::-1]
    assert np.array_equal(there, back)
    assert not np.array_equal(there, along(cells(2), metres))


def test_field_has_no_seams():
    # steepest slope of the profile is 1.5 strength/R about; with 3 m/s and 100 m at most 0.05 per metre
    found = along(cells(), np.arange(0.0, 20e3, 2.0))
    assert np.abs(np.diff(found)).max() < 2 * 0.05
    assert found.min() < -0.5


def test_field_has_its_density_and_no_mean():
    # Campbell: the field's mean is density times the integral of a thermal, 0, and its mean square density
    # times the integral of its square, pi R^2 strength^2 int (1 - s)^2 exp(-2s) ds = pi R^2 strength^2 / 4.
    # Even spreads of +-50 % make <R^2 s^2> (1 + 1/12)^2 of the means' square.
    density, radius, strength = 2e-6, 200.0, 2.0
    wind = cells(3, ThermalField(density, radius, strength))
    points = np.random.default_rng(8).uniform(-30e3, 30e3, (10_000, 2))
    points = points[np.lexsort(points.T // wind._side)]
    n, e = plane()._north, plane()._east
    down = np.array([wind.at(0.0, LAT + x / n, LON + y / e, 0.0)[2] for x, y in points])
    wanted = density * math.pi * radius**2 / 4.0 * strength**2 * (13.0 / 12.0) ** 2
    # The 7200 thermals there differ among each other: about 1.3/sqrt(7200) of the mean square, 1.5 %.  The points:
    # int (1-s)^4 e^(-4s) ds = 0.13 against 0.25 of the square, so a square has the variance of about
    # 0.13/0.25 1.6 wanted strength^2, the 1.6 for the spread of the strengths: 2.1 % for 10 000 of them.
    assert np.mean(down**2) == pytest.approx(wanted, rel=5 * math.hypot(0.015, 0.021))
    assert abs(np.mean(down)) < 5 * math.sqrt(wanted / len(down))


def test_a_thermal_without_size_is_refused():
    with pytest.raises(InputError, match="a thermal of 0 m radius"):
        Thermals([Thermal(LAT, LON, 0.0, 3.0)], plane())
    with pytest.raises(InputError, match="a thermal of -1 m radius"):
        cells(field=ThermalField(1e-6, -1.0, 2.0))


def test_plane_knows_the_date_line():
    near = LocalPlane(0.0, math.pi - 1e-6, 0.0)
    assert near.at(0.0, 0.0, -math.pi + 1e-6)[1] == pytest.approx(2e-6 * 6378137.0, rel=1e-6)


def test_plane_against_geodesics():
    north, east = plane().at(0.0, *beside(3000.0, -4000.0))
    assert (north, east) == pytest.approx((3000.0, -4000.0), abs=3.0)
