"""Vectors of three numbers for compiled loops."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import ParamSpec, TypeVar

from numba import njit

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")
Triple = tuple[float, float, float]


def kernel(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function; a division by zero gives infinity or NaN as in NumPy."""
    compiled: Callable[Parameters, Result] = njit(cache=True, nogil=True, error_model="numpy")(
        function
    )
    return compiled


@kernel
def dot(a: Triple, b: Triple) -> float:
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def scaled(vector: Triple, length: float) -> Triple:
    """Return the vector at another length; a negative one turns it round."""
    factor = length / sqrt(dot(vector, vector))
    return vector[0] * factor, vector[1] * factor, vector[2] * factor
