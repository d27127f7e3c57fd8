"""Calibration at the paper's setting: bias, efficiency, sigmas, lines, blunders, what is not observable."""

import numpy as np
import pytest
from oblique_flights import CAMERA, EXPECTED, POINT, SIGMAS, TRUE, control, flight

from aerosim import frames
from aerosim.errors import InputError
from aerosim.geolocation.calibrated import DEG, ControlPoints, guard
from aerosim.geolocation.calibration import calibrate
from aerosim.geolocation.chain import ObliqueCamera, Poses


def fitted(count, seed, *, wrong=0.0, by=200.0, **options):
    """A calibration and which rows were made blunders of `by` px in row and in column."""
    poses, pixel, line = flight(count, seed, **options)
    rng = np.random.default_rng(seed)
    bad = rng.random(count) < wrong
    pixel = np.clip(pixel + by * rng.choice([-1.0, 1.0], (count, 2)) * bad[:, None], 0.0, 4095.0)
    return calibrate(CAMERA, poses, pixel, control(seed), np.zeros(count, int), SIGMAS, line=line), bad


@pytest.fixture(scope="module")
def two_sided():
    return fitted(4000, 1)[0]


@pytest.fixture(scope="module")
def one_sided():
    return fitted(4000, 3, two_sided=False, spread=3.0)[0]


class TestEstimate:
    def test_the_papers_errors_come_back(self, two_sided):
        """4 sigma each; sigmas of the Cramer-Rao bound of an independent study of the same setting."""
        assert two_sided.names == ("boresight_yaw", "boresight_pitch", "roll_plus_alpha", "beta")
        assert np.abs(two_sided.values / DEG - EXPECTED) / (two_sided.sigma / DEG) == pytest.approx(0.0, abs=4.0)
        assert two_sided.sigma / DEG == pytest.approx([49e-5, 77e-5, 22e-5, 54e-5], rel=0.06)
        assert two_sided.observable == ("yes",) * 4
        assert two_sided.not_observable == ("roll_minus_alpha",)
        assert two_sided.used + len(two_sided.rejected) == 4000
        # the tail of chi-square of 2 beyond 11.83 is 0.27 %: 10.8 of 4000, three standard deviations about it
        assert len(two_sided.rejected) <= 21

    def test_without_noise_it_is_exact(self):
        poses, _, _ = flight(60, 5)
        from aerosim.geolocation.chain import pixels

        target = np.broadcast_to(frames.ecef_from_geodetic(*POINT), (60, 3))
        shown = pixels(CAMERA, poses, target, TRUE)
        inside = ((shown > 0.0) & (shown < 4095.0)).all(axis=1)
        exact = control(0, sigma=0.0)
        # a prior so wide that its pull is below 1e-6 of the answer
        found = calibrate(
            CAMERA, poses.rows(inside), shown[inside], exact, np.zeros(inside.sum(), int),
            SIGMAS._replace(correction=10.0 * DEG),
        )  # fmt: skip
        assert found.values / DEG == pytest.approx(EXPECTED, abs=1e-6)

    def test_same_shares_of_the_study_in_the_navigation_order(self):
        """All five are told apart only by the order in which the boresight turns n."""
        camera = ObliqueCamera(CAMERA.optics, CAMERA.boresight, CAMERA.antenna_b, boresight_on="navigation")
        poses, pixel, _ = flight(4000, 6, camera=camera)
        found = calibrate(camera, poses, pixel, control(6), np.zeros(4000, int), SIGMAS)
        assert found.observable == ("yes",) * 5
        assert found.not_observable == ()
        assert found.sigma / DEG == pytest.approx([49e-5, 29e-5, 29e-5, 22e-5, 46e-5], rel=0.1)
        expected = [0.030, -0.015, 0.012, 0.010, -0.020]
        assert np.abs(found.values / DEG - expected) / (found.sigma / DEG) == pytest.approx(0.0, abs=4.0)

    @pytest.mark.parametrize(("name", "field"), [("axis_tilt", "tilt"), ("detector_twist", "twist")])
    def test_optional_parameters(self, name, field):
        true = TRUE._replace(**{field: 0.05 * DEG})
        poses, _, _ = flight(600, 7, spread=60.0)
        from aerosim.geolocation.chain import pixels

        shown = pixels(CAMERA, poses, np.broadcast_to(frames.ecef_from_geodetic(*POINT), (600, 3)), true)
        inside = ((shown > 0.0) & (shown < 4095.0)).all(axis=1)
        found = calibrate(
            CAMERA, poses.rows(inside), shown[inside], control(0, 0.0), np.zeros(inside.sum(), int),
            SIGMAS._replace(correction=10.0 * DEG), extra=(name,),
        )  # fmt: skip
        assert found.names[-1] == name
        if name == "axis_tilt":  # told from the others by the picture's rotation only
            assert found.values[-1] / DEG == pytest.approx(0.05, abs=max(2e-3, 0.01 * found.sigma[-1] / DEG))
        else:
            assert found.values[-1] / DEG == pytest.approx(0.05, abs=2e-3)


class TestObservability:
    def test_one_sided_flight_is_weak(self, one_sided):
        """The study's sigmas without a prior: 0.093, 0.026, 0.0009, 0.097 deg."""
        assert one_sided.observable == ("weak", "weak", "yes", "weak")
        assert one_sided.alone / DEG == pytest.approx([0.0955, 0.0263, 0.00089, 0.0987], rel=0.15)
        assert (one_sided.sigma <= SIGMAS.correction * 1.0001).all()
        assert "weak" in one_sided.report()
        # the combination that is worst known is yaw against beta
        assert np.abs(one_sided.directions[-1]) == pytest.approx([0.7, 0.2, 0.0, 0.7], abs=0.05)

    def test_one_picture_leaves_directions_open(self):
        poses, pixel, _ = flight(1, 9)
        found = calibrate(CAMERA, poses, pixel, control(9), [0], SIGMAS)
        assert "yes" not in found.observable[:2]
        assert np.isinf(found.alone).sum() >= 2
        assert np.isinf(found.direction_sigmas[-2:]).all()
        assert (found.sigma <= SIGMAS.correction * 1.0001).all()

    def test_what_no_picture_says_has_no_number(self):
        """Looking along the axis of alpha with beta = 90 deg less nothing: roll and alpha turn about the sight."""
        north = Poses(0.0, 0.0, 5000.0, 0.0, 0.0, 0.0, 0.0, np.pi / 2.0)
        camera = ObliqueCamera(CAMERA.optics)
        target = ControlPoints(
            frames.ecef_from_geodetic(0.0, 0.0, 5000.0)[None] + [[0.0, 0.0, 20_000.0]], np.zeros(1)
        )
        found = calibrate(camera, north, [[2060.3, 2031.8]], target, [0], SIGMAS, atmosphere=None)
        assert found.observable[2] == "no"
        assert found.sigma[2] == pytest.approx(SIGMAS.correction)
        line = next(text for text in found.report().splitlines() if text.startswith("roll_plus_alpha"))
        assert line == "roll_plus_alpha: not observable, sigma = prior sigma 0.0300 deg"

    def test_guard_knows_the_other_side(self, one_sided, two_sided):
        """Study, one-sided fit: same geometry 0.0005 deg across, left and right mixed 0.17 without the prior."""
        same, px, _ = flight(300, 20, two_sided=False, spread=3.0)
        other = Poses(same.lat, same.lon, same.height, same.heading, same.pitch, same.roll, -same.alpha, same.beta)
        here, there = (guard(one_sided, CAMERA, p, px, SIGMAS) for p in (same, other))
        assert not here.unseen.any()
        assert there.unseen.all()
        assert np.median(here.across) / DEG < 0.001
        assert np.median(there.across) / DEG > 0.02
        assert not guard(two_sided, CAMERA, other, px, SIGMAS).unseen.any()


class TestRobust:
    def test_blunders_are_found(self):
        """5 %, 200 px in row and column: 7 sigma of the elevation, whose share of 200 px is never small."""
        found, bad = fitted(4000, 12, wrong=0.05)
        assert bad[found.rejected].sum() >= 0.95 * bad.sum()
        assert (~bad)[found.rejected].sum() <= 21
        assert np.abs(found.values / DEG - EXPECTED) / (found.sigma / DEG) == pytest.approx(0.0, abs=4.0)

    def test_lines_widen_the_sigmas(self):
        """Yaw: 0.03 deg / sqrt(20 lines) x sqrt(0.7), not / sqrt(1000 pictures)."""
        found, _ = fitted(1000, 13, lines=20, white=0.3)
        assert found.sigma[0] / DEG == pytest.approx(0.03 * np.sqrt(0.7 / 20), rel=0.4)
        assert np.abs(found.values / DEG - EXPECTED) / (found.sigma / DEG) == pytest.approx(0.0, abs=4.0)
        shared, own = found.line_share
        assert 0.4 <= shared <= 1.3
        assert own == pytest.approx(0.3, abs=0.11)

    def test_few_points_use_the_prior(self):
        found, _ = fitted(3, 14)
        assert found.used + len(found.rejected) == 3
        assert (found.sigma <= SIGMAS.correction).all()

    def test_points_of_their_own(self):
        """300 points, 30 m each: about 1 mrad at 28 to 50 km, against 0.18 mrad of roll and pitch."""
        poses, pixel, _ = flight(300, 15)
        point = control(15, sigma=0.0)
        many = ControlPoints(np.repeat(point.pos_e, 300, axis=0), np.full(300, 30.0))
        vague = calibrate(CAMERA, poses, pixel, many, np.arange(300), SIGMAS)
        sharp = calibrate(CAMERA, poses, pixel, point, np.zeros(300, int), SIGMAS)
        assert vague.sigma[2] > 3.0 * sharp.sigma[2]


def many(runs, count, **options):
    """Errors in sigmas (runs, 4), their rms over the sigmas', and the first of them."""
    found = [fitted(count, 2000 + k, **options)[0] for k in range(runs)]
    error = np.array([f.values for f in found]) / DEG - EXPECTED
    sigma = np.array([f.sigma for f in found]) / DEG
    return error, sigma


@pytest.mark.slow
class TestMonteCarlo:
    """Runs: 200.  A mean of so many standardised errors has a standard deviation of 0.07, a variance one of
    0.10."""

    @pytest.mark.parametrize("options", [{}, {"lines": 20, "white": 0.3}])
    def test_unbiased_efficient_and_honest(self, options):
        error, sigma = many(200, 2000, **options)
        standard = error / sigma
        assert np.abs(standard.mean(axis=0)).max() < 4.0 * 0.07 * 1.2
        # sigma is the Cramer-Rao bound of the true model where factors of lines are known; with 200 runs the
        # rms of one parameter has a standard deviation of 5 %, the mean over four less: 1.15 for the mean, 1.25
        # for the worst
        rms = np.sqrt((error**2).mean(axis=0) / (sigma**2).mean(axis=0))
        assert np.sqrt((rms**2).mean()) < 1.15
        assert rms.max() < 1.25
        variance = (standard**2).mean(axis=0)
        assert 0.8 < variance.mean() < 1.25

    def test_blunders_cost_little(self):
        error, sigma = many(100, 2000, wrong=0.05)
        assert np.sqrt(((error / sigma) ** 2).mean()) < 1.15


class TestBadInput:
    def given(self):
        poses, pixel, _ = flight(20, 30)
        return poses, pixel, control(30), np.zeros(20, int)

    def call(self, poses, pixel, points, point, sigmas=SIGMAS, **options):
        return calibrate(CAMERA, poses, pixel, points, point, sigmas, **options)

    def test_control_points(self):
        poses, pixel, points, point = self.given()
        two = ControlPoints(np.repeat(points.pos_e, 2, axis=0), np.zeros(2))
        with pytest.raises(InputError, match="control point 1 is in no picture"):
            self.call(poses, pixel, two, point)
        with pytest.raises(InputError, match="no control point 1"):
            self.call(poses, pixel, points, point + 1)
        with pytest.raises(InputError, match="not a finite number"):
            self.call(poses, pixel, ControlPoints(points.pos_e * np.nan, points.sigma), point)
        with pytest.raises(InputError, match="one row or more"):
            self.call(poses, pixel, points, point[:5])
        swapped = ControlPoints(
            frames.ecef_from_geodetic(POINT[1] - np.pi / 2, POINT[0], 3132.0)[None], np.zeros(1)
        )
        with pytest.raises(InputError, match=r"row 0: the control point is .* km away .*swapped"):
            self.call(poses, pixel, swapped, point)

    def test_signs_that_do_not_fit(self):
        poses, pixel, points, point = self.given()
        mirrored = Poses(
            poses.lat, poses.lon, poses.height, poses.heading, poses.pitch, poses.roll, -poses.alpha, poses.beta
        )
        with pytest.raises(InputError, match="do not look at their control points"):
            self.call(mirrored, pixel, points, point)

    def test_sigmas_and_names(self):
        given = self.given()
        for bad in (SIGMAS._replace(heading=-1.0), SIGMAS._replace(position=(1.0, np.nan, 1.0))):
            with pytest.raises(InputError, match="sigma: a standard deviation is negative or not finite"):
                self.call(*given, sigmas=bad)
        with pytest.raises(InputError, match="sigma: a standard deviation of zero"):
            self.call(*given, sigmas=SIGMAS._replace(correction=0.0))
        with pytest.raises(InputError, match="extra: unknown parameter 'focal'"):
            self.call(*given, extra=("focal",))
