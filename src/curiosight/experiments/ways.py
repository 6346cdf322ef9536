"""How long the ways between the views of a source are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from curiosight.datasets import Dataset
from curiosight.rooms.drawn_views import DrawnViews


class MetresBetween:
    """How long the ways are from each view to all: around what stands, where that is known.

    Found when asked for, a view at a time: of n views there are n x n.

    indices: of the views. Raises ValueError where a view has no pose.
    """

    def __init__(self, dataset: Dataset, indices: Sequence[int]) -> None:
        known = [pose for pose in (dataset.poses[index] for index in indices) if pose is not None]
        if not known or len(known) < len(indices):
            raise ValueError("views: expected poses of all")
        self._dataset, self._indices = dataset, np.asarray(indices)
        self._places = np.stack(known)[:, :3, 3]

    def __len__(self) -> int:
        return len(self._indices)

    def __getitem__(self, number: int) -> npt.NDArray[np.float64]:
        """Return the (n,) metres of the ways from a view."""
        if isinstance(self._dataset, DrawnViews):
            metres = self._dataset.metres_from(int(self._indices[number]))
            return metres.take(self._indices)
        return np.asarray(np.linalg.norm(self._places - self._places[number], axis=1))


def ways_between(dataset: Dataset, indices: Sequence[int]) -> MetresBetween | None:
    """Return the ways between views, None where not all poses are known."""
    poses = [dataset.poses[index] for index in indices]
    return MetresBetween(dataset, indices) if poses and all(p is not None for p in poses) else None
