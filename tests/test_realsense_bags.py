"""RealSense's recordings of before 2026: bags of ROS 1 with topics of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bags import Line, Messages, write_bag
from curiosight.datasets import open_dataset
from curiosight.datasets.cameras.registration import register_depth
from curiosight.errors import DataError
from curiosight.frame import Camera
from drawn_cameras import UNIT, room_views
from room import kinect

MAKE = Messages("ros1")
DEPTH_STREAM, COLOUR_STREAM = "/device_0/sensor_0/Depth_0", "/device_0/sensor_1/Color_0"
DEPTH_CAMERA = Camera(160, 120, 120.0, 120.0, 80.0, 60.0)
START_NS = 1_612_345_678_900_000_000
# From the axes of depth to those of colour: as a D435 has it, turned by a degree.
TURN, AT = np.deg2rad(1.0), (0.0148, 0.0003, 0.0002)


def colour_from_depth() -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3] = [
        [np.cos(TURN), 0, np.sin(TURN)],
        [0, 1, 0],
        [-np.sin(TURN), 0, np.cos(TURN)],
    ]
    pose[:3, 3] = AT
    return pose


def units_of(number: int) -> np.ndarray:
    return np.nan_to_num(room_views()[number].depth / UNIT).astype(np.uint16)


def lines(n_frames: int = 3, *, unit: float = UNIT, tf: dict[str, Any] | None = None) -> list[Line]:
    """Return what librealsense wrote; what is static comes first, at 0."""

    def transform(pose: np.ndarray) -> Any:
        vector, turn = MAKE.vector("Vector3", pose), MAKE.quaternion(pose)
        return MAKE.new("geometry_msgs/Transform", translation=vector, rotation=turn)

    words = MAKE.new("std_msgs/String", data="Depth units")
    key = MAKE.new("diagnostic_msgs/KeyValue", key="Name", value="Intel RealSense D435")
    told: list[Line] = [
        ("/file_version", 1, MAKE.new("std_msgs/UInt32", data=3)),
        ("/device_0/info", 1, key),
        (f"{DEPTH_STREAM}/info/camera_info", 1, MAKE.info(DEPTH_CAMERA, 0, frame="")),
        (f"{COLOUR_STREAM}/info/camera_info", 1, MAKE.info(kinect(), 0, frame="")),
        (
            "/device_0/sensor_0/option/Depth Units/value",
            1,
            MAKE.new("std_msgs/Float32", data=float(np.float32(unit))),
        ),
        ("/device_0/sensor_0/option/Depth Units/description", 1, words),
        (f"{DEPTH_STREAM}/tf/0", 1, transform(np.eye(4))),
        (f"{COLOUR_STREAM}/tf/0", 1, transform(colour_from_depth())),
    ]
    for number in range(n_frames):
        at = START_NS + number * 33_333_333
        depth = MAKE.image(units_of(number), "mono16", at, frame="0")
        infrared = MAKE.image((units_of(number) >> 8).astype(np.uint8), "mono8", at, frame="0")
        colour = MAKE.image(room_views()[number].rgb, "rgb8", at + 2_000_000, frame="0")
        logged = 1000 + number * 33_333_333
        told += [
            (f"{DEPTH_STREAM}/image/data", logged, depth),
            ("/device_0/sensor_0/Infrared_1/image/data", logged, infrared),
            (f"{COLOUR_STREAM}/image/data", logged, colour),
        ]
    return told


def test_it_is_read_with_its_unit_and_both_cameras(tmp_path: Path) -> None:
    dataset = open_dataset(write_bag(tmp_path / "old.bag", lines(), "ros1"))
    assert len(dataset) == 3
    assert dataset.ids[0] == "1612345678.902000000"
    assert dataset.camera is not None
    assert (dataset.camera.fx, dataset.camera.cx) == (kinect().fx, kinect().cx)
    assert f"depth is registered to colour, by {COLOUR_STREAM}/tf/0" in dataset.remarks
    for index in range(3):
        frame = dataset[index]
        assert frame.problem is None
        assert np.array_equal(frame.rgb, room_views()[index].rgb)
        raw = units_of(index)
        metres = np.where(raw == 0, np.nan, raw * np.float32(UNIT)).astype(np.float32)
        expected = register_depth(metres, DEPTH_CAMERA, kinect(), colour_from_depth())
        np.testing.assert_allclose(frame.depth, expected, rtol=1e-5)


@pytest.mark.parametrize("unit", [0.001, 0.0001])
def test_unit_is_the_one_that_is_noted(tmp_path: Path, unit: float) -> None:
    dataset = open_dataset(write_bag(tmp_path / "old.bag", lines(1, unit=unit), "ros1"))
    assert dataset.depth_scale == pytest.approx(unit)


def test_orbbecs_own_recordings_are_refused_with_a_remedy(tmp_path: Path) -> None:
    image = MAKE.image(room_views()[0].rgb, "rgb8", START_NS)
    path = write_bag(tmp_path / "orbbec.bag", [("/cam/sensor_2/frameType_2", 1, image)], "ros1")
    with pytest.raises(DataError, match=r"a recording of Orbbec's SDK.*play it into ROS"):
        open_dataset(path)
