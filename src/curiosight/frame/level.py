"""Directions on the ground."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def ground_axes(up: Array) -> Array:
    """Return (2, 3) two directions at right angles to a (3,) unit vector and to each other."""
    helper = np.eye(3)[np.argmin(np.abs(up))]
    across = np.cross(up, helper)
    across /= np.linalg.norm(across)
    return np.stack([across, np.cross(up, across)])
