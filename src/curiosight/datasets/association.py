"""Pair colour and depth images by the times at which they were taken."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

MAX_OFFSET_NS = 20_000_000


def associate(
    colour: Sequence[tuple[int, Path]], depth: Sequence[tuple[int, Path]]
) -> list[tuple[int, Path, Path]]:
    """Pair every colour image with the depth image nearest in time, within 20 ms.

    colour, depth: nanoseconds and files; depth must not be empty.
    """
    listed = np.array([stamp for stamp, _ in depth], np.int64)
    stamps, first = np.unique(listed, return_index=True)
    wanted = np.array([stamp for stamp, _ in colour], np.int64)
    after = np.searchsorted(stamps, wanted).clip(max=len(stamps) - 1)
    before = (after - 1).clip(min=0)
    # Of two depth images equally near, the earlier one.
    is_before = np.abs(stamps[before] - wanted) <= np.abs(stamps[after] - wanted)
    nearest = np.where(is_before, before, after)
    is_near = np.abs(stamps[nearest] - wanted) <= MAX_OFFSET_NS
    return [
        (stamp, rgb, depth[row][1])
        for (stamp, rgb), row, is_pair in zip(colour, first[nearest], is_near, strict=True)
        if is_pair
    ]
