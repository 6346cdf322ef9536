"""curiosight score-teacher: what it writes, prints and refuses."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from command import call, files, interrupt_at, refusal, succeed
from curiosight.evaluation import score_frame
from curiosight.experiments.scoring import COLUMNS, Scoring
from curiosight.frame import Frame, Label
from curiosight.teacher import Segmentation
from curiosight.viewing.mistakes import CUT, INVENTED, MISSED, RIGHT, overlay_mistakes
from recordings import truncate, write_folder, write_image, write_osd

Capsys = pytest.CaptureFixture[str]


def figures_of(out: Path) -> Any:
    return json.loads((out / "teacher.json").read_text())


def score(capsys: Capsys, source: Path, out: Path, *options: str | Path | int) -> Any:
    """Score a recording and return teacher.json."""
    succeed(capsys, "score-teacher", source, "--out", out, *options)
    return figures_of(out)


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def test_it_writes_figures_and_the_worst_frames(room: Path, out: Path, capsys: Capsys) -> None:
    figures = score(capsys, room, out, "--worst", 2)
    assert files(out) - {"teacher.json", "frames.csv", "config.toml"} == {
        f"overlays/{row['id']}.jpg"
        for row in sorted(figures["per_frame"], key=lambda row: -row["n_wrong_px"])[:2]
    }
    pixels = figures["pixels"]
    assert figures["frames"] == 8
    assert pixels["precision"] > 0.95
    assert pixels["recall"] > 0.8
    assert pixels["coverage"] > 0.8
    assert sum(figures["missed_by_reason"].values()) == pytest.approx(1)
    with (out / "frames.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == COLUMNS
    assert [row["id"] for row in rows] == [row["id"] for row in figures["per_frame"]]
    assert float(rows[3]["recall"]) == pytest.approx(figures["per_frame"][3]["recall"], abs=1e-6)


def test_a_recording_that_does_not_tell_objects_apart_says_so(
    room: Path, out: Path, capsys: Capsys
) -> None:
    shown = succeed(capsys, "score-teacher", room, "--out", out).out
    assert "instances no instance truth" in " ".join(shown.split())
    assert figures_of(out)["instances"] is None


def test_instances_are_scored_where_they_are_known(
    tmp_path: Path, out: Path, capsys: Capsys
) -> None:
    write_osd(tmp_path / "osd", 3)
    instances = score(capsys, tmp_path / "osd", out)["instances"]
    assert instances["n_true"] == 9
    assert 0.5 < instances["overlap_f"] <= 1
    assert 0 < instances["boundary_f"] <= 1


def test_every_kth_frame_with_truth(tmp_path: Path, out: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 6)
    (tmp_path / "room/ground_truth/000001.png").unlink()
    figures = score(capsys, tmp_path / "room", out, "--every", 2)
    assert [row["id"] for row in figures["per_frame"]] == ["000000", "000003", "000005"]


def test_temporal_looks_at_the_frames_between_too(room: Path, out: Path, capsys: Capsys) -> None:
    outcome = succeed(capsys, "score-teacher", room, "--out", out, "--temporal", "--every", 4)
    assert "5/5" in outcome.err
    assert [row["id"] for row in figures_of(out)["per_frame"]] == ["000000", "000004"]


def test_what_is_farther_does_not_count(room: Path, out: Path, capsys: Capsys) -> None:
    everything = score(capsys, room, out / "all")["pixels"]
    near = score(capsys, room, out / "near", "--max-distance", 2)["pixels"]
    assert 0 < near["n_true"] < everything["n_true"]
    nothing = score(capsys, room, out / "nothing", "--max-distance", 0.1)["pixels"]
    assert nothing["n_true"] == 0
    assert nothing["precision"] is None


def test_a_wider_frame_of_the_image_cuts_more(room: Path, out: Path, capsys: Capsys) -> None:
    usual = score(capsys, room, out / "usual")["pixels"]
    wide = score(capsys, room, out / "wide", "--border-px", 40)["pixels"]
    assert wide["n_whole"] < usual["n_whole"]
    assert wide["n_object"] == usual["n_object"]


def test_other_ground_truth_can_be_given(
    room: Path, tmp_path: Path, out: Path, capsys: Capsys
) -> None:
    (tmp_path / "masks").mkdir()
    cv2.imwrite(str(tmp_path / "masks/000002.png"), np.zeros((120, 160), np.uint8))
    figures = score(capsys, room, out, "--ground-truth", tmp_path / "masks")
    assert figures["frames"] == 1
    assert figures["pixels"]["precision"] is None  # nothing is marked
    assert figures["pixels"]["recall"] is None


def test_another_teacher_can_be_scored(room: Path, out: Path, capsys: Capsys) -> None:
    figures = score(capsys, room, out, "--teacher", f"masks:{room / 'ground_truth'}")
    assert figures["pixels"]["precision"] == figures["pixels"]["recall_of_all"] == 1
    assert {row["n_wrong_px"] for row in figures["per_frame"]} == {0}


def test_masks_tell_no_objects_apart(tmp_path: Path, out: Path, capsys: Capsys) -> None:
    (view, *_) = write_osd(tmp_path / "osd", 1)
    write_image(tmp_path / "masks/learn0.png", view.ground_truth)
    arguments = ("--teacher", f"masks:{tmp_path / 'masks'}")
    shown = succeed(capsys, "score-teacher", tmp_path / "osd", "--out", out, *arguments).out
    assert "not told apart by this teacher" in shown
    assert figures_of(out)["instances"] is None


def test_json_is_what_the_file_holds(room: Path, out: Path, capsys: Capsys) -> None:
    printed = json.loads(succeed(capsys, "score-teacher", room, "--out", out, "--json").out)
    assert printed.pop("out") == str(out)
    assert printed == figures_of(out)


def test_bad_frames_and_bad_truth_are_left_out_and_told(
    tmp_path: Path, out: Path, capsys: Capsys
) -> None:
    write_folder(tmp_path / "room", 5)
    truncate(tmp_path / "room/depth/000001.png")
    truncate(tmp_path / "room/ground_truth/000003.png")
    outcome = succeed(capsys, "score-teacher", tmp_path / "room", "--out", out)
    assert "2 of 5 frames told nothing: bad frame, first 000001" in outcome.err
    assert [row["id"] for row in figures_of(out)["per_frame"]] == ["000000", "000002", "000004"]


@pytest.mark.usefixtures("ctrl_c_as_usual")
def test_interrupted_it_keeps_what_is_scored(
    room: Path, out: Path, monkeypatch: pytest.MonkeyPatch, capsys: Capsys
) -> None:
    interrupt_at(monkeypatch, Scoring, "_add", turn=3)
    outcome = call(capsys, "score-teacher", room, "--out", out)
    assert outcome.status == 130
    assert "stopped after 3 frames; these are kept" in outcome.err
    assert figures_of(out)["frames"] == 3


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ("--every 0", "every: expected 1 or more, got 0"),
        ("--worst -1", "worst: expected 0 or more, got -1"),
        ("--border-px -1", "border-px: expected 0 or more, got -1"),
        ("--temporal --teacher masks:anywhere", "temporal: expected teacher depth"),
        ("--max-distance 0", "max-distance: expected metres above 0, got 0"),
        ("--max-distance nan", "max-distance: expected metres above 0, got nan"),
    ],
)
def test_unusable_options(options: str, words: str, room: Path, out: Path, capsys: Capsys) -> None:
    assert words in refusal(capsys, "score-teacher", room, "--out", out, *options.split())
    assert not out.exists()


def test_without_ground_truth_there_is_nothing_to_score(
    tmp_path: Path, out: Path, capsys: Capsys
) -> None:
    write_folder(tmp_path / "room", 3, with_ground_truth=False)
    line = refusal(capsys, "score-teacher", tmp_path / "room", "--out", out)
    assert "has no ground truth to score the teacher against; give --ground-truth" in line
    assert not out.exists()


def test_no_truth_that_can_be_read(tmp_path: Path, out: Path, capsys: Capsys) -> None:
    write_folder(tmp_path / "room", 2)
    for path in (tmp_path / "room/ground_truth").iterdir():
        truncate(path)
    outcome = call(capsys, "score-teacher", tmp_path / "room", "--out", out)
    assert outcome.status == 2
    assert "no frame could be scored" in outcome.err


def test_overlay_shows_right_missed_invented_and_cut() -> None:
    truth, labels = np.zeros((60, 400), np.uint8), np.zeros((60, 400), np.uint8)
    truth[20:40, 20:60] = truth[20:40, 0:5] = Label.SALIENT
    truth[20:40, 300:] = Label.UNKNOWN
    labels[20:40, 40:80] = labels[20:40, 300:] = Label.SALIENT
    frame = Frame("0", np.full((60, 400, 3), 100, np.uint8))
    picture = overlay_mistakes(score_frame(frame, Segmentation.of_labels(labels), truth))
    assert picture.shape == (88, 400, 3)
    for u, colour in ((50, RIGHT), (30, MISSED), (70, INVENTED), (2, CUT)):
        expected = np.round(0.45 * 100 + 0.55 * np.array(colour))
        np.testing.assert_array_equal(picture[30, u], expected)
    np.testing.assert_array_equal(picture[30, [200, 350]], [[100] * 3, [50] * 3])


@pytest.mark.skipif(
    "CURIOSIGHT_TEST_DATA" not in os.environ, reason="CURIOSIGHT_TEST_DATA is not set"
)
def test_real_recording(tmp_path: Path, capsys: Capsys) -> None:
    data = Path(os.environ["CURIOSIGHT_TEST_DATA"]) / "data"
    figures = score(capsys, data / "osd_learn", tmp_path / "out", "--every", 5)
    assert figures["frames"] == 9
    assert figures["pixels"]["precision"] > 0.995
    assert figures["pixels"]["recall"] > 0.94
    assert figures["instances"]["overlap_f"] > 0.75
