"""Frames against pyproj, closed forms and each sign once."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pyproj import Geod, Transformer

from aerosim import frames
from aerosim.errors import InputError

LATITUDES = np.radians([-90.0, -89.9999999, -60.0, -1e-9, 0.0, 36.5, 84.0, 89.9999999, 90.0])
LONGITUDES = np.radians([-180.0, -179.9999999, -84.25, 0.0, 90.0, 179.9999999, 180.0])
HEIGHTS = np.array([-5000.0, 0.0, 500.0, 3500.0, 1.0e6])
angles = st.floats(-np.pi, np.pi)


@pytest.fixture(scope="module")
def points():
    return (a.ravel() for a in np.meshgrid(LATITUDES, LONGITUDES, HEIGHTS))


def test_ecef_is_pyprojs_both_ways(points):
    lat, lon, height = points
    ours = frames.ecef_from_geodetic(lat, lon, height)
    to_ecef = Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    theirs = np.column_stack(to_ecef.transform(np.degrees(lon), np.degrees(lat), height))
    # Degrees in and out cost pyproj 1e-9 m at this distance from the Earth's centre; 1e-8 leaves a margin.
    assert np.abs(ours - theirs).max() < 1e-8
    back_lat, back_lon, back_height = frames.geodetic_from_ecef(ours)
    assert np.abs(back_height - height).max() < 5e-9
    assert np.abs(back_lat - lat).max() * frames.WGS84_A < 5e-9
    # At a pole every longitude is right, and 180 degrees is -180: compare the points.
    again = frames.ecef_from_geodetic(back_lat, back_lon, back_height)
    assert np.abs(again - ours).max() < 1e-8


@pytest.mark.parametrize(
    ("lat", "lon", "pos_e"),
    [
        (0.0, 0.0, [6378137.0, 0.0, 0.0]),
        (0.0, np.pi / 2, [0.0, 6378137.0, 0.0]),
        (np.pi / 2, 0.0, [0.0, 0.0, 6356752.314245179]),
        (-np.pi / 2, 0.0, [0.0, 0.0, -6356752.314245179]),
    ],
)
def test_axes_of_ecef(lat, lon, pos_e):
    assert frames.ecef_from_geodetic(lat, lon, 0.0) == pytest.approx(pos_e, abs=1e-8)


def test_radii_are_those_of_small_geodesics():
    # A geodesic of 100 m is its arc to 1e-8 m: the fourth power of 100 m over R.
    geod = Geod(ellps="WGS84")
    for lat in (0.0, 36.5, -60.0, 80.0):
        meridian, normal = frames.radii(np.radians(lat))
        d_lat = np.degrees(100.0 / meridian)
        _, _, north = geod.inv(10.0, lat - d_lat / 2, 10.0, lat + d_lat / 2)
        d_lon = np.degrees(100.0 / (normal * np.cos(np.radians(lat))))
        _, _, east = geod.inv(10.0, lat, 10.0 + d_lon, lat)
        assert north == pytest.approx(100.0, abs=1e-6)
        assert east == pytest.approx(100.0, abs=1e-6)


@pytest.mark.parametrize("lat", [-89.0, -45.0, 0.0, 36.5, 89.0])
@pytest.mark.parametrize("lon", [-180.0, -84.25, 0.0, 123.0, 180.0])
def test_ned_axes_are_derivatives_of_the_position(lat, lon):
    lat, lon = np.radians([lat, lon])
    mat_ne = frames.mat_ne(lat, lon)
    step = 1e-7
    north = frames.ecef_from_geodetic(lat + step, lon, 0.0) - frames.ecef_from_geodetic(lat - step, lon, 0.0)
    east = frames.ecef_from_geodetic(lat, lon + step, 0.0) - frames.ecef_from_geodetic(lat, lon - step, 0.0)
    down = frames.ecef_from_geodetic(lat, lon, -1.0) - frames.ecef_from_geodetic(lat, lon, 1.0)
    for axis, along in enumerate((north, east, down)):
        # Differences of 0.6 m in numbers of 6e6 m are good to 2e-9 relative to them.
        assert mat_ne[axis] == pytest.approx(along / np.linalg.norm(along), abs=1e-6)
    assert np.linalg.det(mat_ne) == pytest.approx(1.0)


def test_signs_of_the_attitude():
    quarter = np.pi / 2
    nose, starboard = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    north, east, up = np.eye(3)[0], np.eye(3)[1], -np.eye(3)[2]
    assert frames.mat_from_attitude(quarter, 0.0, 0.0) @ nose == pytest.approx(east)
    assert frames.mat_from_attitude(0.0, quarter, 0.0) @ nose == pytest.approx(up)
    assert frames.mat_from_attitude(0.0, 0.0, quarter) @ starboard == pytest.approx(-up)
    # Roll is innermost: a banked aircraft that heads east and climbs still has its nose up and east.
    banked = frames.mat_from_attitude(quarter, 0.1, 0.5) @ nose
    assert banked == pytest.approx(np.cos(0.1) * east + np.sin(0.1) * up)
    assert banked @ north == pytest.approx(0.0)


def test_rotations_are_scipys():
    from scipy.spatial.transform import Rotation

    for axis, rotation in zip("xyz", (frames.rot_x, frames.rot_y, frames.rot_z), strict=True):
        assert rotation(0.3) == pytest.approx(Rotation.from_euler(axis, 0.3).as_matrix())
    ours = frames.mat_from_attitude(2.5, -0.2, 0.4)
    assert ours == pytest.approx(Rotation.from_euler("ZYX", [2.5, -0.2, 0.4]).as_matrix())


@given(angles, st.floats(-1.55, 1.55), angles)
def test_attitude_comes_back(heading, pitch, roll):
    back = frames.attitude_from_mat(frames.mat_from_attitude(heading, pitch, roll))
    apart = frames.wrap_pi(np.array(back) - [heading, pitch, roll])
    # The arc sine loses half the digits as pitch nears a right angle.
    assert np.abs(apart).max() < 1e-6


@given(st.floats(-1e4, 1e4))
def test_wrap_pi(angle):
    folded = float(frames.wrap_pi(angle))
    assert -np.pi < folded <= np.pi
    assert np.hypot(np.cos(angle) - np.cos(folded), np.sin(angle) - np.sin(folded)) < 1e-9


def test_wrap_pi_at_its_ends():
    assert frames.wrap_pi([np.pi, -np.pi, 3 * np.pi]) == pytest.approx([np.pi] * 3)


GRIDS = {
    "utm 16N": ("EPSG:32616", 36.53, -84.25),
    "south": ("EPSG:32735", -33.69, 24.39),
    "Gauss-Krueger, northing first": ("EPSG:31467", 51.0, 9.3),
    "cone": ("EPSG:2154", 46.1, 3.0),
    "tmerc": ("+proj=tmerc +lat_0=46 +lon_0=7 +k=1 +datum=WGS84 +units=m", 46.1, 7.2),
    "beyond the date line": ("EPSG:32660", -17.0, 179.95),
    "polar": ("EPSG:3413", 88.0, 20.0),
}


@pytest.mark.parametrize("name", GRIDS)
def test_map_grid_is_pyprojs(name):
    crs, lat, lon = GRIDS[name]
    grid = frames.MapGrid(crs)
    e, n = grid.from_geodetic(np.radians([lat]), np.radians([lon]))
    expected = Transformer.from_crs("EPSG:4326", crs, always_xy=True).transform(lon, lat)
    assert (e[0], n[0]) == pytest.approx(expected, abs=1e-6)
    back = np.degrees(grid.to_geodetic(e, n)).ravel()
    # PROJ's way back through a datum shift (Gauss-Krueger here) is good to half a millimetre, 5e-9 deg.
    assert back == pytest.approx([lat, lon], abs=1e-8)


@pytest.mark.parametrize("crs", ["EPSG:4326", "EPSG:2225", "EPSG:4978"])
def test_map_grid_refuses_degrees_and_feet(crs):
    with pytest.raises(InputError, match="not a projected one in metres"):
        frames.MapGrid(crs)


def test_map_grid_of_a_compound_crs_is_its_horizontal_part():
    assert frames.MapGrid("EPSG:32616+5773").crs == frames.MapGrid("EPSG:32616").crs


@pytest.mark.parametrize("name", [n for n in GRIDS if n != "polar"])
def test_local_map_is_right_to_a_millimetre(name):
    crs, lat, lon = GRIDS[name]
    grid = frames.MapGrid(crs)
    centre = np.radians([lat, lon])
    local = grid.local(centre[0] + np.array([-0.001, 0.001]), centre[1] + np.array([-0.003, 0.003]))
    rng = np.random.default_rng(1)
    for d_lat, d_lon in rng.uniform((-0.004, -0.006), (0.004, 0.006), (200, 2)):
        at = centre + np.array([d_lat, d_lon])
        assert np.hypot(*np.subtract(local(*at)[:2], grid.from_geodetic(*at))) < 1e-3


def test_local_maps_derivatives_are_metres_on_the_ellipsoid():
    grid = frames.MapGrid("EPSG:32616")
    lat, lon = np.radians([36.53, -84.25])
    local = grid.local(lat, lon)
    e_north, e_east, n_north, n_east = local(lat, lon)[2:]
    meridian, normal = frames.radii(lat)
    step = 10.0
    north = np.subtract(grid.from_geodetic(lat + step / meridian, lon), grid.from_geodetic(lat, lon)) / step
    d_lon = step / (normal * np.cos(lat))
    east = np.subtract(grid.from_geodetic(lat, lon + d_lon), grid.from_geodetic(lat, lon)) / step
    assert (e_north, n_north) == pytest.approx(tuple(north), abs=1e-5)
    assert (e_east, n_east) == pytest.approx(tuple(east), abs=1e-5)
    # 2.75 deg east of the central meridian, grid north lies 1.64 deg to the right of true north: n leans west.
    assert np.degrees(np.arctan2(-e_north, n_north)) == pytest.approx(2.75 * np.sin(lat), abs=0.01)


def test_local_map_refuses_a_region_without_a_good_polynomial():
    with pytest.raises(InputError, match="too large for its map grid"):
        frames.MapGrid("EPSG:32616").local(np.radians([0.0, 75.0]), np.radians([-120.0, -54.0]))
