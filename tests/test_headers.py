"""What a picture or a video says of its size is looked at before room is made for it."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import succeed
from curiosight.datasets import headers
from curiosight.datasets.decoding import UnreadableFile, decode_unchanged, read_grey, read_rgb
from curiosight.datasets.headers import size_in_file, size_in_header
from curiosight.datasets.video_frames import VideoFrames
from recordings import write_folder, write_image

Capsys = pytest.CaptureFixture[str]
ENDINGS = ("png", "jpg", "bmp", "tif", "webp", "ppm")


def claim(path: Path, width: int, height: int) -> None:
    """Have a PNG say another size, with the right checksum."""
    content = bytearray(path.read_bytes())
    struct.pack_into(">II", content, 16, width, height)
    struct.pack_into(">I", content, 29, zlib.crc32(content[12:29]))
    path.write_bytes(content)


@pytest.mark.parametrize("ending", ENDINGS)
def test_size_is_that_of_the_picture(ending: str, tmp_path: Path) -> None:
    write_image(tmp_path / f"one.{ending}", np.full((30, 50, 3), 99, np.uint8))
    assert size_in_file(tmp_path / f"one.{ending}") == (50, 30)


def test_size_of_a_jpeg_stands_after_any_other_segments() -> None:
    plain = cv2.imencode(".jpg", np.zeros((30, 50, 3), np.uint8))[1].tobytes()
    progressive = cv2.imencode(
        ".jpg", np.zeros((30, 50, 3), np.uint8), [cv2.IMWRITE_JPEG_PROGRESSIVE, 1]
    )[1].tobytes()
    comment = b"\xff\xfe" + struct.pack(">H", 40_002) + bytes(40_000)
    for content in (plain, progressive, plain[:2] + 3 * comment + b"\xff\xff" + plain[2:]):
        assert size_in_header(io.BytesIO(content)) == (50, 30)
    for length in range(len(plain[: plain.index(b"\xff\xc0") + 8])):
        assert size_in_header(io.BytesIO(plain[:length])) is None


@pytest.mark.parametrize("content", [b"", b"hello", b"\xff\xd8\xff\xff\xff", b"P5", b"II*\0\xff"])
def test_what_has_no_size_says_none(content: bytes) -> None:
    assert size_in_header(io.BytesIO(content)) is None


@pytest.mark.parametrize("ending", ENDINGS)
def test_picture_that_says_it_is_giant_is_not_decoded(
    ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / f"one.{ending}"
    write_image(path, np.full((30, 50, 3), 99, np.uint8))
    monkeypatch.setattr(headers, "MAX_PIXELS", 1500)
    assert read_rgb(path).shape == (30, 50, 3)
    monkeypatch.setattr(headers, "MAX_PIXELS", 1499)
    for read in (read_rgb, read_grey, decode_unchanged):
        with pytest.raises(UnreadableFile, match=r"^one\.\w+ says that it has more than"):
            read(path)


def test_frames_that_say_another_size_are_bad_before_they_are_decoded(
    tmp_path: Path, capsys: Capsys
) -> None:
    write_folder(tmp_path / "room", 5)
    claim(tmp_path / "room/rgb/000001.png", 170, 120)
    claim(tmp_path / "room/depth/000002.png", 160, 130)
    claim(tmp_path / "room/ground_truth/000003.png", 170, 130)
    outcome = succeed(
        capsys, "evaluate", tmp_path / "room", "--folds", 2, "--out", tmp_path / "out"
    )
    assert "3 of 5 frames could not be used: bad frame, first 000001" in outcome.err
    assert "000001.png is 170x120, not 160x120 as the recording" in outcome.err


def test_video_has_no_more_frames_than_its_file_can_hold(tmp_path: Path) -> None:
    path = tmp_path / "film.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10, (64, 48))
    for _ in range(5):
        writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    assert VideoFrames(path, is_turned=False).n_announced == 5
    content = bytearray(path.read_bytes())
    for chunk, field in ((b"avih", 24), (b"strh", 40)):  # frames in all; length of the stream
        struct.pack_into("<I", content, content.index(chunk) + field, 100_000)
    path.write_bytes(content)
    n_bytes = path.stat().st_size
    assert VideoFrames(path, is_turned=False).n_announced <= n_bytes // 4 < 100_000
