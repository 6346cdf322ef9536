"""Compile the loops over pixels and rays."""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

from curiosight.errors.compiling import njit

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def kernel(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function; a division by zero gives infinity or NaN as in NumPy."""
    compiled: Callable[Parameters, Result] = njit(cache=True, nogil=True, error_model="numpy")(
        function
    )
    return compiled
