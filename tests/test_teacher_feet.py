"""What of an object is within the slab of its support."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from curiosight.teacher.cloud.points import Points, observe_points
from curiosight.teacher.things.feet import MIN_FOOT_HEIGHT, join_feet
from room import ROOM
from scenes import CAMERA, kinect_noise, see

NOISE, SLAB = 0.0035, 0.03
SEED = 5


def joined_by_numpy(
    number: npt.NDArray[np.int32],
    are_objects: npt.NDArray[np.bool_],
    free: npt.NDArray[np.bool_],
    heights: npt.NDArray[np.float32],
    depth: npt.NDArray[np.float32],
) -> npt.NDArray[np.int32]:
    """The rule, a whole row at once."""
    number = number.copy()
    for v in range(1, len(number)):
        slack = NOISE * depth[v] ** 2
        joins = (number[v] == 0) & free[v] & are_objects[number[v - 1]]
        joins &= (heights[v] > MIN_FOOT_HEIGHT + 0.2 * slack) & (heights[v] < SLAB + slack)
        joins &= np.abs(depth[v] - depth[v - 1]) < 0.01 + slack
        number[v][joins] = number[v - 1][joins]
    return number


def observe() -> Points:
    frame, _ = see(ROOM, distance=2.0, height=1.1, tilt_deg=25)
    assert frame.depth is not None
    return observe_points(kinect_noise(frame.depth, np.random.default_rng(SEED)), CAMERA)


def test_feet_are_joined_as_the_plain_rule_says() -> None:
    points, rng = observe(), np.random.default_rng(SEED)
    number = rng.choice(4, points.depth.shape, p=[0.7, 0.1, 0.1, 0.1]).astype(np.int32)
    are_objects = np.array([False, True, False, True])
    free = rng.random(points.depth.shape) < 0.8
    heights = rng.uniform(-0.02, 0.08, points.depth.shape).astype(np.float32)
    expected = joined_by_numpy(number, are_objects, free, heights, points.depth)
    before = number.copy()
    join_feet(number, are_objects, free, heights, points.depth, SLAB, NOISE)
    assert np.count_nonzero(expected != before) > 500
    np.testing.assert_array_equal(number, expected)


def test_nothing_is_joined_to_what_is_no_object() -> None:
    points = observe()
    number = np.ones(points.depth.shape, np.int32)
    number[:, 30:] = 2
    number[20:] = 0
    heights = np.full(points.depth.shape, 0.03, np.float32)
    free = np.ones(points.depth.shape, np.bool_)
    are_objects = np.array([False, False, True])
    join_feet(number, are_objects, free, heights, points.depth, SLAB, NOISE)
    assert not number[20:, :30].any()
    assert number[20, 30:].any()
