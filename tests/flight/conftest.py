from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from aerosim import assets
from aerosim.flight.aircraft import Aircraft
from aerosim.flight.jsbsim_flight import JsbsimFlight
from aerosim.flight.plan import FlightPlan, Line
from aerosim.frames import WGS84_A
from aerosim.truth import AirState, Where

AIRSPEED = 69.44
HEIGHT = 3000.0


@pytest.fixture(scope="session")
def folder() -> Path:
    return assets.folder("aircraft") / "survey_twin"


@pytest.fixture
def twin(folder: Path) -> Aircraft:
    return Aircraft(folder, 120.0)


def still(wind_north: float = 0.0, wind_east: float = 0.0) -> AirState:
    return AirState(wind_north, wind_east, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Steady:
    """The same air everywhere and always, unless a test changes it."""

    def __init__(self, state: AirState) -> None:
        self.state = state

    def at(self, index: int, where: Where) -> AirState:
        return self.state


def beside(point: tuple[float, float], east: float, north: float) -> tuple[float, float]:
    """A point so many metres away, on a sphere: good enough to lay out lines."""
    lat, lon = point
    return lat + north / WGS84_A, lon + east / (WGS84_A * math.cos(lat))


def line_of(course_deg: float, length: float, start: tuple[float, float] = (0.89, 0.23)) -> Line:
    course = math.radians(course_deg)
    return Line(start, beside(start, length * math.sin(course), length * math.cos(course)))


@pytest.fixture
def fly(folder: Path) -> Callable[..., JsbsimFlight]:
    def make(lines: list[Line], wind: tuple[float, float] = (0.0, 0.0), **more: float) -> JsbsimFlight:
        plan = FlightPlan(lines, HEIGHT, AIRSPEED, **more)  # type: ignore[arg-type]
        return JsbsimFlight(Aircraft(folder, 120.0), plan, Steady(still(*wind)), 3)

    return make


def steps(flight: JsbsimFlight, most_s: float) -> Iterator[int]:
    """Fly to the end."""
    for step in range(int(120 * most_s)):
        if flight.done:
            return
        flight.advance(1)
        yield step
    raise AssertionError("the flight did not end")
