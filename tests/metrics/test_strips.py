"""What a strip ought to have said, against closed forms of made-up flights."""

from __future__ import annotations

import numpy as np
import pytest

from aerosim.estimation.motion import UNUSED, MotionParameters
from aerosim.metrics.strips import strip_table, strip_truth
from aerosim.recorder import Samples
from aerosim.signals import Reason, StripMatch, StripUse

LAT0, LON0, HEIGHT, GROUND = np.radians(36.5), np.radians(-84.2), 3400.0, 400.0
A, F = 6378137.0, 1.0 / 298.257223563
SPACING, FOCAL, PERIOD = 39.7, 132.6, 0.05


def position(north: np.ndarray, east: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Latitude and longitude at distances from the start: radii of curvature of WGS-84, by the textbook."""
    e2 = F * (2 - F)
    w = np.sqrt(1 - e2 * np.sin(LAT0) ** 2)
    meridian, normal = A * (1 - e2) / w**3, A / w
    return LAT0 + north / (meridian + HEIGHT), LON0 + east / ((normal + HEIGHT) * np.cos(LAT0))


def samples(speed: float, track: np.ndarray, heading: np.ndarray, mount: np.ndarray, dt: float = 0.05) -> Samples:
    """A flight of constant speed along a track (rad), from t = 0; one value each sample."""
    t = dt * np.arange(len(track))
    # midpoints: the direction of each step's way
    middle = np.r_[track[0], (track[1:] + track[:-1]) / 2]
    step = np.r_[0.0, np.full(len(t) - 1, speed * dt)]
    lat, lon = position(np.cumsum(step * np.cos(middle)), np.cumsum(step * np.sin(middle)))
    whole = np.ones(len(t))
    return Samples({
        "t": t, "lat": lat, "lon": lon, "height": HEIGHT * whole, "heading": heading, "mount_yaw": mount,
        "strip": GROUND * whole,
    })  # fmt: skip


def straight(crab_deg: float, yaw_deg: float = 0.0, course_deg: float = 50.0, speed: float = 69.4) -> Samples:
    whole = np.ones(601)
    track, drift = np.radians(course_deg) * whole, np.radians(crab_deg + yaw_deg)
    heading = np.angle(np.exp(1j * (track - drift)))
    return samples(speed, track, heading, np.radians(yaw_deg) * whole)


T1, T2 = np.array([4.0, 10.0]), np.array([16.9, 22.9])


@pytest.mark.parametrize("course", [0.0, 90.0, 179.0, 181.0, 303.0])
@pytest.mark.parametrize(("crab", "yaw"), [(8.3, 0.0), (-1.5, 9.0), (0.0, -8.3)])
def test_straight_flight_with_crab(course: float, crab: float, yaw: float) -> None:
    flown = straight(crab, yaw, course)
    for on_camera, angle in ((True, crab), (False, crab + yaw)):
        seen, vh = strip_truth(T1, T2, flown, on_camera)
        # over 1.6 km the meridians turn by 0.01 deg
        np.testing.assert_allclose(np.degrees(seen), angle, atol=0.02)
        np.testing.assert_allclose(vh, 69.4 / (HEIGHT - GROUND), rtol=1e-4)


def test_a_turning_aircraft_counts_at_its_ends_only() -> None:
    """mu = d (mean track - mean of the headings at the two exposures): studied for this camera."""
    t = 0.05 * np.arange(601)
    track = np.radians(50.0) * np.ones(601)
    swing = np.radians(5.0) * np.sin(2 * np.pi * (t - T1[0]) / (T2[0] - T1[0]))  # nothing at both ends
    bulge = np.radians(3.0) * np.sin(np.pi * (t - T1[0]) / (T2[0] - T1[0]))  # nothing there, mean 1.9 deg
    ramp = np.radians(4.0) * (t - T1[0]) / (T2[0] - T1[0])  # 0 to 4 deg: the mean of the ends is 2
    for turn, angle in ((swing, 0.0), (bulge, 0.0), (ramp, -2.0)):
        for heading, mount, on_camera in ((track + turn, 0 * t, False), (track, turn, True), (track, turn, False)):
            seen, _ = strip_truth(T1[:1], T2[:1], samples(69.4, track, heading, mount), on_camera)
            wanted = angle if (heading is not track or on_camera) else 0.0
            assert np.degrees(seen[0]) == pytest.approx(wanted, abs=0.02)


def test_a_turning_track_counts_by_its_mean() -> None:
    """Along an arc the chord's direction is the mean of the tracks, its length R times 2 sin(half the turn)."""
    t = 0.05 * np.arange(601)
    rate, heading = np.radians(1.0), np.radians(20.0)
    track = heading + rate * (t - T1[0])
    flown = samples(69.4, track, heading * np.ones(601), 0 * t)
    seen, vh = strip_truth(T1[:1], T2[:1], flown, False)
    turned = rate * (T2[0] - T1[0])
    assert seen[0] == pytest.approx(turned / 2, abs=2e-4)
    chord = 2 * (69.4 / rate) * np.sin(turned / 2)
    assert vh[0] == pytest.approx(chord / (T2[0] - T1[0]) / (HEIGHT - GROUND), rel=1e-4)


def test_headings_through_north_are_one_direction() -> None:
    t = 0.05 * np.arange(601)
    heading = np.angle(np.exp(1j * np.radians(178.0 + 4.0 * (t - T1[0]) / (T2[0] - T1[0]))))  # 178 to -178 deg
    seen, _ = strip_truth(T1[:1], T2[:1], samples(69.4, np.radians(180.0) * np.ones(601), heading, 0 * t), False)
    assert np.degrees(seen[0]) == pytest.approx(0.0, abs=0.02)


def test_height_is_above_the_strip_at_mid_time() -> None:
    flown = straight(0.0)
    rising = 300.0 + 10.0 * flown.t
    _, vh = strip_truth(T1, T2, Samples(flown.values | {"strip": rising}), True)
    np.testing.assert_allclose(vh, 69.4 / (HEIGHT - 300.0 - 10.0 * (T1 + T2) / 2), rtol=1e-4)


def test_a_strip_that_was_never_found_has_no_truth() -> None:
    seen, vh = strip_truth(np.array([4.0]), np.array([np.nan]), straight(5.0), True)
    assert np.isnan(seen).all()
    assert np.isnan(vh).all()
    one = Samples({name: column[:1] for name, column in straight(5.0).values.items()})
    assert np.isnan(strip_truth(T1, T2, one, True)).all()


PARAMETERS = MotionParameters(
    spacing_px=SPACING, focal_px=FOCAL, period=PERIOD, on_camera=True, right_cosine=True, series="riccati",
    walk_drift=1e-4, sigma_drift=0.1, gamma_drift=None, walk_vh=1e-4, sigma_vh=0.05, gamma_vh=None,
    strip_period=1.0,
)  # fmt: skip


def match(strip: int, reason: Reason, n: float, mu: float) -> StripMatch:
    surface = np.zeros((1, 15), np.float32)
    t2 = 4.0 + PERIOD * n
    return StripMatch(strip, 80, 4.0, t2, t2 + 0.7, n, mu, 2.5, 0.14, 0.16, reason, 150, surface)


def test_table_of_a_perfect_strip_and_of_a_lost_one() -> None:
    crab, yaw = 3.0, np.degrees(0.15)
    flown = straight(crab, yaw)
    # the strip that a perfect matcher would find: (1) with the crab's cosine, and the shift of that angle
    vh = 69.4 / (HEIGHT - GROUND)
    n = SPACING / (FOCAL * PERIOD * vh * np.cos(np.radians(crab)))
    mu = SPACING * np.tan(np.radians(crab))
    use = StripUse(0.5, 0.4, 1.5, -0.5, np.radians(1.0) ** 2, 1e-6)
    lost = match(1, Reason.TIMEOUT, np.nan, np.nan)._replace(yaw2=np.nan, mad_min=np.nan)
    table = strip_table([(match(0, Reason.ACCEPTED, n, mu), use), (lost, UNUSED)], flown, PARAMETERS)
    assert table["strip"].tolist() == [0, 1]
    assert table["accepted"].tolist() == [True, False]
    assert table["reason"].tolist() == ["accepted", "timeout"]
    assert [type(reason) for reason in table["reason"]] == [str, str]
    row = {name: column[0] for name, column in table.items() if name != "reason"}
    assert row["angle_deg"] == pytest.approx(row["crab_true_deg"], abs=0.02)
    assert row["angle_deg"] == pytest.approx(crab, abs=1e-9)
    assert row["drift_deg"] == pytest.approx(crab + yaw, abs=1e-9)
    assert row["vh_per_s"] == pytest.approx(vh, rel=1e-12)
    assert row["vh_per_s"] == pytest.approx(row["vh_true_per_s"], rel=1e-4)
    assert row["n_true"] == pytest.approx(n, rel=1e-4)
    assert row["variance_drift_deg2"] == pytest.approx(1.0)
    assert (row["gain_drift"], row["gain_vh"]) == (0.5, 0.4)
    assert (row["innovation_drift"], row["innovation_vh"]) == (1.5, -0.5)
    for name in ("n", "mu_px", "angle_deg", "drift_deg", "vh_per_s", "crab_true_deg", "vh_true_per_s", "n_true"):
        assert np.isnan(table[name][1]), name


def test_no_strips_no_rows() -> None:
    table = strip_table([], straight(0.0), PARAMETERS)
    assert {len(column) for column in table.values()} == {0}
