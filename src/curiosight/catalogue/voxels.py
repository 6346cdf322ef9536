"""Surfaces as sets of small cubes of the world, so that views can be laid over each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
# Sorted, each once: a cube's three whole numbers of 21 bits as one.
Voxels = npt.NDArray[np.int64]

# Metres along a cube's side: finer than things, coarser than a Kinect's noise at 3 m.
SIDE = 0.03
_ORIGIN = 1 << 20
_UP, _ALONG = 1 << 42, 1 << 21
# To a cube's neighbours, itself among them.
_AROUND = np.array(
    [x * _UP + y * _ALONG + z for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1)]
)


def voxels_of(points: Array) -> Voxels:
    """Return the cubes that (n, 3) points in the world, metres, lie in; up to 30 km from it."""
    cells = np.floor(points / SIDE).astype(np.int64) + _ORIGIN
    return np.unique((cells[:, 0] * _UP) + (cells[:, 1] * _ALONG) + cells[:, 2])


def centres_of(voxels: Voxels) -> npt.NDArray[np.float64]:
    """Return the (n, 3) centres of cubes, metres."""
    cells = np.stack([voxels >> 42, (voxels >> 21) & (_ALONG - 1), voxels & (_ALONG - 1)], axis=1)
    return (cells - _ORIGIN + 0.5) * SIDE


def grown(voxels: Voxels) -> Voxels:
    """Return cubes with all of their neighbours."""
    return np.unique(voxels[:, None] + _AROUND)


def share_in(voxels: Voxels, others: Voxels) -> float:
    """Return the share of some cubes that is among others; 0 of none."""
    if not len(voxels) or not len(others):
        return 0.0
    places = np.searchsorted(others, voxels)
    places[places == len(others)] = 0
    return float(np.count_nonzero(others[places] == voxels)) / len(voxels)
