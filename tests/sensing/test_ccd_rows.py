"""The rows as a device: converter, noise, exposure; and what both see of the same land in flight."""

import math

import numpy as np
import pytest
from row_world import EAST, FOCAL, NORTH, PIXELS, SHIFT, SPACING, pose, rows, spot
from scipy.ndimage import gaussian_filter


def even(grey):
    return spot(lambda x, y: grey)


def test_noise_of_the_converter_and_of_rounding():
    # Variance: noise, and 1/12 of rounding; that of N values has a relative sd of sqrt(2/N), 4 of them 2.8 %.
    device, land = rows(noise_grey=1.5, bits=8), even(100.3)
    made = [device.expose(pose(), land) for _ in range(200)]
    row1, row2 = np.array([m.row1 for m in made]), np.array([m.row2 for m in made])
    assert row1.shape[1] == PIXELS + 2 * SHIFT
    assert row2.shape[1] == PIXELS
    for grey in (row1, row2):
        count = grey.size
        assert np.array_equal(grey, np.rint(grey))
        assert grey.mean() == pytest.approx(100.3, abs=4.0 * 1.53 / math.sqrt(count))
        assert grey.var() == pytest.approx(1.5**2 + 1.0 / 12.0, rel=4.0 * math.sqrt(2.0 / count))
    # pixels and exposures share nothing
    flat = row2 - row2.mean()
    for lagged in (flat[1:] * flat[:-1], flat[:, 1:] * flat[:, :-1]):
        assert abs(lagged.mean()) / flat.var() < 4.0 / math.sqrt(lagged.size)
    # nor do the rows
    for first in range(2 * SHIFT + 1):
        other = row1[:, first : first + PIXELS]
        assert abs(np.corrcoef(other.ravel(), row2.ravel())[0, 1]) < 5.0 / math.sqrt(row2.size)


def test_rounding_alone():
    # A ramp over 200 grey levels: errors are even over +-0.5, variance 1/12, that of N values +-sqrt(0.8/N).
    device = rows(bits=8)
    errors = []
    for k in range(40):
        made = device.expose(pose(), spot(lambda x, y, k=k: 128.0 + 0.0817 * x + 0.0123 * k))
        exact = 128.0 + 0.0817 * (np.arange(PIXELS) - 47.5) * 3000.0 / FOCAL + 0.0123 * k
        errors.append(made.row2 - exact)
    # the curve of the Earth moves the outer pixels by 4 cm, 0.003 grey levels
    errors = np.array(errors)
    assert np.abs(errors).max() < 0.505
    assert errors.var() == pytest.approx(1.0 / 12.0, rel=4.0 * math.sqrt(0.8 / errors.size))


@pytest.mark.parametrize("bits", [8, 10, 12])
def test_full_scale(bits):
    full = 2**bits - 1
    made = rows(bits=bits, exposure=0.02).expose(pose(), even(250.0))
    assert (made.row1 == full).all()
    assert (made.row2 == full).all()
    half = rows(bits=bits, exposure=0.005).expose(pose(), even(250.0))
    assert half.row2 == pytest.approx(np.round(125.0 * full / 255.0))
    assert half.exposure == 0.005


def test_noise_does_not_go_below_zero():
    made = rows(bits=8, noise_grey=3.0).expose(pose(), even(0.0))
    assert made.row2.min() == 0.0
    assert (made.row2 > 0.0).mean() == pytest.approx(0.43, abs=0.2)  # P(3 z > 0.5) = 0.434, 96 pixels: 4 sd 0.2


def test_dark_level_drifts_in_row_two_only():
    device = rows(bits=8, dark_drift_grey_per_s=0.5)
    for t in (0.0, 10.0, 60.0):
        made = device.expose(pose(t=t), even(80.0))
        assert (made.row1 == 80.0).all()
        assert (made.row2 == 80.0 + 0.5 * t).all()
        assert made.t == t


class TestAutomaticExposure:
    @pytest.mark.parametrize("bits", [8, 12])
    @pytest.mark.parametrize("grey", [60.0, 110.0, 180.0, 240.0])
    def test_brings_the_mean_to_110_of_255(self, bits, grey):
        # On waves of 37 m to 900 m around the mean; the 96 pixels hold no whole waves: the row's own mean counts.
        device = rows(bits=bits, exposure=None)
        land = spot(lambda x, y: grey + 5.0 * np.sin(x / 90.0) + 5.0 * np.cos(y / 140.0))
        assert device.expose(pose(), land).exposure == 0.01
        device.new_cycle()
        made = device.expose(pose(), land)
        assert made.exposure == pytest.approx(0.01 * 110.0 / grey, rel=0.12)
        assert made.row2.mean() == pytest.approx((2**bits - 1) * 110.0 / 255.0, abs=0.1)

    @pytest.mark.parametrize(("grey", "exposure"), [(20.0, 0.02), (5.0, 0.02)])
    def test_has_an_end(self, grey, exposure):
        device = rows(bits=8, exposure=None)
        device.expose(pose(), even(grey))
        device.new_cycle()
        made = device.expose(pose(), even(grey))
        assert made.exposure == exposure
        assert (made.row2 == 2.0 * grey).all()

    def test_holds_between_cycles(self):
        device = rows(bits=8, exposure=None)
        device.expose(pose(), even(80.0))
        device.new_cycle()
        first = device.expose(pose(), even(80.0))
        darker = device.expose(pose(), even(40.0))
        assert darker.exposure == first.exposure == pytest.approx(0.01 * 110.0 / 80.0)
        assert (first.row1 == 110.0).all()
        assert (darker.row2 == 55.0).all()
        device.new_cycle()
        assert device.expose(pose(), even(40.0)).exposure == 0.02

    def test_black_or_missing_land_leaves_it(self):
        device = rows(bits=8, exposure=None)
        device.expose(pose(), even(80.0))
        device.expose(pose(), even(np.nan))
        device.new_cycle()
        assert device.expose(pose(), even(80.0)).exposure == pytest.approx(0.01 * 110.0 / 80.0)
        device.expose(pose(), even(0.0))
        device.new_cycle()
        assert device.expose(pose(), even(0.0)).exposure == pytest.approx(0.01 * 110.0 / 80.0)

    def test_a_given_exposure_stays(self):
        device = rows(bits=8, exposure=0.004)
        device.expose(pose(), even(80.0))
        device.new_cycle()
        assert device.expose(pose(), even(80.0)).exposure == 0.004


def test_what_row_two_reads_does_not_depend_on_row_one():
    always, never = rows(noise_grey=1.5, bits=8), rows(noise_grey=1.5, bits=8)
    land = spot(lambda x, y: 100.0 + 0.02 * x)
    for k in range(600):  # noise is drawn in blocks of 512
        a = always.expose(pose(), land)
        b = never.expose(pose(), land, ahead=k % 100 == 0)
        assert np.array_equal(a.row2, b.row2)
        assert a.number == b.number == k
        if k % 100 == 0:
            assert np.array_equal(a.row1, b.row1)
        else:
            assert not b.row1.any()


def test_same_generator_same_noise():
    first, again, other = (rows(noise_grey=2.0, seed=s).expose(pose(), even(90.0)).row1 for s in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_reach_covers_every_ray():
    device = rows(start_height=300.0)
    for tilt in np.radians([0.0, 10.0, 14.0]):
        for roll, pitch in ((tilt, 0.0), (0.0, tilt), (-tilt / 1.5, tilt / 1.5)):
            where = pose(0.7, pitch, roll, height=3300.0)
            rays = np.array([[x, y, FOCAL] for x in (-SPACING / 2, SPACING / 2) for y in (-54.5, 54.5)])
            d = rays @ where.mat_nc.T
            furthest = 3000.0 * np.hypot(d[:, 0], d[:, 1]) / d[:, 2]
            assert device.reach(3300.0) > furthest.max()


def texture(seed):
    """Random land of 6.4 km in cells of 8 m: noise smoothed over 12 m, contrast 30 grey levels."""
    rng = np.random.default_rng(seed)
    fine = gaussian_filter(rng.standard_normal((801, 801)), 1.5, mode="wrap")
    return np.asarray(128.0 + 30.0 * fine / fine.std(), np.float32)


@pytest.mark.parametrize("heading_deg", [0.0, 60.0, 215.0])
@pytest.mark.parametrize("mu", [-4, 0, 3])
def test_row_two_sees_after_n_exposures_what_row_one_saw(heading_deg, mu):
    # Straight and level at v, crab atan(mu/d): the land passes from row I to row II while the camera covers
    # d/f of its height along its axis, and mu/f across.  n = d/(f dt v/h cos(crab)), index in row I = index in
    # row II + mu.  Speed is such that n is whole.
    height, period, n = 2400.0, 0.05, 220
    crab, heading = math.atan2(mu, SPACING), math.radians(heading_deg)
    speed = SPACING / (FOCAL * period * n / height * math.cos(crab))
    track = heading + crab
    land = spot(lambda x, y: 0.0)
    land = land._replace(ortho=texture(4), ortho_place=np.array([EAST - 3200.0, NORTH + 3200.0, 8.0, -8.0]))
    device = rows(noise_grey=1.5, bits=8)

    def look(step):
        north, east = (speed * period * (step - n / 2) * f(track) for f in (math.cos, math.sin))
        here = land._replace(grid=np.array([EAST + east, NORTH + north, 0.0, 1.0, 1.0, 0.0]))
        where = pose(heading, height=height)._replace(
            vel_n=speed * np.array([math.cos(track), math.sin(track), 0])
        )
        return device.expose(where, here)

    kept = look(0).row1
    found = {}
    for k in range(n - 12, n + 13):
        row2 = look(k).row2
        for shift in range(-SHIFT, SHIFT + 1):
            found[k, shift] = float(np.corrcoef(kept[SHIFT + shift : SHIFT + shift + PIXELS], row2)[0, 1])
    assert found[n, mu] > 0.98
    best = max(found, key=found.get)
    assert abs(best[0] - n) <= 1  # a step is 0.2 px here
    assert best[1] == mu
    elsewhere = [c for (k, shift), c in found.items() if abs(k - n) > 8 or abs(shift - mu) > 2]
    assert max(elsewhere) < 0.8
