"""Box proposals: what is proposed, in which order, and in COCO's words."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from command import call, refusal, succeed
from curiosight.config import load_config
from curiosight.evaluation.proposals import consistency, propose, run_lengths, to_coco
from curiosight.experiments.components import make_learner

INSTANCES = np.zeros((40, 60), np.uint16)
INSTANCES[5:15, 10:30] = 1
INSTANCES[20:35, 35:50] = 3  # 2 is nowhere
LOOKS = np.where(INSTANCES == 1, 0.9, 0.1).astype(np.float32)


def test_each_instance_has_its_box_and_mask() -> None:
    large, small = propose(INSTANCES)
    assert (large.box, small.box) == ((35, 20, 15, 15), (10, 5, 20, 10))
    assert large.mask.all()
    assert np.isnan(large.score)


def test_what_looks_salient_comes_first() -> None:
    first, second = propose(INSTANCES, LOOKS)
    assert first.box == (10, 5, 20, 10)
    assert 1 >= first.score > 0.8 > 0.2 > second.score >= 0
    assert [p.box for p in propose(INSTANCES, LOOKS, top=1)] == [first.box]
    assert propose(np.zeros((4, 4), np.uint16)) == []


def test_half_an_object_agrees_less_with_the_map_than_the_whole() -> None:
    half = (INSTANCES == 1) & (np.arange(60) < 20)
    assert consistency(INSTANCES == 1, LOOKS) > consistency(half, LOOKS) + 0.05


@given(arrays(np.bool_, st.tuples(st.integers(1, 9), st.integers(1, 9))))
def test_run_lengths_tell_the_mask(mask: np.ndarray) -> None:
    runs = run_lengths(mask)
    values = np.repeat(np.arange(len(runs)) % 2 == 1, runs)
    assert np.array_equal(values.reshape(mask.shape, order="F"), mask)


def test_coco_holds_full_size_masks_and_images_without_boxes() -> None:
    coco = to_coco({"a": propose(INSTANCES, LOOKS)}, {"a": (40, 60), "b": (40, 60)})
    assert [image["file_name"] for image in coco["images"]] == ["a", "b"]
    best = coco["annotations"][0]
    assert (best["bbox"], best["area"], best["image_id"]) == ([10, 5, 20, 10], 200, 1)
    runs = best["segmentation"]["counts"]
    mask = np.repeat(np.arange(len(runs)) % 2 == 1, runs).reshape((40, 60), order="F")
    assert np.array_equal(mask, INSTANCES == 1)


def test_command_writes_what_a_teacher_can_read(
    room: Path, model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "p"
    succeed(capsys, "propose", room, "--model", model, "--top", 2, "--out", out)
    coco = json.loads((out / "proposals.json").read_text())
    scores = [annotation["score"] for annotation in coco["annotations"]]
    assert scores
    assert all(0 <= score <= 1 for score in scores)
    assert len(scores) <= 2 * len(coco["images"])
    boxes = f"boxes:{out / 'proposals.json'}"
    assert call(capsys, "learn", room, "--teacher", boxes, "--out", tmp_path / "l").status == 0


def test_model_that_learned_nothing_ranks_nothing(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    make_learner(load_config(), None).save(tmp_path / "model.npz")
    told = call(capsys, "propose", room, "--model", tmp_path / "model.npz", "--out", tmp_path / "p")
    assert told.status == 0
    assert "ranked by area" in told.err
    assert "ranked by area" in " ".join(told.out.split())


def test_nonsense_is_one_line(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line = refusal(capsys, "propose", room, "--top", 0, "--out", tmp_path / "x")
    assert "top: expected 1 or more, got 0" in line
