"""The paper's way to ground truth: segment, clean the labels by hand, test against them."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import pytest

from command import succeed
from curiosight.cli.app import run
from curiosight.datasets import open_dataset

Capsys = pytest.CaptureFixture[str]
CORNER = (slice(0, 20), slice(0, 30))


@pytest.fixture(scope="module")
def segmented(room: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The labels that `segment` wrote of the room; not to be changed."""
    out = tmp_path_factory.mktemp("runs") / "segment"
    assert run(["segment", str(room), "--out", str(out), "--quiet"]) == 0
    return out / "labels"


@pytest.fixture
def labels(segmented: Path, tmp_path: Path) -> Path:
    """A copy of these labels, to be edited."""
    return Path(shutil.copytree(segmented, tmp_path / "labels"))


def read(path: Path) -> npt.NDArray[np.uint8]:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert image is not None
    return image.astype(np.uint8)


def test_labels_are_ground_truth_as_they_are(
    room: Path, labels: Path, tmp_path: Path, capsys: Capsys
) -> None:
    truth = open_dataset(room, ground_truth=labels).ground_truth(2)
    written = read(labels / "000002.png")
    assert {0, 125, 255} <= set(np.unique(written))
    np.testing.assert_array_equal(truth, np.where(np.isin(written, (0, 255)), written, 125))
    succeed(capsys, "score-teacher", room, "--ground-truth", labels, "--out", tmp_path / "out")
    pixels = json.loads((tmp_path / "out/teacher.json").read_text())["pixels"]
    assert pixels["precision"] == pixels["recall_of_all"] == 1


@pytest.mark.parametrize("channels", ["grey", "colour", "with alpha"])
def test_edited_label_is_what_the_editor_saved(channels: str, room: Path, labels: Path) -> None:
    file = labels / "000001.png"
    edited = read(file)
    edited[CORNER] = 255
    conversions = {"colour": cv2.COLOR_GRAY2BGR, "with alpha": cv2.COLOR_GRAY2BGRA}
    saved = cv2.cvtColor(edited, conversions[channels]) if channels in conversions else edited
    assert cv2.imwrite(str(file), saved)
    truth = open_dataset(room, ground_truth=labels).ground_truth(1)
    np.testing.assert_array_equal(truth, np.where(np.isin(edited, (0, 255)), edited, 125))


def test_what_is_added_by_hand_is_missed_by_the_teacher(
    room: Path, labels: Path, tmp_path: Path, capsys: Capsys
) -> None:
    file = labels / "000001.png"
    edited = read(file)
    is_added = np.zeros(edited.shape, bool)
    is_added[CORNER] = edited[CORNER] != 255
    edited[is_added] = 255
    for path in labels.iterdir():
        path.unlink()
    cv2.imwrite(str(file), edited)
    out = tmp_path / "out"
    succeed(capsys, "score-teacher", room, "--ground-truth", labels, "--out", out)
    figures = json.loads((out / "teacher.json").read_text())
    assert [row["id"] for row in figures["per_frame"]] == ["000001"]
    n_salient = int((edited == 255).sum())
    expected = 1 - is_added.sum() / n_salient
    assert figures["pixels"]["recall_of_all"] == pytest.approx(expected, abs=1e-6)


def test_saliency_is_tested_on_the_edited_frames(
    room: Path, model: Path, labels: Path, tmp_path: Path, capsys: Capsys
) -> None:
    for path in labels.iterdir():
        if path.stem not in ("000001", "000005"):
            path.unlink()
    out = tmp_path / "out"
    succeed(capsys, "evaluate", model, room, "--ground-truth", labels, "--out", out)
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["truth"] == "ground truth"
    assert [row["id"] for row in metrics["per_frame"]] == ["000001", "000005"]
    assert metrics["pooled"]["all"]["roc_auc"] > 0.9
