"""Look at a recording: each of its frames is a viewpoint."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.datasets.dataset import Dataset
from curiosight.datasets.prefetch import Prefetch
from curiosight.frame import Frame, Viewpoint
from curiosight.worlds.travel import Floats, straight_ways, travel, travel_seconds


class ReplayWorld:
    """Replay the frames of a recording in any order; a viewpoint's index is the frame's.

    regions: (len(dataset),) region of each frame, -1 = none; such as `Regions.of_view`.
    indices: the frames within reach, those kept for training, say; None = all.
    memory_mb: for decoded frames.
    seconds: of the ways from a viewpoint to others, where a map tells them and poses do not.
    upcoming: may be set to a strategy's `upcoming`, so that frames are decoded ahead of use.

    Use as a context manager or call `close`.
    """

    def __init__(
        self,
        dataset: Dataset,
        regions: npt.NDArray[np.integer[Any]],
        *,
        indices: Sequence[int] | None = None,
        memory_mb: float = 256,
        seconds: Callable[[Viewpoint, Sequence[Viewpoint]], Floats] | None = None,
    ) -> None:
        if len(regions) != len(dataset):
            raise ValueError(
                f"regions: expected one for each of {len(dataset)} frames, got {len(regions)}"
            )
        within_reach = range(len(dataset)) if indices is None else indices
        if not all(0 <= index < len(dataset) for index in within_reach):
            raise ValueError(f"indices: expected frames from 0 to {len(dataset) - 1}")
        self._views = tuple(
            Viewpoint(int(index), int(regions[index]), dataset.poses[index])
            for index in within_reach
        )
        self._prefetch = Prefetch(dataset, memory_mb=memory_mb)
        self._seconds = seconds
        self._here: Viewpoint | None = None
        self.upcoming: Callable[[], Sequence[Viewpoint]] | None = None

    @property
    def views(self) -> Sequence[Viewpoint]:
        return self._views

    def move_to(self, viewpoint: Viewpoint) -> float:
        """Go to a frame's viewpoint; the way is a straight line between poses."""
        start, self._here = self._here, viewpoint
        if start is None:
            return 0.0
        if self._seconds is not None:
            return float(self._seconds(start, [viewpoint])[0])
        if start.T_world_camera is None or viewpoint.T_world_camera is None:
            return 0.0
        return travel_seconds(*travel(start.T_world_camera, viewpoint.T_world_camera))

    def ways(self, start: Viewpoint, goals: Sequence[Viewpoint]) -> tuple[Floats, Floats]:
        """Return the (n,) metres and degrees of the ways to viewpoints: straight ones."""
        return straight_ways(start, goals)

    def capture(self) -> Frame:
        """Return the frame of the viewpoint, and have the upcoming ones decoded meanwhile."""
        if self._here is None:
            raise ValueError("capture: expected a `move_to` before it, got none")
        frame = self._prefetch[self._here.index]
        if self.upcoming is not None:
            self._prefetch.expect([upcoming.index for upcoming in self.upcoming()])
        return frame

    def look_again(self, index: int, n_looks: int) -> Frame:
        """Return what look number `n_looks`, from 0, showed of a view: its frame, each time."""
        return self._prefetch.dataset[index]

    def state(self) -> Viewpoint | None:
        """Return what moves change, for `go_on`: where it is."""
        return self._here

    def go_on(self, state: Viewpoint | None, n_looks: int) -> None:
        """Go on as a world of the same views with this `state` after so many looks."""
        self._here = state

    def close(self) -> None:
        """Stop decoding ahead and free the memory."""
        self._prefetch.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
