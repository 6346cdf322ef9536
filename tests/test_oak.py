"""OAK cameras without one: pipelines that run on this machine alone."""

from __future__ import annotations

import time
from datetime import timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import refusal
from curiosight.frame import Camera
from curiosight.robot.cameras.camera import CameraError, CameraFeed
from curiosight.robot.cameras.oak import Oak, open_oak, synced
from curiosight.robot.feed import EndedError
from drawn_cameras import room_views, shots_of
from scan_writers import write_video

dai: Any = pytest.importorskip("depthai")

N_FRAMES, LOST = 12, 7
K = [[131.0, 0.0, 79.0], [0.0, 132.0, 61.0], [0.0, 0.0, 1.0]]


class Drawn(dai.node.ThreadedHostNode):  # type: ignore[misc]
    """Sends colour and depth of the room, 30 times a second, as a camera would; loses one depth."""

    def __init__(self) -> None:
        super().__init__()
        self.colour, self.depth = self.createOutput(), self.createOutput()

    def run(self) -> None:
        for number in range(N_FRAMES):
            view = room_views()[number % len(room_views())]
            rgb, depth = view.rgb.copy(), np.nan_to_num(view.depth * 1000).astype(np.uint16)
            rgb[0, 0], depth[0, 0] = (255, 0, number), 2000 + number
            colour = dai.ImgFrame()
            colour.setCvFrame(np.ascontiguousarray(rgb[..., ::-1]), dai.ImgFrame.Type.BGR888i)
            colour.setTransformation(dai.ImgTransformation(160, 120, K))
            beside = dai.ImgFrame()
            beside.setFrame(depth)
            beside.setType(dai.ImgFrame.Type.RAW16)
            beside.setWidth(160)
            beside.setHeight(120)
            for image, late_s in ((colour, 0.0), (beside, 0.003)):
                image.setTimestamp(timedelta(seconds=50 + number / 30 + late_s))
                image.setSequenceNum(number)
            self.colour.send(colour)
            if number != LOST:
                self.depth.send(beside)
            time.sleep(1 / 30)


def test_colour_and_depth_of_one_moment_with_what_the_camera_says_of_itself() -> None:
    pipeline = dai.Pipeline(False)
    drawn = pipeline.create(Drawn)
    queue = synced(dai, pipeline, drawn.colour, drawn.depth)
    pipeline.start()
    feed = CameraFeed(Oak("drawn", pipeline, queue), silent_s=0.8)
    shots, end = shots_of(feed)
    assert isinstance(end, CameraError)
    assert str(end).startswith("drawn: has given no frame for 0.8 s")
    feed.close()
    numbers = [int(shot.frame.rgb[0, 0, 2]) for shot in shots]
    assert numbers == sorted(set(numbers))
    assert LOST not in numbers
    assert numbers[-1] == N_FRAMES - 1
    for shot, number in zip(shots, numbers, strict=True):
        frame, view = shot.frame, room_views()[number % len(room_views())]
        assert frame.depth is not None
        assert frame.depth[0, 0] == pytest.approx(2 + number / 1000)
        assert np.array_equal(frame.rgb[1:], view.rgb[1:])
        assert np.allclose(frame.depth[1:], view.depth[1:], atol=2e-3, equal_nan=True)
        assert frame.camera == Camera(160, 120, 131.0, 132.0, 79.0, 61.0)
        assert frame.stamp_ns == pytest.approx((50 + number / 30) * 1e9, abs=2e3)


def test_video_is_replayed_without_a_camera(tmp_path: Path) -> None:
    path = tmp_path / "room.mp4"
    views = room_views()
    write_video(path, [view.rgb for view in views] * 4)
    feed = CameraFeed(open_oak(str(path)))
    assert not feed.device.has_depth
    shots, end = shots_of(feed)
    assert isinstance(end, EndedError)
    feed.close()
    assert shots
    assert np.abs(shots[-1].frame.rgb.astype(int) - views[-1].rgb).mean() < 8


def test_no_camera_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    line = refusal(capsys, "watch", "oak:", "--learn")
    assert line == (
        "curiosight: oak: no OAK camera was found on USB or the network; plug it in, and see the "
        "rights of USB (udev rules)"
    )
