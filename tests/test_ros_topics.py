"""Messages as they come: paired by stamp, located by tf, turned into frames. Without ROS."""

from __future__ import annotations

from types import SimpleNamespace as Message
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from curiosight.datasets.bags.transforms import numbers_of
from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.topics.by_stamp import ByStamp
from curiosight.datasets.topics.frames import Joining, TopicFrames
from curiosight.datasets.topics.tf_buffer import TfBuffer

MS = 1_000_000
S = 1_000_000_000


def header(stamp_ns: int, frame: str) -> Message:
    stamp = Message(sec=stamp_ns // S, nanosec=stamp_ns % S)
    return Message(stamp=stamp, frame_id=frame)


def image(pixels: np.ndarray, encoding: str, stamp_ns: int, frame: str = "camera") -> Message:
    return Message(
        header=header(stamp_ns, frame),
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        is_bigendian=0,
        step=pixels.strides[0],
        data=np.frombuffer(pixels.tobytes(), np.uint8),
    )


def info(width: int, height: int, f: float, frame: str = "camera") -> Message:
    K = [f, 0, width / 2 - 0.5, 0, f, height / 2 - 0.5, 0, 0, 1]
    P = np.zeros((3, 4))
    P[:, :3] = np.reshape(K, (3, 3))
    roi = Message(x_offset=0, y_offset=0, width=0, height=0)
    return Message(
        header=header(0, frame), width=width, height=height, k=K, p=P.ravel(), d=[],
        binning_x=0, binning_y=0, roi=roi,
    )  # fmt: skip


def link(parent: str, child: str, stamp_ns: int, x: float, yaw: float = 0.0) -> Message:
    qx, qy, qz, qw = Rotation.from_euler("z", yaw).as_quat()
    transform = Message(
        translation=Message(x=x, y=0.0, z=0.0), rotation=Message(x=qx, y=qy, z=qz, w=qw)
    )
    return Message(header=header(stamp_ns, parent), child_frame_id=child, transform=transform)


def told(*links: Message) -> Message:
    return Message(transforms=list(links))


def robot() -> TfBuffer:
    """Return map → odom → base → camera: the base drives 1 m a second along x."""
    tf = TfBuffer()
    tf.take(told(link("base", "camera", 0, 0.5)), is_static=True)
    for number in range(11):
        stamp = S + number * 100 * MS
        tf.take(told(link("map", "odom", stamp, 2.0)), is_static=False)
        tf.take(told(link("odom", "base", stamp, number / 10)), is_static=False)
    return tf


def test_nearest_stamp_is_found_whatever_the_order() -> None:
    kept = ByStamp[str]()
    for stamp, item in ((30, "c"), (10, "a"), (20, "b")):
        kept.add(stamp, item)
    assert kept.nearest(24) == (20, "b")
    assert kept.nearest(26) == (30, "c")
    assert kept.await_nearest(24, 3, 0.0) is None
    assert kept.await_nearest(24, 4, 0.0) == (20, "b")


def test_stamps_that_begin_again_replace_the_old_ones() -> None:
    kept = ByStamp[str](n_kept=3)
    for number in range(5):
        kept.add(number * S + 100 * S, str(number))
    assert kept.nearest(0) == (102 * S, "2")
    kept.add(5 * S, "anew")
    assert kept.nearest(104 * S) == (5 * S, "anew")


def test_tf_is_interpolated_along_the_chain() -> None:
    pose = robot().pose("map", "camera", S + 250 * MS)
    assert pose is not None
    np.testing.assert_allclose(pose[:3, 3], [2 + 0.25 + 0.5, 0, 0], atol=1e-9)


def test_tf_is_found_down_the_tree_and_across_it() -> None:
    tf = robot()
    tf.take(told(link("base", "lidar", 0, -0.2)), is_static=True)
    across = tf.pose("lidar", "camera", S)
    down = tf.pose("camera", "map", S)
    assert across is not None
    assert down is not None
    np.testing.assert_allclose(across[:3, 3], [0.7, 0, 0], atol=1e-9)
    np.testing.assert_allclose(down[:3, 3], [-2.5, 0, 0], atol=1e-9)


def test_turns_are_interpolated_between_stamps() -> None:
    tf = TfBuffer()
    for stamp, yaw in ((S, 0.0), (S + 100 * MS, 0.4)):
        tf.take(told(link("map", "camera", stamp, 0.0, yaw)), is_static=False)
    pose = tf.pose("map", "camera", S + 25 * MS)
    assert pose is not None
    assert np.arctan2(pose[1, 0], pose[0, 0]) == pytest.approx(0.1)


def test_last_transform_is_held_no_longer_than_allowed() -> None:
    tf = robot()
    late = 2 * S + 80 * MS
    assert tf.pose("map", "camera", late) is None
    held = tf.pose("map", "camera", late, hold_ns=100 * MS)
    assert held is not None
    assert held[0, 3] == pytest.approx(3.5)
    assert tf.pose("map", "camera", late, hold_ns=50 * MS) is None


def test_frame_that_is_told_another_parent_hangs_there() -> None:
    tf = robot()
    tf.take(told(link("world", "base", 3 * S, 7.0)), is_static=False)
    assert tf.pose("map", "camera", 3 * S) is None
    moved = tf.pose("world", "camera", 3 * S)
    assert moved is not None
    assert moved[0, 3] == pytest.approx(7.5)


def test_numbers_that_are_none_are_left_out() -> None:
    tf = robot()
    tf.take(told(link("odom", "base", 2 * S + 1, float("nan"))), is_static=False)
    pose = tf.pose("map", "camera", 2 * S)
    assert pose is not None
    assert np.isfinite(pose).all()


@pytest.mark.parametrize(
    ("target", "frame", "stamp", "said"),
    [
        ("map", "hand", S, "no tf from map to hand: tf does not tell of hand"),
        ("earth", "camera", S, "tf does not tell of earth"),
        ("map", "camera", 3 * S, "odom to base is 1.00 s old"),
        ("map", "camera", 0, "odom to base is told only 1.00 s later"),
    ],
)
def test_what_tf_lacks_is_said(target: str, frame: str, stamp: int, said: str) -> None:
    why = robot().why_not(target, frame, stamp)
    assert why is not None
    assert said in why


def test_trees_that_nothing_joins_are_named() -> None:
    tf = TfBuffer()
    assert "nothing comes on /tf" in str(tf.why_not("map", "camera", 0))
    tf.take(told(link("base", "camera", 0, 0.5), link("map", "odom", 0, 0.0)), is_static=True)
    why = tf.why_not("map", "camera", 0)
    assert why == "no tf from map to camera: camera hangs on base, and nothing joins that to map"
    assert robot().why_not("map", "camera", S) is None


def frames(joining: Joining | None = None, **fields: Any) -> TopicFrames:
    return TopicFrames(robot(), joining or Joining(wait_s=0.0, **fields))


RGB = np.arange(48 * 64 * 3, dtype=np.uint8).reshape(48, 64, 3)
DEPTH = np.full((48, 64), 1500, np.uint16)


def test_colour_is_a_frame_at_once_and_depth_joins_it() -> None:
    made = frames()
    made.info = info(64, 48, 50)
    frame = made.mapped(image(RGB, "rgb8", S + 500 * MS))
    assert frame.id == "1.500000000"
    assert frame.depth is None
    np.testing.assert_array_equal(frame.rgb, RGB)
    made.add_depth(image(DEPTH, "16UC1", S + 510 * MS))
    settled = made.settled(frame)
    assert settled.problem is None
    assert settled.depth is not None
    assert settled.depth[10, 10] == pytest.approx(1.5)
    assert settled.camera is not None
    assert settled.camera.fx == 50
    assert settled.T_world_camera is not None
    assert settled.T_world_camera[0, 3] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("depth_stamp", "has_info", "problem"),
    [
        (S + 530 * MS, True, "no depth within 20 ms"),
        (S + 500 * MS, False, "no CameraInfo of colour has come"),
    ],
)
def test_frame_that_lacks_something_has_a_problem(
    depth_stamp: int, has_info: bool, problem: str
) -> None:
    made = frames()
    made.info = info(64, 48, 50) if has_info else None
    frame = made.mapped(image(RGB, "rgb8", S + 500 * MS))
    made.add_depth(image(DEPTH, "16UC1", depth_stamp))
    assert made.settled(frame).problem == problem
    assert made.lacks == {problem: 1}


def test_depth_of_a_camera_beside_is_registered() -> None:
    made = frames()
    made.info, made.depth_info = info(64, 48, 50), info(64, 48, 50, "depth")
    made.tf.take(told(link("camera", "depth", 0, 0.3)), is_static=True)
    frame = made.mapped(image(RGB, "rgb8", S))
    made.add_depth(image(DEPTH, "16UC1", S, "depth"))
    depth = made.settled(frame).depth
    assert depth is not None
    # 0.3 m beside, at 1.5 m and f = 50: 10 pixels to the right.
    assert np.isnan(depth[:, :9]).all()
    np.testing.assert_allclose(depth[:, 11:], 1.5, rtol=1e-6)


def test_smaller_registered_depth_fills_the_image() -> None:
    made = frames()
    made.info = info(64, 48, 50)
    frame = made.mapped(image(RGB, "rgb8", S))
    made.add_depth(image(np.full((24, 32), 2.0, np.float32), "32FC1", S))
    depth = made.settled(frame).depth
    assert depth is not None
    np.testing.assert_allclose(depth, 2.0)


def test_stranger_of_a_depth_camera_is_named() -> None:
    made = frames()
    made.info = info(64, 48, 50)
    frame = made.mapped(image(RGB, "rgb8", S))
    made.add_depth(image(DEPTH, "16UC1", S, "depth"))
    problem = made.settled(frame).problem
    assert problem == "depth is of depth, colour of camera, and tf does not join them"
    made.tf.take(told(link("camera", "depth", 0, 0.1)), is_static=True)
    assert made.settled(frame).problem == "depth is of depth, and no CameraInfo of it has come"


def test_image_that_is_none_is_refused() -> None:
    with pytest.raises(UnreadableFile, match="no such image"):
        frames().mapped(image(RGB[:0], "rgb8", S))


def test_distance_of_stamps_is_that_at_the_best() -> None:
    made = frames()
    assert made.apart_s() is None
    for number in range(3):
        made.mapped(image(RGB, "rgb8", S + number * 33 * MS))
    assert made.apart_s() is None
    made.add_depth(image(DEPTH, "16UC1", S + 80 * MS))
    assert made.apart_s() == pytest.approx(0.014)


def test_transform_and_pose_have_the_same_numbers() -> None:
    transform = link("a", "b", 0, 3.0).transform
    pose = Message(position=transform.translation, orientation=transform.rotation)
    assert numbers_of(pose) == numbers_of(transform) == (3, 0, 0, 0, 0, 0, 1)
