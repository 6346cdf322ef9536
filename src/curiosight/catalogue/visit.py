"""What one visit shows: frames are added as they come, things found at the end."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from curiosight.catalogue.detection import Detection, find_detections
from curiosight.catalogue.glimpses import Glimpses
from curiosight.catalogue.things import Thing, find_things
from curiosight.frame import Frame
from curiosight.teacher import Segmentation

Array = npt.NDArray[Any]


@dataclass(frozen=True, slots=True)
class View:
    """A frame that was looked at.

    size: height and width in pixels. place: number of the place that it was taken in; None = not
    known.
    """

    id: str
    size: tuple[int, int]
    stamp_ns: int | None
    place: int | None


class Visit:
    """Take in the frames of one visit.

    name: of the recording. up_world: (3,) unit vector; None = as the first frame with a support
    has it.
    """

    def __init__(self, name: str = "", up_world: Array | None = None) -> None:
        self.name = name
        self.views: list[View] = []
        self.glimpses = Glimpses()
        self._up_world = up_world
        self._seen: list[tuple[int, Detection]] = []

    @property
    def up_world(self) -> Array:
        """(3,) unit vector in the world's frame; where nothing tells it, z."""
        return np.array([0.0, 0.0, 1.0]) if self._up_world is None else self._up_world

    def add(
        self,
        frame: Frame,
        segmentation: Segmentation,
        saliency: npt.NDArray[np.float32] | None = None,
        place: int | None = None,
    ) -> list[Detection]:
        """Take in a frame and what its teacher says; return what it shows of things.

        saliency: (H, W) in [0, 1], a map of the frame; None = there is no map.
        Raises ValueError for a frame without a pose.
        """
        size = frame.rgb.shape[:2]
        if saliency is not None and saliency.shape != size:
            raise ValueError(f"saliency: expected {size} like the frame, got {saliency.shape}")
        if self._up_world is None:
            up = segmentation.up_in_world(frame.T_world_camera)
            self._up_world = None if up is None else up / np.linalg.norm(up)
        found = find_detections(frame, segmentation, saliency, up_world=self._up_world)
        number = len(self.views)
        self.views.append(View(frame.id, (size[0], size[1]), frame.stamp_ns, place))
        self._seen += [(number, one) for one in found]
        if frame.depth is not None and frame.camera is not None and frame.problem is None:
            assert frame.T_world_camera is not None
            self.glimpses.add(
                frame.depth, frame.camera, frame.T_world_camera, segmentation.labels, saliency
            )
        return found

    def things(self) -> list[Thing]:
        """Return the things that the frames so far show, see `find_things`."""
        return find_things(self._seen, self.up_world)

    def place_of(self, thing: Thing) -> int | None:
        """Return the number of the place that most views of a thing were taken in."""
        places = [self.views[view].place for view in sorted(thing.views)]
        known = Counter(place for place in places if place is not None)
        return min(known, key=lambda place: (-known[place], place)) if known else None
