"""Clusters that stand on clusters: a seat on its legs, a shade on its lamp's stem."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse.csgraph import connected_components

Array = npt.NDArray[Any]


def join_stacked(
    low: Array,
    high: Array,
    boxes: Array,
    hovers: Array,
    *,
    reach: float = 0.5,
    margin: float = 0.03,
) -> Array:
    """Return the (n,) number of the thing that each of n clusters belongs to.

    A cluster that hovers belongs to those below it, seen from above: what joins them is
    hidden in it, or too thin to be seen.

    low, high: (n,) metres over the support. boxes: (n, 4) x_min, y_min, x_max, y_max of their
    ground plan in metres. hovers: (n,) bool. reach: largest gap between the two, metres.
    """
    is_below = low[None, :] < low[:, None]
    is_near = high[None, :] > low[:, None] - reach
    lowest, highest = boxes[:, None, :2] - margin, boxes[:, None, 2:] + margin
    meets = ((lowest < boxes[None, :, 2:]) & (boxes[None, :, :2] < highest)).all(axis=2)
    _, thing = connected_components(hovers[:, None] & is_below & is_near & meets, directed=False)
    things: Array = thing
    return things
