"""What stands whole before a thing that the image cuts is an object, whatever ties them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from curiosight.frame import Frame
from curiosight.teacher import Segmentation, Teacher
from room import Box, View
from scenes import see

RED, GREY = (200, 40, 40), (90, 90, 90)
BEFORE = Box((-0.6, 0.0, 0.15), (0.30, 0.30, 0.30), RED)
# Goes on beyond the left of the image, and shows too little for a wall.
CUT = Box((-1.2, 0.6, 0.20), (1.4, 0.3, 0.40), GREY, is_salient=False)


def tied(*boxes: Box) -> tuple[Frame, View]:
    """Return a frame whose readings stray from the first box back to what is behind its edges."""
    frame, view = see(boxes, height=0.5, tilt_deg=10)
    assert frame.depth is not None
    depth = frame.depth.copy()
    is_first = view.surface == 1
    for row in np.flatnonzero(is_first.any(axis=1)):
        first, last = np.flatnonzero(is_first[row])[[0, -1]]
        for edge, way in ((first, -1), (last, 1)):
            near, far = depth[row, edge], depth[row, edge + 10 * way]
            depth[row, edge + way * np.arange(1, 10)] = np.linspace(near, far, 11)[1:-1]
    return replace(frame, depth=depth), view


def share_of_first(found: Segmentation, view: View) -> float:
    """Return how much of the first box is in one object."""
    numbers = found.instances()[view.surface == 1]
    return float(np.mean(numbers == max(1, np.bincount(numbers).argmax())))


def test_whole_box_before_a_cut_one_is_an_object() -> None:
    frame, view = tied(BEFORE, CUT)
    found = Teacher().segment(frame)
    assert len(found.objects) == 1
    # Its lowest centimetres are within the noise of the floor.
    assert share_of_first(found, view) > 0.8
    assert np.mean(found.instances()[view.surface == 2] > 0) < 0.02


@pytest.mark.parametrize(
    "part",
    [
        # Flush with what is cut, so a part of it; and hanging on it, over the floor.
        replace(BEFORE, centre=(-0.8, 0.44, 0.18), size=(0.25, 0.02, 0.36)),
        replace(BEFORE, centre=(-0.8, 0.40, 0.32), size=(0.25, 0.12, 0.10)),
    ],
)
def test_part_of_a_cut_thing_is_none(part: Box) -> None:
    frame, _ = see((part, CUT), height=0.5, tilt_deg=10)
    assert Teacher().segment(frame).objects == ()
