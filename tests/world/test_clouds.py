"""Cloud shadows: how much, how large, where they go; and what the rows see of them."""

from __future__ import annotations

import numpy as np
import pytest
from flights import scenario
from row_world import EAST, NORTH, cells, pose, rows

from aerosim.errors import InputError
from aerosim.frames import MapGrid
from aerosim.scenario.build.land import clouds_of
from aerosim.sensing.row_kernel import _light
from aerosim.simulate import simulate
from aerosim.world.clouds import CloudShadows
from aerosim.world.ground import Spot


def clouds(seed=1, cover=0.5, cell=800.0, velocity=(0.0, 0.0), darkness=0.6):
    return CloudShadows(np.random.default_rng(seed), cover, cell, velocity, darkness)


def light(field, easting, northing, t=0.0):
    """Light at points (n,) of the map, m, by the place that the field gives."""
    x0, y0, dx, dy, least = field.place(t)
    rows_, cols = (np.asarray(northing) - y0) / dy, (np.asarray(easting) - x0) / dx
    flat = (0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    return np.array([_light(field.shade, flat, least, r, c) for r, c in zip(rows_, cols, strict=True)])


@pytest.mark.parametrize("cover", [0.1, 0.5, 0.8])
def test_cover_and_darkness(cover):
    field = clouds(cover=cover, darkness=0.6)
    # half shadow is 0.7; the field's own points make the cover exact
    assert (field.shade < 0.7).mean() == pytest.approx(cover, abs=1e-4)
    shown = np.clip(field.shade, field.place(0.0)[4], 1.0)
    assert (shown.min(), shown.max()) == pytest.approx((0.4, 1.0))
    # edges of 30 m in shadows of 800 m: most of the ground is in full light or in full shadow
    assert ((shown > 0.401) & (shown < 0.999)).mean() < 0.08


def test_shadows_have_the_length_asked_for():
    """At half cover, a line of 51.2 km crosses an edge each 800 m: 64 times, on 20 lines 1280 times.

    Crossings of a smooth field are nearly independent; 3 sd of a Poisson count of 1280 are 8.4 %.
    """
    field = clouds()
    way = np.arange(0.0, 51_200.0, 20.0)
    dark = [light(field, way, np.full(len(way), 2560.0 * k)) < 0.7 for k in range(20)]
    crossings = sum(int((each != np.roll(each, 1)).sum()) for each in dark)
    assert 20 * 51_200.0 / crossings == pytest.approx(800.0, rel=0.084)


def test_shadows_move_with_their_velocity_and_repeat_without_a_seam():
    field = clouds(velocity=(6.0, -8.0))
    rng = np.random.default_rng(4)
    e, n = rng.uniform(-80_000.0, 80_000.0, (2, 500))
    before = light(field, e, n)
    assert before.std() > 0.2
    assert light(field, e + 6.0 * 500.0, n - 8.0 * 500.0, 500.0) == pytest.approx(before, abs=2e-3)
    assert np.abs(light(field, e, n, 500.0) - before).mean() > 0.1
    side = 64 * 800.0
    assert light(field, e + side, n - 2.0 * side) == pytest.approx(before, abs=2e-3)
    # across the seam the light changes no faster than anywhere else: 0.6 over 30 m, or half of that way
    fine = light(field, np.arange(-200.0, 200.0), np.full(400, 12_345.0))
    assert np.abs(np.diff(fine)).max() < 0.1


def test_seeds():
    assert np.array_equal(clouds(3).shade, clouds(3).shade)
    assert not np.array_equal(clouds(3).shade, clouds(4).shade)


@pytest.mark.parametrize(("cover", "cell"), [(0.0, 800.0), (1.0, 800.0), (0.5, 0.0)])
def test_fields_that_cannot_be(cover, cell):
    with pytest.raises(InputError, match="cover of"):
        clouds(cover=cover, cell=cell)


def test_from_deg_is_of_true_north():
    """Where the grid is turned by 2.1 deg, shadows from 300 deg go to 120 deg true."""
    flown = scenario(terrain={"cloud_shadows": {"speed_m_s": 10, "from_deg": 300}})
    lat, lon = np.radians([50.0, 8.75])  # 2.75 deg from the middle of zone 31: convergence 2.1 deg
    grid = MapGrid("EPSG:32631")
    local = grid.local(np.array([lat]), np.array([lon]))
    field = clouds_of(flown, local)
    moved = field.place(100.0)[:2] - field.place(0.0)[:2]
    e, n = (float(v) for v in grid.from_geodetic(lat, lon))
    to_lat, to_lon = grid.to_geodetic(e + moved[0], n + moved[1])
    north, east = (float(to_lat) - lat) * 6.366e6, (float(to_lon) - lon) * 6.389e6 * np.cos(lat)
    assert np.degrees(np.arctan2(east, north)) == pytest.approx(120.0, abs=0.1)
    assert np.hypot(north, east) == pytest.approx(1000.0, rel=5e-3)


def spot(**shade):
    photo = cells(lambda x, y: 100.0 + 40.0 * np.sin(x / 60.0) * np.cos(y / 75.0))
    return Spot(np.array([EAST, NORTH, 0.0, 1.0, 1.0, 0.0]), *photo, *cells(lambda x, y: 0.0), **shade)


def test_rows_see_their_ground_darker():
    """A shadow with its edge 300 m east of the camera: pixels beyond read 0.4 of what they read before."""
    step = 50.0
    x = (np.arange(200) - 100) * step  # of the cells, from the camera
    shade = np.repeat(np.where(x > 300.0, 0.4, 1.0).astype(np.float32)[None], 200, axis=0)
    place = np.array([EAST - 100 * step, NORTH + 100 * step, step, -step, 0.4])
    plain, dark = (rows().expose(pose(), each).row2 for each in (spot(), spot(shade=shade, shade_place=place)))
    east = (np.arange(96) - 47.5) * 3000.0 / 132.6
    ratio = dark / plain
    assert ratio[east < 300.0] == pytest.approx(1.0)
    assert ratio[east > 350.0] == pytest.approx(0.4, abs=1e-3)
    later = np.array([place[0] + 200.0, *place[1:]])
    ratio = rows().expose(pose(), spot(shade=shade, shade_place=later)).row2 / plain
    assert ratio[east < 500.0] == pytest.approx(1.0)
    assert ratio[east > 550.0] == pytest.approx(0.4, abs=1e-3)


def test_full_light_changes_no_bit():
    bright = np.ones((8, 8), np.float32)
    place = np.array([EAST, NORTH, 100.0, -100.0, 0.4])
    where = pose(0.3, 0.01, 0.02)
    plain, lit = (rows().expose(where, each) for each in (spot(), spot(shade=bright, shade_place=place)))
    assert np.array_equal(plain.row1, lit.row1)
    assert np.array_equal(plain.row2, lit.row2)


def test_shadows_disturb_a_flight():
    """Study, moving shadows on half of the ground, cells of 800 m: 83 % of the strips wrong, 3 % kept."""

    def kept(**terrain):
        matches = simulate(scenario(km=6.0, terrain=terrain)).matches
        return matches["accepted"][matches["reason"] != "timeout"].mean()

    clear, cloudy = kept(), kept(cloud_shadows={"speed_m_s": 12.0})
    assert clear > 0.7
    assert cloudy < 0.6 * clear


@pytest.mark.parametrize(
    ("key", "value"),
    [("cover_pct", 0), ("cover_pct", 100), ("cell_m", 10), ("speed_m_s", -1), ("darkness_pct", 101)],
)
def test_keys_out_of_range_are_told(key, value):
    with pytest.raises(InputError, match=r"range|less|greater|between") as caught:
        scenario(terrain={"cloud_shadows": {key: value}})
    assert key in str(caught.value)
