"""Frames of a video by number: the same in whatever order they are asked for."""

from __future__ import annotations

import random
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from curiosight.datasets.decoding import UnreadableFile
from curiosight.datasets.video_frames import MAX_STEPS, VideoFrames
from curiosight.errors import DataError
from scan_writers import write_video

N_FRAMES = 150


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write frames in which a bar moves on."""
    path = tmp_path_factory.mktemp("video") / "clip.mp4"
    write_video(path, [picture(index) for index in range(N_FRAMES)])
    return path


def picture(index: int) -> npt.NDArray[np.uint8]:
    rgb = np.full((48, 160, 3), 60, np.uint8)
    rgb[:, index : index + 10] = (250, 200, 100)
    return rgb


def place(rgb: npt.NDArray[np.uint8]) -> int:
    """Return which frame a picture is, by its bar."""
    is_bar = rgb[..., 0].mean(0) > 155
    return int(np.flatnonzero(is_bar)[0])


def test_frames_are_those_asked_for_in_any_order(video: Path) -> None:
    frames = VideoFrames(video, is_turned=False)
    assert frames.n_frames == frames.n_announced == N_FRAMES
    in_order = [frames.read(index) for index in range(N_FRAMES)]
    assert [place(rgb) for rgb in in_order] == pytest.approx(range(N_FRAMES), abs=0.5)
    order = [N_FRAMES - 1, 0, 1, 1, 0, *random.Random(0).choices(range(N_FRAMES), k=40)]
    for index in order:
        np.testing.assert_array_equal(frames.read(index), in_order[index])
    frames.close()
    np.testing.assert_array_equal(frames.read(77), in_order[77])


@pytest.mark.parametrize("fault", ["no times", "wrong times"])
def test_frames_are_counted_where_times_do_not_tell_them(
    fault: str, video: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    listed = {"no times": None, "wrong times": {17.0 * k: k for k in range(N_FRAMES)}}[fault]
    monkeypatch.setattr("curiosight.datasets.video_frames._list_times", lambda path: listed)
    frames = VideoFrames(video, is_turned=False)
    for index in (100, 3, 3 + MAX_STEPS + 5, 0, N_FRAMES - 1):
        assert place(frames.read(index)) == index
    assert frames.n_frames == N_FRAMES


def test_seeking_too_far_is_tried_from_farther_ahead(
    video: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames = VideoFrames(video, is_turned=False)
    frames.fps *= 1.3  # as of a phone that dropped frames: times are not numbers by one factor
    for index in (140, 20, 90, 60):
        assert place(frames.read(index)) == index


def test_video_that_breaks_off(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    codec = cv2.VideoWriter.fourcc(*"MJPG")
    writer = cv2.VideoWriter(str(path), cv2.CAP_OPENCV_MJPEG, codec, 10, (160, 48))
    for index in range(40):
        writer.write(cv2.cvtColor(picture(index), cv2.COLOR_RGB2BGR))
    writer.release()
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    frames = VideoFrames(path, is_turned=False)
    assert place(frames.read(5)) == pytest.approx(5, abs=2)
    with pytest.raises(UnreadableFile):
        frames.read(39)
    assert place(frames.read(2)) == pytest.approx(2, abs=2)


def test_what_is_no_video_is_refused(tmp_path: Path) -> None:
    (tmp_path / "rgb.mp4").write_bytes(b"no video")
    with pytest.raises(DataError, match="cannot be read as a video"):
        VideoFrames(tmp_path / "rgb.mp4", is_turned=False)
