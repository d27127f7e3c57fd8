"""How this package compiles its kernels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

OPTIONS: dict[str, Any] = {"cache": True, "nogil": True, "error_model": "numpy", "fastmath": {"contract"}}


def kernel(function: Kernel) -> Kernel:
    """Compile a function that makes no array and no view of one.

    Numba then need not count references to its arguments, which at every call took half of the time of a ray.
    """
    uncounted: dict[str, Any] = {**OPTIONS, "_nrt": False}
    return cast(Kernel, njit(**uncounted)(function))


def entry(function: Kernel) -> Kernel:
    """Compile a function that makes the arrays which kernels work on."""
    return cast(Kernel, njit(**OPTIONS)(function))
