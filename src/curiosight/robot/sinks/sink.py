"""What is new of a watch at a moment, and what takes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from curiosight.frame import Viewpoint
from curiosight.robot.feed import Shot
from curiosight.robot.told import Verdict
from curiosight.robot.watch import Mapped


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """What is new of a watch.

    stamp_ns: of the clock on the wall. zero_ns: the same where the feed's clock is 0.
    state: the values of `/state.json`. mapped, verdict: None = none since the moment before.
    looks: since then, with the columns of looks.csv.
    """

    stamp_ns: int
    zero_ns: int
    state: Mapping[str, Any]
    mapped: Mapped | None
    verdict: Verdict | None
    looks: Sequence[Mapping[str, Any]]

    def stamp_of(self, shot: Shot) -> int:
        """Return when a frame was taken, by the clock on the wall."""
        return self.zero_ns + round(1e9 * shot.taken_at)


class Sink(Protocol):
    """Takes moments, one after the other, in one thread; raises what goes wrong.

    name: what it is called before a user.
    """

    name: str

    def begin(self, title: str, views: Sequence[Viewpoint]) -> None:
        """Make ready. title: what is watched; views: all that it has."""
        ...

    def write(self, moment: Moment) -> None:
        """Take what is new."""
        ...

    def close(self) -> None:
        """End, completely; called once where `begin` was called, whatever became of it."""
        ...


def places_of(views: Sequence[Viewpoint]) -> dict[int, tuple[float, float, float]]:
    """Return the middle of each region's views in the world, metres; those without poses not."""
    placed: dict[int, list[Any]] = {}
    for view in views:
        if view.region >= 0 and view.T_world_camera is not None:
            placed.setdefault(view.region, []).append(view.T_world_camera[:3, 3])
    middles = {region: np.mean(points, axis=0).tolist() for region, points in placed.items()}
    return {region: (x, y, z) for region, (x, y, z) in sorted(middles.items())}
