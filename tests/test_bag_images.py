"""Images of bags: every encoding, order of bytes, padding and compression; and their cameras."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from bags import (
    COLOUR,
    DEPTH,
    DEPTH_INFO,
    INFO,
    START_NS,
    STEP_NS,
    Messages,
    look_alike,
    png,
    rvl,
    write_bag,
    write_plain_mcap,
)
from curiosight.datasets import Reading, RosBag, open_dataset
from curiosight.datasets.bags.camera_info import to_camera
from curiosight.datasets.bags.images import to_depth, to_rgb
from curiosight.datasets.decoding import UnreadableFile
from curiosight.errors import DataError
from curiosight.frame import Camera

RNG = np.random.default_rng(5)
RGB = RNG.integers(0, 256, (6, 8, 3), np.uint8)
UNITS = RNG.integers(300, 5000, (6, 9), np.uint16)
UNITS[1:3, 2:7] = 0
METRES = (UNITS / np.float32(1000)).astype(np.float32)
MAKERS = [Messages("cdr"), Messages("ros1")]
CAMERA = Camera(640, 480, 500.0, 510.0, 320.0, 240.0)


def opened(path: Path, **options: Any) -> RosBag:
    dataset = open_dataset(path, reading=Reading(**options))
    assert isinstance(dataset, RosBag)
    return dataset


@pytest.mark.parametrize("padding", [0, 5])
@pytest.mark.parametrize(
    ("encoding", "code"),
    [
        ("rgb8", None),
        ("bgr8", cv2.COLOR_RGB2BGR),
        ("8UC3", cv2.COLOR_RGB2BGR),
        ("rgba8", cv2.COLOR_RGB2RGBA),
        ("bgra8", cv2.COLOR_RGB2BGRA),
    ],
)
def test_colour_of_every_encoding(encoding: str, code: int | None, padding: int) -> None:
    stored = RGB if code is None else cv2.cvtColor(RGB, code)
    for make in MAKERS:
        message = make.image(stored, encoding, padding=padding)
        np.testing.assert_array_equal(to_rgb(message, "a"), RGB)


def test_grey_is_colour_of_three_equal_channels() -> None:
    for encoding in ("mono8", "8UC1"):
        rgb = to_rgb(MAKERS[0].image(RGB[..., 0], encoding, padding=3), "a")
        np.testing.assert_array_equal(rgb, np.repeat(RGB[..., :1], 3, axis=2))


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_bayer_patterns_are_named_by_their_first_four_pixels(pattern: str) -> None:
    colour = {"r": 200, "g": 120, "b": 40}
    mosaic = np.zeros((12, 16), np.uint8)
    for place, letter in enumerate(pattern):
        mosaic[place // 2 :: 2, place % 2 :: 2] = colour[letter]
    rgb = to_rgb(MAKERS[0].image(mosaic, f"bayer_{pattern}8"), "a")
    np.testing.assert_array_equal(rgb[3:-3, 3:-3], np.full((6, 10, 3), (200, 120, 40)))


@pytest.mark.parametrize(("encoding", "luma"), [("yuv422", 1), ("yuv422_yuy2", 0)])
def test_yuv_tells_brightness_from_colour(encoding: str, luma: int) -> None:
    stored = np.full((4, 6, 2), 128, np.uint8)  # no colour
    stored[..., luma] = 235  # white
    assert (to_rgb(MAKERS[0].image(stored, encoding), "a") == 255).all()


@pytest.mark.parametrize("text", ["png", "rgb8; png compressed bgr8", "bgr8; png compressed bgr8"])
def test_compressed_colour(text: str) -> None:
    message = MAKERS[0].compressed(png(cv2.cvtColor(RGB, cv2.COLOR_RGB2BGR)), text)
    np.testing.assert_array_equal(to_rgb(message, "a"), RGB)


def test_compressed_colour_whose_encoder_was_given_red_first() -> None:
    message = MAKERS[0].compressed(png(RGB), "rgb8; png compressed rgb8")
    np.testing.assert_array_equal(to_rgb(message, "a"), RGB)


def test_jpeg_is_read_and_one_that_is_cut_refused() -> None:
    content = bytes(cv2.imencode(".jpg", np.full((16, 16, 3), (0, 0, 200), np.uint8))[1])
    rgb = to_rgb(MAKERS[0].compressed(content, "jpeg"), "a")
    assert np.abs(rgb.astype(int) - (200, 0, 0)).max() < 4
    with pytest.raises(UnreadableFile, match="a is truncated"):
        to_rgb(MAKERS[0].compressed(content[:-40], "jpeg"), "a")


@pytest.mark.parametrize("padding", [0, 6])
@pytest.mark.parametrize("is_bigendian", [False, True])
@pytest.mark.parametrize(
    ("stored", "encoding"), [(UNITS, "16UC1"), (UNITS, "mono16"), (METRES, "32FC1")]
)
def test_depth_of_every_form(stored: Any, encoding: str, is_bigendian: bool, padding: int) -> None:
    for make in MAKERS:
        message = make.image(stored, encoding, padding=padding, is_bigendian=is_bigendian)
        depth = to_depth(message, "a")
        assert depth.dtype == stored.dtype
        np.testing.assert_array_equal(depth, stored)


def test_the_last_row_may_come_without_its_padding() -> None:
    message = MAKERS[0].image(UNITS, "16UC1", padding=6)
    message.data = message.data[:-6]
    np.testing.assert_array_equal(to_depth(message, "a"), UNITS)
    message.data = message.data[:-1]
    with pytest.raises(UnreadableFile, match="a holds 137 of its 138 bytes"):
        to_depth(message, "a")


@pytest.mark.parametrize("head", [b"\0" * 12, b""])
@pytest.mark.parametrize("text", ["16UC1; compressedDepth", "16UC1; compressedDepth png"])
def test_compressed_depth_of_whole_numbers(text: str, head: bytes) -> None:
    message = MAKERS[0].compressed(head + png(UNITS), text)
    np.testing.assert_array_equal(to_depth(message, "a"), UNITS)


def test_compressed_depth_by_rvl() -> None:
    content = b"\0" * 12 + rvl(UNITS)
    depth = to_depth(MAKERS[0].compressed(content, "16UC1; compressedDepth rvl"), "a")
    assert depth.dtype == np.uint16
    np.testing.assert_array_equal(depth, UNITS)
    with pytest.raises(UnreadableFile, match="a is truncated"):
        to_depth(MAKERS[0].compressed(content[:-20], "16UC1; compressedDepth rvl"), "a")


def test_rvl_of_known_words() -> None:
    # No zeros, a run of 3: 1000, then 1 more, then 3 less; 2 numbers in 3 bits a nibble.
    # 0 | 3 | 2000 = 3720 octal from the last: 8+0 8+2 8+7 3 | 2 | 5
    words = struct.pack("<II", 0x038AF325, 0)
    content = b"\0" * 12 + struct.pack("<II", 3, 1) + words
    depth = to_depth(MAKERS[0].compressed(content, "16UC1; compressedDepth rvl"), "a")
    np.testing.assert_array_equal(depth, [[1000, 1001, 998]])


@pytest.mark.parametrize("form", ["png", "rvl"])
def test_compressed_depth_of_floats_is_an_inverse(form: str) -> None:
    scale, offset = 100.0 * 101.0, 101.0 / 10 - 1  # as the transport has it for 10 m
    inverse = np.array([[0, 5000, 10000]], np.uint16)
    head = struct.pack("<iff", 0, scale, offset)
    body = png(inverse) if form == "png" else rvl(inverse)
    message = MAKERS[0].compressed(head + body, f"32FC1; compressedDepth {form}")
    depth = to_depth(message, "a")
    np.testing.assert_allclose(depth, [[np.nan, 10100 / 4990.9, 10100 / 9990.9]], rtol=1e-6)


@pytest.mark.parametrize("text", ["16UC1; compressedDepth png", "16UC1; compressedDepth rvl"])
def test_compressed_depth_that_is_damaged_is_unreadable(text: str) -> None:
    for content in (b"", b"\0" * 12, b"\0" * 40, b"\xff" * 40):
        with pytest.raises(UnreadableFile):
            to_depth(MAKERS[0].compressed(content, text), "a")


def test_what_is_no_colour_or_depth_is_named() -> None:
    with pytest.raises(UnreadableFile, match="encoded as 32FC1, which is no colour"):
        to_rgb(MAKERS[0].image(METRES, "32FC1"), "a")
    with pytest.raises(UnreadableFile, match="encoded as rgb8, which is no depth"):
        to_depth(MAKERS[0].image(RGB, "rgb8"), "a")
    with pytest.raises(UnreadableFile, match="8 bits a pixel"):
        to_depth(MAKERS[0].image(RGB[..., 0], "mono8"), "a")


def test_compressed_and_raw_bags_are_the_same_frames(tmp_path: Path) -> None:
    make = Messages("ros1")
    lines = look_alike(make)
    other = []
    for topic, stamp, message in lines:
        if topic == COLOUR:
            image = make.compressed(
                png(to_rgb(message, "")[..., ::-1]), "rgb8; png compressed bgr8", stamp
            )
            other.append((f"{COLOUR}/compressed", stamp, image))
        elif topic == DEPTH:
            content = b"\0" * 12 + png(to_depth(message, ""))
            image = make.compressed(content, "16UC1; compressedDepth png", stamp)
            other.append((f"{DEPTH}/compressedDepth", stamp, image))
        else:
            other.append((topic, stamp, message))
    raw = opened(write_bag(tmp_path / "raw.bag", lines, "ros1"))
    packed = opened(write_bag(tmp_path / "packed.bag", other, "ros1"))
    assert raw.camera == packed.camera
    for index in range(2):
        np.testing.assert_array_equal(raw[index].rgb, packed[index].rgb)
        np.testing.assert_array_equal(raw[index].depth, packed[index].depth)


def test_raw_images_are_of_one_matrix_and_rectified_ones_of_the_other() -> None:
    P = [400.0, 0, 310, 7, 0, 410, 230, 0, 0, 0, 1, 0]
    for make in MAKERS:
        info = make.info(CAMERA, P=P, D=[0.1, 0, 0, 0, 0])
        assert to_camera(info, (640, 480), is_rectified=False) == CAMERA
        rectified = to_camera(info, (640, 480), is_rectified=True)
        assert rectified == Camera(640, 480, 400.0, 410.0, 310.0, 230.0)


def test_a_camera_that_was_never_calibrated_is_none() -> None:
    info = MAKERS[0].info(CAMERA, K=[0] * 9, P=[0] * 12)
    assert to_camera(info, (640, 480), is_rectified=False) is None
    only_projected = MAKERS[0].info(CAMERA, K=[0] * 9)
    assert to_camera(only_projected, (640, 480), is_rectified=False) == CAMERA


def test_binning_and_the_region_of_interest_are_taken_from_the_camera() -> None:
    info = MAKERS[0].info(CAMERA, roi=(100, 60, 400, 300), binning=(2, 2))
    part = to_camera(info, (200, 150), is_rectified=False)
    assert part == Camera(200, 150, 250.0, 255.0, 110.0, 90.0)
    binned = to_camera(MAKERS[0].info(CAMERA, binning=(2, 2)), (320, 240), is_rectified=False)
    assert binned == Camera(320, 240, 250.0, 255.0, 160.0, 120.0)
    # Some say so of images that are whole.
    assert to_camera(info, (640, 480), is_rectified=False) == CAMERA


def test_images_smaller_than_their_camera_without_a_word_are_scaled() -> None:
    camera = to_camera(MAKERS[0].info(CAMERA), (320, 240), is_rectified=False)
    assert camera == Camera(320, 240, 250.0, 255.0, 159.75, 119.75)


def test_each_image_has_the_camera_of_its_time(tmp_path: Path) -> None:
    lines = look_alike(Messages(), 3)
    lines[3][2].k[0] = 15.0
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert [dataset[index].camera.fx for index in range(3)] == [14.0, 15.0, 14.0]  # type: ignore[union-attr]


def test_without_camera_info_a_kinect_is_taken_and_said(tmp_path: Path) -> None:
    lines = [line for line in look_alike(Messages()) if line[0] != INFO]
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert dataset.camera is not None
    assert dataset.camera.fx == 525 / 40
    assert "no CameraInfo: the usual intrinsics of a Kinect are assumed" in dataset.remarks


def test_registered_depth_of_half_the_size_is_brought_to_colour(tmp_path: Path) -> None:
    make = Messages()
    lines = [line for line in look_alike(make, 1) if line[0] != DEPTH]
    small = np.arange(1000, 1000 + 8 * 6, dtype=np.uint16).reshape(6, 8)
    lines.append((DEPTH, START_NS, make.image(small, "16UC1")))
    lines.append((DEPTH_INFO, START_NS, make.info(Camera(8, 6, 7.0, 7.0, 3.5, 2.5))))
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    expected = np.repeat(np.repeat(small, 2, axis=0), 2, axis=1) * np.float32(0.001)
    np.testing.assert_array_equal(dataset[0].depth, expected)
    assert any("depth is 8x6: brought to 16x12" in remark for remark in dataset.remarks)


def test_depth_of_a_camera_beside_is_cast_into_colour(tmp_path: Path) -> None:
    make = Messages()
    lines = [line for line in look_alike(make, 1) if line[0] != DEPTH]
    depth = np.full((12, 16), 1000, np.uint16)
    depth[:, 8:] = 2000
    lines.append((DEPTH, START_NS, make.image(depth, "16UC1", frame="depth")))
    own = Camera(16, 12, 14.0, 14.0, 7.5, 5.5)
    lines.append((DEPTH_INFO, START_NS, make.info(own, frame="depth")))
    beside = np.eye(4)
    beside[0, 3] = 1 / 7  # metres to the right: 2 pixels at 1 m, 1 pixel at 2 m
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert any("taken as registered" in remark for remark in dataset.remarks)
    np.testing.assert_allclose(dataset[0].depth[:, 7:9], [[1, 2]] * 12)  # type: ignore[index]
    link = make.tf(("camera_color_optical_frame", "depth", beside, START_NS))
    dataset = opened(
        write_plain_mcap(tmp_path / "b.mcap", [*lines, ("/tf_static", START_NS, link)])
    )
    assert "depth (depth) is registered to colour (camera_color_optical_frame)" in dataset.remarks
    row = dataset[0].depth[6]  # type: ignore[index]
    assert np.isnan(row[:2]).all()
    np.testing.assert_allclose(row[2:10], 1.0)
    np.testing.assert_allclose(row[10:], 2.0)


def test_the_unit_that_a_realsense_notes_is_read(tmp_path: Path) -> None:
    make = Messages()
    text = make.new("std_msgs/String", data="0.000250")
    topic = "/device_0/sensor_0/option/Depth_Units/value"
    path = write_plain_mcap(tmp_path / "a.mcap", [*look_alike(make), (topic, START_NS, text)])
    np.testing.assert_allclose(opened(path)[1].depth, 0.5)
    assert f"depth is in units of 0.00025 m, by {topic}" in opened(path).remarks
    np.testing.assert_allclose(opened(path, depth_scale=0.01)[1].depth, 20.0)


def test_depth_of_eight_bits_is_refused(tmp_path: Path) -> None:
    make = Messages()
    lines = [line for line in look_alike(make) if line[0] != DEPTH]
    grey = make.image(np.zeros((12, 16), np.uint8), "mono8")
    lines.append(("/depth/shown", START_NS, grey))
    path = write_plain_mcap(tmp_path / "a.mcap", lines)
    with pytest.raises(DataError, match="depth of 8 bits a pixel"):
        opened(path, topics="depth=/depth/shown")


def test_an_encoding_of_another_make_is_a_bad_frame(tmp_path: Path) -> None:
    make = Messages()
    lines = look_alike(make, 2)
    last = [index for index, line in enumerate(lines) if line[0] == DEPTH][-1]
    odd = make.image(RGB, "rgb8", START_NS + STEP_NS)
    lines[last] = (DEPTH, START_NS + STEP_NS, odd)
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert dataset[0].problem is None
    assert "encoded as rgb8, which is no depth" in str(dataset[1].problem)
