"""A navigator at his sight: when he looks, and what he says.  The pilot's and the camera's have it in common."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

DEGREE = math.radians(1.0)
LOOK_LEAST_S = 4.0
# Largest correction spoken at once.
SPOKEN_MAX = 10


@dataclass(frozen=True)
class Looking:
    """How a navigator looks and speaks.  rad, s.

    look: mean time between two looks through the sight; look_scatter: its standard deviation, as a part of it.
    settle: longer wait after a correction.  track_sigma: error of a look, in the track's angle.  average: over
    which a look takes the track.  least: smallest correction spoken, whole degrees.  reaction: from the word to
    the hand.
    """

    look: float = 16.0
    look_scatter: float = 0.3
    settle: float = 10.0
    track_sigma: float = 0.7 * DEGREE
    average: float = 5.0
    least: int = 2
    reaction: float = 3.0


def pause(looking: Looking, rng: np.random.Generator) -> float:
    """Time to the next look, s."""
    wait = looking.look * max(1.0 + looking.look_scatter * rng.standard_normal(), 0.0)
    return float(max(wait, LOOK_LEAST_S))


def in_words(angle: float, looking: Looking) -> int:
    """A correction (rad) in whole degrees, as it is spoken; 0 if it is too small to speak of."""
    degrees = min(max(round(angle / DEGREE), -SPOKEN_MAX), SPOKEN_MAX)
    return degrees if abs(degrees) >= looking.least else 0
