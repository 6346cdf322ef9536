"""What was up a moment ago, for recordings without poses."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.frame import Depth
from curiosight.teacher.cloud.planes import Plane

Array = npt.NDArray[Any]
# So many rows and columns of an image are compared with the last one.
N_LINES = 30


class UpTracker:
    """Carries the up direction of the camera's frame from one view to the next.

    It is believed while the camera moves by little from frame to frame: a jump to another view,
    as in a shuffled recording, or too many frames without any support end it.

    max_change: share of depth by which a pixel may change and still show the same.
    min_same: share of the pixels that must show the same.
    max_lost: frames in a row without a support.
    """

    def __init__(
        self, *, max_change: float = 0.1, min_same: float = 0.5, max_lost: int = 15
    ) -> None:
        self.max_change = max_change
        self.min_same = min_same
        self.max_lost = max_lost
        self._up: Array | None = None
        self._last: Depth | None = None
        self._shape: tuple[int, ...] = ()
        self._n_lost = 0

    def up_in(self, depth: Depth) -> Array | None:
        """Return the (3,) unit vector that is about up in this view; None = not known."""
        if self._last is None or depth.shape != self._shape:
            return None
        now = _sparse(depth)
        both = np.isfinite(now) & np.isfinite(self._last)
        same = np.abs(now - self._last)[both] < self.max_change * now[both]
        is_same_view = np.count_nonzero(same) > self.min_same * max(1, len(same))
        return self._up if is_same_view else None

    def update(self, depth: Depth, levels: Iterable[Plane]) -> None:
        """Learn from a view: the largest of its level planes is the best measured vertical."""
        expected = self.up_in(depth)
        self._last, self._shape = _sparse(depth).copy(), depth.shape
        seen = [(np.count_nonzero(plane.inliers), plane.normal) for plane in levels]
        n_seen, normal = max(seen, key=lambda pair: pair[0], default=(0, None))
        if n_seen:
            self._up, self._n_lost = normal, 0
            return
        self._n_lost += 1
        self._up = expected if self._n_lost <= self.max_lost else None


def _sparse(depth: Depth) -> Depth:
    """Return some rows and columns of an image, evenly spaced."""
    step = max(1, min(depth.shape) // N_LINES)
    return depth[::step, ::step]
