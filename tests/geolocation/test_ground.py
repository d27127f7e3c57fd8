"""Rays to the ground: other libraries on the ellipsoid, brute force on relief, statuses, memory, bad input."""

import numpy as np
import pymap3d.los
import pytest
import rasterio
from oblique_lands import GEODETIC, GRIDS, brute, mountains, relief_of, sights
from pyproj import Transformer

from aerosim import frames
from aerosim.errors import InputError
from aerosim.geolocation import ground
from aerosim.geolocation.chain import Rays, e_from_n
from aerosim.geolocation.relief import BYTES, Relief

DOWN = np.array([0.0, 0.0, 1.0])


def looking(lat_deg, lon_deg, height, azimuth_deg, off_nadir_deg):
    lat, lon, az, off = (np.radians(np.atleast_1d(v)) for v in (lat_deg, lon_deg, azimuth_deg, off_nadir_deg))
    los_n = np.stack([np.sin(off) * np.cos(az), np.sin(off) * np.sin(az), np.cos(off)], axis=-1)
    pos = frames.ecef_from_geodetic(lat, lon, np.broadcast_to(float(height), lat.shape))
    return Rays(pos, e_from_n(lat, lon, los_n))


class TestEllipsoid:
    def rays(self):
        """Poles, date line, equator, all azimuths."""
        lat, lon, az, off = np.meshgrid(
            [-90.0, -89.9999, -60.0, 0.0, 34.0, 89.99, 90.0], [-180.0, -0.01, 107.5, 179.9999], [0.0, 77.0, 231.0],
            [0.0, 30.0, 74.0, 85.0], indexing="ij",
        )  # fmt: skip
        return tuple(v.ravel() for v in (lat, lon, az, off))

    def test_agrees_with_pymap3d(self):
        lat, lon, az, off = self.rays()
        hits = ground.on_height(looking(lat, lon, 9000.0, az, off), 0.0, None)
        # at 0 deg pymap3d's own tilt is exactly nadir too
        theirs = pymap3d.los.lookAtSpheroid(lat, lon, 9000.0, az, off)
        expected = frames.ecef_from_geodetic(np.radians(theirs[0]), np.radians(theirs[1]), np.zeros(len(lat)))
        assert np.linalg.norm(hits.pos_e - expected, axis=-1).max() < 1e-3
        assert hits.distance == pytest.approx(theirs[2], abs=1e-3)

    @pytest.mark.parametrize("height", [-50.0, 0.0, 3132.1, 8000.0])
    def test_height_is_that_of_proj(self, height):
        hits = ground.on_height(looking(*self.rays()[:2], 9000.0, *self.rays()[2:]), height)
        to_geodetic = Transformer.from_crs("EPSG:4978", "EPSG:4979")
        lat, _lon, h = to_geodetic.transform(*hits.pos_e.T)
        assert h == pytest.approx(np.full(len(h), height), abs=1e-3)
        assert hits.lat == pytest.approx(np.radians(lat), abs=1e-10)

    def test_sky_horizon_and_a_camera_below_miss(self):
        hits = ground.on_height(looking([10.0, 10.0], [20.0, 20.0], 9000.0, [5.0, 5.0], [91.0, 120.0]), 0.0)
        assert hits.names == ["miss", "miss"]
        assert np.isnan(hits.lat).all()
        assert ground.on_height(looking(10.0, 20.0, 900.0, 0.0, 30.0), 1000.0).names == ["miss"]
        # the dip of the horizon from 9000 m is 3.04 deg without air and about 2.8 deg with it
        dip = np.degrees(np.arccos(1.0 / (1.0 + 9000.0 / 6_371_000.0)))
        for off, air, name in ((90 - dip + 0.1, None, "miss"), (90 - dip - 0.1, None, "hit")):
            assert ground.on_height(looking(10.0, 20.0, 9000.0, 90.0, off), 0.0, air).names == [name]
        assert ground.on_height(looking(10.0, 20.0, 9000.0, 90.0, 90 - dip + 0.1), 0.0).names == ["hit"]


def holed():
    values = mountains()
    values[100:160, 200:260] = np.nan
    values[300:330, 40:300] = np.nan
    values[:40, :60] = np.nan
    return values


def compare(grid, off_nadir, count, seed):
    values = holed()
    rays = sights(values, grid, count, np.radians(off_nadir), seed, around=1.3)
    hits = ground.on_relief(rays, relief_of(values, grid), None)
    expected = brute(rays, values, grid, step=1.5)
    status = np.array([e[0] for e in expected]) == np.array(hits.names)
    near = np.abs(hits.distance - np.array([e[1] for e in expected])) < 0.5
    crossings = hits.crossings == np.array([e[2] for e in expected])
    return status, near | (hits.status != ground.HIT), crossings, hits


class TestRelief:
    @pytest.mark.parametrize("grid", list(GRIDS))
    @pytest.mark.parametrize("off_nadir", [60, 74, 80])
    def test_agrees_with_small_steps(self, grid, off_nadir):
        """Steps of 1.5 m pass over a graze now and then: one ray of 60 may differ."""
        status, near, crossings, hits = compare(grid, off_nadir, 60, off_nadir)
        assert min(status.sum(), near.sum(), crossings.sum()) >= 59
        assert {"hit", "outside"} <= set(hits.names)

    @pytest.mark.slow
    def test_agrees_for_995_of_1000(self):
        found = [compare(grid, off, 230, 100 + off) for grid in GRIDS for off in (60, 67, 74, 80)]
        for kind in range(3):
            assert np.concatenate([f[kind] for f in found]).mean() >= 0.995

    def test_point_lies_on_the_ground(self):
        values = mountains()
        relief = relief_of(values)
        hits = ground.on_relief(sights(values, "geographic", 2000, np.radians(74), 5), relief)
        good = hits.status == ground.HIT
        off = np.abs(hits.height - relief.heights(hits.lat, hits.lon))[good]
        # float32 heights are known to 0.1 mm; a ray along a slope may end a few centimetres off
        assert np.quantile(off, 0.99) < 2e-3
        assert off.max() < 0.1
        assert good.mean() > 0.7

    def test_does_not_depend_on_memory(self):
        values = mountains(1400, seed=8)
        rays = sights(values, "utm", 1500, np.radians(74), 6)
        whole, scarce = relief_of(values, "utm"), relief_of(values, "utm", memory=2 * BYTES)
        assert len(scarce.blocks.posts) == 2 < whole.blocks.slots.size == len(whole.blocks.posts)
        for a, b in zip(ground.on_relief(rays, whole), ground.on_relief(rays, scarce), strict=True):
            np.testing.assert_allclose(a, b, rtol=0, atol=2e-3)  # pieces of a ray begin elsewhere

    def test_over_the_date_line(self):
        values = mountains(300)
        at_180 = Relief.of(values, GEODETIC.translation(180 - 107.4 - 0.04, 0) * GEODETIC, "EPSG:4326")
        here = relief_of(values)
        rays = sights(values, "geographic", 200, np.radians(74), 7)
        turn = np.radians(180 - 107.4 - 0.04)
        turned = Rays(*(np.asarray(v) @ frames.rot_z(turn).T for v in rays))
        a, b = ground.on_relief(rays, here), ground.on_relief(turned, at_180)
        assert a.names == b.names
        # heights of the same cells; the two longitudes differ by rounding, 1e-9 m
        assert b.height == pytest.approx(a.height, abs=1e-4, nan_ok=True)

    def test_polar_grid_with_the_pole_inside(self):
        values = mountains(200)
        from affine import Affine

        relief = Relief.of(values, Affine(30, 0, -3000, 0, -30, 3000), "EPSG:3413")
        hits = ground.on_relief(looking([89.99, 90.0], [10.0, 0.0], 9000.0, [0.0, 50.0], [10.0, 0.0]), relief)
        assert hits.names == ["hit", "hit"]
        assert hits.height == pytest.approx(relief.heights(hits.lat, hits.lon), abs=1e-3)

    def test_camera_below_the_terrain_misses(self):
        values = mountains()
        relief = relief_of(values)
        lat, lon = np.radians(34.05), np.radians(107.45)
        inside = float(relief.heights(lat, lon)) - 5.0
        assert ground.on_relief(looking(34.05, 107.45, inside, 0.0, 60.0), relief).names == ["miss"]
        assert ground.on_relief(looking(34.05, 107.45, inside + 10.0, 0.0, 30.0), relief).names == ["hit"]


class TestHeightIteration:
    def test_reports_what_does_not_converge(self):
        """At 74 deg it stands slopes below 16 deg: nearly all of gentle land, few rays of mountains."""
        values = mountains()
        gentle = (1500 + (values - 1500) * 0.03).astype(np.float32)
        for land, least, most in ((gentle, 0.95, 1.0), (values, 0.0, 0.6)):
            relief = relief_of(land)
            rays = sights(land, "geographic", 400, np.radians(74), 9, around=0.5)
            found = ground.by_height_iteration(rays, relief, 4)
            first = ground.on_relief(rays, relief, None)
            share = (found.hits.status == ground.HIT).mean()
            assert least <= share <= most
            assert np.isnan(found.hits.lat[found.hits.status != ground.HIT]).all()
            assert (found.change[found.hits.status == ground.NOT_CONVERGED] >= 1.0).all()
            if land is gentle:
                good = found.hits.status == ground.HIT
                assert np.nanmax(np.abs(found.hits.distance - first.distance)[good]) < 5.0


def write(path, values, crs, **tags):
    with rasterio.open(
        path, "w", driver="GTiff", crs=crs, transform=GEODETIC, count=1, height=values.shape[0],
        width=values.shape[1], dtype="float32", nodata=-9999.0,
    ) as file:  # fmt: skip
        file.write(np.nan_to_num(values, nan=-9999.0)[None])
        file.update_tags(**tags)
    return path


class TestBadInput:
    def test_datum_is_never_guessed(self, tmp_path):
        values = mountains(60)
        with pytest.raises(InputError, match=r"vertical_datum: .*does not say what its heights refer to"):
            Relief.open(write(tmp_path / "a.tif", values, "EPSG:4326"))
        open_3d = Relief.open(write(tmp_path / "b.tif", values, "EPSG:4979"))
        named = Relief.open(tmp_path / "a.tif", vertical_datum="ellipsoidal")
        lifted = Relief.open(tmp_path / "a.tif", vertical_datum=-35.0)
        assert open_3d.high == named.high == pytest.approx(lifted.high + 35.0)

    def test_voids_and_impossible_heights(self, tmp_path):
        values = mountains(60)
        values[:, :] = np.nan
        with pytest.raises(InputError, match="no height at all"):
            relief_of(values)
        values[:] = 32767.0
        with pytest.raises(InputError, match="a value for missing ground"):
            relief_of(values)
        with pytest.raises(InputError, match="1 x 5 cells"):
            relief_of(np.zeros((1, 5)))

    def test_rays_that_are_none(self):
        rays = looking(10.0, 20.0, 9000.0, 0.0, 30.0)
        for bad in (Rays(rays.pos_e * np.nan, rays.los_e), Rays(rays.pos_e, rays.los_e * 0.0)):
            with pytest.raises(InputError, match="a ray"):
                ground.on_height(bad, 0.0)
        with pytest.raises(InputError, match="no ground has"):
            ground.on_height(rays, 12_000.0)
        with pytest.raises(InputError, match="0 iterations"):
            ground.by_height_iteration(rays, relief_of(mountains(60)), 0)
