"""What a strategy can be sent into: a recording, a simulated room, a robot."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from curiosight.frame import Frame, Viewpoint


class World(Protocol):
    """Places to look from, and what is seen there."""

    @property
    def views(self) -> Sequence[Viewpoint]:
        """The viewpoints within reach, each with an index of its own."""
        ...

    def capture(self, viewpoint: Viewpoint) -> Frame:
        """Look from one of `views`; a bad frame is a Frame with a problem, no exception."""
        ...
