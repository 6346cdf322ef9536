"""Vectors of three numbers for compiled loops."""

from __future__ import annotations

from math import sqrt

from curiosight.rooms.compiling import kernel

Triple = tuple[float, float, float]


@kernel
def dot(a: Triple, b: Triple) -> float:
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def scaled(vector: Triple, length: float) -> Triple:
    """Return the vector at another length; a negative one turns it round."""
    factor = length / sqrt(dot(vector, vector))
    return vector[0] * factor, vector[1] * factor, vector[2] * factor
