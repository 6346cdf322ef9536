"""curiosight export --layout: bags that rosbags reads, and that give the same frames and labels."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from rosbags.highlevel import AnyReader

from command import call, files, interrupt_at, refusal, succeed
from curiosight.cli.app import run
from curiosight.datasets import BagWriter, Dataset, RosBag, open_dataset
from recordings import truncate, write_folder, write_tum

Capsys = pytest.CaptureFixture[str]
Labels = npt.NDArray[np.uint8]
OUT = {"ros1": "a.bag", "rosbag2": "a", "mcap": "a.mcap"}
LAYOUTS = pytest.mark.parametrize("layout", list(OUT))


def opened(path: Path) -> RosBag:
    dataset = open_dataset(path)
    assert isinstance(dataset, RosBag)
    return dataset


def export(capsys: Capsys, source: Path | str, layout: str, folder: Path) -> Path:
    path = folder / OUT[layout]
    succeed(capsys, "export", source, "--layout", layout, "--out", path, "--quiet")
    return path


def labels(source: Path, out: Path) -> list[Labels]:
    assert run(["segment", str(source), "--out", str(out), "--quiet"]) == 0
    return [cv2.imread(str(path), -1) for path in sorted((out / "labels").glob("*.png"))]


def check_same(one: Dataset, other: Dataset) -> None:
    assert len(one) == len(other)
    for index in range(len(one)):
        a, b = one[index], other[index]
        assert b.problem is None
        assert a.camera == b.camera
        np.testing.assert_array_equal(a.rgb, b.rgb)
        np.testing.assert_array_equal(a.depth, b.depth)
        np.testing.assert_allclose(a.T_world_camera, b.T_world_camera, atol=1e-12)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of a drawn room; not to be changed."""
    path = tmp_path_factory.mktemp("drawn") / "room"
    assert run(["render", "room:7", "--views", "2", "--out", str(path), "--quiet"]) == 0
    return path


@pytest.fixture(scope="module")
def labels_of_drawn(drawn: Path) -> list[Labels]:
    """What the teacher makes of the folder."""
    return labels(drawn, drawn.parent / "labelled")


@LAYOUTS
def test_a_drawn_room_gives_the_same_frames_and_labels(
    layout: str, drawn: Path, labels_of_drawn: list[Labels], tmp_path: Path, capsys: Capsys
) -> None:
    path = export(capsys, drawn, layout, tmp_path)
    check_same(open_dataset(drawn), opened(path))
    of_bag = labels(path, tmp_path / "labelled")
    assert len(of_bag) == len(labels_of_drawn) == 2
    assert any((image == 255).any() for image in labels_of_drawn)
    for one, other in zip(labels_of_drawn, of_bag, strict=True):
        np.testing.assert_array_equal(one, other)


@LAYOUTS
def test_depth_in_millimetres_stays_so_and_rosbags_reads_the_bag(
    layout: str, tmp_path: Path, capsys: Capsys
) -> None:
    write_folder(tmp_path / "room", 2)
    path = export(capsys, tmp_path / "room", layout, tmp_path)
    check_same(open_dataset(tmp_path / "room"), opened(path))
    depth = cv2.imread(str(tmp_path / "room/depth/000000.png"), -1)
    with AnyReader([path]) as reader:
        assert reader.message_count == 10
        assert {topic: told.msgcount for topic, told in reader.topics.items()} == dict.fromkeys(
            [
                "/tf",
                "/camera/color/image_raw",
                "/camera/color/camera_info",
                "/camera/aligned_depth_to_color/image_raw",
                "/camera/aligned_depth_to_color/camera_info",
            ],
            2,
        )
        messages = [
            reader.deserialize(content, connection.msgtype)
            for connection, _, content in reader.messages()
            if connection.topic == "/camera/aligned_depth_to_color/image_raw"
        ]
    first = messages[0]
    assert (first.encoding, first.step, first.is_bigendian) == ("16UC1", 320, 0)  # type: ignore[attr-defined]
    values = first.data.view(np.uint16).reshape(depth.shape)  # type: ignore[attr-defined]
    np.testing.assert_array_equal(values, depth)


def test_depth_of_finer_units_is_written_as_floats(tmp_path: Path, capsys: Capsys) -> None:
    write_tum(tmp_path / "tum", 2)
    path = export(capsys, tmp_path / "tum", "mcap", tmp_path)
    check_same(open_dataset(tmp_path / "tum"), opened(path))
    assert opened(path).ids == ("1305031229.500000000", "1305031229.700000000")


def test_what_camera_info_has_no_place_for_is_kept(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 1)
    file = tmp_path / "room/camera.json"
    told = {"depth_window": [4, 5, 150, 110], "mount": "left"}
    file.write_text(json.dumps({**json.loads(file.read_text()), **told}))
    dataset = opened(export(capsys, tmp_path / "room", "ros1", tmp_path))
    assert dataset.camera == open_dataset(tmp_path / "room").camera
    assert dataset.camera is not None
    assert dataset.camera.depth_window == (4, 5, 150, 110)
    assert dataset.mount == "left"


def test_frames_keep_stamps_that_rise(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 3)
    (tmp_path / "room/poses.txt").unlink()
    path = export(capsys, tmp_path / "room", "rosbag2", tmp_path)
    ids = ("1.000000000", "1.033333333", "1.066666666")
    assert opened(path).ids == ids
    again = tmp_path / "again"
    again.mkdir()
    assert opened(export(capsys, path, "ros1", again)).ids == ids


def test_every_and_bad_frames(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 6)
    truncate(tmp_path / "room/rgb/000002.png")
    path = tmp_path / "a.mcap"
    options = ("--layout", "mcap", "--every", 2, "--out", path, "--json")
    outcome = succeed(capsys, "export", tmp_path / "room", *options)
    facts = json.loads(outcome.out)
    assert facts["frames"] == 2
    assert facts["out"] == str(path)
    assert "1 of 3 frames were not written: bad frame, first 000002" in outcome.err
    assert len(opened(path)) == 2


@LAYOUTS
def test_what_is_there_stays_unless_told(
    layout: str, room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    path = export(capsys, room, layout, tmp_path)
    again = ("export", room, "--every", 4, "--layout", layout, "--out", path)
    assert "exists; choose another --out, or add --overwrite" in refusal(capsys, *again)
    assert len(opened(path)) == 8
    succeed(capsys, *again, "--overwrite")
    assert len(opened(path)) == 2
    own = tmp_path / "own"
    write_folder(own, 1)
    kept = files(own)
    refusal(capsys, "export", room, "--layout", layout, "--out", own, "--overwrite")
    assert files(own) == kept


def test_a_folder_does_not_take_the_place_of_a_file(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    path = export(capsys, room, "mcap", tmp_path)
    kept = path.read_bytes()
    again = ("export", room, "--layout", "rosbag2", "--out", path, "--overwrite")
    line = refusal(capsys, *again)
    assert "is a file; a bag of rosbag2 is a folder; choose another --out" in line
    assert path.read_bytes() == kept
    assert list(tmp_path.iterdir()) == [path]


def test_what_else_lies_in_the_folder_of_a_bag_is_not_lost(
    room: Path, tmp_path: Path, capsys: Capsys
) -> None:
    path = export(capsys, room, "rosbag2", tmp_path)
    (path / "notes.txt").write_text("mine")
    again = ("export", room, "--every", 4, "--layout", "rosbag2", "--out", path, "--overwrite")
    line = refusal(capsys, *again)
    assert "holds more than a bag: notes.txt; choose another --out, or move that away" in line
    assert (path / "notes.txt").read_text() == "mine"
    assert len(opened(path)) == 8


def test_wrong_wishes_leave_nothing_behind(room: Path, tmp_path: Path, capsys: Capsys) -> None:
    out = ("--out", tmp_path / "a.bag")
    said = refusal(capsys, "export", room, "--layout", "ros3", *out)
    assert "layout: expected rl-iac, ros1, rosbag2, mcap, onnx, got 'ros3'" in said
    said = refusal(capsys, "export", room, "--layout", "ros1", "--regions", "time:2", *out)
    assert "a bag holds no regions" in said
    for layout, name, ending in (("ros1", "a.ros1", ".bag"), ("mcap", "a.bag", ".mcap")):
        said = refusal(capsys, "export", room, "--layout", layout, "--out", tmp_path / name)
        assert f"path: expected a name that ends in {ending}, got '{name}'" in said
    inside = ("--layout", "ros1", "--out", room / "a.bag")
    assert "lies inside the recording" in refusal(capsys, "export", room, *inside)
    assert list(tmp_path.iterdir()) == []


def test_nothing_to_write_leaves_nothing_behind(tmp_path: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 2)
    for path in sorted((tmp_path / "room/depth").iterdir())[1:]:
        truncate(path)
    (tmp_path / "room/rgb/000000.png").write_bytes(b"")
    out = ("--layout", "mcap", "--out", tmp_path / "a.mcap", "--quiet")
    outcome = call(capsys, "export", tmp_path / "room", *out)
    assert outcome.status == 2
    assert "has no frame that can be written" in outcome.err
    assert {path.name for path in tmp_path.iterdir()} == {"room"}


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_interrupted_it_keeps_what_is_written(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, BagWriter, "_write", turn=3)
    path = tmp_path / "a.mcap"
    outcome = call(capsys, "export", room, "--layout", "mcap", "--out", path)
    assert outcome.status == 130
    assert "stopped after 3 frames; these are kept" in outcome.err
    assert len(opened(path)) == 3
    assert [file.name for file in tmp_path.iterdir()] == ["a.mcap"]
