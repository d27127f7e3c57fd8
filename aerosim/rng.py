"""Random generators by name: each device and each component of the air has its own."""

from __future__ import annotations

import zlib

import numpy as np


def generator(seed: int, name: str) -> np.random.Generator:
    """The generator of one component.  Another name or seed: an independent stream; the same: the same.

    seed: the scenario's.  name: for example ``air.turbulence.u``; what one component draws never moves another.
    """
    return np.random.Generator(
        np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(zlib.crc32(name.encode()),)))
    )
