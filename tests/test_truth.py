"""What predictions are tested against: ground truth, else the teacher, else nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from curiosight.datasets import check_dataset
from curiosight.errors import DataError
from curiosight.experiments.problems import Problems
from curiosight.experiments.truth import find_truth
from curiosight.teacher import Teacher, survey_recording
from room_world import RoomRecording


@pytest.fixture
def room() -> RoomRecording:
    return RoomRecording(6)


def teacher_for(room: RoomRecording) -> Teacher:
    return Teacher(survey_recording(room.frames))


def test_the_fixture_is_a_dataset(room) -> None:
    check_dataset(room)


def test_ground_truth_wins_and_only_frames_that_have_it_count(room) -> None:
    del room.truths[0], room.truths[4]
    truth = find_truth(room, [0, 1, 4, 5], teacher_for(room))
    assert truth.kind == "ground truth"
    assert truth.indices == (1, 5)
    for (frame, labels), index in zip(truth, (1, 5), strict=True):
        assert frame is room.frames[index]
        assert labels is room.truths[index]


def test_ground_truth_needs_no_teacher(room) -> None:
    truth = find_truth(room, range(6), None)
    assert (truth.kind, len(truth.indices)) == ("ground truth", 6)


def test_without_ground_truth_the_teacher_stands_in(room) -> None:
    room.truths.clear()
    teacher = teacher_for(room)
    truth = find_truth(room, [2, 3], teacher)
    assert (truth.kind, truth.indices) == ("teacher", (2, 3))
    for frame, labels in truth:
        assert np.array_equal(labels, teacher.segment(frame).labels)
        assert (labels == 255).any()


def test_ground_truth_elsewhere_in_the_recording_does_not_count(room) -> None:
    room.truths = {0: room.truths[0]}
    assert find_truth(room, [2, 3], teacher_for(room)).kind == "teacher"


@pytest.mark.parametrize("has_truth", [True, False])
def test_bad_frames_have_no_labels_and_are_passed_over(room, has_truth: bool) -> None:
    if not has_truth:
        room.truths.clear()
    teacher = teacher_for(room)
    room.frames[1] = replace(room.frames[1], problem="truncated")
    truth = find_truth(room, range(3), teacher)
    assert [labels is None for _, labels in truth] == [False, True, False]
    problems = Problems()
    frames = [frame for frame, _ in truth.labelled_frames(problems)]
    assert len(frames) == 2
    assert frames[0].rgb is room.frames[0].rgb
    assert frames[1].rgb is room.frames[2].rgb
    assert problems.counts() == {"bad frame": 1}


def test_no_frames_to_test_is_nothing(room) -> None:
    room.truths.clear()
    truth = find_truth(room, [], None)
    assert truth.kind == "nothing"
    assert list(truth) == []


def test_neither_ground_truth_nor_teacher_is_an_error(room) -> None:
    room.truths.clear()
    with pytest.raises(DataError, match="neither ground truth nor depth") as caught:
        find_truth(room, [0], None)
    assert "--ground-truth" in caught.value.remedy


def test_only_bad_frames_are_refused(room) -> None:
    room.frames[1] = replace(room.frames[1], problem="truncated")
    truth = find_truth(room, [1], None)
    with pytest.raises(DataError, match="cannot be tested on"):
        list(truth.labelled_frames(Problems()))


def test_at_most_so_many_frames_evenly_spread(room) -> None:
    truth = find_truth(room, range(len(room)), None, max_frames=2)
    assert truth.indices == (0, len(room) - 1)
