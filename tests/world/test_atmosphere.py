"""The air put together: one generator each, nothing moved by another component, slow wind, wind by height."""

import itertools
import math
from functools import partial

import numpy as np
import pytest

from aerosim.rng import generator
from aerosim.world.atmosphere import GaussMarkov, make_air
from aerosim.world.gusts import CosineGust
from aerosim.world.mesoscale import Mesoscale
from aerosim.world.thermals import Thermal, ThermalField
from aerosim.world.turbulence import Turbulence
from aerosim.world.wind import Level, WindField, steady_wind

LAT, LON, HEIGHT = math.radians(47.0), math.radians(8.0), 3000.0
SLOW = {"gauss_markov": GaussMarkov(1.5, 120.0), "mesoscale": Mesoscale(), "none": None}
GUSTY = {
    "dryden": Turbulence.equal("dryden", 0.7, 533.4),
    "von_karman": Turbulence.equal("von_karman", 0.7, 762.0),
    "none": None,
}
PARTS = {
    "slow": SLOW["gauss_markov"],
    "turbulence": GUSTY["dryden"],
    "gusts": (CosineGust(1.0, 3.0, 2.0, 1.0, -1.0),),
    "thermals": (Thermal(LAT, LON, 800.0, 2.0),),
    "thermal_field": ThermalField(1e-6, 300.0, 2.0),
    "wind": WindField([Level(0.0, 9.0, 1.0)], exponent=0.15),
}


def made(seed=1, *, dt=0.025, rng_of=None, **more):
    kind = {"wind": steady_wind(0.0, 0.0), **more}
    return make_air(
        origin=(LAT, LON),
        height=HEIGHT,
        airspeed=69.44,
        span=19.81,
        dt=dt,
        rng_of=rng_of or partial(generator, seed),
        **kind,
    )


def table(air, steps, speed=69.44):
    """States along a path eastwards."""
    metres = speed * air.dt / (6.39e6 * math.cos(LAT))
    return np.array([air.at(step, lambda step=step: (LAT, LON + step * metres, HEIGHT)) for step in range(steps)])


def test_no_two_components_share_a_generator():
    for slow, gusty in itertools.product(SLOW.values(), GUSTY.values()):
        names = []

        def rng_of(name, names=names):
            names.append(name)
            return generator(1, name)

        made(rng_of=rng_of, slow=slow, turbulence=gusty, thermal_field=PARTS["thermal_field"])
        assert len(names) == len(set(names))
        assert (
            len(names) == {GaussMarkov: 2, Mesoscale: 1, type(None): 0}[type(slow)] + 4 * (gusty is not None) + 1
        )
        # seeds are made from 32 bits of the names
        starts = [generator(1, name).random() for name in names]
        assert len(set(starts)) == len(names)


@pytest.mark.parametrize("part", list(PARTS))
@pytest.mark.parametrize("slow", ["gauss_markov", "mesoscale"])
@pytest.mark.parametrize("gusty", ["dryden", "von_karman"])
def test_one_component_more_moves_no_other(part, slow, gusty):
    # The air of all components is that without one and this one's: bit for bit the same draws, so that only the
    # rounding of the sums is left.
    whole = {**PARTS, "slow": SLOW[slow], "turbulence": GUSTY[gusty]}
    without = {name: value for name, value in whole.items() if name != part}
    all_of_it, rest = table(made(3, **whole), 600), table(made(3, **without), 600)
    wind = table(made(3, wind=whole["wind"]), 600)
    alone = table(made(3, **{"wind": whole["wind"], part: whole[part]}), 600)
    if part == "wind":  # it carries mesoscale wind along; by the clock nothing changes
        assert np.array_equal(all_of_it[:, 3:], rest[:, 3:])
        if slow == "gauss_markov":
            assert all_of_it[:, :3] == pytest.approx(rest[:, :3] + wind[:, :3], abs=1e-12)
        return
    assert np.abs(alone - wind).max() > 0.0
    assert np.array_equal(all_of_it[:, 3:], (alone if part == "turbulence" else rest)[:, 3:])
    assert all_of_it[:, :3] == pytest.approx((rest + alone - wind)[:, :3], abs=1e-12)


def test_same_seed_same_air_other_seed_other_air():
    kind = {"slow": SLOW["mesoscale"], "turbulence": GUSTY["von_karman"], "thermal_field": PARTS["thermal_field"]}
    first, again, other = (table(made(seed, **kind), 600) for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert (first != other)[1:].all()


def test_components_of_no_strength_draw_nothing():
    def rng_of(name):
        raise AssertionError(name)

    air = made(
        rng_of=rng_of,
        wind=steady_wind(5.0, 270.0),
        slow=GaussMarkov(0.0, 120.0),
        turbulence=Turbulence.equal("dryden", 0.0, 533.4),
        thermal_field=ThermalField(0.0, 200.0, 2.0),
    )

    def nowhere():
        raise AssertionError("the place was asked for")

    assert air.at(1000, nowhere)[:3] == pytest.approx((0.0, 5.0, 0.0))


@pytest.mark.parametrize("gusty", ["dryden", "von_karman"])
def test_gusts_scale_with_sigma_and_keep_their_shape(gusty):
    kind = GUSTY[gusty]
    small, large = (
        table(made(5, turbulence=kind._replace(sigma_u=sigma, sigma_w=sigma)), 600)[:, 3:] for sigma in (0.5, 2.0)
    )
    assert large == pytest.approx(4.0 * small, rel=1e-9)


def test_slow_wind_has_its_sigma_and_time_constant():
    # D/T = 4000: sd of a variance sqrt(2 T/D) = 2.2 %, of the correlation at T at most sqrt(T/D) = 1.6 %, of a
    # correlation of two independent ones sqrt(T/D); 4.5 of them.
    steps = 40_000
    air = table(made(7, dt=1.0, wind=steady_wind(5.0, 180.0), slow=GaussMarkov(1.5, 10.0)), steps)
    slow = air[:, :2] - (5.0, 0.0)
    assert not air[:, 2:].any()
    for component in slow.T:
        variance = float(np.mean(component**2))
        assert variance == pytest.approx(1.5**2, rel=0.10)
        assert np.mean(component[10:] * component[:-10]) / variance == pytest.approx(math.exp(-1.0), abs=0.07)
    assert abs(np.mean(slow[:, 0] * slow[:, 1])) / 1.5**2 < 0.07


def test_slow_wind_lets_the_drift_wander_as_the_study_says():
    # sigma 1.5 m/s and 120 s: the heading of an aircraft that holds its line walks by 2 sigma^2/(T V^2), 0.025
    # deg^2/s, for times far below T; here over 5 s, exactly 2 sigma^2 (1 - exp(-5/120)), 2 % less.  400 000 s hold
    # 80 000 differences: sd 0.5 %; 4 of them.
    wind = table(made(11, dt=5.0, slow=GaussMarkov(1.5, 120.0)), 80_000)[:, 0]
    walk = np.mean(np.diff(wind) ** 2) / 5.0 / 69.44**2 * math.degrees(1.0) ** 2
    assert walk == pytest.approx(0.02553 * (1 - math.exp(-5 / 120)) * 24.0, rel=0.02)
    assert walk == pytest.approx(0.025, abs=0.001)


def test_wind_by_height_is_that_of_the_aircraft():
    field = WindField([Level(1000.0, 10.0, 0.0), Level(3000.0, 20.0, 0.0)])
    air = made(wind=field)
    assert [air.at(k, lambda h=h: (LAT, LON, h)).wind_north for k, h in enumerate((1000.0, 1500.0, 3500.0))] == [
        pytest.approx(-each) for each in (10.0, 12.5, 20.0)
    ]


def test_mesoscale_wind_is_flown_through_at_the_airspeed():
    # Carried along by the mean wind, it is met faster against the wind over ground: an aircraft that stands in
    # the moving air meets no change.
    field = steady_wind(20.0, 270.0)
    air = made(2, wind=field, slow=Mesoscale())
    drifting = table(air, 400, speed=20.0)[:, :2]
    flying = table(made(2, wind=field, slow=Mesoscale()), 400)[:, :2]
    # the path's metres are those of a sphere, 0.3 % off
    assert np.ptp(drifting, axis=0).max() < 0.02 * np.ptp(flying, axis=0).max()


def test_thermals_stand_unless_they_drift():
    def where():
        return LAT, LON, HEIGHT

    kind = {"wind": steady_wind(10.0, 270.0), "thermals": (Thermal(LAT, LON, 300.0, 3.0),)}
    for drifts, down in ((False, -3.0), (True, 0.0)):
        assert made(thermals_drift=drifts, **kind).at(40 * 120, where).wind_down == pytest.approx(down, abs=1e-3)
