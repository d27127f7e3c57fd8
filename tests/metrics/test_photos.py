"""The photo table: columns, signs, blur, verdicts."""

import numpy as np
import pytest
from photo_world import CAMERA, HALF_ANGLE, LAT, LON, flat, ground_of, pose_at, shot, window_of

from aerosim.metrics.blur import blur, image_motion
from aerosim.metrics.photos import PERIOD_PRACTICE, Tolerances, photo_table

POSE = [("lat", "deg"), ("lon", "deg"), ("height", "m"), ("roll", "deg"), ("pitch", "deg"), ("heading", "deg")]
CORNERS = ["front_left", "front_right", "rear_right", "rear_left"]
CONTRACT = [
    *["photo", "t_s", "line"],
    *[f"{name}_{kind}_{unit}" for kind in ("true", "measured", "smoothed") for name, unit in POSE],
    *["interval_s", "end_lap_pct", "end_lap_terrain_pct", "crab_deg", "tilt_deg", "blur_px", "fmc_deg_s", "gsd_m"],
    *[f"corner_{corner}_{axis}_deg" for corner in CORNERS for axis in ("lat", "lon")],
    *["verdict", "file"],
]
EXPOSURE = 0.003
# Of true east, as the grid sees it: its north is turned clockwise against true north by dlon sin(lat).
TILT = -np.radians(2.7) * np.sin(LAT)
RATE = 70.0 / 3000.0
ANYTHING = Tolerances(1.0, 3.0, 4.0, 1e9)


def one(**how):
    fmc = how.pop("fmc_rate", RATE)
    table = photo_table([shot(pose_at((0.0, 0.0, 0.0), **how), fmc_rate=fmc)], CAMERA, EXPOSURE, flat())
    return {name: values[0] for name, values in table.items()}


def test_every_column_of_the_contract_one_value_a_photo() -> None:
    shots = [
        shot(pose_at((north, 0.0, 0.0)), line)
        for north, line in ((0.0, 0), (1800.0, 0), (3600.0, 1), (0.0, -1), (9.0, -1))
    ]
    table = photo_table(shots, CAMERA, EXPOSURE, flat())
    assert [name for name in table if name != "terrain_mean_height_m"] == CONTRACT
    assert {len(values) for values in table.values()} == {5}
    assert table["photo"].tolist() == [0, 1, 2, 3, 4]
    # Only the second photo has one before it on its line; turns are no line.
    assert np.isfinite(table["end_lap_pct"]).tolist() == [False, True, False, False, False]
    assert np.isfinite(table["end_lap_terrain_pct"]).tolist() == [False, True, False, False, False]
    assert table["end_lap_pct"][1] == pytest.approx(
        100.0 * (1.0 - 1800.0 * CAMERA.focal_px / 3000.0 / CAMERA.rows), abs=0.03
    )
    assert np.isnan(table["lat_measured_deg"]).all()
    assert table["file"] == [None] * 5


def test_no_photos_make_an_empty_table() -> None:
    table = photo_table([], CAMERA, EXPOSURE, flat())
    assert {len(values) for values in table.values()} == {0}


def test_pose_and_corners_in_degrees() -> None:
    assert one(attitude_deg=(-90.0, 2.0, -1.0))["heading_true_deg"] == pytest.approx(270.0)
    row = one(attitude_deg=(90.0, 2.0, -1.0))
    np.testing.assert_allclose(
        [row[f"{n}_true_deg"] for n in ("lat", "lon", "heading", "pitch", "roll")],
        [np.degrees(LAT), np.degrees(LON), 90.0, 2.0, -1.0],
        atol=1e-9,
    )
    assert row["height_true_m"] == pytest.approx(3300.0, abs=1e-6)
    # Flown east: the left edge of the picture is in the north, the front edge in the east.
    assert row["corner_front_left_lat_deg"] > row["lat_true_deg"] > row["corner_front_right_lat_deg"]
    assert row["corner_front_left_lon_deg"] > row["lon_true_deg"] > row["corner_rear_left_lon_deg"]


def test_gsd_is_the_height_over_the_mean_ground_by_the_focal_length() -> None:
    assert one()["gsd_m"] == pytest.approx(3000.0 * 12e-6 / 0.153, rel=1e-9)
    # Ground that rises by 0.1 eastward: the rays with tangents -a and a end at x = 2800 t / (1 + 0.1 t), and the
    # footprint is as wide there as the depth 2800 - 0.1 x: the mean over its area.
    ground = ground_of(window_of(lambda x, y: 500.0 + 0.1 * (x * np.cos(TILT) + y * np.sin(TILT))))
    table = photo_table([shot(pose_at((0.0, 0.0, 0.0)))], CAMERA, EXPOSURE, ground)
    x = np.linspace(*(2800.0 * t / (1.0 + 0.1 * t) for t in (-np.tan(HALF_ANGLE), np.tan(HALF_ANGLE))), 100_001)
    mean = 500.0 + 0.1 * np.average(x, weights=2800.0 - 0.1 * x)
    assert table["terrain_mean_height_m"][0] == pytest.approx(mean, abs=0.5)
    assert table["gsd_m"][0] == pytest.approx((3300.0 - mean) * 12e-6 / 0.153, rel=2e-4)


@pytest.mark.parametrize(
    ("heading", "vel", "crab"),
    [(85.0, (0.0, 70.0, 0.0), 5.0), (95.0, (0.0, 70.0, 3.0), -5.0), (-175.0, (-70.0, 6.1241, 0.0), -10.0)],
)
def test_crab_is_track_less_camera_heading(heading: float, vel: tuple[float, float, float], crab: float) -> None:
    assert one(attitude_deg=(heading, 0.0, 0.0), vel_n=vel)["crab_deg"] == pytest.approx(crab, abs=1e-3)


def test_tilt_is_the_angle_of_the_optical_axis() -> None:
    # cos(tilt) = cos(pitch) cos(roll)
    expected = np.degrees(np.arccos(np.cos(np.radians(2.0)) * np.cos(np.radians(-1.5))))
    assert one(attitude_deg=(123.0, 2.0, -1.5))["tilt_deg"] == pytest.approx(expected, abs=1e-9)
    assert one()["tilt_deg"] == pytest.approx(0.0, abs=1e-9)


def test_compensation_cancels_level_flight_and_leaves_what_v_h_is_wrong() -> None:
    # Uncompensated, the image runs by v t / GSD; corners lie 1 m lower (the Earth's curve): 4e-4 of it remain.
    whole = 70.0 * EXPOSURE / (3000.0 * 12e-6 / 0.153)
    assert one(fmc_rate=0.0)["blur_px"] == pytest.approx(whole, rel=1e-4)
    assert one()["blur_px"] == pytest.approx(0.0, abs=1e-3 * whole)
    assert one(fmc_rate=0.9 * RATE)["blur_px"] == pytest.approx(0.1 * whole, rel=5e-3)
    assert one(fmc_rate=0.9 * RATE)["fmc_deg_s"] == pytest.approx(np.degrees(0.9 * RATE))
    assert one(fmc_rate=1.1 * RATE)["blur_px"] == pytest.approx(0.1 * whole, rel=5e-3)


def test_crab_leaves_the_motion_across() -> None:
    # |(1 - cos c, sin c)| = 2 sin(c/2) of the whole motion.
    whole = 70.0 * EXPOSURE / (3000.0 * 12e-6 / 0.153)
    found = one(attitude_deg=(-6.0, 0.0, 0.0))["blur_px"]
    assert found == pytest.approx(whole * 2.0 * np.sin(np.radians(3.0)), rel=5e-3)


def motion_at(
    pixel: tuple[float, float],
    rates: tuple[float, float, float],
    vel: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> list[float]:
    pose = pose_at((0.0, 0.0, 0.0), rates=rates, vel_n=vel)
    return image_motion(CAMERA, pose, CAMERA.rays([pixel]), np.array([3000.0]), 0.0)[0].tolist()


def test_signs_of_image_motion() -> None:
    f, middle, half = CAMERA.focal_px, tuple(CAMERA.centre), CAMERA.rows / 2.0
    assert motion_at(middle, (0.0, 0.0, 0.0), (70.0, 0.0, 0.0)) == pytest.approx([-f * RATE, 0.0])
    assert motion_at(middle, (0.0, 0.0, 0.0), (0.0, 70.0, 0.0)) == pytest.approx([0.0, -f * RATE])
    assert motion_at(middle, (0.0, 0.02, 0.0)) == pytest.approx([-f * 0.02, 0.0])
    assert motion_at(middle, (0.02, 0.0, 0.0)) == pytest.approx([0.0, f * 0.02])
    assert motion_at(middle, (0.0, 0.0, 0.02)) == pytest.approx([0.0, 0.0])
    assert motion_at((-0.5, middle[1]), (0.0, 0.0, 0.02)) == pytest.approx([0.0, -half * 0.02])
    # Sinking makes the picture grow: the front edge moves forward.
    assert motion_at((-0.5, middle[1]), (0.0, 0.0, 0.0), (0.0, 0.0, 3.0)) == pytest.approx([half * 0.001, 0.0])


def test_image_motion_is_the_derivative_of_the_projection() -> None:
    # A fixed ground point seen by the camera a millisecond earlier and later; rotation R exp(omega_nc_c t).
    rates, vel = np.array([0.03, -0.05, 0.04]), np.array([65.0, 10.0, -2.0])
    pose = pose_at((0.0, 0.0, 0.0), (20.0, 2.0, -3.0), tuple(vel), tuple(rates))
    pixel, depth, h = np.array([4000.0, 15000.0]), 2900.0, 1e-3
    point_n = pose.mat_nc @ (CAMERA.rays(pixel) * depth / CAMERA.focal_px)
    cross = np.array([[0.0, -rates[2], rates[1]], [rates[2], 0.0, -rates[0]], [-rates[1], rates[0], 0.0]])
    seen = [CAMERA.pixels((point_n - vel * t) @ pose.mat_nc @ (np.eye(3) + cross * t)) for t in (-h, h)]
    row_rate, col_rate = (seen[1] - seen[0]) / (2.0 * h)
    found = image_motion(CAMERA, pose, CAMERA.rays([pixel]), np.array([depth]), 0.0)[0]
    np.testing.assert_allclose(found, [-row_rate, col_rate], rtol=1e-4)


def test_yaw_rate_blurs_only_away_from_the_middle() -> None:
    pose = pose_at((0.0, 0.0, 0.0), rates=(0.0, 0.0, 0.02))
    corner = DEPTHS @ pose.mat_nc.T
    assert blur(CAMERA, pose, corner[:1], EXPOSURE, RATE) == pytest.approx(0.0, abs=1e-9)
    expected = EXPOSURE * 0.02 * CAMERA.rows / np.sqrt(2.0)
    assert blur(CAMERA, pose, corner, EXPOSURE, RATE) == pytest.approx(expected, rel=1e-9)
    assert one(rates=(0.0, 0.0, 0.02))["blur_px"] == pytest.approx(expected, rel=2e-3)


DEPTHS = 3000.0 * np.array([[0.0, 0.0, 1.0], [np.tan(HALF_ANGLE), np.tan(HALF_ANGLE), 1.0]])


@pytest.mark.parametrize(("rates", "along", "across"), [((0.0, 0.02, 0.0), 1, 0), ((0.02, 0.0, 0.0), 0, 1)])
def test_pitch_and_roll_rate_blur_most_in_the_corners(
    rates: tuple[float, float, float], along: int, across: int
) -> None:
    # At tangents (a, b) a pitch rate moves the image by (1 + a^2, a b) f rate, a roll rate by (a b, 1 + b^2).
    a = np.tan(HALF_ANGLE)
    expected = EXPOSURE * 0.02 * CAMERA.focal_px * np.hypot(1.0 + a * a, a * a)
    assert one(rates=rates)["blur_px"] == pytest.approx(expected, rel=2e-3)
    assert along + across == 1


def verdicts(shots, ground=None, **how):
    return photo_table(shots, CAMERA, EXPOSURE, ground or flat(), **how)["verdict"]


def pair(base: float, **how):
    return [shot(pose_at((0.0, 0.0, 0.0)), fmc_rate=RATE), shot(pose_at((base, 0.0, 0.0), **how), fmc_rate=RATE)]


def test_verdicts_are_those_of_the_period() -> None:
    length = 3000.0 * CAMERA.rows / CAMERA.focal_px
    assert verdicts(pair(0.40 * length)) == ["ok", "ok"]
    assert verdicts(pair(0.445 * length)) == ["ok", "ok"]
    assert verdicts(pair(0.456 * length)) == ["ok", "end_lap"]
    assert verdicts(pair(0.344 * length)) == ["ok", "end_lap"]
    assert verdicts(pair(0.20 * length), wanted_end_lap=0.8) == ["ok", "ok"]
    assert verdicts(pair(0.40 * length, attitude_deg=(0.0, 0.0, 2.9))) == ["ok", "ok"]
    assert verdicts(pair(0.40 * length, attitude_deg=(0.0, 0.0, 3.1))) == ["ok", "tilt"]
    assert verdicts(pair(0.40 * length, attitude_deg=(4.9, 0.0, 0.0))) == ["ok", "ok"]
    assert verdicts(pair(0.40 * length, attitude_deg=(5.1, 0.0, 0.0))) == ["ok", "crab"]
    assert verdicts(pair(0.40 * length, attitude_deg=(-5.1, 0.0, 3.1))) == ["ok", "tilt"]
    assert verdicts(pair(0.40 * length, rates=(0.0, 0.0, 0.02))) == ["ok", "blur"]
    assert verdicts(pair(0.5 * length, rates=(0.0, 0.0, 0.02)), tolerances=ANYTHING) == ["ok", "ok"]
    assert PERIOD_PRACTICE.blur == 0.5


def test_a_photo_that_leaves_the_terrain_says_so_first() -> None:
    window = window_of(lambda x, y: np.where(y > 3000.0, np.nan, 300.0))
    table = photo_table(pair(1800.0, attitude_deg=(9.0, 0.0, 9.0)), CAMERA, EXPOSURE, ground_of(window))
    assert table["verdict"] == ["ok", "outside_terrain"]
    assert np.isnan(table["corner_front_left_lat_deg"][1])
    assert np.isfinite(table["corner_rear_left_lat_deg"][1])
    assert np.isnan([table[n][1] for n in ("end_lap_pct", "end_lap_terrain_pct", "blur_px", "gsd_m")]).all()
