"""Where in an image its numbered objects are."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def boxes_of(numbers: npt.NDArray[np.integer[Any]]) -> list[tuple[slice, slice] | None]:
    """Return the rows and columns of the objects 1, 2, … of (H, W); None for one not there."""
    v, u = np.nonzero(numbers)
    number = numbers[v, u].astype(np.int64)
    n = int(number.max(initial=0)) + 1
    first, last = np.full((2, n), max(numbers.shape)), np.full((2, n), -1)
    for axis, places in enumerate((v, u)):
        np.minimum.at(first[axis], number, places)
        np.maximum.at(last[axis], number, places)
    ends = zip(*first[:, 1:].tolist(), *(last[:, 1:] + 1).tolist(), strict=True)
    return [
        (slice(top, bottom), slice(left, right)) if bottom else None
        for top, left, bottom, right in ends
    ]
