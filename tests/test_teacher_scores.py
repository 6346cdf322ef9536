"""How right and how complete labels are: counts, reasons, and the frames to look at."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from curiosight.evaluation import (
    TeacherCounts,
    TeacherScores,
    missed_by_reason,
    score_frame,
    teacher_counts,
    whole_objects,
)
from curiosight.frame import Frame, Label
from curiosight.teacher import Cluster, Segmentation, Verdict

Labels = npt.NDArray[np.uint8]
SIZE = (60, 80)


def box(v: int, u: int, height: int, width: int) -> tuple[slice, slice]:
    return slice(v, v + height), slice(u, u + width)


def labels_of(default: int, *boxes: tuple[tuple[slice, slice], int]) -> Labels:
    """Return (60, 80) labels of one kind, with boxes of others."""
    labels = np.full(SIZE, default, np.uint8)
    for where, label in boxes:
        labels[where] = label
    return labels


def cluster(verdict: Verdict) -> Cluster:
    return Cluster(verdict, (0, 0, 1, 1), 1, (0.1, 0.1, 0.1), 1.0, 0.0)


CUT, WHOLE, IGNORED = box(20, 5, 10, 20), box(20, 40, 10, 20), box(40, 40, 10, 20)
TRUTH = labels_of(Label.NOT_SALIENT, (CUT, 255), (WHOLE, 255), (IGNORED, 125))


def frame(id: str = "0") -> Frame:
    return Frame(id, np.zeros((*SIZE, 3), np.uint8))


def test_shares_of_a_hand_worked_frame() -> None:
    labels = labels_of(
        Label.UNKNOWN,
        (box(20, 50, 10, 20), Label.SALIENT),  # half on the object, half beside
        (IGNORED, Label.SALIENT),
        (box(50, 0, 10, 80), Label.NOT_SALIENT),
    )
    counts = teacher_counts(labels, TRUTH)
    assert counts.precision == 100 / 200
    assert counts.recall == 100 / 200
    assert counts.recall_of_all == 100 / 400
    assert counts.coverage == (200 + 800) / (60 * 80 - 200)
    assert counts.n_wrong == 100 + 100


def test_without_pixels_a_share_is_nan_and_none_in_a_table() -> None:
    nothing = TeacherCounts()
    assert np.isnan([nothing.precision, nothing.recall, nothing.coverage]).all()
    assert set(nothing.shares().values()) == {None}


def test_precision_is_undefined_where_truth_marks_no_object() -> None:
    nothing = labels_of(Label.NOT_SALIENT)
    empty = teacher_counts(labels_of(Label.SALIENT), nothing)
    assert empty.shares()["precision"] is None
    assert empty.coverage == 1
    # Beside frames with objects its pixels count as what they are: wrong.
    both = empty + teacher_counts(np.where(TRUTH == 255, 255, 0).astype(np.uint8), TRUTH)
    assert both.precision == 400 / (400 + 60 * 80)


def test_counts_add_up() -> None:
    none = teacher_counts(labels_of(Label.UNKNOWN), TRUTH)
    all_of_it = teacher_counts(labels_of(Label.SALIENT), TRUTH)
    assert none.recall == 0
    assert all_of_it.precision == 400 / 4600
    assert (none + all_of_it).recall == 0.5
    assert (none + all_of_it).precision == all_of_it.precision


@pytest.mark.parametrize(("border_px", "n_whole"), [(10, 200), (5, 400), (0, 400), (30, 0)])
def test_whole_objects_keep_out_of_the_frame(border_px: int, n_whole: int) -> None:
    assert whole_objects(TRUTH, border_px=border_px).sum() == n_whole


def test_an_object_that_touches_the_frame_is_left_out_with_all_of_its_pixels() -> None:
    truth = labels_of(Label.NOT_SALIENT, (box(30, 9, 2, 60), 255), (box(28, 69, 1, 1), 255))
    assert whole_objects(truth)[28, 69]
    truth[29, 69] = 255  # corner to corner with the long one
    assert not whole_objects(truth).any()


def test_missed_pixels_are_told_apart_by_what_they_were_taken_for() -> None:
    labels = labels_of(
        Label.UNKNOWN, (box(20, 40, 1, 20), 0), (box(21, 40, 2, 20), Label.UNAVAILABLE)
    )
    number = np.zeros(SIZE, np.uint16)
    number[23:26, 40:60], number[26, 40:60] = 1, 2
    clusters = (cluster(Verdict.SMALL), cluster(Verdict.OBJECT))
    reasons = missed_by_reason(Segmentation(labels, number, clusters), whole_objects(TRUTH))
    assert reasons == {
        "taken for a support or a wall": 20,
        "no reading, or beyond the range": 40,
        "too small": 60,
        "in an object: enclosed by it, or denied by other views": 20,
        "in no cluster": 60,
    }


def test_where_nothing_could_be_said_that_is_the_reason() -> None:
    empty = Segmentation.of_labels(labels_of(Label.UNKNOWN), "no support plane is in view")
    assert missed_by_reason(empty, whole_objects(TRUTH)) == {"no support plane is in view": 200}


def test_only_counted_pixels_count() -> None:
    is_near = np.zeros(SIZE, np.bool_)
    is_near[:, 50:] = True
    empty = Segmentation.of_labels(labels_of(Label.SALIENT))
    instances = np.where(TRUTH == 255, 1, 0)
    scored = score_frame(frame(), empty, TRUTH, instances, counted=is_near)
    # Half of the whole object is left, and it is not taken for cut.
    assert (scored.counts.n_whole, scored.counts.n_object) == (100, 100)
    assert scored.counts.n_true == 60 * 30 - 100
    assert scored.instances is not None
    assert scored.instances.n_true == 1


def test_missed_and_invented_pixels() -> None:
    labels = labels_of(Label.NOT_SALIENT, (box(20, 50, 10, 20), Label.SALIENT))
    scored = score_frame(frame(), Segmentation.of_labels(labels), TRUTH)
    np.testing.assert_array_equal(np.argwhere(scored.is_missed).min(0), (20, 40))
    np.testing.assert_array_equal(np.argwhere(scored.is_missed).max(0), (29, 49))
    np.testing.assert_array_equal(np.argwhere(scored.is_invented).min(0), (20, 60))
    np.testing.assert_array_equal(np.argwhere(scored.is_invented).max(0), (29, 69))


def test_the_worst_frames_are_kept_worst_first() -> None:
    scores = TeacherScores(n_worst=2)
    for id, n_rows in (("a", 1), ("b", 10), ("c", 0), ("d", 5), ("e", 5)):
        labels = labels_of(Label.NOT_SALIENT, (WHOLE, Label.SALIENT))
        labels[20 : 20 + n_rows] = Label.NOT_SALIENT
        scores.add(score_frame(frame(id), Segmentation.of_labels(labels), TRUTH))
    assert [scored.frame.id for scored in scores.worst] == ["b", "d"]
    assert [row["n_wrong_px"] for row in scores.rows] == [20, 200, 0, 100, 100]


def test_frames_without_a_mistake_are_not_worst() -> None:
    scores = TeacherScores()
    labels = labels_of(Label.NOT_SALIENT, (WHOLE, Label.SALIENT))
    scores.add(score_frame(frame(), Segmentation.of_labels(labels), TRUTH))
    assert scores.worst == []
    table = scores.table()
    assert table["missed_by_reason"] == {}
    assert table["instances"] is None
    assert table["pixels"]["precision"] == table["pixels"]["recall"] == 1
    assert table["per_frame"][0]["overlap_f"] is None


def test_negative_border_is_refused() -> None:
    with pytest.raises(ValueError, match="border_px: expected 0 or more, got -1"):
        whole_objects(TRUTH, border_px=-1)
