"""Directions on the ground."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

# The cosine from which on up is along the x axis, and tells nothing beside it.
NEAR_X = 0.9


def ground_axes(up: Array) -> Array:
    """Return (2, 3) two directions at right angles to a (3,) unit vector and to each other.

    Nearly the same for nearly the same `up`, unless it is some 26° from the x axis: along an axis,
    as it mostly is, the noise of two surveys would turn one's directions against the other's.
    """
    helper = np.eye(3)[0 if abs(up[0]) < NEAR_X else 2]
    across = np.cross(up, helper)
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(up, across)])
