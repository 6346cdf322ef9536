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


def coco(path: Path, *names: str) -> Path:
    images = [{"id": number, "file_name": name} for number, name in enumerate(names)]
    boxes = [{"image_id": number, "bbox": [1, 1, 8, 8]} for number in range(len(names))]
    path.write_text(json.dumps({"images": images, "annotations": boxes}))
    return path


def test_file_names_are_matched_with_frames(tmp_path: Path) -> None:
    path = coco(tmp_path / "c.json", "rgb/000001.png", "rgb/000002.png")
    teacher = BoxTeacher(path, ["000000", "000001", "000002"])
    assert teacher.segment(Frame("000001", FRAME.rgb)).labels[5, 5] == Label.SALIENT
    problem = teacher.segment(Frame("000000", FRAME.rgb)).problem
    assert problem == "c.json does not name this frame (of 3 frames 2 are named)"


def test_results_are_matched_by_the_number_of_the_image(tmp_path: Path) -> None:
    path = tmp_path / "r.json"
    path.write_text(json.dumps([{"image_id": 2, "bbox": [1, 1, 8, 8]}]))
    teacher = BoxTeacher(path, ["frame-000001", "frame-000002"])
    assert teacher.segment(Frame("frame-000002", FRAME.rgb)).labels[5, 5] == Label.SALIENT
    assert teacher.segment(Frame("frame-000001", FRAME.rgb)).problem is not None


@pytest.mark.parametrize("kind", ["boxes", "masks"])
def test_labels_of_another_recording_are_refused_at_once(
    kind: str, room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    coco(tmp_path / "boxes", "kitchen/cat7.jpg")
    (tmp_path / "masks/kitchen").mkdir(parents=True)
    cv2.imwrite(str(tmp_path / "masks/kitchen/cat7.png"), MASK)
    source = f"{kind}:{tmp_path / kind}"
    line = refusal(capsys, "learn", room, "--teacher", source, "--out", tmp_path / "x")
    assert "names no frame of the recording" in line
    assert "kitchen/cat7" in line
    assert "a frame is '000000'" in line
    assert not (tmp_path / "x").exists()


def test_names_that_fit_twice_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"'a/1\.png' and 'b/1\.png' fit one"):
        BoxTeacher(coco(tmp_path / "c.json", "a/1.png", "b/1.png"), ["1"])


def test_masks_below_links_and_of_other_endings(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "masks").mkdir()
    cv2.imwrite(str(tmp_path / "elsewhere/a.png"), MASK)
    np.save(tmp_path / "elsewhere/b.npy", MASK == 255)
    cv2.imwrite(str(tmp_path / "elsewhere/c.jpg"), MASK, [cv2.IMWRITE_JPEG_QUALITY, 100])
    (tmp_path / "masks/seq-01").symlink_to(tmp_path / "elsewhere")
    (tmp_path / "elsewhere/again").symlink_to(tmp_path / "masks")
    for ids in (None, ["seq-01/a", "seq-01/b", "seq-01/c"]):
        teacher = MaskTeacher(tmp_path / "masks", ids)
        for name in "abc":
            labels = teacher.segment(Frame(f"seq-01/{name}", FRAME.rgb)).labels
            assert np.mean((labels == Label.SALIENT) == (MASK == 255)) > 0.99
            assert (labels[35:, :] == Label.NOT_SALIENT).all()


def test_mask_of_another_size_tells_both(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), MASK[:30])
    problem = MaskTeacher(tmp_path, ["a"]).segment(FRAME).problem
    assert problem == "mask: a.png is 60x30, not the image's size, 60x40"


@pytest.mark.parametrize(
    "bbox",
    [[1e308] * 4, [0, 0, int("9" * 400), 5], [0, 0, 1e9, 5], [0, 0, 5, 1e-300], [-1e9, 0, 5, 5],
     [float("nan"), 0, 5, 5], [0, 0, float("inf"), 5]],
    ids=str,
)  # fmt: skip
def test_numbers_that_are_no_pixels_are_refused(bbox: list[float], tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"c\.json: is not COCO"):
        BoxTeacher(write_boxes(tmp_path / "c.json", bbox))


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
    with pytest.raises(ValueError, match="masks:FOLDER or boxes:FILE, got 'cnn'"):
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
    assert "expected depth, depth+masks:FOLDER, masks:FOLDER or boxes:FILE, got 'cnn'" in line
