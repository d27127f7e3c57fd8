"""Errors found behind the scenario get the place of their key."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from aerosim.errors import InputError
from aerosim.scenario.scenario import Scenario


@contextmanager
def at(scenario: Scenario, key: str) -> Iterator[None]:
    """Errors raised inside are about this key, unless they name another; they get its place or keep theirs."""
    try:
        yield
    except InputError as error:
        raise scenario.place(
            error if "." in error.key else InputError(error.problem, key, error.allowed, error.where)
        ) from error
