"""What a strategy can be sent into: a recording, a simulated room, a robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from curiosight.frame import Frame, Viewpoint


class World(Protocol):
    """Places to look from, and what is seen there."""

    @property
    def views(self) -> Sequence[Viewpoint]:
        """The viewpoints to choose from, each with an index of its own."""
        ...

    def move_to(self, viewpoint: Viewpoint) -> float:
        """Go to a viewpoint and return the cost: the seconds that a robot needs for the way.

        0 where that is unknown, as for a recording without poses, and for the first move.
        """
        ...

    def capture(self) -> Frame:
        """Look from where the last move led to; a bad frame is a Frame with a problem."""
        ...
