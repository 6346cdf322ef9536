"""Move through a drawn room, or a drawn home."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from curiosight.frame import Frame, Viewpoint
from curiosight.rooms.drawn_views import DrawnViews
from curiosight.worlds.travel import Floats, straight_ways, travel, travel_seconds


class RoomWorld:
    """A robot with a camera in a room or a home; it can go to any place that is free.

    Every look is new: the sensors' noise and the exposure differ from visit to visit.

    room_views: of the room or home, the viewpoints to choose from.
    regions: (len(room_views),) region of each viewpoint, -1 = none; such as `Regions.of_view`.
    indices: the viewpoints within reach; None = all.
    upcoming: may be set to a strategy's `upcoming`, so that views are rendered ahead of use.

    Use as a context manager or call `close`.
    """

    def __init__(
        self,
        room_views: DrawnViews,
        regions: npt.NDArray[np.integer[Any]],
        *,
        indices: Sequence[int] | None = None,
    ) -> None:
        if len(regions) != len(room_views):
            raise ValueError(
                f"regions: expected one for each of {len(room_views)} views, got {len(regions)}"
            )
        self.room_views = room_views
        self._views = tuple(
            Viewpoint(index, int(regions[index]), room_views.poses[index])
            for index in (range(len(room_views)) if indices is None else indices)
        )
        self.upcoming: Callable[[], Sequence[Viewpoint]] | None = None
        self._here: Viewpoint | None = None
        self._n_looks = 0
        self._executor = ThreadPoolExecutor(1, thread_name_prefix="render")
        self._ahead: tuple[Viewpoint, Future[Frame]] | None = None

    @property
    def views(self) -> Sequence[Viewpoint]:
        return self._views

    def move_to(self, viewpoint: Viewpoint) -> float:
        """Go to a viewpoint, one of `views` or any other; the way leads around what stands.

        Raises ValueError for a place where the robot cannot stand.
        """
        pose = viewpoint.T_world_camera
        if pose is None:
            raise ValueError("viewpoint: expected a pose, got None")
        space, goal = self.room_views.free_space, pose[:2, 3]
        space.check(goal)
        before, self._here = self._here, viewpoint
        if before is None or before.T_world_camera is None:
            return 0.0
        start = before.T_world_camera
        return travel_seconds(space.way(start[:2, 3], goal), travel(start, pose)[1])

    def ways(self, start: Viewpoint, goals: Sequence[Viewpoint]) -> tuple[Floats, Floats]:
        """Return the (n,) metres and degrees of the ways to viewpoints, around what stands."""
        _, degrees = straight_ways(start, goals)
        if all(map(self._is_drawn, (start, *goals))):
            return self.room_views.metres_from(start.index)[[g.index for g in goals]], degrees
        places = np.array([_place(goal) for goal in goals]).reshape(-1, 2)
        return self.room_views.free_space.ways(_place(start), places), degrees

    def _is_drawn(self, viewpoint: Viewpoint) -> bool:
        """Tell whether a viewpoint is one of those that were drawn, and stands where that does."""
        poses = self.room_views.poses
        is_known = 0 <= viewpoint.index < len(poses)
        return is_known and viewpoint.T_world_camera is poses[viewpoint.index]

    def capture(self) -> Frame:
        """Look from here, and have the next view rendered meanwhile."""
        if self._here is None:
            raise ValueError("capture: expected a `move_to` before it, got none")
        if self._ahead is not None and self._ahead[0] is self._here:
            frame = self._ahead[1].result()
        else:
            frame = self._look(self._here, self._n_looks)
        self._n_looks += 1
        self._look_ahead()
        return frame

    def look_again(self, index: int, n_looks: int) -> Frame:
        """Return what look number `n_looks`, from 0, showed of a view: its noise too."""
        return self._look(next(view for view in self._views if view.index == index), n_looks)

    def state(self) -> Viewpoint | None:
        """Return what moves change, for `go_on`, beside the number of looks: where it is."""
        return self._here

    def go_on(self, state: Viewpoint | None, n_looks: int) -> None:
        """Go on as a world of the same views with this `state` after so many looks."""
        self._here, self._n_looks = state, n_looks

    def close(self) -> None:
        """Stop rendering ahead."""
        self._executor.shutdown(cancel_futures=True)
        self._ahead = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _look_ahead(self) -> None:
        upcoming = self.upcoming() if self.upcoming is not None else ()
        self._ahead = None
        if upcoming:
            look = self._executor.submit(self._look, upcoming[0], self._n_looks)
            self._ahead = (upcoming[0], look)

    def _look(self, viewpoint: Viewpoint, n_looks: int) -> Frame:
        """Look for the n-th time: its chance depends on nothing else."""
        assert viewpoint.T_world_camera is not None
        rng = self.room_views.visits_stream(n_looks)
        ids = self.room_views.ids
        is_drawn = 0 <= viewpoint.index < len(ids)
        id = ids[viewpoint.index] if is_drawn else f"look-{n_looks}"
        pose = viewpoint.T_world_camera
        return self.room_views.look_from(pose, id, rng, n_looks=n_looks).frame


def _place(viewpoint: Viewpoint) -> Floats:
    """Return (2,) where on the floor a camera stands."""
    if viewpoint.T_world_camera is None:
        raise ValueError("viewpoint: expected a pose, got None")
    return viewpoint.T_world_camera[:2, 3]
