"""Generators by name: the same stream always, independent streams otherwise."""

import math
import os
import subprocess
import sys
from itertools import combinations

import numpy as np
import pytest

from aerosim.rng import generator

NAMES = (
    *(f"air.turbulence.{axis}" for axis in "uvwp"),
    "air.slow_wind.north",
    "air.slow_wind.east",
    "mount.encoder",
    "ccd_rows.noise",
)


def test_same_name_and_seed_is_the_same_stream():
    assert np.array_equal(generator(5, "mount.encoder").random(100), generator(5, "mount.encoder").random(100))


def test_streams_do_not_know_each_other():
    # Correlations of N independent numbers have an sd of 1/sqrt(N); 5 of them.
    size = 20_000
    made = [generator(seed, name).standard_normal(size) for seed in (0, 1, 2) for name in NAMES]
    for a, b in combinations(made, 2):
        assert abs(np.corrcoef(a, b)[0, 1]) < 5.0 / math.sqrt(size)


def test_drawing_from_one_leaves_the_others():
    before = generator(1, "a").random(10)
    first, second = generator(1, "a"), generator(1, "b")
    second.random(1000)
    np.random.seed(0)  # noqa: NPY002  (the global state must not matter)
    assert np.array_equal(first.random(10), before)


@pytest.mark.parametrize("salt", ["1", "2"])
def test_other_processes_give_the_same_stream(salt):
    # Python salts the hash of a string anew in each process.
    code = "from aerosim.rng import generator; print(repr(float(generator(3, 'air.turbulence.u').random())))"
    out = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONHASHSEED": salt},
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    assert float(out.stdout) == generator(3, "air.turbulence.u").random()
