"""What is varied: lists, steps and ranges, as options, YAML and Python give them, and the points they make."""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterator, Mapping, Sequence
from decimal import Decimal
from itertools import product
from math import isfinite, prod
from typing import Any, NamedTuple

from aerosim.errors import InputError
from aerosim.scenario.reader import parse
from aerosim.sweep.matrix import identity

POINTS_MAX = 100_000
VALUES_MAX = 10_000  # of one key
SAMPLINGS = ("grid", "list", "latin_hypercube")
FORMS = "KEY=A,B,C, KEY=LOW:HIGH:STEP or KEY=LOW..HIGH"
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_STEPS = re.compile(rf"\s*({_NUMBER})\s*:\s*({_NUMBER})\s*(?::\s*({_NUMBER})\s*)?")
_RANGE = re.compile(rf"\s*({_NUMBER})\s*\.\.\s*({_NUMBER})\s*")


class Range(NamedTuple):
    """Numbers from low to high, for a Latin hypercube."""

    low: float
    high: float


Varied = tuple[Any, ...] | Range


def _exact(number: Any) -> Decimal:
    return Decimal(str(number))


def steps(low: Any, high: Any, step: Any) -> tuple[int | float, ...]:
    """Numbers from low to high, both included if the step meets it; 0:0.3:0.1 is 0, 0.1, 0.2, 0.3, in decimals.

    All whole if low and step are.  Raises InputError if the step does not lead from low to high.
    """
    first, last, by = _exact(low), _exact(high), _exact(step)
    if not all(number.is_finite() for number in (first, last, by)):
        raise InputError(f"{low}:{high}:{step} is not finite", allowed="LOW:HIGH:STEP")
    if by == 0 or (last - first) / by < 0:
        problem = f"a step of {step} does not lead from {low} to {high}"
        raise InputError(problem, allowed="LOW:HIGH:STEP, a step of the right sign")
    count = int((last - first) / by) + 1
    if count > VALUES_MAX:
        raise InputError(f"{low}:{high}:{step} has {count} values", allowed=f"at most {VALUES_MAX}")
    whole = all("." not in str(number).lower() and "e" not in str(number).lower() for number in (low, step))
    return tuple(int(first + k * by) if whole else float(first + k * by) for k in range(count))


def between(low: Any, high: Any) -> Range:
    """Range from low to high.  Raises InputError unless low is below high."""
    first, last = float(low), float(high)
    if not (isfinite(first) and isfinite(last) and first < last):
        raise InputError(f"{low}..{high} is no range", allowed="LOW..HIGH, low below high")
    return Range(first, last)


def parse_vary(text: str, option: str = "--vary") -> tuple[str, Varied]:
    """Key and values of ``key=a,b,c``, ``key=low:high:step`` or ``key=low..high``; values are read as YAML.

    Raises InputError.
    """
    key, equals, values = text.partition("=")
    key = key.strip()
    if not equals or not key or not all(key.split(".")):
        raise InputError(f"{text!r} varies nothing", key=option, allowed=FORMS)
    try:
        return key, _parsed(values)
    except InputError as error:
        raise InputError(error.problem, key=f"{option} {key}", allowed=error.allowed or FORMS) from error


def _parsed(values: str) -> Varied:
    if found := _STEPS.fullmatch(values):
        if found[3] is None:
            raise InputError(f"{values.strip()} has no step", allowed="LOW:HIGH:STEP, or LOW..HIGH")
        return steps(*found.groups())
    if found := _RANGE.fullmatch(values):
        return between(*found.groups())
    if not values.strip():
        raise InputError("has no values")
    return checked(parse(f"[{values}]", "values")[0])


def checked(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """A list of values, if there are some and none is twice.  Raises InputError."""
    if not values:
        raise InputError("has no values", allowed="at least one")
    if len(values) > VALUES_MAX:
        raise InputError(f"has {len(values)} values", allowed=f"at most {VALUES_MAX}")
    return values


def varied(value: Any) -> Varied:
    """Values as YAML or Python give them: a list, {from, to, step}, {from, to} or a Range.  Raises InputError."""
    if isinstance(value, Range):
        return between(*value)
    if isinstance(value, Mapping):
        return _from_to(value)
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (list, tuple, range)):
        return checked(tuple(each.item() if hasattr(each, "item") else each for each in value))
    raise InputError(f"{value!r} is no list", allowed="a list, {from: LOW, to: HIGH, step: STEP} or {from, to}")


def _from_to(value: Mapping[str, Any]) -> Varied:
    allowed = "{from: LOW, to: HIGH, step: STEP} or {from: LOW, to: HIGH}"
    if not {"from", "to"} <= set(value) <= {"from", "to", "step"}:
        raise InputError(f"{dict(value)} is no range of values", allowed=allowed)
    if not all(isinstance(each, (int, float)) and not isinstance(each, bool) for each in value.values()):
        raise InputError(f"{dict(value)} has what is no number", allowed=allowed)
    if "step" in value:
        return steps(value["from"], value["to"], value["step"])
    return between(value["from"], value["to"])


def together(grids: Sequence[Mapping[str, Varied]]) -> dict[str, Varied]:
    """All values of each key of several grids, in their order; what is twice is there once."""
    if len(grids) == 1:
        return dict(grids[0])
    out: dict[str, dict[Hashable, Any]] = {}
    for key, values in (item for grid in grids for item in grid.items()):
        if isinstance(values, Range):
            problem = f"{values.low:g} to {values.high:g} has no step"
            raise InputError(problem, key=key, allowed="values; a range is for latin_hypercube sampling")
        out.setdefault(key, {}).update({identity(value): value for value in values})
    return {key: tuple(values.values()) for key, values in out.items()}


def as_written(values: Varied) -> Any:
    """Values as a sweep file has them."""
    return {"from": values.low, "to": values.high} if isinstance(values, Range) else list(values)


def combined(
    vary: Mapping[str, Varied], sampling: str, samples: int | None, seed: int
) -> Iterator[dict[str, Any]]:
    """Values of each point, in order; the last key changes quickest in a grid.

    sampling: grid (all combinations), list (first values, second values, ...) or latin_hypercube (`samples`
    points, drawn by `seed`).  Raises InputError at once.
    """
    _check(vary, sampling, samples)
    if sampling == "latin_hypercube":
        assert samples is not None
        return _hypercube(vary, samples, seed)
    ways = product(*vary.values()) if sampling == "grid" else zip(*vary.values(), strict=True)
    return (dict(zip(vary, values, strict=True)) for values in ways)


def _check(vary: Mapping[str, Varied], sampling: str, samples: int | None) -> None:
    if not vary:
        raise InputError("nothing is varied", key="vary", allowed=FORMS)
    if sampling != "latin_hypercube":
        for key, values in vary.items():
            if isinstance(values, Range):
                problem = f"{values.low:g} to {values.high:g} has no step"
                raise InputError(problem, key=key, allowed="a step, or latin_hypercube sampling with samples")
        if samples is not None:
            raise InputError(f"is of no use for a {sampling}", key="samples", allowed="latin_hypercube sampling")
    elif samples is None:
        raise InputError("how many points is not said", key="samples", allowed="samples: 1 to 100000")
    sizes = {key: len(values) for key, values in vary.items()}
    if sampling == "list" and len(set(sizes.values())) > 1:
        told = ", ".join(f"{key} {size}" for key, size in sizes.items())
        raise InputError("a list takes as many values of each key", key="vary", allowed=f"now: {told}")
    count = samples or (prod(sizes.values()) if sampling == "grid" else max(sizes.values()))
    if not 1 <= count <= POINTS_MAX:
        key = "samples" if samples is not None else "vary"
        raise InputError(
            f"{count} points are too {'many' if count > 1 else 'few'}", key=key, allowed=f"1 to {POINTS_MAX}"
        )


def _hypercube(vary: Mapping[str, Varied], samples: int, seed: int) -> Iterator[dict[str, Any]]:
    """Each key's range is cut into as many equal parts as there are points, and each part is met once.

    Every key has its own generator: one key more leaves the others' values as they are.  Of a list each value is
    met equally often, as far as the number of points allows.
    McKay, Beckman, Conover (1979), Technometrics 21, 239-245.
    """
    from aerosim.rng import generator

    columns: list[list[Any]] = []
    for key, values in vary.items():
        rng = generator(seed, f"sweep.latin_hypercube.{key}")
        share = (rng.permutation(samples) + rng.random(samples)) / samples
        if isinstance(values, Range):
            columns.append([float(f"{x:.9g}") for x in values.low + share * (values.high - values.low)])
        else:
            columns.append([values[min(int(s * len(values)), len(values) - 1)] for s in share])
    return (dict(zip(vary, each, strict=True)) for each in zip(*columns, strict=True))
