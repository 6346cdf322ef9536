"""RealSense cameras without one: a software device, and playback of what it recorded."""

from __future__ import annotations

import gc
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command import refusal, succeed
from curiosight.datasets import open_dataset
from curiosight.datasets.cameras.registration import register_depth
from curiosight.experiments import camera_start
from curiosight.robot.cameras import realsense
from curiosight.robot.cameras.camera import CameraFeed
from curiosight.robot.cameras.realsense import RealSense, open_realsense
from curiosight.robot.feed import EndedError, Shot
from drawn_cameras import FIRST_S, MIDDLE, NEAR, UNIT, DrawnRealSense, room_views, shots_of

# It needs libusb of the system, which a fresh one lacks.
rs: Any = pytest.importorskip("pyrealsense2", exc_type=ImportError)

Capsys = pytest.CaptureFixture[str]
N_FRAMES, SHIFT = 20, 0.02


def number_of(shot: Shot) -> int:
    """Return what colour is marked with."""
    return int(shot.frame.rgb[0, 0, 0])


def next_shot(feed: CameraFeed) -> Shot:
    until = time.monotonic() + 5
    while time.monotonic() < until:
        if (shot := feed.newest(0.1)) is not None:
            return shot
    raise AssertionError("no frame came")


def test_depth_is_registered_to_colour_in_its_own_unit() -> None:
    drawn = DrawnRealSense(shift=SHIFT)
    feed = CameraFeed(RealSense("drawn", drawn.device))
    assert feed.newest(0.01) is None
    drawn.show(3)
    frame = next_shot(feed).frame
    units = np.nan_to_num(room_views()[3].depth / UNIT).astype(np.uint16)
    units[54:66, 74:86] = NEAR + 3
    metres = np.where(units == 0, np.nan, units * np.float32(UNIT)).astype(np.float32)
    T_colour_depth = np.eye(4)
    T_colour_depth[0, 3] = np.float32(SHIFT)
    expected = register_depth(metres, drawn.depth_camera, drawn.camera, T_colour_depth)
    assert frame.depth is not None
    assert np.allclose(frame.depth, expected, atol=1e-5, equal_nan=True)
    assert frame.camera is not None
    assert frame.camera.fx == pytest.approx(drawn.camera.fx)
    assert frame.camera.depth_window is not None
    assert frame.stamp_ns == pytest.approx(FIRST_S * 1e9 + 102e6, abs=1e3)
    assert frame.id == f"{FIRST_S}.{frame.stamp_ns % 10**9:09d}"
    feed.close()


def test_frames_of_one_moment_alone_are_given() -> None:
    drawn = DrawnRealSense()
    feed = CameraFeed(RealSense("drawn", drawn.device), silent_s=0.3)
    feed.newest(0.01)
    drawn.show_depth(0, np.full((120, 160), 2000, np.uint16))
    drawn.show_colour(1, room_views()[0].rgb)  # the colour of 0 was lost, and the depth of 1
    shots, end = shots_of(feed)
    assert not shots
    assert "colour and depth come, but not of one moment" in str(end)
    feed.close()


def test_camera_that_stopped_is_told_from_one_that_never_began() -> None:
    drawn = DrawnRealSense()
    camera = RealSense("drawn", drawn.device)
    feed = CameraFeed(camera)
    feed.newest(0.01)
    drawn.show(0)
    next_shot(feed)
    assert camera.silence(now=time.monotonic() + 2) == "colour and depth have stopped"
    feed.close()


def test_stream_that_is_missing_is_named() -> None:
    drawn = DrawnRealSense()
    feed = CameraFeed(RealSense("drawn", drawn.device), silent_s=0.3)
    feed.newest(0.01)
    drawn.show_colour(1, room_views()[0].rgb)
    shots, end = shots_of(feed)
    assert not shots
    assert "(no depth at all)" in str(end)
    feed.close()


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What pyrealsense2 records of a software device: 20 frames."""
    path = tmp_path_factory.mktemp("recordings") / "realsense.db3"
    drawn = DrawnRealSense(shift=SHIFT)
    recorder = rs.recorder(str(path), drawn.device)
    camera = RealSense("drawn", recorder)
    for number in range(N_FRAMES):
        drawn.show(number)
        time.sleep(0.02)
    time.sleep(0.3)
    camera.close()
    del camera, recorder, drawn
    gc.collect()  # it is closed with the last that knows it
    return path


def test_playback_never_mixes_frames(recording: Path) -> None:
    feed = CameraFeed(open_realsense(str(recording)))
    shots, end = shots_of(feed)
    assert isinstance(end, EndedError)
    feed.close()
    numbers = [number_of(shot) for shot in shots]
    assert numbers == sorted(set(numbers))
    assert numbers[-1] == N_FRAMES - 1
    for shot, number in zip(shots, numbers, strict=True):
        assert shot.frame.depth is not None
        assert shot.frame.depth[MIDDLE] == pytest.approx((NEAR + number) * UNIT, abs=1e-5)


def test_recording_is_read_without_the_driver(recording: Path) -> None:
    dataset = open_dataset(recording)
    assert dataset.name == "ROS bag"
    assert len(dataset) >= N_FRAMES - 1
    assert dataset.camera is not None
    for index in range(0, len(dataset), 6):
        frame = dataset[index]
        assert frame.problem is None
        assert frame.depth is not None
        number = int(frame.rgb[0, 0, 0])
        assert frame.depth[MIDDLE] == pytest.approx((NEAR + number) * UNIT, abs=1e-5)
    assert dataset.camera.fx == pytest.approx(DrawnRealSense().camera.fx)
    assert dataset.depth_camera is not None
    assert dataset.depth_camera.T_colour_depth[:3, 3] == pytest.approx([SHIFT, 0, 0])
    assert dataset.depth_camera.camera.fx == pytest.approx(DrawnRealSense().depth_camera.fx)


def test_frames_are_paired_by_when_they_were_taken_not_by_when_they_came(tmp_path: Path) -> None:
    path = tmp_path / "late.db3"
    drawn = DrawnRealSense()
    recorder = rs.recorder(str(path), drawn.device)
    camera = RealSense("drawn", recorder)
    for number in range(8):  # colour comes when the next depth is there already
        drawn.show_depth(number, np.full((120, 160), NEAR + number, np.uint16))
        time.sleep(0.002)
        if number:
            drawn.show_colour(number - 1, np.full((120, 160, 3), number - 1, np.uint8))
        time.sleep(0.02)
    time.sleep(0.2)
    camera.close()
    del camera, recorder, drawn
    gc.collect()
    dataset = open_dataset(path)
    assert "colour and depth are paired by the frames' own times" in dataset.remarks
    assert len(dataset) >= 5
    for index in range(len(dataset)):
        frame = dataset[index]
        assert frame.depth is not None
        number = int(frame.rgb[0, 0, 0])
        assert frame.depth[60, 80] == pytest.approx((NEAR + number) * UNIT, abs=1e-5)


def test_watch_learns_from_it(
    capsys: Capsys, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    drawn = DrawnRealSense()
    monkeypatch.setattr(realsense, "connected", lambda rs: [drawn.device])
    monkeypatch.setattr(camera_start, "LOOK_ROUND_S", 0.3)
    out = tmp_path / "run"
    asked = "watch", "realsense:SW123", "--learn", "--seconds", 1, "--out", out, "--json"
    with drawn.showing():
        told = succeed(capsys, *asked)
    summary = json.loads(told.out)
    assert summary["source"] == "realsense:SW123"
    assert summary["learned"] > 0


def test_no_camera_is_one_line(capsys: Capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    line = refusal(capsys, "watch", "realsense:", "--learn")
    assert line == (
        "curiosight: realsense: no RealSense camera was found on USB or the network; plug it in "
        "(a port of USB 3), and see its rights"
    )
    monkeypatch.setattr(realsense, "connected", lambda rs: [DrawnRealSense().device])
    line = refusal(capsys, "watch", "realsense:7", "--learn")
    assert "no RealSense camera of serial number 7 was found; there are SW123" in line
