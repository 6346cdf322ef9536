"""Bags of every kind are read as recordings: files, pairs, topics, what is cut or missing."""

from __future__ import annotations

import pickle
import shutil
import sqlite3
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode

from bags import (
    COLOUR,
    DEPTH,
    INFO,
    START_NS,
    STEP_NS,
    Line,
    Messages,
    look_alike,
    png,
    write_bag,
    write_plain_mcap,
)
from command import files, refusal, succeed
from curiosight import check_dataset
from curiosight.datasets import Reading, RosBag, open_dataset
from curiosight.errors import DataError
from curiosight.frame import Camera
from recordings import truncate, write_folder

Capsys = pytest.CaptureFixture[str]
IDS = ("1305031229.528748000", "1305031229.628748000")


def opened(path: Path, topics: str = "") -> RosBag:
    dataset = open_dataset(path, reading=Reading(topics=topics))
    assert isinstance(dataset, RosBag)
    return dataset


def check_look_alike(dataset: RosBag, ids: Sequence[str] = IDS) -> None:
    assert dataset.ids == tuple(ids)
    assert dataset.camera == Camera(16, 12, 14.0, 14.0, 7.5, 5.5)
    for number, frame in enumerate(dataset[index] for index in range(len(ids))):
        assert frame.problem is None
        assert frame.stamp_ns == START_NS + number * STEP_NS
        assert (frame.rgb == number).all()
        assert frame.depth is not None
        np.testing.assert_allclose(frame.depth, number + 1, rtol=1e-6)


@pytest.mark.parametrize("kind", ["ros1", "sqlite", "mcap"])
def test_every_kind_is_read(kind: str, tmp_path: Path) -> None:
    make = Messages("ros1" if kind == "ros1" else "cdr")
    path = write_bag(tmp_path / "a.bag", look_alike(make), kind)
    check_look_alike(opened(path))
    check_dataset(opened(path))
    assert f"topics: color {COLOUR}, depth {DEPTH}, info {INFO}" in opened(path).remarks
    assert not any("announces" in remark or "cut" in remark for remark in opened(path).remarks)
    check_look_alike(pickle.loads(pickle.dumps(opened(path))))
    if kind != "ros1":  # the file alone, without its metadata.yaml
        (bare,) = (file for file in path.iterdir() if file.suffix != ".yaml")
        check_look_alike(opened(bare))


@pytest.mark.parametrize("compression", ["lz4", "bz2"])
def test_compressed_chunks_of_ros1_are_read(compression: str, tmp_path: Path) -> None:
    form = Ros1Writer.CompressionFormat[compression.upper()]
    lines = look_alike(Messages("ros1"))
    path = write_bag(tmp_path / "a.bag", lines, "ros1", lambda w: w.set_compression(form))
    check_look_alike(opened(path))


@pytest.mark.parametrize("kind", ["sqlite", "mcap"])
@pytest.mark.parametrize("mode", [CompressionMode.FILE, CompressionMode.MESSAGE])
def test_compressed_bags_of_ros2_are_read(kind: str, mode: CompressionMode, tmp_path: Path) -> None:
    def compress(writer: object) -> None:
        writer.set_compression(mode, CompressionFormat.ZSTD)  # type: ignore[attr-defined]

    path = write_bag(tmp_path / "a", look_alike(Messages()), kind, compress)
    check_look_alike(opened(path))


def test_compressed_chunks_of_mcap_are_read(tmp_path: Path) -> None:
    def compress(writer: object) -> None:
        mode = CompressionMode.STORAGE
        writer.set_compression(mode, CompressionFormat.ZSTD)  # type: ignore[attr-defined]

    path = write_bag(tmp_path / "a", look_alike(Messages()), "mcap", compress)
    assert (path / "a.mcap").stat().st_size < 5000  # else nothing was compressed
    check_look_alike(opened(path))


@pytest.mark.parametrize("is_chunked", [False, True])
def test_mcap_without_any_index_and_out_of_order_is_read(is_chunked: bool, tmp_path: Path) -> None:
    lines = look_alike(Messages())[::-1]
    check_look_alike(opened(write_plain_mcap(tmp_path / "a.mcap", lines, is_chunked=is_chunked)))


@pytest.mark.parametrize("kind", ["ros1", "sqlite", "mcap"])
def test_cut_recording_is_read_to_its_last_whole_message(kind: str, tmp_path: Path) -> None:
    make = Messages("ros1" if kind == "ros1" else "cdr")
    camera = Camera(80, 60, 70.0, 70.0, 39.5, 29.5)
    path = write_bag(tmp_path / "a.bag", look_alike(make, 6, camera=camera), kind)
    if kind != "ros1":
        (path,) = (file for file in path.iterdir() if file.suffix != ".yaml")
    truncate(path, 0.7)
    dataset = opened(path)
    assert 3 <= len(dataset) <= 4
    for number in range(len(dataset)):
        frame = dataset[number]
        assert frame.problem is None
        assert (frame.rgb == number).all()
        np.testing.assert_allclose(frame.depth, number + 1, rtol=1e-6)
    assert any("read to its last whole message" in remark for remark in dataset.remarks)


def test_what_a_bag_announces_is_compared_with_what_was_read(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "a", look_alike(Messages()), "mcap")
    metadata = path / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace("message_count: 6", "message_count: 9"))
    assert "it announces 9 messages, 6 were read" in opened(path).remarks
    check_look_alike(opened(path))


def test_what_a_killed_recorder_left_beside_its_database_is_read(tmp_path: Path) -> None:
    path = write_bag(tmp_path / "a", look_alike(Messages()), "sqlite")
    (tmp_path / "killed").mkdir()
    database = sqlite3.connect(path / "a.db3")
    database.execute("PRAGMA journal_mode=WAL")
    database.execute("PRAGMA wal_autocheckpoint=0")
    (row,) = database.execute("SELECT max(id) FROM messages").fetchone()
    columns = "topic_id, timestamp, data"
    database.execute(f"INSERT INTO messages({columns}) SELECT {columns} FROM messages WHERE id < 3")
    database.execute("DELETE FROM messages WHERE id < 3")
    database.commit()
    for file in path.glob("a.db3*"):
        shutil.copy(file, tmp_path / "killed" / file.name.replace("a.db3", "a_0.db3"))
    database.close()
    assert row == 6
    (tmp_path / "killed/a_0.db3-shm").unlink()
    dataset = opened(tmp_path / "killed")
    check_look_alike(dataset)
    assert files(tmp_path / "killed") == {"a_0.db3", "a_0.db3-wal"}
    assert "there is no metadata.yaml: it was not closed" in dataset.remarks


def test_parts_of_a_split_bag_are_one_recording(tmp_path: Path) -> None:
    lines = look_alike(Messages())
    for number, part in enumerate((lines[:3], lines[3:])):
        write_plain_mcap(tmp_path / f"a_{number}.mcap", part)
    check_look_alike(opened(tmp_path))
    write_plain_mcap(tmp_path / "other.mcap", lines)
    with pytest.raises(DataError, match=r"holds 3 bags; give one of them, a_0\.mcap say"):
        open_dataset(tmp_path)


def test_a_recording_beside_a_bag_is_still_a_folder(tmp_path: Path) -> None:
    write_folder(tmp_path, 2)
    write_plain_mcap(tmp_path / "raw.mcap", look_alike(Messages()))
    assert open_dataset(tmp_path).name == "plain folder"


def test_depth_is_the_nearest_in_time_and_the_tolerance_is_said(tmp_path: Path) -> None:
    make = Messages()
    rgb, depth = np.zeros((4, 6, 3), np.uint8), np.full((4, 6), 1000, np.uint16)
    lines: list[Line] = []
    for number, offset_ms in enumerate((0, 19, 21)):
        stamp = START_NS + number * STEP_NS
        lines.append((COLOUR, stamp, make.image(rgb, "rgb8", stamp)))
        lines.append((DEPTH, stamp, make.image(depth, "16UC1", stamp + offset_ms * 10**6)))
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert dataset.ids == IDS
    said = "depth is the nearest in time within 20 ms; 1 colour images have none: left out"
    assert said in dataset.remarks
    apart = [line for line in lines if line[0] == COLOUR]
    apart.append((DEPTH, START_NS, make.image(depth, "16UC1", START_NS - 50 * 10**6)))
    with pytest.raises(DataError, match=r"none of its 3 colour images has depth.* 50 ms off"):
        opened(write_plain_mcap(tmp_path / "b.mcap", apart))


def test_images_stamped_alike_go_by_the_time_of_recording(tmp_path: Path) -> None:
    make = Messages()
    lines = [
        (topic, logged_ns, message)
        for topic, logged_ns, message in look_alike(make)
        if topic != INFO
    ]
    for _, _, message in lines:
        message.header.stamp.sec = message.header.stamp.nanosec = 0
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert dataset.ids == IDS
    assert any("are all stamped alike" in remark for remark in dataset.remarks)


def test_images_of_one_stamp_are_one_frame(tmp_path: Path) -> None:
    lines = look_alike(Messages())
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", [*lines, *lines]))
    check_look_alike(dataset)
    assert "2 colour images have another's stamp: left out" in dataset.remarks


def test_topics_are_guessed_among_others(tmp_path: Path) -> None:
    make = Messages()
    lines = look_alike(make)
    grey, ir = np.full((12, 16), 9, np.uint8), np.full((12, 16), 9, np.uint16)
    shown = np.full((12, 16, 3), 9, np.uint8)
    for number in range(4):
        stamp = START_NS + number * STEP_NS // 2
        others = {
            "/camera/infra1/image_rect_raw": make.image(grey, "mono8", stamp),
            "/camera/ir/image_raw": make.image(ir, "mono16", stamp),
            "/camera/depth/colored": make.image(shown, "rgb8", stamp),
            "/detector/debug_image": make.image(shown, "bgr8", stamp),
            "/camera/color/image_raw/compressed": make.compressed(png(shown), "png", stamp),
        }
        lines += [(topic, stamp, message) for topic, message in others.items()]
    check_look_alike(opened(write_plain_mcap(tmp_path / "a.mcap", lines)))


def test_named_topics_are_read(tmp_path: Path, capsys: Capsys) -> None:
    make = Messages()
    lines = look_alike(make)
    red, near = np.full((12, 16, 3), 5, np.uint8), np.full((12, 16), 500, np.uint16)
    lines.append(("/odd", START_NS, make.image(red, "rgb8", START_NS)))
    lines.append(("/odder", START_NS, make.image(near, "16UC1", START_NS)))
    wide = Camera(16, 12, 9.0, 9.0, 7.5, 5.5)
    lines.append(("/oddest", START_NS, make.info(wide, START_NS)))
    path = write_plain_mcap(tmp_path / "a.mcap", lines)
    dataset = opened(path, "color=/odd, depth=odder,info=/oddest")
    assert dataset.ids == IDS[:1]
    assert (dataset[0].rgb == 5).all()
    np.testing.assert_array_equal(dataset[0].depth, np.float32(0.5))
    assert dataset.camera == wide
    said = succeed(capsys, "info", path, "--topics", "color=/odd").out
    assert f"topics: color /odd, depth {DEPTH}, info {INFO}" in said


@pytest.mark.parametrize(
    ("topics", "line"),
    [
        ("color=/nowhere", "has no messages on /nowhere; there are /camera/color/camera_info"),
        (f"depth={INFO}", "is of sensor_msgs/CameraInfo; expected sensor_msgs/Image or"),
        (f"pose={COLOUR}", "is of sensor_msgs/Image; expected tf2_msgs/TFMessage or"),
        (f"color={DEPTH}", "is encoded as 16UC1, which is no colour that is read; there are"),
        (f"depth={COLOUR}", "is encoded as rgb8, which is no depth that is read; there are"),
        ("colours=/a", "topics: expected such as color=/camera/color/image_raw"),
        ("color", "topics: expected such as color=/camera/color/image_raw"),
    ],
)
def test_wrong_topics_are_refused(topics: str, line: str, tmp_path: Path, capsys: Capsys) -> None:
    path = write_plain_mcap(tmp_path / "a.mcap", look_alike(Messages()))
    assert line in refusal(capsys, "info", path, "--topics", topics)


def test_topics_of_a_folder_are_refused(room: Path, capsys: Capsys) -> None:
    assert "has no topics" in refusal(capsys, "info", room, "--topics", "color=/a")


def test_a_bag_without_images_lists_what_it_holds(tmp_path: Path, capsys: Capsys) -> None:
    line = look_alike(Messages())[0]
    path = write_bag(tmp_path / "a", [line])
    said = refusal(capsys, "info", path)
    assert f"holds no colour images, but {INFO} (sensor_msgs/CameraInfo)" in said
    assert "--topics color=" in said


@pytest.mark.parametrize("kind", ["ros1", "sqlite", "mcap"])
def test_an_empty_bag_is_refused(kind: str, tmp_path: Path, capsys: Capsys) -> None:
    path = write_bag(tmp_path / "a.bag", [], kind)
    assert "is a bag without any message" in refusal(capsys, "info", path)


@pytest.mark.parametrize("ending", ["bag", "db3", "mcap"])
@pytest.mark.parametrize("content", [b"", b"anything", b"#ROSBAG V1.2\n"])
def test_what_is_only_called_a_bag_is_refused(
    ending: str, content: bytes, tmp_path: Path, capsys: Capsys
) -> None:
    path = tmp_path / f"a.{ending}"
    path.write_bytes(content)
    said = refusal(capsys, "info", path)
    assert "is no " in said or "of an old version; convert it with `rosbag migrate`" in said


def test_without_rosbags_the_extra_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    path = write_plain_mcap(tmp_path / "a.mcap", look_alike(Messages()))
    monkeypatch.setitem(sys.modules, "rosbags.typesys", None)
    said = refusal(capsys, "info", path)
    assert "rosbags, which is missing; pip install 'curiosight[bags]'" in said


def test_colour_alone_is_for_map(tmp_path: Path) -> None:
    lines = [line for line in look_alike(Messages()) if line[0] == COLOUR]
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    assert dataset.ids == IDS
    assert not dataset.has_depth
    assert (dataset[1].rgb == 1).all()


def test_a_damaged_image_is_a_bad_frame(tmp_path: Path) -> None:
    make = Messages()
    lines = look_alike(make, 3)
    lines[4][2].data = lines[4][2].data[:-1]
    dataset = opened(write_plain_mcap(tmp_path / "a.mcap", lines))
    problems = [dataset[index].problem for index in range(3)]
    assert problems == [None, "colour 1305031229.628748000 holds 575 of its 576 bytes", None]
