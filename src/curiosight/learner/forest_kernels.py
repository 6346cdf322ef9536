"""What the forest's compiled loops share: arrays, how they pack counts and nodes, and chance.

A tree is two arrays. `nodes` (N,) int64 packs a node into eight bytes, `left child << 24 |
feature << 8 | threshold`: a row goes left where its feature is <= threshold, else to the node
after the left child. A leaf is its own left child with threshold 255, so a walk that has
arrived stays. `values` (N,) float32 is the salient share of a node's weight.

Two class counts are packed into one int64, `salient << 32 | not salient`: one addition counts
both, and a child's histogram is its parent's minus its sibling's.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numpy as np
import numpy.typing as npt

from curiosight.errors.compiling import njit

Rows = npt.NDArray[np.uint8]
Points = npt.NDArray[np.uint8]
Packed = npt.NDArray[np.int64]
Indices = npt.NDArray[np.int32]
Values = npt.NDArray[np.float32]
RandomState = npt.NDArray[np.uint64]

N_BINS = 256
ONE_SALIENT = 1 << 32
NOT_SALIENT_BITS = ONE_SALIENT - 1
FEATURE_BITS = (1 << 16) - 1

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")


def kernel(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function; a division by zero gives NaN as in NumPy (see `find_cut`)."""
    compiled: Callable[Parameters, Result] = njit(cache=True, nogil=True, error_model="numpy")(
        function
    )
    return compiled


@kernel
def mix(number: np.uint64) -> np.uint64:
    """Return the number with all its bits stirred (the last steps of splitmix64)."""
    number = (number ^ (number >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    number = (number ^ (number >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return number ^ (number >> np.uint64(31))


@kernel
def draw_below(state: RandomState, bound: int) -> int:
    """Draw an integer in [0, bound) and advance the splitmix64 generator `state` (1,)."""
    state[0] += np.uint64(0x9E3779B97F4A7C15)
    return int(np.int64(((mix(state[0]) >> np.uint64(32)) * np.uint64(bound)) >> np.uint64(32)))


@kernel
def has_both(total: int) -> bool:
    """Tell whether packed class counts hold both classes."""
    return min(total >> 32, total & NOT_SALIENT_BITS) > 0
