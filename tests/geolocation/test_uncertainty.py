"""Uncertainty of targets: distribution of circles, coverage of simulated targets, guard, bad input."""

import numpy as np
import pytest
from oblique_flights import CAMERA, SIGMAS
from oblique_lands import mountains, relief_of
from scipy.stats import chi2, norm

from aerosim import frames
from aerosim.errors import InputError
from aerosim.geolocation import ground
from aerosim.geolocation.calibrated import DEG
from aerosim.geolocation.chain import Poses, Rays, e_from_n, n_from_e, rays
from aerosim.geolocation.uncertainty import circle_90, uncertainty

LEVEL = 1500.0


def targets(count, seed, off=(70.0, 78.0)):
    """Poses 9 km above LEVEL that look at the middle of the relief, from all sides, and pixels."""
    rng = np.random.default_rng(seed)
    lat, lon = rng.uniform(34.02, 34.07, count) * DEG, rng.uniform(107.43, 107.48, count) * DEG
    off_nadir, azimuth = rng.uniform(*off, count) * DEG, rng.uniform(0.0, 2.0 * np.pi, count)
    level = 9000.0 * np.tan(off_nadir)
    back = np.stack([-level * np.cos(azimuth), -level * np.sin(azimuth), np.full(count, -9000.0)], axis=-1)
    lat, lon, height = frames.geodetic_from_ecef(
        frames.ecef_from_geodetic(lat, lon, np.full(count, LEVEL)) + e_from_n(lat, lon, back)
    )
    side = rng.choice([-1.0, 1.0], count)
    heading = azimuth + side * (90.0 + rng.uniform(-20.0, 20.0, count)) * DEG
    pitch, roll = rng.uniform(-2.0, 2.0, (2, count)) * DEG
    return Poses(lat, lon, height, heading, pitch, roll, side * off_nadir, 0.0), rng.uniform(
        1000, 3000, (count, 2)
    )


def true_targets(poses, pixel, relief, seed):
    """Where the pictures truly looked, when what is measured errs by SIGMAS and the ground by its own sigma."""
    rng, n, s = np.random.default_rng(seed), poses.count, SIGMAS
    north, east, up = rng.standard_normal((3, n)) * np.array(s.position)[:, None]

    def off(values, sigma):
        return values + sigma * rng.standard_normal(n)

    true = Poses(
        poses.lat + north / frames.radii(poses.lat)[0],
        poses.lon + east / frames.radii(poses.lat)[1] / np.cos(poses.lat),
        poses.height + up, off(poses.heading, s.heading), off(poses.pitch, s.pitch), off(poses.roll, s.roll),
        off(poses.alpha, s.gimbal), off(poses.beta, s.gimbal),
    )  # fmt: skip
    sight = rays(CAMERA, true, pixel + s.pixel * rng.standard_normal((n, 2)))
    lift = s.elevation * rng.standard_normal(n)
    if relief is None:
        return ground.on_height(sight, LEVEL + lift).pos_e
    place = ground.on_height(sight, LEVEL)
    vertical = lift[:, None] * -e_from_n(place.lat, place.lon, np.broadcast_to([0.0, 0.0, 1.0], (n, 3)))
    return ground.on_relief(Rays(sight.pos_e - vertical, sight.los_e), relief).pos_e + vertical


def coverage(count, relief, **options):
    """Share of targets within CE90 and LE90, and the uncertainty."""
    poses, pixel = targets(count, 1)
    sight = rays(CAMERA, poses, pixel)
    hits = ground.on_height(sight, LEVEL) if relief is None else ground.on_relief(sight, relief)
    good = hits.status == ground.HIT
    poses, pixel, hits = poses.rows(good), pixel[good], ground.Hits(*(v[good] for v in hits))
    found = uncertainty(CAMERA, poses, pixel, hits, SIGMAS, relief=relief, **options)
    off = n_from_e(hits.lat, hits.lon, true_targets(poses, pixel, relief, 99) - hits.pos_e)
    # a true target that is nowhere is not within any circle
    circle, height = np.hypot(off[:, 0], off[:, 1]), np.abs(off[:, 2])
    return (circle <= found.ce90).mean(), (height <= found.le90).mean(), found


class TestCircle:
    def test_closed_forms(self):
        assert circle_90(1.0, 1.0) == pytest.approx(np.sqrt(chi2.ppf(0.9, 2)), rel=1e-9)
        assert circle_90(2.0, 0.0) == pytest.approx(2.0 * norm.ppf(0.95), rel=1e-6)
        assert circle_90(0.0, 0.0) == 0.0

    @pytest.mark.parametrize("ratio", [0.05, 0.3, 0.7])
    def test_against_draws(self, ratio):
        """4e5 draws: sd of the share 0.0005."""
        x = np.random.default_rng(1).standard_normal((400_000, 2)) * [1.0, ratio]
        assert (np.hypot(*x.T) <= circle_90(1.0, ratio)).mean() == pytest.approx(0.9, abs=0.002)


class TestCoverage:
    """Sd of a share of 20,000: 0.2 %; of 3000: 0.55 %."""

    def test_twenty_thousand_targets_at_one_height(self):
        circle, height, found = coverage(20_000, None)
        assert 0.88 <= circle <= 0.92
        assert 0.88 <= height <= 0.92
        assert found.le90 == pytest.approx(np.full(20_000, 1.645 * SIGMAS.elevation), rel=1e-3)
        assert not found.drawn.any()

    def test_drawn_rays_say_the_same(self):
        circle, _, drawn = coverage(400, None, draw="always")
        _, _, linear = coverage(400, None, draw="never")
        # a quantile of 200 draws has a relative sd of about 6 %, its mean over 400 targets 0.3 %
        assert (drawn.ce90 / linear.ce90).mean() == pytest.approx(1.0, abs=0.03)
        assert circle == pytest.approx(0.9, abs=0.05)

    def test_slope_is_in_the_linear_errors(self):
        """A plane of 8 deg: what is drawn needs no slope, and a quantile of 200 draws has a sd of about 6 %."""
        rows, _ = np.mgrid[0:400, 0:400]
        relief = relief_of(LEVEL + 30.9 * np.tan(8.0 * DEG) * (rows - 200.0))
        found = {draw: coverage(300, relief, draw=draw)[2] for draw in ("always", "never")}
        for name in ("ce90", "le90"):
            ratio = getattr(found["never"], name) / getattr(found["always"], name)
            assert np.median(ratio) == pytest.approx(1.0, abs=0.03)
            assert np.quantile(np.abs(ratio - 1.0), 0.8) < 0.12

    @pytest.mark.parametrize("steepness", [0.1, 1.0])
    def test_on_relief(self, steepness):
        values = (LEVEL + steepness * (mountains() - LEVEL)).astype(np.float32)
        circle, height, found = coverage(1200, relief_of(values))
        # about 600 hits: sd 1.2 %
        assert 0.86 <= circle <= 0.94
        assert 0.86 <= height <= 0.94
        assert found.drawn.any()

    @pytest.mark.slow
    @pytest.mark.parametrize("steepness", [0.1, 0.4, 1.0])
    def test_twenty_thousand_on_relief(self, steepness):
        values = (LEVEL + steepness * (mountains() - LEVEL)).astype(np.float32)
        circle, _, _ = coverage(20_000, relief_of(values))
        assert 0.88 <= circle <= 0.92


def test_ellipse_lies_along_the_sight():
    poses, pixel = targets(50, 3)
    hits = ground.on_height(rays(CAMERA, poses, pixel), LEVEL)
    found = uncertainty(CAMERA, poses, pixel, hits, SIGMAS)
    towards = n_from_e(hits.lat, hits.lon, hits.arriving_e)
    sight = np.arctan2(towards[:, 1], towards[:, 0])
    assert np.abs(np.sin(found.azimuth - sight)).max() < 0.1
    assert (found.major > found.minor).all()
    assert found.major**2 + found.minor**2 == pytest.approx(found.covariance[:, 0, 0] + found.covariance[:, 1, 1])


def test_no_number_for_a_miss():
    poses, pixel = targets(5, 3)
    up = Poses(
        poses.lat, poses.lon, poses.height, poses.heading, poses.pitch, poses.roll, np.pi - poses.alpha, poses.beta
    )
    hits = ground.on_height(rays(CAMERA, up, pixel), LEVEL)
    assert set(hits.names) == {"miss"}
    found = uncertainty(CAMERA, up, pixel, hits, SIGMAS)
    assert np.isnan(found.ce90).all()
    assert np.isnan(found.le90).all()


def test_bad_input():
    poses, pixel = targets(5, 3)
    hits = ground.on_height(rays(CAMERA, poses, pixel), LEVEL)
    with pytest.raises(InputError, match="auto, never, always"):
        uncertainty(CAMERA, poses, pixel, hits, SIGMAS, draw="some")
    with pytest.raises(InputError, match="5 hits of 4 poses"):
        uncertainty(CAMERA, poses.rows(np.arange(4)), pixel[:4], hits, SIGMAS)
    with pytest.raises(InputError, match="sigma"):
        uncertainty(CAMERA, poses, pixel, hits, SIGMAS._replace(pixel=np.nan))
