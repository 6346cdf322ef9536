"""Teachers that read what something else has labelled."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from command import refusal, succeed
from curiosight.errors import DataError
from curiosight.frame import Frame, Label
from curiosight.teacher.given import BoxTeacher, CallTeacher, MaskTeacher, open_teacher

FRAME = Frame("a", np.zeros((40, 60, 3), np.uint8))
MASK = np.full((40, 60), Label.NOT_SALIENT, np.uint8)
MASK[10:20, 10:30] = Label.SALIENT
MASK[20:30] = 90  # what somebody's editor made of it


def write_boxes(path: Path, *boxes: list[float], scores: tuple[float, ...] = ()) -> Path:
    annotations = [{"image_id": 3, "bbox": box} for box in boxes]
    for annotation, score in zip(annotations, scores, strict=False):
        annotation["score"] = score
    images = [{"id": 3, "file_name": "a.color.png"}, {"id": 4, "file_name": "seq-01/b.jpg"}]
    path.write_text(json.dumps({"images": images, "annotations": annotations}))
    return path


def test_a_function_teaches() -> None:
    assert np.array_equal(CallTeacher(lambda _: MASK).segment(FRAME).labels, MASK)
    with pytest.raises(ValueError, match=r"expected \(40, 60\) uint8 for frame a, got \(2, 3\)"):
        CallTeacher(lambda _: np.zeros((2, 3), np.uint8)).segment(FRAME)


def test_masks_teach_and_other_greys_are_unknown(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), MASK)
    labels = MaskTeacher(tmp_path).segment(FRAME).labels
    assert np.array_equal(labels, np.where(MASK == 90, Label.UNKNOWN, MASK))


def test_frames_without_a_good_mask_teach_nothing(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), MASK[:30])
    (tmp_path / "b.png").write_bytes(b"no image")
    teacher = MaskTeacher(tmp_path)
    for id, finding in (("a", "not the image's size"), ("b", "b.png"), ("c", "c.png is missing")):
        found = teacher.segment(Frame(id, FRAME.rgb))
        assert found.problem is not None
        assert finding in found.problem
        assert (found.labels == Label.UNKNOWN).all()


def test_boxes_teach_their_ellipse_and_doubt_their_corners(tmp_path: Path) -> None:
    labels = BoxTeacher(write_boxes(tmp_path / "c.json", [10, 5, 30, 20])).segment(FRAME).labels
    box = labels[5:25, 10:40]
    assert box[10, 15] == box[10, 1] == box[1, 15] == Label.SALIENT
    assert box[0, 0] == box[-1, -1] == Label.UNKNOWN
    assert np.mean(box == Label.SALIENT) == pytest.approx(np.pi / 4, abs=0.05)
    labels[5:25, 10:40] = Label.NOT_SALIENT
    assert (labels == Label.NOT_SALIENT).all()


def test_boxes_with_a_low_score_do_not_count(tmp_path: Path) -> None:
    boxes = write_boxes(tmp_path / "c.json", [0, 0, 9, 9], [20, 0, 9, 9], scores=(0.4, 0.6))
    labels = BoxTeacher(boxes).segment(FRAME).labels
    assert labels[4, 4] == Label.NOT_SALIENT
    assert labels[4, 24] == Label.SALIENT


def test_frame_that_was_not_looked_at_differs_from_one_without_boxes(tmp_path: Path) -> None:
    teacher = BoxTeacher(write_boxes(tmp_path / "c.json", [0, 0, 9, 9]))
    assert (teacher.segment(Frame("seq-01/b", FRAME.rgb)).labels == Label.NOT_SALIENT).all()
    assert teacher.segment(Frame("z", FRAME.rgb)).problem == "c.json does not name this frame"


def test_list_of_results_is_read(tmp_path: Path) -> None:
    path = tmp_path / "r.json"
    path.write_text(json.dumps([{"image_id": "a", "bbox": [1, 1, 8, 8], "score": 0.9}]))
    assert BoxTeacher(path).segment(FRAME).labels[5, 5] == Label.SALIENT


@pytest.mark.parametrize(
    "content",
    ["{", "[3]", "{}", '[{"image_id": 1, "bbox": [1, 2, 3]}]', '[{"image_id": 1, "bbox": "abcd"}]',
     '[{"image_id": 1, "bbox": [0, 0, -1, 5]}]', '[{"image_id": [1], "bbox": [0, 0, 1, 5]}]'],
)  # fmt: skip
def test_bad_box_file_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / "bad.json"
    path.write_text(content)
    with pytest.raises(DataError, match=r"bad\.json"):
        BoxTeacher(path)


def test_sources_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="expected depth, masks:FOLDER or boxes:FILE, got 'cnn'"):
        open_teacher("cnn")
    with pytest.raises(DataError, match="has no mask"):
        open_teacher(f"masks:{tmp_path}")
    with pytest.raises(DataError, match=r"none\.json"):
        open_teacher(f"boxes:{tmp_path / 'none.json'}")


def test_recording_learns_from_the_masks_that_segment_wrote(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    succeed(capsys, "segment", room, "--preset", "paper", "--out", tmp_path / "s")
    for source in ("depth", f"masks:{tmp_path / 's' / 'labels'}"):
        options = ["--preset", "paper", "--teacher", source, "--out", tmp_path / source[:5]]
        succeed(capsys, "learn", room, *options)
    with (
        np.load(tmp_path / "depth" / "model.npz") as one,
        np.load(tmp_path / "masks" / "model.npz") as other,
    ):
        assert all(np.array_equal(one[name], other[name]) for name in one.files)


def test_another_teacher_is_one_line(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = refusal(capsys, "learn", room, "--teacher", "cnn", "--out", tmp_path / "x")
    assert "expected depth, masks:FOLDER or boxes:FILE, got 'cnn'" in line
